"""From LLVM to object code: all translated functions as one module, which shows nothing but its entries."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import llvmlite.binding as llvm

OPT = 3


def merge(parts: Iterable[bytes]) -> bytes:
    """One module of many, in which each function stands once."""
    modules = [llvm.parse_bitcode(part) for part in parts]
    for module in modules:
        for function in module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                # Some helpers of Numba stand in more than one part.
                function.linkage = "weak_odr"
    # Two and two, since LLVM walks all of a module for each that it takes in.
    while len(modules) > 1:
        for module, other in zip(modules[::2], modules[1::2], strict=False):
            module.link_in(other)
        modules = modules[::2]
    return bytes(modules[0].as_bitcode())


def prepare(bitcode: bytes, kept: set[str], triple: str) -> bytes:
    """The module for all processors of a machine: all but the kept symbols may be inlined, changed and dropped."""
    machine = _machine(triple, "", "")
    module = llvm.parse_bitcode(bitcode)
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = "external" if function.name in kept else "internal"
    for variable in module.global_variables:
        if not variable.is_declaration:
            variable.linkage = "internal"
    module.triple = triple
    module.data_layout = str(machine.target_data)
    # References that a function counts up and down again are found before it is inlined into others.
    first = llvm.create_new_module_pass_manager()
    for add in (first.add_sroa_pass, first.add_simplify_cfg_pass, first.add_instruction_combine_pass):
        add()
    first.add_refprune_pass()
    first.run(module, llvm.create_pass_builder(machine, _options()))
    return bytes(module.as_bitcode())


def emit(bitcode: bytes, triple: str, processor: str, features: str, rename: dict[str, str]) -> bytes:
    """Object code of a prepared module for one kind of processor, its entries renamed."""
    machine = _machine(triple, processor, features)
    module = llvm.parse_bitcode(bitcode)
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
    options.loop_vectorization = True
    options.slp_vectorization = False
    return options
