"""Rest state of a force law: damped Newton's method on the very function that the time integration uses.

The law is asked for the generalised forces of a state; those belonging to the equations in hand must vanish.
Any coordinate or rate may be an unknown, so that the same function finds a wheelset standing on the track,
rolling straight at a spin rate to be found, or held at a given shift. Inertia forces are not added: the
state must be one without acceleration (straight track, or a standing wheelset), or the law must contain them
(``wrsim.simulation.steady``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from wrsim.errors import SimulationError
from wrsim.simulation.system import COORDINATES, Array, ForceLaw

RATES = tuple(f"{name}_rate" for name in COORDINATES)
"""Names of the rates of the coordinates, as unknowns."""

STATES = COORDINATES + RATES

LENGTH = 1.0
"""Lever that turns moments into forces where residuals are compared [m]."""

SMALL = {"z": 1e-5, "x": 1e-2, "y": 1e-4, "heading": 1e-4, "roll": 1e-5, "spin": 1e-2}
"""Change of a coordinate [m, rad], or of its rate per second, that changes the forces by a few per cent."""

DIFFERENCE = 0.01
"""Step of the numerical derivative as a part of ``SMALL``."""

LONGEST = 30.0
"""Longest step of one iteration, in units of ``SMALL``."""

SEARCH_HEIGHT = 0.05
"""How far a wheelset is lowered or raised in search of the rails [m]."""

SEARCH_ROLL = 0.05
"""How far it is rolled in search of the other rail [rad]."""


@dataclass(frozen=True)
class Equilibrium:
    """A state without acceleration: q, q_t (6 per body); largest residual over the weight; Newton's iterations."""

    q: Array
    q_t: Array
    residual: float
    iterations: int


def _index(name: str, size: int) -> int:
    """Place of an unknown in (q, q_t): a name of ``STATES``, with ``@n`` behind it for body n."""
    base, _, body = name.partition("@")
    place = 6 * int(body or 0) + STATES.index(base) % 6
    return place + (size if base in RATES else 0)


def _words(residual: Array, equations: Sequence[str], unknowns: Sequence[str], x: Array) -> str:
    """The residuals and the state where the search ended."""
    forces = ", ".join(f"{name} {value:.3g}" for name, value in zip(equations, residual, strict=True))
    state = ", ".join(f"{name} {value:.6g}" for name, value in zip(unknowns, x, strict=True))
    return f"remaining forces over the weight: {forces}; at {state}"


def find_equilibrium(
    forces: ForceLaw,
    q: Array,
    q_t: Array,
    unknowns: Sequence[str],
    *,
    weight: float,
    equations: Sequence[str] | None = None,
    t: float = 0.0,
    tolerance: float = 1e-9,
    max_iterations: int = 60,
) -> Equilibrium:
    """Find the state near (q, q_t) where the generalised forces of the given equations vanish.

    q, q_t: (6 per body,) guess, kept where not unknown. unknowns: names of ``STATES`` to be found, for
    example ``("z", "y", "heading", "roll", "spin_rate")`` for a wheelset rolling straight; ``"z@1"`` means body 1.
    equations: the coordinates whose forces must vanish, default those of the unknowns (a rate stands for its
    coordinate). weight [N]: the scale of forces; moments are divided by weight times 1 m.
    tolerance: largest scaled force.

    A wheelset that hangs above the rails is first lowered until they carry it.
    Raises SimulationError when the forces do not vanish, naming those that remain and the state.
    """
    state = np.concatenate([np.array(q, dtype=float), np.array(q_t, dtype=float)])
    size = state.size // 2
    if equations is None:
        equations = [name.replace("_rate", "") for name in unknowns]
    if len(equations) != len(unknowns) or not unknowns:
        raise ValueError(f"{len(equations)} equations for {len(unknowns)} unknowns")
    columns = np.array([_index(name, size) for name in unknowns])
    rows = np.array([_index(name, size) for name in equations])
    small = np.array([SMALL[name.partition("@")[0].replace("_rate", "")] for name in unknowns])
    scale = np.where(rows % 6 < 3, 1.0 / weight, 1.0 / (weight * LENGTH))
    out = np.zeros(size)
    names = [name.partition("@")[0] for name in unknowns]

    def residual(x: Array) -> Array:
        state[columns] = x
        forces(t, state[:size], state[size:], out)
        return out[rows] * scale

    x = state[columns].copy()
    r = residual(x)
    if not np.all(np.isfinite(r)):
        raise SimulationError("equilibrium: the forces are not finite; " + _words(r, equations, unknowns, x))
    equation = {int(row): i for i, row in enumerate(rows)}
    for place, column in enumerate(columns):
        if names[place] == "z" and column in equation:
            roll = int(column) + STATES.index("roll")
            tilt = list(columns).index(roll) if roll in columns and roll in equation else -1
            _stand(residual, x, place, equation[int(column)], tilt, equation.get(roll, -1))
    x, r, iterations = newton(residual, x, small, tolerance, max_iterations)
    largest = float(np.max(np.abs(r)))
    if not largest <= tolerance:
        raise SimulationError("equilibrium not found; " + _words(r, equations, unknowns, x))
    return Equilibrium(state[:size].copy(), state[size:].copy(), largest, iterations)


def newton(
    residual: Callable[[Array], Array], x: Array, small: Array, tolerance: float, max_iterations: int
) -> tuple[Array, Array, int]:
    """Damped Newton's method: the best x, its residual (evaluated last), the iterations; the caller judges."""
    r = residual(x)
    damping = 0.0
    iteration = 0
    while iteration < max_iterations and np.max(np.abs(r)) > tolerance:
        iteration += 1
        jacobian = _jacobian(residual, x, small)
        for _ in range(15):
            step = _solve(jacobian, -r, damping)
            step *= min(1.0, LONGEST / float(np.max(np.abs(step))))
            trial = residual(x + small * step)
            if np.linalg.norm(trial) < np.linalg.norm(r):  # false for not-a-number
                break
            damping = max(10.0 * damping, 1e-6)
        else:
            break
        x = x + small * step
        r = trial
        damping = 0.1 * damping if damping > 1e-6 else 0.0
    return x, residual(x), iteration


def _jacobian(residual: Callable[[Array], Array], x: Array, small: Array) -> Array:
    """Derivative of the residual with respect to x / small, by central differences."""
    columns = []
    for i in range(x.size):
        h = np.zeros(x.size)
        h[i] = DIFFERENCE * small[i]
        columns.append((residual(x + h) - residual(x - h)) / (2.0 * DIFFERENCE))
    return np.array(columns).T


def _solve(jacobian: Array, right: Array, damping: float) -> Array:
    """Levenberg's step; undamped the shortest least-squares one: the undetermined stays where it is."""
    if damping == 0.0:
        return np.asarray(np.linalg.lstsq(jacobian, right, rcond=1e-12)[0], dtype=float)
    normal = jacobian.T @ jacobian
    return np.linalg.solve(normal + damping * np.trace(normal) * np.eye(jacobian.shape[1]), jacobian.T @ right)


def bracket(function: Callable[[float], float], begin: float, small: float, enough: float, reach: float) -> bool:
    """Move from ``begin`` as the sign of the force points until it is small or changes sign, then bisect.

    function: force along a coordinate. Stops with its last call where abs(force) <= enough; False if there
    is no such place within ``reach``.
    """
    force = function(begin)
    if abs(force) <= enough:
        return True
    sign = 1.0 if force > 0.0 else -1.0
    inner, outer, move = begin, begin, small
    while force * sign > 0.0:
        if not move <= reach:
            return False
        inner, outer = outer, begin + sign * move
        force = function(outer)
        move *= 1.5
    for _ in range(80):
        if abs(force) <= enough:
            break
        middle = 0.5 * (inner + outer)
        force = function(middle)
        if force * sign > 0.0:
            inner = middle
        else:
            outer = middle
    return bool(np.isfinite(force))


def _stand(residual: Callable[[Array], Array], x: Array, place: int, row: int, tilt: int, tilt_row: int) -> None:
    """Set the height x[place] so that the rails carry about the weight, and the roll x[tilt] so that both do.

    Newton's method does not find its way from a wheelset in the air or on one wheel.
    """

    def seat(roll: float | None = None) -> float:
        if roll is not None:
            x[tilt] = roll

        def excess(height: float) -> float:
            x[place] = height
            return float(residual(x)[row])

        begin = float(x[place])
        if not bracket(excess, begin, SMALL["z"], 0.5, SEARCH_HEIGHT):
            raise SimulationError(
                "equilibrium: the rails do not carry the wheelset anywhere within "
                f"{1e3 * SEARCH_HEIGHT:.0f} mm of z = {begin:.6g} m; is it above the rails?"
            )
        return float(residual(x)[tilt_row])

    if tilt < 0:
        seat()
    else:
        bracket(seat, float(x[tilt]), SMALL["roll"], 0.1, SEARCH_ROLL)
