"""Equations of equilibrium: damped Newton's method, a bracketing search, and pseudo-transient continuation."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim.errors import SimulationError
from wrsim.simulation.force_law import Array, Groups, all_on_all

DIFFERENCE = 0.01
"""Step of the numerical derivative as a part of the small changes."""

LONGEST = 30.0
"""Longest step of one iteration, in small changes."""

PROBE, BENT = 0.1, 0.5
"""Where along a step its curvature is evaluated, and the largest curvature correction as a part of the step."""

Terms = Sequence[tuple[Callable[[Array], Array], Groups]]
"""Functions whose sum has the derivatives of a residual, each with the unknowns that may be changed at once."""

REUSED = 0.1
"""Derivatives are used for another step as long as a step reduces the residual to this part."""

HALVINGS, FALL = 6, 0.25
"""Most halvings of a step, and the least fall of the residual as a part of the one that the step's part foretells."""

STALLED, LITTLE = 20, 0.1
"""The search ends where so many iterations have not reduced the residual by this part."""


def damped_newton(
    residual: Callable[[Array], Array],
    x: Array,
    small: Array,
    tolerance: float,
    max_iterations: int,
    terms: Terms | None = None,
    while_deriving: Callable[[], AbstractContextManager[None]] = nullcontext,
    difference: float | Array = DIFFERENCE,
    held: Array | None = None,
) -> tuple[Array, Array, int]:
    """The best x, its residual (evaluated last), number of derivatives; the caller decides on convergence.

    small: changes of the unknowns that change the residual by a few per cent. terms: of the derivatives, default the
    residual itself, by one unknown after the other. while_deriving: a context for the derivatives. difference: steps of
    the derivatives as parts of the small changes. held: springs on the unknowns in the derivatives alone, per small
    change; with them the equations are sparse, and a step becomes shorter along its own direction ahead of any damping.

    Friction of a coupling is stiff where it sticks and yields nothing where it slips: a step from slip leads far beyond
    the place where it sticks. Levenberg's damping goes by the trace of all equations, in which the contacts are by far
    the stiffest: its smallest value stops the bodies of a train, which have to move.

    Steps follow the curvature of the residual along them (geodesic acceleration, Transtrum and Sethna 2012, arXiv
    1201.5885): a wheelset that moves across its rails is on a curved path between stiff contacts.
    """
    r = residual(x)
    terms = terms or [(residual, all_on_all(x.size))]
    damping = 0.0
    jacobian = None
    norms: list[float] = []
    while np.max(np.abs(r)) > tolerance:
        if jacobian is not None and damping == 0.0:
            step = _step(jacobian, r, damping, held)
            trial = residual(x + small * step)
            if np.linalg.norm(trial) < REUSED * np.linalg.norm(r):
                x, r = x + small * step, trial
                continue
        stalled = len(norms) > STALLED and norms[-1] > (1.0 - LITTLE) * norms[-1 - STALLED]
        if stalled or len(norms) == max_iterations:
            break
        norms.append(float(np.linalg.norm(r)))
        with while_deriving():
            jacobian = derivatives(terms, x, small, difference)
        for _ in range(15):
            step = _step(jacobian, r, damping, held)
            if held is not None and damping == 0.0 and (shorter := _shorter(residual, x, small, step, r)) is not None:
                step, trial = shorter
                break
            bend = residual(x + PROBE * small * step) - r - PROBE * jacobian @ step
            turn = _step(jacobian, bend / PROBE**2, damping, held)
            if np.linalg.norm(turn) <= BENT * np.linalg.norm(step):  # false for not-a-number
                step = step + turn
            trial = residual(x + small * step)
            if np.linalg.norm(trial) < np.linalg.norm(r):  # likewise
                break
            damping = max(10.0 * damping, 1e-6)
        else:
            break
        x, r = x + small * step, trial
        damping = 0.1 * damping if damping > 1e-6 else 0.0
    return x, residual(x), len(norms)


def derivatives(terms: Terms, x: Array, small: Array, difference: float | Array = DIFFERENCE) -> Array:
    """Derivative of the sum of the terms with respect to x / small, by central differences; see ``damped_newton``."""
    columns_of_it = np.zeros((x.size, x.size))
    part = np.broadcast_to(difference, x.size)
    for term, groups in terms:
        for columns, rows in groups:
            h = np.zeros(x.size)
            h[columns] = part[columns] * small[columns]
            change = term(x + h) - term(x - h)
            columns_of_it[columns[:, None], rows] += change[rows] / (2.0 * part[columns, None])
    return columns_of_it.T


def _shorter(
    residual: Callable[[Array], Array], x: Array, small: Array, step: Array, r: Array
) -> tuple[Array, Array] | None:
    """The largest of 1, 1/2, 1/4 ... of a step that reduces the residual enough, and what is left of it; else None."""
    for part in 0.5 ** np.arange(HALVINGS + 1):
        trial = residual(x + small * part * step)
        if np.linalg.norm(trial) < (1.0 - FALL * part) * np.linalg.norm(r):
            return part * step, trial
    return None


def _step(jacobian: Array, r: Array, damping: float, held: Array | None = None) -> Array:
    """Levenberg's step, limited to the longest; undamped the shortest least-squares solution, or where unknowns are
    held that of sparse equations."""
    if held is not None:
        matrix = scipy.sparse.csc_matrix(jacobian - np.diag(held))
        right = -r
        if damping > 0.0:
            normal = matrix.T @ matrix
            matrix = normal + damping * normal.trace() * scipy.sparse.identity(len(r), format="csc")
            right = jacobian.T @ -r
        try:
            step = scipy.sparse.linalg.splu(scipy.sparse.csc_matrix(matrix)).solve(right)
        except RuntimeError:
            raise SimulationError("steady motion: its equations are singular") from None
    elif damping == 0.0:
        step = np.asarray(np.linalg.lstsq(jacobian, -r, rcond=1e-12)[0], dtype=float)
    else:
        normal = jacobian.T @ jacobian
        step = np.linalg.solve(normal + damping * np.trace(normal) * np.eye(jacobian.shape[1]), jacobian.T @ -r)
    return np.asarray(step * (LONGEST / np.max(np.abs(step), initial=LONGEST)))


def roots(
    function: Callable[[Array], Array], begin: Array, small: float, enough: float, reach: float = np.inf
) -> tuple[Array, NDArray[np.bool_]]:
    """Roots of falling functions (n,), each of its own argument, all at once, by the Illinois method; which were found.

    function: of all arguments (n,), evaluated at the roots at last; begin (n,): first guess, from which steps double
    from ``small`` on, no farther than ``reach``. Ends where all are within ``enough``, or after 40 steps: where a
    function jumps over 0, at the jump.
    """
    x, f = begin.copy(), function(begin)
    bracket, f_bracket = x.copy(), f.copy()
    step = small * np.sign(f)
    for _ in range(40):
        far = ~(np.abs(f) <= enough)
        astride = f * f_bracket < 0.0
        if not np.any(far & (astride | (np.abs(x - begin) < reach))):
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            between = (x * f_bracket - bracket * f) / (f_bracket - f)
        new = np.where(far, np.where(astride, between, np.clip(x + step, begin - reach, begin + reach)), x)
        step = np.where(astride, step, 2.0 * step)
        f_new = function(new)
        crossed = f_new * f < 0.0
        f_bracket = np.where(crossed, f, np.where(astride, 0.5 * f_bracket, f_new))
        bracket = np.where(crossed, x, np.where(astride, bracket, new))
        x, f = new, f_new
    return x, (np.abs(f) <= enough) | (f * f_bracket < 0.0)


DRAG = 1e-3
"""Residual that moves an unknown by one small change in a unit of the pseudo-time."""

FIRST, LONGER, SHORTER = 1.0, 3.0, 0.25
"""The first step in pseudo-time, and factors after an easy step and after a failed one."""

REACH, EASY = 10.0, 3.0
"""Longest change in a step, in small changes, and one after which the next step may be longer."""

ASTRAY = 0.7
"""Part of the residual by which a step may miss the equation that it solves to first order."""

CREEPS = 15
"""The search ends after so many shortened steps that changed no unknown by its small change."""

STALE = 0.5
"""The same part above which the next step takes new derivatives."""

TRIES = 12
"""Most trials of a step, each shorter than the last."""


def relax(
    residual: Callable[[Array], Array],
    x: Array,
    small: Array,
    terms: Terms,
    goal: float,
    most: int,
    rolled: Callable[[Array], Array],
) -> tuple[Array, float]:
    """The x (n,) of a creeping motion after at most so many steps, and the largest residual there.

    Newton's method reduces forces from step to step; a wheelset on its way to a flange, and independent wheels between
    theirs, have less of them at its begin than in its middle. So every unknown moves with the force along it,
    x_t = r / d, in implicit Euler steps that become longer as the motion decays: (d / h - r') dx = r (Kelley and Keyes,
    SIAM J. Numer. Anal. 35 (1998) 508). Derivatives serve as long as steps go where they lead.

    residual: force along every unknown; small (n,): changes of the unknowns that change it by a few per cent; terms:
    of its derivatives; goal: largest residual that ends the search; rolled: sets some unknowns to zeros of their own
    residuals.
    """
    x = rolled(x)
    r, h, creeps, slope = residual(x), FIRST, 0, None
    for _ in range(most):
        if np.max(np.abs(r)) <= goal or creeps == CREEPS:
            break
        new = False
        for _ in range(TRIES):
            if slope is None:
                slope, new = derivatives(terms, x, small), True
            step = np.linalg.solve(np.diag(np.full(x.size, DRAG / h)) - slope, r)
            far = float(np.max(np.abs(step)))
            if far <= REACH:
                point = rolled(x + small * step)
                trial = residual(point)
                missed = float(np.linalg.norm(DRAG / h * step - trial))
                missed /= max(float(np.linalg.norm(r)), float(np.linalg.norm(trial)))
                if missed <= ASTRAY:  # false for nan
                    break
                slope = slope if new else None
            if slope is not None:
                h *= SHORTER
        else:
            break
        x, r = point, trial
        slope = None if missed > STALE else slope
        creeps += far < 1.0 and h < FIRST
        if far < EASY:
            h *= LONGER
    return x, float(np.max(np.abs(r)))
