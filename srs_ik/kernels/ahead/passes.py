"""Numba's passes over a kernel: those that kernels need, in two halves.

The first half ends where the types are known, for a caller needs no more than them. The second writes the code, and can
be done later, in any order and in another process.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import Any

from numba.core import compiler, interpreter, ir, postproc, transforms, typed_passes, untyped_passes
from numba.core.compiler_machinery import AnalysisPass, PassManager, _pass_registry, register_pass
from numba.core.funcdesc import PythonFunctionDescriptor
from numba.core.targetconfig import ConfigStack

from srs_ik.kernels import __name__ as KERNELS
from srs_ik.kernels.ahead.borrow import holders

NOT_NEEDED = {
    untyped_passes.WithLifting,
    untyped_passes.InlineClosureLikes,
    untyped_passes.RewriteDynamicRaises,
    untyped_passes.MakeFunctionToJitFunction,
    untyped_passes.InlineInlinables,
    untyped_passes.FindLiterallyCalls,
    untyped_passes.ReconstructSSA,
    untyped_passes.LiteralUnroll,
    untyped_passes.LiteralPropagationSubPipelinePass,
    typed_passes.InlineOverloads,
    typed_passes.NopythonRewrites,
    typed_passes.NoPythonSupportedFeatureValidation,
    typed_passes.AnnotateTypes,
    typed_passes.DumpParforDiagnostics,
}
"""Passes for what no kernel contains; and every name in a kernel has one type, wherever it is assigned."""


class Plain(PassManager):
    """The passes one after another; what they leave is not looked at between them."""

    def _runPass(self, index: int, one: Any, state: Any) -> None:
        one.analysis = self._analysis
        one.run_initialization(state)
        mutated = one.run_pass(state)
        one.run_finalizer(state)
        if _pass_registry.get(one.__class__).mutates_CFG and not mutated:
            state.func_ir.blocks = transforms.canonicalize_cfg(state.func_ir.blocks)


class Halves:
    """Numba's passes, cut in two for as long as `postponing`.

    `wait` takes the call that writes the code of a function that has types, and returns its name.
    """

    def __init__(self, wait: Callable[[Callable[[], str]], None]) -> None:
        self.postponing = True
        self._wait = wait

    def install(self) -> None:
        """Change Numba in this process, for good."""
        compiler.Compiler.define_pipelines = self._cut(compiler.Compiler.define_pipelines)
        typed_passes.IRLegalization.run_pass = _where_counted(typed_passes.IRLegalization.run_pass)
        postproc.PostProcessor.run = _where_lives_end(postproc.PostProcessor.run)
        interpreter.Interpreter.post_process = _without_peepholes(interpreter.Interpreter.post_process)

    def _cut(self, usual: Callable[..., Any]) -> Callable[..., Any]:
        known: dict[bool, tuple[PassManager, PassManager, PassManager]] = {}

        def define_pipelines(pipeline: Any) -> Any:
            is_kernel = _is_kernel(pipeline.state.func_id)
            if is_kernel not in known:
                known[is_kernel] = _cut_in_two(usual(pipeline)[0], is_kernel)
            whole, first, left = known[is_kernel]
            if not self.postponing:
                return [whole]
            pipeline.state["postpone"] = partial(self._wait, partial(_finish, pipeline.state, left))
            return [first]

        return define_pipelines


def _cut_in_two(found: PassManager, is_kernel: bool) -> tuple[PassManager, PassManager, PassManager]:
    """All passes over a function, those up to where its types are known, and those that are left."""
    passes, cut = found.passes, typed_passes.IRLegalization
    if is_kernel:
        passes = [(one, words) for one, words in passes if one not in NOT_NEEDED]
        passes.insert([one for one, _ in passes].index(typed_passes.NopythonTypeInference), (OneType, "names"))
        cut = typed_passes.NopythonTypeInference
    at = [one for one, _ in passes].index(cut) + 1
    backend = next(each for each in passes if each[0] is typed_passes.NoPythonBackend)
    first = _manager([*passes[:at], (Postpone, "postpone"), backend])
    left = _manager([each for each in passes[at:] if each is not backend])
    return _manager(passes) if is_kernel else found, first, left


def _manager(passes: list[Any]) -> PassManager:
    manager = Plain("kernels")
    manager.passes = passes
    manager.finalize()
    return manager


def _is_kernel(identity: Any) -> bool:
    return str(identity.modname).startswith(KERNELS)


def _where_counted(usual: Callable[..., Any]) -> Callable[..., Any]:
    """Where each variable's life ends is written down where references are counted."""

    def run_pass(self: Any, state: Any) -> Any:
        return True if _is_kernel(state.func_id) and not holders(state).owners else usual(self, state)

    return run_pass


def _where_lives_end(usual: Callable[..., Any]) -> Callable[..., Any]:
    """Where variables begin and end to live is asked for once for kernels: when their ends are written down."""

    def run(self: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
        if emit_dels or not _is_kernel(self.func_ir.func_id):
            usual(self, emit_dels, extend_lifetimes)
        else:
            self.func_ir.blocks = transforms.canonicalize_cfg(self.func_ir.blocks)
            self.func_ir.generator_info = None

    return run


def _without_peepholes(usual: Callable[..., Any]) -> Callable[..., Any]:
    """Kernels have no `with`, and make no dictionary."""
    needless = ("peep_hole_delete_with_exit", "peep_hole_fuse_dict_add_updates")

    def post_process(self: Any, peepholes: Any, func_ir: Any) -> Any:
        if _is_kernel(func_ir.func_id):
            peepholes = [each for each in peepholes if each.__name__ not in needless]
        return usual(self, peepholes, func_ir)

    return post_process


def _finish(state: Any, left: PassManager) -> str:
    """The second half: write the code of a function that has types."""
    with ConfigStack().enter(state.flags.copy()):
        left.run(state)
    return str(state["cr"].fndesc.llvm_func_name)


@register_pass(mutates_CFG=False, analysis_only=True)
class Postpone(AnalysisPass):
    """Stands where the code of a function would be written, and says what its callers need to know of it."""

    _name = "postpone"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Give the function a name and a type."""
        flags = state.flags
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        descriptor = PythonFunctionDescriptor.from_specialized_function(
            state.func_ir,
            state.typemap,
            state.return_type,
            state.calltypes,
            mangler=state.targetctx.mangler,
            inline=flags.forceinline,
            noalias=flags.noalias,
            abi_tags=[flags.get_mangle_string()],
        )
        # Functions are told apart by what would be called: any builtin of its own will do.
        called = list[Any]().append
        state.targetctx.insert_user_function(called, descriptor)
        state["cr"] = compiler._LowerResult(descriptor, None, cfunc=called, env=None)
        state["postpone"]()
        return False


@register_pass(mutates_CFG=False, analysis_only=False)
class OneType(AnalysisPass):
    """What stands between a kernel and names that have one type each, wherever they are assigned."""

    _name = "one_type"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Each value that is left to "_" has a name of its own, and no name has the type of one global constant."""
        found: dict[str, list[tuple[Any, Any]]] = defaultdict(list)
        for block in state.func_ir.blocks.values():
            for each in block.find_insts(ir.Assign):
                found[each.target.name].append((block, each))
        for name, places in found.items():
            discarded = name.split(".")[0] == "_"
            for i, (block, each) in enumerate(places if discarded or len(places) > 1 else []):
                if discarded or isinstance(each.value, (ir.Global, ir.FreeVar)):
                    name_of_all, each.target = (
                        each.target,
                        ir.Var(each.target.scope, f"{name}.only.{i}", each.target.loc),
                    )
                    if not discarded:
                        block.insert_after(ir.Assign(each.target, name_of_all, each.loc), each)
        return True
