"""From LLVM to object code: all translated functions as one module, which shows nothing but its entries."""

from __future__ import annotations

from collections.abc import Iterable

import llvmlite.binding as llvm

OPT = 3


def merge(parts: Iterable[bytes], kept: set[str]) -> bytes:
    """One module of many, in which all but the kept symbols may be inlined, changed and dropped."""
    modules = map(llvm.parse_bitcode, parts)
    whole = next(modules)
    for module in [whole, *modules]:
        for function in module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                # Some helpers of Numba stand in more than one part.
                function.linkage = "weak_odr"
        if module is not whole:
            whole.link_in(module)
    for function in whole.functions:
        if not function.is_declaration:
            function.linkage = "external" if function.name in kept else "internal"
    for variable in whole.global_variables:
        if not variable.is_declaration:
            variable.linkage = "internal"
    return whole.as_bitcode()


def emit(bitcode: bytes, triple: str, processor: str, features: str, rename: dict[str, str]) -> bytes:
    """Object code of a module for one kind of processor, its entries renamed."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(
        cpu=processor, features=features, opt=OPT, reloc="pic", codemodel="default"
    )
    module = llvm.parse_bitcode(bitcode)
    module.triple = triple
    module.data_layout = str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=OPT)
    options.loop_vectorization = True
    options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    passes = builder.getModulePassManager()
    passes.run(module, builder)
    for function in module.functions:
        if function.name in rename:
            function.name = rename[function.name]
    return machine.emit_object(module)
