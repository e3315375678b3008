"""Stages as machine code for a linker: position-independent, no name seen by others but their own.

The code that numba has optimised for this machine names no processor: it is made into objects of other systems as it
is, with sums in the same order. Where a product and a sum may be one (`jit.spline`), processors without such an
instruction round twice: the strip model's forces differ by some 1e-11 of them, those of Kik-Piotrowski in no bit.
"""

import platform
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from llvmlite import binding

from wrsim.errors import WrsimError
from wrsim.jit.cache import CONFIG
from wrsim.jit.stages import ARGUMENTS, SYMBOL


class Target(NamedTuple):
    """A system that machine code is made for."""

    triple: str
    levels: Mapping[str, str]
    """Features by processor, by LLVM's names, the best first."""


_X86 = {"x86-64-v3": "", "x86-64": ""}
TARGETS = {
    "linux": Target("x86_64-unknown-linux-gnu", _X86),
    "linux-arm": Target("aarch64-unknown-linux-gnu", {"generic": ""}),
    "windows": Target("x86_64-w64-windows-gnu", _X86),
    "macos": Target("arm64-apple-macosx11.0.0", {"apple-m1": ""}),
    "wasm": Target("wasm32-unknown-wasi", {"generic": "+simd128"}),
}
_HERE = {
    ("Linux", "x86_64"): "linux", ("Linux", "aarch64"): "linux-arm", ("Windows", "AMD64"): "windows",
    ("Darwin", "arm64"): "macos",
}  # fmt: skip


def this_target() -> str:
    """Name of the target that this machine is. Raises WrsimError where it is none."""
    machine = platform.system(), platform.machine()
    if machine not in _HERE:
        raise WrsimError(f"{' '.join(machine)}: no machine code is made for it; for {', '.join(TARGETS)} only")
    return _HERE[machine]


def emit_objects(stages: Mapping[str, Any], target: str) -> list[bytes]:
    """Object files with these stages (`jit.stages`) for a target, one for each of its levels, the best first.

    In that of level i names, and the symbol of the table of stages, end with _i. Stages are compiled here or from the
    cache. Raises WrsimError where kernels are not compiled (NUMBA_DISABLE_JIT).
    """
    if CONFIG.DISABLE_JIT:
        raise WrsimError("NUMBA_DISABLE_JIT is set: kernels are not compiled")
    first, *others = (_module(name, kernel) for name, kernel in stages.items())
    for module in others:
        first.link_in(module)
    here = _machine(binding.get_process_triple(), "generic", "")
    # the wrappers for Python
    passes = binding.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(first, binding.create_pass_builder(here, binding.create_pipeline_tuning_options()))
    first.verify()
    return [
        _emit(_without_pointer_sizes(first) if "32" in TARGETS[target].triple else first.clone(), target, i, stages)
        for i in range(len(TARGETS[target].levels))
    ]


def emit_constant(name: str, content: bytes, target: str) -> bytes:
    """Object file with bytes under this name, at a multiple of 64 in memory, for a target."""
    text = "".join(f"\\{byte:02x}" for byte in content)
    code = f'@{name} = hidden constant [{len(content)} x i8] c"{text}", align 64'
    return _emit(binding.parse_assembly(code), target)


def _machine(triple: str, processor: str, features: str) -> Any:
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    return binding.Target.from_triple(triple).create_target_machine(
        cpu=processor, features=features, opt=CONFIG.OPT, reloc="pic", codemodel="default"
    )


def _emit(module: Any, target: str, level: int = 0, names: Mapping[str, Any] | tuple[str, ...] = ()) -> bytes:
    """Object file of a module; names: of functions that get the number of the level."""
    triple, levels = TARGETS[target]
    machine = _machine(triple, *list(levels.items())[level])
    module.triple, module.data_layout = triple, str(machine.target_data)
    for value in (*module.functions, *module.global_variables):
        if value.name in names or value.name == SYMBOL:
            value.name += f"_{level}"
    return bytes(machine.emit_object(module))


def _without_pointer_sizes(module: Any) -> Any:
    """The code with bytes for records of pointers on the stack: optimised code knows the places of their fields in
    bytes, for pointers of 64 bits."""
    text = str(module)
    kinds = sorted(set(re.findall(r" = alloca (\{.*\bptr\b.*\}), align", text)))
    declared = binding.parse_assembly("\n".join(f"@k{i} = external global {kind}" for i, kind in enumerate(kinds)))
    data = binding.create_target_data(module.data_layout)
    for i, kind in enumerate(kinds):
        size = data.get_abi_size(declared.get_global_variable(f"k{i}").global_value_type)
        text = text.replace(f" = alloca {kind}, align", f" = alloca [{size} x i8], align")
    record = r"([{[<].*?[}\]>])"
    forms = "= alloca R, align", "= load R, ptr [%@]", "store R [%@<{z]", "getelementptr [a-z ]*?(?:R|(ptr)), (?:ptr|<)"
    if any("ptr" in "".join(kinds) for form in forms for kinds in re.findall(form.replace("R", record), text)):
        raise WrsimError("the code of a kernel depends on the size of pointers: it cannot be made for 32 bits")
    return binding.parse_assembly(text)


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
