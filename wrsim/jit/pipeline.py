"""How a kernel becomes code: numba's passes without those that kernels have no use for.

Three quarters of numba's time to compile is its own Python. Kernels have no closures, no context managers, nothing to
unroll and no literals to propagate, so these passes are left out, and with them the analyses of variables that numba
makes after every pass. Kernels allocate no memory (all arrays lie in workspaces): references to arrays are counted
where a kernel returns some to Python, and nowhere else.

The types of calls are resolved once: numba asks all candidates for every operator (some fifty for ``+``) at every
place where it stands, and computes a hash of all options for each.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from numba.core import compiler, transforms, types
from numba.core.analysis import dead_branch_prune, rewrite_semantic_constants
from numba.core.ir_utils import legalize_single_scope
from numba.core.rewrites import rewrite_registry, static_getitem
from numba.core.targetconfig import ConfigStack
from numba.core.typed_passes import NativeLowering, NoPythonBackend, PreLowerStripPhis, type_inference_stage
from numba.core.untyped_passes import FixupArgs, ReconstructSSA, TranslateByteCode

PLAIN = types.Number, types.Boolean, types.Literal, types.Array, types.Record, types.BaseTuple, types.DType
"""Kinds of arguments whose types alone decide what a call returns."""


MEMORY: dict[int, tuple[Any, dict[Any, Any]]] = {}
"""What calls return, of all functions so far, by their identity."""

RESOLVE: Any = types.BaseFunction.get_call_type


class Flags(compiler.Flags):
    """Options, one object for the same ones (`one_of`): its hash costs nothing."""

    made: ClassVar[dict[Any, "Flags"]] = {}

    def one_of(self) -> "Flags":
        """The object for these options, which must not be changed."""
        return self.made.setdefault(tuple(map(repr, self.values().items())), self)

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other


def counts_references() -> bool:
    """Whether references to arrays are counted in the kernel that is being compiled, and in its parts."""
    flags = ConfigStack.top_or_none()
    return flags is not None and flags.nrt


def holds_arrays(kind: types.Type) -> bool:
    """Whether something of this type is an array, or a tuple of such."""
    parts: Any = kind if isinstance(kind, types.BaseTuple) else ()
    return isinstance(kind, types.Array) or any(map(holds_arrays, parts))


class Pipeline(compiler.CompilerBase):
    """Compiles one kernel."""

    def _compile_core(self) -> Any:
        state = self.state
        with ConfigStack().enter(state.flags):
            TranslateByteCode().run_pass(state)
            FixupArgs().run_pass(state)
            _order(state)
            rewrite_semantic_constants(state.func_ir, state.args)
            dead_branch_prune(state.func_ir, state.args)
            _rewrite(state, rewrite_registry.rewrites["before-inference"])
            ReconstructSSA().run_pass(state)
            state.typemap, state.return_type, state.calltypes, _ = type_inference_stage(
                state.typingctx, state.targetctx, state.func_ir, state.args, state.return_type, state.locals
            )
            PreLowerStripPhis().run_pass(state)
            rewrites = rewrite_registry.rewrites["after-inference"]
            _rewrite(state, [one for one in rewrites if one.__module__ == static_getitem.__name__])
            NativeLowering().run_pass(state)
            NoPythonBackend().run_pass(state)
        return state.cr


def _order(state: Any) -> None:
    """Bring the blocks of the code into their canonical form."""
    state.func_ir.blocks = transforms.canonicalize_cfg(state.func_ir.blocks)
    legalize_single_scope(state.func_ir.blocks)


def _rewrite(state: Any, kinds: Any) -> None:
    """Apply rewrites of the code as long as they find something."""
    blocks = state.func_ir.blocks
    for kind in kinds:
        rewrite, work = kind(state), list(blocks.items())
        while work:
            key, block = work.pop()
            if rewrite.match(state.func_ir, block, state.typemap, state.calltypes):
                blocks[key] = rewrite.apply()
                work.append((key, blocks[key]))
    _order(state)


def _remembered(self: Any, context: Any, args: Any, kws: Any) -> Any:
    """What a call returns: as numba resolves it, once for the same function, types and options."""
    if kws or not all(isinstance(one, PLAIN) for one in args):
        return RESOLVE(self, context, args, kws)
    _, memory = MEMORY.setdefault(id(self), (self, {}))
    key = args, ConfigStack.top_or_none()
    if key not in memory:
        memory[key] = RESOLVE(self, context, args, kws)
    return memory[key]


@contextmanager
def remembered_calls() -> Iterator[None]:
    """While this lasts, what calls return is remembered."""
    functions: Any = types.BaseFunction
    before, functions.get_call_type = functions.get_call_type, _remembered
    try:
        yield
    finally:
        functions.get_call_type = before
