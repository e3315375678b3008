"""Kernels that others call by a number, through a table of addresses: `run`.

What is called by its name is compiled into its caller. A stage is compiled once, by itself, and only when it is asked
for (``make_ready``): the contact is not in the machine code of a vehicle, a normal model that is not chosen is in none.
The table belongs to the process and compiled code knows it by the name of a symbol, so that numbers are kept in the
workspaces and in the cache, never addresses. A number that was not made ready must not be run: there is no address yet.
"""

from typing import Any

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.extending import intrinsic

from wrsim.jit.arena import Array, Ints
from wrsim.jit.cache import CONFIG

MOST = 8
SYMBOL = "wrsim_stages"
ARGUMENTS = types.float64[::1], types.int64[:, ::1]
"""Of every stage: the buffer and the index of a workspace. It returns a status."""

_addresses = np.zeros(MOST, np.int64)
_stages: dict[int, Any] = {}
binding.add_symbol(SYMBOL, _addresses.ctypes.data)


def make_ready(number: int, kernel: Any) -> None:
    """From now on ``run(number, ...)`` runs this kernel; compiles it, or takes it from the cache."""
    if _stages.get(number) is kernel:
        return
    if not CONFIG.DISABLE_JIT:
        kernel.compile(ARGUMENTS)
        found = kernel.overloads[ARGUMENTS]
        if types.unliteral(found.signature.return_type) != types.int64:
            raise TypeError(f"the stage {kernel.__name__} returns {found.signature.return_type}, not a status")
        _addresses[number] = found.library.get_pointer_to_function(found.fndesc.llvm_func_name)
    _stages[number] = kernel


def _run(number: int, buffer: Array, index: Ints) -> int:
    """Run a stage in a workspace; returns its status."""
    return _stages[number](buffer, index)


def _call(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Code for a call of the address in the table under a number."""
    number, *workspace = args
    word = ir.IntType(64)
    table = builder.module.globals.get(SYMBOL)
    if table is None:
        table = ir.GlobalVariable(builder.module, ir.ArrayType(word, MOST), SYMBOL)
    convention = context.call_conv
    kind = convention.get_function_type(types.int64, ARGUMENTS)
    address = builder.load(builder.gep(table, [word(0), number]))
    called = builder.inttoptr(address, kind.as_pointer())
    _, status = convention.call_function(builder, called, types.int64, ARGUMENTS, workspace)
    return status


@intrinsic
def _run_compiled(_context: Any, number: Any, buffer: Any, index: Any) -> Any:
    """As `_run`."""
    return types.int64(types.int64, *ARGUMENTS), _call


run: Any = _run if CONFIG.DISABLE_JIT else _run_compiled
