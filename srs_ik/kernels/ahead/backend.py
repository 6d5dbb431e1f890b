"""From LLVM to object code: all translated functions as one module, which shows nothing but its entries."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import llvmlite.binding as llvm

OPT = 3


def prepare(module: str, kept: set[str] | None, triple: str) -> bytes:
    """A module, as Numba writes it, for all processors of a machine.

    All but the kept symbols (None: all), which other modules use, are seen by nobody else.
    """
    machine = _machine(triple, "", "")
    whole = llvm.parse_assembly(module)
    for each in (*whole.functions, *whole.global_variables):
        if not each.is_declaration and kept is not None:
            each.linkage = "external" if each.name in kept else "internal"
    whole.triple = triple
    whole.data_layout = str(machine.target_data)
    # References that a function counts up and down again are found before it is inlined into others.
    first = llvm.create_new_module_pass_manager()
    for add in (first.add_sroa_pass, first.add_simplify_cfg_pass, first.add_instruction_combine_pass):
        add()
    first.add_refprune_pass()
    # Nobody will read the names of variables, and each function that is inlined would make them longer.
    first.add_strip_symbols_pass()
    first.run(whole, llvm.create_pass_builder(machine, _options()))
    return bytes(whole.as_bitcode())


def join(parts: Iterable[bytes], kept: set[str], triple: str) -> str:
    """All prepared parts as one module, which shows nothing but the kept symbols, and in which all have names."""
    whole = _linked([llvm.parse_bitcode(part) for part in parts])
    for i, each in enumerate((*whole.functions, *whole.global_variables)):
        if not each.is_declaration:
            each.linkage = "external" if each.name in kept else "internal"
        if not each.name:
            each.name = f"nameless.{i}"
    # What calls may be told of a function, above all that it never fails, before they are compiled apart from it.
    known = llvm.create_new_module_pass_manager()
    known.add_ipsccp_pass()
    known.add_post_order_function_attributes_pass()
    known.run(whole, llvm.create_pass_builder(_machine(triple, "", ""), _options()))
    return str(whole)


def _linked(modules: list[Any]) -> Any:
    # Two and two, since LLVM walks all of a module for each that it takes in.
    while len(modules) > 1:
        for module, other in zip(modules[::2], modules[1::2], strict=False):
            module.link_in(other)
        modules = modules[::2]
    return modules[0]


def emit(text: str, triple: str, processor: str, features: str, rename: dict[str, str]) -> bytes:
    """Object code of a prepared module for one kind of processor, its entries renamed."""
    machine = _machine(triple, processor, features)
    module = llvm.parse_assembly(text)
    builder = llvm.create_pass_builder(machine, _options())
    passes = builder.getModulePassManager()
    passes.add_refprune_pass()
    passes.run(module, builder)
    for function in module.functions:
        if function.name in rename:
            function.name = rename[function.name]
    return bytes(machine.emit_object(module))


def _machine(triple: str, processor: str, features: str) -> Any:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple(triple)
    return target.create_target_machine(cpu=processor, features=features, opt=OPT, reloc="pic", codemodel="default")


def _options() -> Any:
    options = llvm.create_pipeline_tuning_options(speed_level=OPT)
    # Kernels have few loops, and short ones: no call is quicker where they are unrolled or made into vectors.
    options.loop_vectorization = options.loop_unrolling = options.slp_vectorization = False
    return options
