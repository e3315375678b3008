"""How kernels are compiled: one place for numba's options.

``kernel`` for functions with work to do, ``inlined`` for the small ones that are called per strip or per sample: numba
does not inline across functions by itself, and a call with a dozen scalars in and eight out costs more than the
arithmetic inside (*measured*: a point of the contact locus 45 ns called, 19 ns inlined). LLVM does the inlining: each
function is typed once, wherever it is used (a quarter less time to compile than ``inline="always"``).

No fastmath: it would let the compiler drop tests for not-a-number. ``error_model="numpy"``: a division by zero gives
infinity, as in C, instead of a test at every division. Two kinds let the compiler take several numbers at once:
``reassociating_kernel`` is for long sums and nothing else, which it may add in another order; ``noalias_kernel`` for
loops that fill arrays which overlap no other argument.

numba makes machine code of every function that another one calls, with wrappers for Python around it, and optimises it
once more in every caller that it is linked into. Here what a kernel calls stays a *part* (`InlinedLibrary`), as it was
typed and lowered; the kernel that Python calls (`EntryLibrary`) gathers its parts and is optimised, made and kept once.
So only kernels can call kernels. What is called by number (jit.stages) has a library of its own. With
WRSIM_PLAIN_NUMBA=1 numba does all of it in its own way.
"""

import gc
import importlib
import inspect
import logging
import os
import time
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numba
from llvmlite import binding
from numba import prange as prange
from numba.core import compiler, event, sigutils, types, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.environment import lookup_environment
from numba.core.registry import CPUDispatcher

from wrsim.errors import InputError
from wrsim.jit.cache import CACHE, CONFIG, PLAIN, KernelCache
from wrsim.jit.pipeline import Flags, Pipeline, counts_references, holds_arrays, remembered_calls

F = TypeVar("F", bound=Callable[..., Any])

LOGGER = logging.getLogger("wrsim.kernels")
"""Says at level INFO how many kernels are compiled, of how many that are known to be needed; nothing at the end."""


class Count:
    """Kernels of this process that had to be compiled, by their functions, and how long that took."""

    def __init__(self) -> None:
        self.due: set[Any] = set()
        self.done: set[Any] = set()
        self.seconds = 0.0

    def begin(self, function: Any) -> None:
        """A kernel that Python calls is compiled, with all that it calls."""
        if LOGGER.isEnabledFor(logging.INFO):
            _gather(function, self.due)

    def end(self, function: Any, all_in_it: bool = False) -> None:
        """This one is compiled, or with all that it calls."""
        if all_in_it:
            _gather(function, self.done)
        self.done.add(function)
        if function in self.due:
            LOGGER.info("compiling kernels, once: %d of %d", len(self.done & self.due), len(self.due))
            if self.due <= self.done:
                LOGGER.info("")


def _gather(function: Any, functions: set[Any]) -> None:
    """Add a kernel's function and those of all kernels that it calls."""
    if function not in functions:
        functions.add(function)
        for thing in inspect.getclosurevars(function).globals.values():
            if isinstance(thing, Kernel):
                _gather(thing.py_func, functions)


COUNT = Count()


class InlinedLibrary(JITCodeLibrary):
    """A function for others to take in: neither optimised as a whole nor made into machine code."""

    def finalize(self) -> None:
        self._raise_if_finalized()
        self._finalized = True

    def parts(self, libraries: dict[Any, None]) -> None:
        """Add this and all that it calls to ``libraries``, those that are called first, each of them once."""
        for library in self._linking_libraries:
            if isinstance(library, InlinedLibrary) and library not in libraries:
                library.parts(libraries)
            libraries[library] = None
        libraries[self] = None


class EntryLibrary(InlinedLibrary):
    """A function that Python calls, with everything that it calls."""

    def finalize(self) -> None:
        libraries: dict[Any, None] = {}
        self.parts(libraries)
        del libraries[self]
        # callers first: LLVM takes in nothing that is not called yet
        self._linking_libraries = list(reversed(libraries))
        super(InlinedLibrary, self).finalize()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name)
            if environment is not None:
                self.codegen.set_env(variable.name, environment)

    def _optimize_final_module(self) -> None:
        """Drop arguments of parts that nothing reads, too: an array is passed as seven words or more, on the stack."""
        super()._optimize_final_module()
        for function in self._final_module.functions:
            if function.linkage == binding.Linkage.linkonce_odr:
                function.linkage = "internal"
        passes, builder = binding.create_new_module_pass_manager(), self.codegen._pass_builder()
        passes.add_ipsccp_pass()
        passes.add_dead_arg_elimination_pass()
        passes.add_instruction_combine_pass()
        passes.add_simplify_cfg_pass()
        passes.run(self._final_module, builder)


class Compiler(_FunctionCompiler):
    """Compiles into a library of this kind."""

    library: type[InlinedLibrary] = EntryLibrary
    noalias = False
    """Whether the arrays that the function is called with do not overlap."""

    def __init__(self, plain: _FunctionCompiler) -> None:
        """plain: numba's of the same function, which has read its signature: a fifth of a kernel's time."""
        self.__dict__.update(vars(plain), _failed_cache={})

    def _compile_core(self, args: Any, return_type: Any) -> Any:
        entry, began = self.library is EntryLibrary, time.perf_counter()
        if entry:
            COUNT.begin(self.py_func)
        collects = gc.isenabled()
        gc.disable()  # numba's types and blocks live on: to look through them takes a seventh of the time
        try:
            with remembered_calls():
                made = self._compiled(args, return_type, not entry and counts_references())
                if entry and holds_arrays(made.signature.return_type):  # Python owns them
                    made = self._compiled(args, return_type, True)
        finally:
            if collects:
                gc.enable()
        COUNT.end(self.py_func)
        if entry:  # its parts are compiled within
            COUNT.seconds += time.perf_counter() - began
        return made

    def _compiled(self, args: Any, return_type: Any, counting: bool) -> Any:
        """counting: references to arrays are counted."""
        description = self.targetdescr
        flags: Any = Flags()
        description.options.parse_as_flags(flags, self.targetoptions)
        flags.no_cfunc_wrapper = True
        flags.no_cpython_wrapper = flags.no_compile = self.library is InlinedLibrary
        flags.noalias, flags.nrt = self.noalias, counting
        library = self.library(description.target_context.codegen(), self.py_func.__qualname__)
        library.enable_object_caching()
        return compiler.compile_extra(
            description.typing_context, description.target_context, self.py_func, args, return_type, flags.one_of(),
            self.locals, library, Pipeline,
        )  # fmt: skip


class Kernel(CPUDispatcher):
    """A compiled function: an entry where Python calls it, a part where another kernel does. An argument decides by its
    type, not by its value: numba compiles for every literal number anew."""

    _compiler: Any

    def __init__(
        self, py_func: Any, locals: Any = None, targetoptions: Any = None, pipeline_class: Any = compiler.Compiler
    ) -> None:
        super().__init__(py_func, locals, targetoptions, pipeline_class)
        self._compiler, self._part_compiler = Compiler(self._compiler), Compiler(self._compiler)
        self._part_compiler.library = InlinedLibrary
        self._parts: dict[tuple[tuple[types.Type, ...], bool], Any] = {}

    @cached_property
    def _cache(self) -> KernelCache:
        """Made when it is asked for: most kernels are parts of others."""
        return KernelCache(self.py_func)

    def compile(self, sig: Any) -> Any:
        """For arguments of these types. The cache knows types in words under another key than those of a call."""
        return super().compile(sigutils.normalize_signature(sig)[0])

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """What another kernel's types ask for: see numba's dispatcher."""
        pysig, args = self._compiler.fold_argument_types(args, kws)
        args = tuple(types.unliteral(one) for one in args)
        name = self.py_func.__name__
        template = typing.make_concrete_template(name, key=name, signatures=[self._part(args).signature])
        return template, pysig, args, {}

    def get_overload(self, sig: Any) -> Any:
        """The part of these types in numba's registers."""
        return self._part(tuple(sig)).fndesc

    def _part(self, args: Any) -> Any:
        key = args, counts_references()
        if key not in self._parts:
            with self._compiling_counter, event.trigger_event("numba:compile", {"dispatcher": self, "args": args}):
                part = self._parts[key] = self._part_compiler.compile(args, None)
            self.targetctx.insert_user_function(part.fndesc, part.fndesc, [part.library])
        return self._parts[key]


def is_cached(kernel: Any) -> bool:
    """Whether compiled code of this kernel is at hand: in the user's cache, or with the package."""
    cache = kernel._cache
    return isinstance(cache, KernelCache) and (
        cache.shipped is not None or os.path.exists(cache._cache_file._index_path)
    )


def _declared(plain: bool = PLAIN, noalias: bool = False, **options: Any) -> Callable[[F], F]:
    """plain: numba compiles in its own way, which knows no ``noalias``."""

    def declare(function: F) -> F:
        if CONFIG.DISABLE_JIT:
            return function
        options.update(nopython=True, error_model="numpy")
        made: Any = numba.jit(**options)(function) if plain else Kernel(function, targetoptions=dict(options))
        if not plain:
            made._compiler.noalias = made._part_compiler.noalias = noalias
        if CACHE and plain:
            made._cache = KernelCache(function)
        elif CACHE:
            del made._cache  # numba's, which keeps nothing
        return made

    return declare


kernel = _declared()
inlined = _declared(forceinline=True)
reassociating_kernel = _declared(fastmath={"reassoc", "nsz"})
noalias_kernel = _declared(noalias=True)
released = _declared(nogil=True)
"""A kernel that runs while other threads of Python do."""

parallel = _declared(plain=True, parallel=True)
"""A kernel that Python or a stage calls, whose ``prange`` loops run on the threads of `use_threads`."""

SPINS = "1000"
"""Turns, of some 20 ns, in which a thread waits awake for work: about as long as it takes to wake one that sleeps."""


def cores() -> int:
    """Largest number of threads on this machine."""
    return int(CONFIG.NUMBA_NUM_THREADS)


def use_threads(count: int) -> None:
    """From now on parallel kernels of this process run on so many threads. Raises InputError where they cannot. OpenMP
    hands work over and back in 1.4 us while threads wait awake, numba's own queue of work in some 140."""
    if not 1 <= count <= cores():
        raise InputError(f"threads: must be a whole number from 1 to {cores()}, the cores of this machine, not {count}")
    if count > 1 and not CONFIG.DISABLE_JIT:
        os.environ.setdefault("GOMP_SPINCOUNT", SPINS)  # read when the library is loaded
        try:
            importlib.import_module("numba.np.ufunc.omppool")
        except ImportError:
            needed = f"threads: {count} need OpenMP (Debian's libgomp1), which is not found; 1 needs none"
            raise InputError(needed) from None
        CONFIG.THREADING_LAYER = "omp"
        numba.set_num_threads(count)
