"""Kernels that others call by a number, through a table of addresses: `run`.

What is called by its name is compiled into its caller. A stage is compiled once, by itself, and only when it is asked
for (``make_ready``): the contact is not in the machine code of a vehicle, a normal model that is not chosen is in none.
The table belongs to the process and grows with the numbers. Compiled code knows the place that holds its address by the
name of a symbol, so that numbers are kept in the workspaces and in the cache, never addresses. A number that was not
made ready must not be run: there is no address yet.
"""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.extending import intrinsic

from wrsim.jit.arena import Array, Ints
from wrsim.jit.cache import CACHE, CALL, CONFIG, python_process
from wrsim.jit.compiling import COUNT, cores, is_cached

SYMBOL = "wrsim_stages"
ARGUMENTS = types.float64[::1], types.int64[:, ::1]
"""Of every stage: the buffer and the index of a workspace. It returns a status."""

_tables = [np.zeros(8, np.int64)]
"""The table of addresses, behind the smaller ones before it: a thread may still read these."""
_table_address = np.array([_tables[-1].ctypes.data], np.int64)
_stages: dict[int, Any] = {}
binding.add_symbol(SYMBOL, _table_address.ctypes.data)


def make_ready(number: int, kernel: Any) -> None:
    """From now on ``run(number, ...)`` runs this kernel; compiles it, or takes it from the cache."""
    if _stages.get(number) is kernel:
        return
    if not CONFIG.DISABLE_JIT:
        kernel.compile(ARGUMENTS)
        overload = kernel.overloads[ARGUMENTS]
        if types.unliteral(overload.signature.return_type) != types.int64:
            raise TypeError(f"the stage {kernel.__name__} returns {overload.signature.return_type}, not a status")
        if number >= _tables[-1].size:
            _tables.append(np.concatenate((_tables[-1], np.zeros(number + 1, np.int64))))
        _tables[-1][number] = overload.library.get_pointer_to_function(overload.fndesc.llvm_func_name)
        _table_address[0] = _tables[-1].ctypes.data
    _stages[number] = kernel


@contextmanager
def compile_in_background(stage: Any) -> Iterator[bool]:
    """While this lasts another process compiles a stage into the cache, which is waited for at the end. Not where it is
    there already, or there is one processor: False. If that process fails the stage is compiled when it is asked for.
    """
    if CACHE is None or CONFIG.DISABLE_JIT or cores() < 2 or is_cached(stage):
        yield False
        return
    function = stage.py_func
    code = (
        f"from {function.__module__} import {function.__name__} as stage; from {__name__} import ARGUMENTS; "
        "stage.compile(ARGUMENTS)"
    )
    process = subprocess.Popen(**python_process(code), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield True
        process.wait()
        COUNT.end(function, all_in_it=True)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def repeat_calls(folder: str) -> None:
    """End the process with 0 if the calls that came with shipped kernels give the same again, to the bit: each of the
    first of the stages that it takes, by their numbers in the table STAGES of a module."""
    paths = sorted(Path(folder).glob(CALL.format("*")))
    for path in paths:
        with np.load(path) as stored:
            table, numbers = import_module(str(stored["module"])).STAGES, stored["stages"].tolist()
            for number in numbers:
                make_ready(number, table[number])
            buffer, index = stored["before"].copy(), stored["index"].copy()
            status = table[numbers[0]](buffer, index)
            if status != stored["status"] or buffer.tobytes() != stored["after"].tobytes():
                sys.exit(1)
    sys.exit(0 if paths else 1)


def _run(number: int, buffer: Array, index: Ints) -> int:
    """Run a stage in a workspace; returns its status."""
    return _stages[number](buffer, index)


def _call(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Code for a call of the address in the table under a number."""
    number, *workspace = args
    convention, word = context.call_conv, ir.IntType(64)
    kind = convention.get_function_type(types.int64, ARGUMENTS).as_pointer()
    table_address = builder.module.globals.get(SYMBOL)
    if table_address is None:
        table_address = ir.GlobalVariable(builder.module, word, SYMBOL)
    # whole numbers of 64 bits, also where pointers are shorter
    place = builder.add(builder.load(table_address), builder.shl(number, word(3)))
    stage = builder.inttoptr(builder.load(builder.inttoptr(place, word.as_pointer())), kind)
    _, status = convention.call_function(builder, stage, types.int64, ARGUMENTS, workspace)
    return status


@intrinsic
def _run_compiled(_context: Any, number: Any, buffer: Any, index: Any) -> Any:
    """As `_run`."""
    return types.int64(types.int64, *ARGUMENTS), _call


run: Any = _run if CONFIG.DISABLE_JIT else _run_compiled
