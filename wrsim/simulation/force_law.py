"""What a force law is, and the derivatives of its forces, block by block where it is a sum of blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.workspace import WARM_TOLERANCE
from wrsim.vehicle.dynamics import derivative as k
from wrsim.vehicle.elements import Array
from wrsim.vehicle.equivalent import Stroke

Groups = Sequence[tuple[NDArray[np.intp], NDArray[np.intp]]]
"""Groups of places (n,) that may be changed at once, each of which acts on its own row of places (n, m) alone."""

COORDINATES = ("z", "x", "y", "heading", "roll", "spin")
"""Names of the six coordinates of a body, in the order of q and q_t [m, rad]."""

SMALL = {"z": 1e-7, "x": 1e-6, "y": 1e-6, "heading": 1e-6, "roll": 1e-7, "spin": 1e-4}
"""Difference of a coordinate [m, rad] for its derivative: it changes the forces by some 1e-4 of them."""

SMALL_RATE = 1e-4
"""The same of a rate [m/s, rad/s]."""

SMALL_EXTENSION = 1e-4
"""The same of the extension of a damper in series with a spring [m], and of the pitch of an axle box and the twist of
an axle [rad]; forces are linear in it or nearly so."""

SMALL_SLIP = 1e-7
"""The same of the unknowns of sliders [m]: their forces saturate within a part of a millimetre."""

DIFFERENCE_TOLERANCE = 0.03
"""To which part of their tolerance contacts are solved for differences."""

Forces = Callable[[float, Array, Array, Array], object]
"""Generalised forces at a time [s], coordinates and rates, filled into the last argument."""


class ForceLaw:
    """Generalised forces on all bodies: those of a function, or of a subclass, which may know more of them.

    Called with the time [s], the coordinates q and rates q_t (6 per body; read-only views of the solver's state) and
    ``out`` of the same length to fill: forces along z, x, y [N], moments about the vertical, the forward direction and
    the axle [N m]. A law that cannot go on raises ``SimulationError``, which ends the run in good order.

    units: vehicles in a row, each of which acts on its neighbours alone. dampers: unknowns behind the coordinates of
    the bodies; the last ``positions`` of them are positions, of axle boxes, twisted axles and rails; the last ``rails``
    of these are displacements of rails. sliders: places of the unknowns of friction; wagons: of mass times way of
    vehicles that move along the track alone, whose masses [kg] follow.
    """

    units = 1
    explicit = True
    """Whether its forces belong to a state alone, so that an explicit method can take a step."""
    dampers = positions = rails = 0
    sliders: NDArray[np.intp] = np.zeros(0, dtype=np.intp)
    wagons: NDArray[np.intp] = np.zeros(0, dtype=np.intp)
    masses: Array = np.zeros(0)

    def __init__(self, function: Forces) -> None:
        self._function = function

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> object:
        return self._function(t, q, q_t, out)

    def follow(self, on: bool, tolerance: float = WARM_TOLERANCE) -> None:
        """Start every call from the solution of the last one (a warm start, faster in a run), or without it.

        tolerance: of the force, in parts of it.
        """

    @contextmanager
    def following(self, tolerance: float = WARM_TOLERANCE) -> Iterator[None]:
        """While this lasts, warm starts."""
        self.follow(True, tolerance)
        try:
            yield
        finally:
            self.follow(False)

    def begin_step(self, step: float, q: Array, q_t: Array, q_tt: Array, again: bool) -> None:
        """Called ahead of an implicit step [s], with the solver's own first guess of its end, which it may change;
        again: the solver begins the same step once more."""

    def hold(self, first: bool, tolerance: float, last: Array, q: Array, q_t: Array, q_tt: Array) -> bool:
        """Called ahead of the forces of an iteration but the first of a step, which it may change; first: call of this
        step; tolerance [N]; last: q at the last iteration. Returns whether it has changed any."""
        return False

    def end_step(self, q: Array, q_t: Array) -> None:
        """Called after such a step with the state at its end, of which it may write rates that are not
        integrated."""

    def equivalent(self, stroke: Stroke, t: float, q: Array, q_t: Array) -> AbstractContextManager[None]:
        """While this lasts, elements are those that are equivalent at this state, and linear."""
        return nullcontext()

    def blocks(self) -> Sequence[Block]:
        """The blocks whose sum the law is; empty if it is one piece."""
        return ()

    def coordinates_of_units(self, alone: bool = False) -> Sequence[NDArray[np.intp]]:
        """Places of the unknowns of every vehicle in a row; alone: without those of couplings."""
        return ()

    def preserve_state(self) -> AbstractContextManager[None]:
        """Calls while this lasts do not change the state of the law, and are sharp enough for differences."""
        return nullcontext()

    def memory(self) -> Sequence[NDArray[Any]]:
        """Views of all data beside time and coordinates that the next result depends on, to the last bit."""
        return ()

    def get_state(self) -> Array:
        """A copy of its memory as one row."""
        return np.concatenate([np.zeros(0), *(np.ravel(view) for view in self.memory())])

    def set_state(self, state: Array) -> None:
        place = 0
        for view in self.memory():
            view[...] = state[place : place + view.size].reshape(view.shape)
            place += view.size


class Block:
    """One term of a law's sum, and which coordinates may be changed at once because their effects are separate."""

    def __init__(self, forces: Forces, groups: Groups) -> None:
        self.forces, self.groups = forces, groups

    def add_differences(self, t: float, central: bool, work: Array, matrix: Array) -> None:
        """Add the derivative of its forces to the matrix (size, size); work: see ``dynamics.derivative``."""
        state, rate, up, down = work[k.STATE], work[k.RATE], work[k.UP], work[k.DOWN]
        if not central:
            self.forces(t, state, rate, down)
        for columns, rows in self.groups:
            for by, out in ((1.0, up), (-1.0, down))[: 1 + central]:
                state[columns] = work[k.HERE, columns] + by * work[k.MORE, columns]
                rate[columns] = work[k.HERE_RATE, columns] + by * work[k.MORE_RATE, columns]
                self.forces(t, state, rate, out)
            state[columns], rate[columns] = work[k.HERE, columns], work[k.HERE_RATE, columns]
            matrix[rows, columns[:, None]] += (up - down)[rows] / work[k.SPAN, columns, None]


def all_on_all(size: int) -> Groups:
    """Groups of one coordinate each, which may act on all."""
    return [(np.array([i]), np.arange(size)[None]) for i in range(size)]


def groups_in_a_row(units: Sequence[NDArray[np.intp]]) -> Groups:
    """Groups of the coordinates of things in a row, of which each acts on itself and its neighbours."""
    longest = max(map(len, units))
    groups: list[tuple[list[int], list[NDArray[np.intp]]]] = [([], []) for _ in range(min(3, len(units)) * longest)]
    near = [np.concatenate(units[max(i - 1, 0) : i + 2]) for i in range(len(units))]
    widest = max(map(len, near))
    for i, coordinates in enumerate(units):  # a duplicate row is written twice alike
        rows = np.concatenate([near[i], np.full(widest - len(near[i]), near[i][0])])
        for j, place in enumerate(coordinates):
            columns, of_columns = groups[i % 3 * longest + j]
            columns.append(int(place))
            of_columns.append(rows)
    return [(np.array(columns), np.array(rows)) for columns, rows in groups if columns]


def force_derivative(
    forces: ForceLaw,
    q: Array,
    q_t: Array,
    bodies: int,
    t: float = 0.0,
    by_q: float = 1.0,
    by_q_t: float = 0.0,
    central: bool = True,
) -> Array:
    """Derivative of the generalised forces (n, n): by_q times that with respect to q and by_q_t times that to q_t.

    By differences of both at once: central ones, or forward ones at half the cost, enough for Newton's method.
    """
    n, rails, positions = len(q), forces.rails, forces.positions
    dampers = slice(6 * bodies, n - positions)
    change, change_t = np.full(n, SMALL_EXTENSION), np.full(n, SMALL_RATE)
    change[: 6 * bodies] = np.tile([SMALL[name] for name in COORDINATES], bodies)
    change[n - rails :] = np.tile([SMALL["y"], SMALL["z"]], rails // 2)
    change[dampers] = np.inf  # these coordinates have no meaning, their rates are extensions
    change_t[dampers] = SMALL_EXTENSION
    change_t[forces.sliders] = SMALL_SLIP
    change[forces.wagons], change_t[forces.wagons] = SMALL["x"] * forces.masses, SMALL_RATE * forces.masses
    with np.errstate(divide="ignore"):
        step = np.minimum(change / abs(by_q), change_t / abs(by_q_t))
    step[~np.isfinite(step)] = SMALL_EXTENSION
    matrix, work = np.zeros((n, n)), np.zeros((k.ROWS, n))
    work[[k.HERE, k.STATE]], work[[k.HERE_RATE, k.RATE]] = q, q_t
    work[k.MORE], work[k.MORE_RATE], work[k.SPAN] = by_q * step, by_q_t * step, (2.0 if central else 1.0) * step
    with forces.preserve_state():
        for block in forces.blocks() or (Block(forces, all_on_all(n)),):
            block.add_differences(t, central, work, matrix)
    return matrix
