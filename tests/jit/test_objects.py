"""Machine code of stages for other systems: made of the same optimised code, for each system in its own format."""

import struct

import numba
import pytest
from llvmlite import binding

from wrsim import WrsimError
from wrsim.contact import records as k
from wrsim.contact.wheel_rail import STAGES
from wrsim.jit.objects import TARGETS, _without_pointer_sizes, emit_constant, emit_objects, this_target

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing compiled")

MACHINES = {
    "linux": struct.pack("<H", 62), "linux-arm": struct.pack("<H", 183), "windows": struct.pack("<H", 0x8664),
    "macos": struct.pack("<II", 0xFEEDFACF, 0x0100000C), "wasm": b"\0asm",
}  # fmt: skip
PLACES = {"linux": 18, "linux-arm": 18}
"""Where a file of each format names the machine: in ELF behind 18 bytes, else first."""


@pytest.mark.parametrize("target", TARGETS)
def test_a_stage_is_machine_code_of_each_system_and_level(target):
    objects = emit_objects({"wrsim_creep": STAGES[k.CREEP_FORCES]}, target)
    assert len(objects) == len(TARGETS[target].levels)
    for level, code in enumerate(objects):
        assert code[PLACES.get(target, 0) :].startswith(MACHINES[target])
        assert f"wrsim_creep_{level}".encode() in code
    assert len(set(objects)) == len(objects)


@pytest.mark.parametrize("target", TARGETS)
def test_a_constant_lies_in_an_object_as_it_is(target):
    content = bytes(range(256)) * 3
    code = emit_constant("wrsim_constant", content, target)
    assert content in code and b"wrsim_constant" in code
    assert code[PLACES.get(target, 0) :].startswith(MACHINES[target])


def parsed(line):
    """Code of one function for pointers of 64 bits, with this line in it."""
    layout = 'target datalayout = "e-p:64:64-i64:64"'
    return binding.parse_assembly(f"{layout}\ndefine void @f(ptr %a, i64 %n) {{\n  {line}\n  ret void\n}}")


def test_records_of_pointers_keep_their_room_where_pointers_are_shorter():
    made = str(_without_pointer_sizes(parsed("%b = alloca { ptr, { ptr, i64 }, [2 x ptr] }, align 8")))
    assert "alloca [40 x i8], align 8" in made
    for line in ("%b = load { i64, ptr }, ptr %a, align 8", "%b = getelementptr inbounds ptr, ptr %a, i64 %n",
                 "%b = load <2 x ptr>, ptr %a, align 8"):  # fmt: skip
        with pytest.raises(WrsimError, match="depends on the size of pointers"):
            _without_pointer_sizes(parsed(line))


def test_a_machine_that_is_no_target_is_named(monkeypatch):
    monkeypatch.setattr("platform.machine", lambda: "riscv64")
    with pytest.raises(WrsimError, match="riscv64: no machine code is made for it; for linux, linux-arm, windows"):
        this_target()
