"""One step of generalised alpha for a deadline: a fixed number of iterations with an inverse that was made beforehand.

The method is that of ``dynamics.implicit_step`` (Arnold and Bruls, Multibody System Dynamics 18
(2007), algorithm 1); an iteration is one evaluation of the forces and one correction, whatever its residual. The
inverse of M - q_of_q_tt dF/dq - q_t_of_q_tt dF/dq_t belongs to a state of the past. The coordinates x and y are global,
so the residual of every body is turned back by what its heading has changed since then, and the correction forth. At
1 ms the mass is several times as large as what stiffness and creep add to it: an iteration with such an inverse leaves
a small part of the residual.
"""

from math import cos, inf, isfinite, sin, sqrt

from wrsim.contact.records import STATUS_COARSE, STATUS_NOT_CONVERGED
from wrsim.jit import Array, Ints, Record, Records, kernel, matrix, record, records
from wrsim.jit.dense import multiply
from wrsim.vehicle.dynamics.kinematics import HEADING, X, Y
from wrsim.vehicle.dynamics.rigid_body import INERTIA, mass_block, quadratic_forces
from wrsim.vehicle.dynamics.vehicle_forces import FIRST_WHEEL, vehicle_forces
from wrsim.vehicle.dynamics.wheel_forces import ARRAYS, memo_of, reserve, share, wheel_record

STEP = record("""
    h           [s]   step
    alpha_m     [1]   number of the method
    alpha_f     [1]   number of the method
    beta        [1]   number of the method
    gamma       [1]   number of the method
    q_of_q_tt   [s2]  change of q for a change of q_tt
    q_t_of_q_tt [s]   change of q_t for a change of q_tt
    residual    [N]   norm of the residual ahead of the last correction, at this step
    most        [N]   largest of these so far
    budget      [1]   what the strips of all wheels may take in a step (``strips.newton``); inf: anything
    work        [1]   what they took in this step
    most_work   [1]   most of these so far
    coarse      [1]   contacts of this step that the budget was too small for, as often as they were evaluated
    unsolved    [1]   of these: without a solution of the strip model
    iterations  [int] number of iterations of a step
    steps       [int] number of steps done
    coarse_steps [int] number of steps in which contacts were coarse
    all_coarse   [int] number of contacts that were
    all_unsolved [int] number of contacts that were unsolved
""")

Q, Q_T, Q_TT, A, LAST, FORCES, RESIDUAL, CORRECTION, INVERTED_AT = range(9)
"""Rows (size,): coordinates, rates, accelerations and those of the method; accelerations a step ago; forces, residual,
correction; the coordinates that the inverse belongs to."""
ROWS = 9

STEP_RECORD, STATE, INVERSE, INERTIAS, SCRATCH, SEEN, WHEELS = range(7)
"""Arrays of the workspace: record STEP; rows; (size, size); records INERTIA of the bodies; (6, 6); what is read of
bodies and wheels (``dynamics.outputs``)."""
VEHICLE_ARRAYS = 7
"""The first of those of ``vehicle_forces``, behind them."""

NOT_FINITE = -1
LEAST = 1e-9  # of a budget that is spent: 0 would be none

TREND = 0.5
"""Part of the last change of the accelerations that is extrapolated to the next step."""


@kernel
def advance(buffer: Array, index: Ints) -> int:
    """Take one step from the state in the rows. Returns a status: that of ``vehicle_forces`` at the last evaluation, or
    NOT_FINITE."""
    step, vehicle = records(buffer, index, STEP_RECORD, STEP)[0], index[VEHICLE_ARRAYS:]
    rows = matrix(buffer, index, STATE)
    inverse, block = matrix(buffer, index, INVERSE), matrix(buffer, index, SCRATCH)
    inertia, n = records(buffer, index, INERTIAS, INERTIA), rows.shape[1]
    h, am, af = step.h, step.alpha_m, step.alpha_f
    a_of_q_tt = (1.0 - af) / (1.0 - am)
    trend = TREND if step.steps > 0 else 0.0
    for i in range(n):
        known, q_tt = rows[A, i], rows[Q_TT, i]
        a = (af * q_tt - am * known) / (1.0 - am)
        ahead = q_tt + trend * (q_tt - rows[LAST, i])
        rows[Q, i] += h * rows[Q_T, i] + h * h * ((0.5 - step.beta) * known + step.beta * a) + step.q_of_q_tt * ahead
        rows[Q_T, i] += h * ((1.0 - step.gamma) * known + step.gamma * a) + step.q_t_of_q_tt * ahead
        rows[A, i] = a + a_of_q_tt * ahead
        rows[LAST, i], rows[Q_TT, i] = q_tt, ahead
    step.steps += 1
    time = step.steps * h
    status = 0
    step.work = step.coarse = step.unsolved = 0.0
    for behind in range(step.iterations - 1, -1, -1):
        _begin(step, behind, buffer, vehicle[FIRST_WHEEL:])
        status = vehicle_forces(time, rows[Q], rows[Q_T], rows[FORCES], buffer, vehicle)
        _end(step, buffer, vehicle[FIRST_WHEEL:])
        step.residual = _residual(rows, inertia, block)
        if not isfinite(step.residual):
            return NOT_FINITE
        _turn(rows, RESIDUAL, inertia.shape[0], -1.0)
        multiply(inverse, n, rows[RESIDUAL], rows[CORRECTION])
        _turn(rows, CORRECTION, inertia.shape[0], 1.0)
        for i in range(n):
            more = rows[CORRECTION, i]
            rows[Q_TT, i] -= more
            rows[Q_T, i] -= step.q_t_of_q_tt * more
            rows[Q, i] -= step.q_of_q_tt * more
            rows[A, i] -= a_of_q_tt * more
    step.most = max(step.most, step.residual)
    step.most_work = max(step.most_work, step.work)
    step.all_coarse += int(step.coarse)
    step.all_unsolved += int(step.unsolved)
    step.coarse_steps += int(step.coarse > 0.0)
    return status


@kernel
def _begin(step: Record, behind: int, buffer: Array, wheels: Ints) -> None:
    """Give an evaluation its share of the budget; ``behind`` more follow in the step."""
    if wheels.shape[0] > 0:
        wheels_reserve = reserve(buffer, wheels)
        part = share(step.budget - step.work, wheels_reserve, behind * wheels_reserve)
        wheel_record(buffer, wheels, 0).budget = max(part, LEAST)


@kernel
def _end(step: Record, buffer: Array, wheels: Ints) -> None:
    """Take what an evaluation's contacts have taken, and which it was not enough for, into the step's."""
    for i in range(wheels.shape[0] // ARRAYS):
        memo = memo_of(buffer, wheels, i)
        step.work += memo.work
        memo.budget = inf
        status = wheel_record(buffer, wheels, i).status
        if status & STATUS_COARSE:
            step.coarse += 1.0
            step.unsolved += int(status & STATUS_NOT_CONVERGED != 0)
    if wheels.shape[0] > 0:
        wheel_record(buffer, wheels, 0).budget = 0.0


@kernel
def _residual(rows: Array, inertia: Records, block: Array) -> float:
    """Write M q_tt + h - F to the row RESIDUAL; returns its norm. block: (6, 6) scratch."""
    q, q_t, q_tt, left = rows[Q], rows[Q_T], rows[Q_TT], rows[RESIDUAL]
    n = q.size
    for i in range(n):
        left[i] = q_tt[i]
    for b in range(inertia.shape[0]):
        first, last, body = 6 * b, 6 * b + 6, inertia[b]
        quadratic_forces(q[first:last], q_t[first:last], body.xx, body.yy, body.zz, left[first:last])
        mass_block(q[first:last], body.mass, body.xx, body.yy, body.zz, block)
        for i in range(6):
            for j in range(6):
                left[first + i] += block[i, j] * q_tt[first + j]
    total = 0.0
    for i in range(n):
        left[i] -= rows[FORCES, i]
        total += left[i] * left[i]
    return sqrt(total)


@kernel
def _turn(rows: Array, row: int, bodies: int, sign: float) -> None:
    """Turn x and y of every body in a row by what its heading has changed since the inverse was made."""
    for b in range(bodies):
        x, y, angle = 6 * b + X, 6 * b + Y, rows[Q, 6 * b + HEADING] - rows[INVERTED_AT, 6 * b + HEADING]
        c, s = cos(angle), sign * sin(angle)
        along, across = rows[row, x], rows[row, y]
        rows[row, x], rows[row, y] = c * along - s * across, s * along + c * across
