"""Newton's method within the implicit steps of generalised alpha: first guess, estimates, and failure.

First guess: a step starts from accelerations that are a combination of the last ones, the one that would have given
those of the steps before with the least squares of errors (linear prediction: Makhoul, Proc. IEEE 63 (1975) 561).
Wheels vibrate on their contacts with a few steps a period: a vibration takes two accelerations, a drift two more. q,
q_t and q_tt change together, as in an iteration (Arnold and Bruls, Multibody System Dynamics 18 (2007), algorithm 1).

Estimates: the forces after an iteration differ from those predicted by the Jacobian by a part (``ratio``) of the
predicted change. It is measured wherever forces are computed, and there the estimating Jacobian is updated (Broyden,
body by body, a wheelset with the rails under it), not the one that the integrator holds. Where the difference is sure
to be within the tolerance, the prediction ends the iteration (the test of Hairer and Wanner, Solving Ordinary
Differential Equations II, IV.8).

Failure: where new Jacobians predict less than half of the change, the force is discontinuous.
"""

from math import isfinite, sqrt

from wrsim.jit.arena import Array, Record, Records, record
from wrsim.jit.compiling import inlined, kernel, reassociating_kernel
from wrsim.jit.dense import copy, factorise, solve_factorised
from wrsim.vehicle.dynamics.kinematics import first_not_finite

CONTRACTION = 0.5
"""Newton's method retains its Jacobian as long as an iteration reduces the residual below this part of it."""

ORDER, FADE, REGULARISATION = 4, 0.98, 1e-4
"""Accelerations that are combined; what a step counts in the sums of squares of the next one; part of these sums with
which the combination is held to the last one, which decides where all are alike."""

MAX_CHANGE, MAX_ESTIMATES, FORGET = 100.0, 16, 0.9
"""Forces are estimated, not computed, where the expected residual is within the tolerance and their change, also since
the last step, within so many tolerances; in at most so many steps in succession. The contraction in a step counts as
this part of it in the next."""

BODY, RAILS = 6, 4
"""Coordinates of a body, and of the rails under a wheelset."""

MAX_FAILED = 2
"""New Jacobians in a step that predict less than half of the change, at which the method stops or fails."""

STEP = record("""
    q_of_q_tt          [s2]  change of q for a change of q_tt
    q_t_of_q_tt        [s]   change of q_t for a change of q_tt
    tolerance          [N]   norm of the residual at which the iteration has converged
    max_residual       [N]   largest norm of the residual at which the method may stop
    predicted          [N]   norm of the predicted change of the forces
    residual           [N]   norm of the error of the last prediction
    force_change       [N]   norm of the change of the forces since the last step
    ratio              [1]   largest recent error of a prediction over the predicted change
    bodies             [int] number of bodies
    rails              [int] number of coordinates of rails
    steps              [int] number of steps done
    iteration          [int] iteration of this step, -1 outside of steps
    estimates          [int] 1: forces may be estimated
    known              [int] 1: there is a Jacobian
    steps_estimated    [int] number of estimates since ``ratio`` was measured
    new                [int] 1: the Jacobian is of this step
    failed_predictions [int] number of predictions of new Jacobians in this step that have failed
""")
"""A step of generalised alpha and its iteration."""

COMPUTED_AT, FORCES, MOVED, CHANGE, AHEAD, WEIGHTS, PAST = range(7)
"""Rows (size,): coordinates of the last computed forces, these, the change of the coordinates since, the predicted one
of the forces; accelerations predicted for the next step; weights of coordinates in sums; the accelerations at the ends
of the last steps, the last one first."""
ROWS = PAST + ORDER + 1

SOLVABLE, NOT_SOLVED = -1, -2
"""What `update` returns beside the index of a force that is not finite."""


@kernel
def predict(step: Records, rows: Array, q: Array, q_t: Array, q_tt: Array) -> None:
    """The first guess of a step; iteration 0."""
    state = step[0]
    state.iteration, state.new, state.failed_predictions = 0, 0, 0
    for i in range(q.size):
        change = rows[AHEAD, i]
        q_tt[i] += change
        q_t[i] += state.q_t_of_q_tt * change
        q[i] += state.q_of_q_tt * change


@kernel
def end_step(step: Records, rows: Array, sums: Array, fit: Array, q_tt: Array) -> None:
    """Predict the accelerations of the next step. sums (ORDER + 1, ORDER + 1): products of those of the last steps with
    each other, of all steps; fit (ORDER + 2, ORDER): scratch, the last row receives the combination."""
    state, n, combination = step[0], q_tt.size, fit[ORDER + 1]
    for k in range(ORDER, 0, -1):
        copy(n, rows[PAST + k - 1], rows[PAST + k])
    copy(n, q_tt, rows[PAST])
    state.steps += 1
    combination[:] = 0.0
    combination[0] = 1.0
    if state.steps > ORDER:
        whole, of_bodies = 1e-300, BODY * state.bodies
        for k in range(ORDER + 1):
            for m in range(ORDER + 1):
                more = _product(rows[WEIGHTS, :of_bodies], rows[PAST + k], rows[PAST + m])
                sums[k, m] = FADE * sums[k, m] + more
            whole += sums[k, k]
        for k in range(ORDER):
            for m in range(ORDER):
                fit[k, m] = sums[k + 1, m + 1]
            fit[k, k] += REGULARISATION * whole
            combination[k] = sums[k + 1, 0] + REGULARISATION * whole * combination[k]
        factorise(fit, ORDER, fit[ORDER])
        solve_factorised(fit, ORDER, fit[ORDER], combination)
    for i in range(n):
        rows[AHEAD, i] = 0.0
        for k in range(ORDER):
            rows[AHEAD, i] += combination[k] * rows[PAST + k, i]


@kernel
def estimate(step: Records, rows: Array, jacobian: Array, q: Array, out: Array) -> bool:
    """Fill ``out`` with the forces that the Jacobian predicts and return True, if that ends the iteration."""
    state = step[0]
    if state.iteration < 1 or state.known == 0:
        return False
    for i in range(q.size):
        rows[MOVED, i] = q[i] - rows[COMPUTED_AT, i]
    for i in range(q.size):
        rows[CHANGE, i] = _dot(jacobian[i], rows[MOVED])
    state.predicted = sqrt(_dot(rows[CHANGE], rows[CHANGE]))
    if state.estimates == 0:
        return False
    at_jump = state.failed_predictions >= MAX_FAILED and state.residual <= state.max_residual
    calm = max(state.predicted, state.force_change if state.iteration == 1 else 0.0) <= MAX_CHANGE * state.tolerance
    close = state.ratio <= CONTRACTION and state.ratio * state.predicted <= state.tolerance
    if not (at_jump or (calm and close and state.steps_estimated < MAX_ESTIMATES)):
        return False
    state.steps_estimated += 1
    for i in range(q.size):
        out[i] = rows[FORCES, i] + rows[CHANGE, i]
    return True


@kernel
def update(step: Records, rows: Array, jacobian: Array, q: Array, forces: Array) -> int:
    """Compare computed forces with the prediction; SOLVABLE, NOT_SOLVED, or the index of a force that is not finite."""
    state, n = step[0], q.size
    status = first_not_finite(forces, forces)
    if status >= 0:
        return status
    if state.iteration >= 1 and state.known != 0:
        state.residual = _distance(forces, rows[FORCES], rows[CHANGE])
        if state.residual <= CONTRACTION * state.predicted:
            _bend(state, rows, jacobian, forces)
        ratio = state.residual / max(state.predicted, state.tolerance)  # below that contacts are not solved
        forgotten = 0.0 if state.iteration > 1 or not isfinite(state.ratio) else FORGET * state.ratio
        state.ratio, state.steps_estimated = max(ratio, forgotten), 0
        if state.new != 0 and ratio > CONTRACTION:
            state.failed_predictions += 1
            if state.failed_predictions > MAX_FAILED and state.residual > state.max_residual:
                status = NOT_SOLVED
    elif state.iteration == 0:
        rows[CHANGE] = 0.0
        state.force_change = _distance(forces, rows[FORCES], rows[CHANGE])
    for i in range(n):
        rows[FORCES, i], rows[COMPUTED_AT, i] = forces[i], q[i]
    return status


@kernel
def set_jacobian(step: Records, jacobian: Array, derivative: Array, by_q: float) -> None:
    """Take a new derivative of the forces with respect to by_q q."""
    state = step[0]
    for i in range(jacobian.shape[0]):
        for j in range(jacobian.shape[0]):
            jacobian[i, j] = derivative[i, j] / by_q
    state.ratio, state.new, state.known = float("inf"), 1, 1


@inlined
def _coordinate(body: int, rails: int, i: int) -> int:
    """The i-th coordinate of a body, behind its own those of the rails under it, which begin at ``rails``."""
    return BODY * body + i if i < BODY else rails + i - BODY


@kernel
def _bend(state: Record, rows: Array, jacobian: Array, forces: Array) -> None:
    """Broyden's update of the estimating Jacobian, body by body, a wheelset with the rails under it: the one that would
    have left nothing."""
    n = forces.size
    for b in range(state.bodies):
        rails = n - state.rails + RAILS * b
        count = BODY + (RAILS if rails < n else 0)
        square = 0.0
        for j in range(count):
            c = _coordinate(b, rails, j)
            square += rows[WEIGHTS, c] * rows[MOVED, c] ** 2
        square = max(square, 1e-300)
        for i in range(count):
            r = _coordinate(b, rails, i)
            missed = forces[r] - rows[FORCES, r] - rows[CHANGE, r]
            for j in range(count):
                c = _coordinate(b, rails, j)
                jacobian[r, c] += missed * (rows[WEIGHTS, c] * rows[MOVED, c] / square)


@reassociating_kernel
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@reassociating_kernel
def _product(weights: Array, a: Array, b: Array) -> float:
    total = 0.0
    for i in range(weights.size):
        total += weights[i] * a[i] * b[i]
    return total


@reassociating_kernel
def _distance(a: Array, b: Array, c: Array) -> float:
    """Norm of a - b - c."""
    total = 0.0
    for i in range(a.size):
        total += (a[i] - b[i] - c[i]) ** 2
    return sqrt(total)
