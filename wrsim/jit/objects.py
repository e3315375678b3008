"""Stages as machine code for a linker: position-independent, no name seen by others but their own."""

from collections.abc import Mapping
from typing import Any

from llvmlite import binding

from wrsim.errors import WrsimError
from wrsim.jit.cache import CONFIG
from wrsim.jit.stages import ARGUMENTS


def target(kernel: Any) -> tuple[str, str, str]:
    """Triple, processor and features that a kernel is compiled for."""
    triple, processor, features = kernel.targetctx.codegen().magic_tuple()
    return triple, processor, features


def emit_object(stages: Mapping[str, Any]) -> bytes:
    """Object file with these stages (`jit.stages`) under these names, for the processor that numba compiles for;
    compiled here or from the cache. Raises WrsimError where kernels are not compiled (NUMBA_DISABLE_JIT)."""
    if CONFIG.DISABLE_JIT:
        raise WrsimError("NUMBA_DISABLE_JIT is set: kernels are not compiled")
    first, *others = (_module(name, kernel) for name, kernel in stages.items())
    for module in others:
        first.link_in(module)
    triple, processor, features = target(next(iter(stages.values())))
    machine = binding.Target.from_triple(triple).create_target_machine(
        cpu=processor, features=features, opt=CONFIG.OPT, reloc="pic", codemodel="default"
    )
    # the wrappers for Python
    passes = binding.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(first, binding.create_pass_builder(machine, binding.create_pipeline_tuning_options()))
    first.verify()
    return bytes(machine.emit_object(first))


def _module(name: str, kernel: Any) -> Any:
    """The optimised code of a stage, with nothing in it that others see but the stage under this name."""
    kernel.compile(ARGUMENTS)
    overload = kernel.overloads[ARGUMENTS]
    module = overload.library._get_module_for_linking().clone()
    for value in (*module.functions, *module.global_variables):
        if value.name == overload.fndesc.llvm_func_name:
            value.name, value.linkage, value.visibility = name, "external", "hidden"
        elif not value.is_declaration:
            value.linkage = "internal"
    return module
