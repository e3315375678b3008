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

from wrsim.dynamics.kinematics import first_not_finite
from wrsim.jit.arena import Array, Record, Records, record
from wrsim.jit.compiling import inlined, kernel, summing
from wrsim.jit.dense import copy, factorise, solve_factorised

CONTRACTION = 0.5
"""Newton's method retains its Jacobian as long as an iteration reduces the residual below this part of it."""

ORDER, FADE, HELD = 4, 0.98, 1e-4
"""Accelerations that are combined; what a step counts in the sums of squares of the next one; part of these sums with
which the combination is held to the last one, which decides where all are alike."""

NEAR, UNSEEN, FORGET = 100.0, 16, 0.9
"""Forces are estimated, not computed, where the expected residual is within the tolerance and their change, also since
the last step, within so many tolerances; in at most so many steps in succession. The contraction in a step counts as
this part of it in the next."""

BODY, RAILS = 6, 4
"""Coordinates of a body, and of the rails under a wheelset."""

MOST_ASTRAY = 2
"""New Jacobians in a step that predict less than half of the change, at which the method stops or fails."""

STEP = record(
    "q_of_q_tt q_t_of_q_tt tolerance loosest predicted residual moved ratio",
    "bodies rails steps iteration estimates known unseen new astray",
)
"""Changes of q and q_t for a change of q_tt (s2, s); norms of forces [N]: tolerance, largest residual at which the
method may stop, predicted change, error of the last prediction, change since the last step; largest recent error of a
prediction over the predicted change. Bodies; coordinates of rails; steps done; iteration of this step, -1 outside of
steps; whether forces may be estimated; whether there is a Jacobian; steps since ``ratio`` was measured; whether the
Jacobian is of this step; how many of its predictions have failed."""

AT, FORCES, MOVED, CHANGE, AHEAD, WEIGHTS, PAST = range(7)
"""Rows (size,): coordinates of the last computed forces, these, the change of the coordinates since, the predicted one
of the forces; accelerations predicted for the next step; weights of coordinates in sums; the accelerations at the ends
of the last steps, the last one first."""
ROWS = PAST + ORDER + 1

SOLVABLE, NOT_SOLVED = -1, -2
"""What `update` returns beside the index of a force that is not finite."""


@kernel
def predict(step: Records, rows: Array, q: Array, q_t: Array, q_tt: Array) -> None:
    """The first guess of a step; iteration 0."""
    own = step[0]
    own.iteration, own.new, own.astray = 0, 0, 0
    for i in range(q.size):
        more = rows[AHEAD, i]
        q_tt[i] += more
        q_t[i] += own.q_t_of_q_tt * more
        q[i] += own.q_of_q_tt * more


@kernel
def end_step(step: Records, rows: Array, sums: Array, fit: Array, q_tt: Array) -> None:
    """Predict the accelerations of the next step. sums (ORDER + 1, ORDER + 1): products of those of the last steps with
    each other, of all steps; fit (ORDER + 2, ORDER): scratch, the last row receives the combination."""
    own, n, by = step[0], q_tt.size, fit[ORDER + 1]
    for k in range(ORDER, 0, -1):
        copy(n, rows[PAST + k - 1], rows[PAST + k])
    copy(n, q_tt, rows[PAST])
    own.steps += 1
    by[:] = 0.0
    by[0] = 1.0
    if own.steps > ORDER:
        whole, of_bodies = 1e-300, BODY * own.bodies
        for k in range(ORDER + 1):
            for m in range(ORDER + 1):
                more = _product(rows[WEIGHTS, :of_bodies], rows[PAST + k], rows[PAST + m])
                sums[k, m] = FADE * sums[k, m] + more
            whole += sums[k, k]
        for k in range(ORDER):
            for m in range(ORDER):
                fit[k, m] = sums[k + 1, m + 1]
            fit[k, k] += HELD * whole
            by[k] = sums[k + 1, 0] + HELD * whole * by[k]
        factorise(fit, ORDER, fit[ORDER])
        solve_factorised(fit, ORDER, fit[ORDER], by)
    for i in range(n):
        rows[AHEAD, i] = 0.0
        for k in range(ORDER):
            rows[AHEAD, i] += by[k] * rows[PAST + k, i]


@kernel
def estimate(step: Records, rows: Array, jacobian: Array, q: Array, out: Array) -> bool:
    """Fill ``out`` with the forces that the Jacobian predicts and return True, if that ends the iteration."""
    own = step[0]
    if own.iteration < 1 or own.known == 0:
        return False
    for i in range(q.size):
        rows[MOVED, i] = q[i] - rows[AT, i]
    for i in range(q.size):
        rows[CHANGE, i] = _dot(jacobian[i], rows[MOVED])
    own.predicted = sqrt(_dot(rows[CHANGE], rows[CHANGE]))
    if own.estimates == 0:
        return False
    stuck = own.astray >= MOST_ASTRAY and own.residual <= own.loosest
    calm = max(own.predicted, own.moved if own.iteration == 1 else 0.0) <= NEAR * own.tolerance
    close = own.ratio <= CONTRACTION and own.ratio * own.predicted <= own.tolerance
    if not (stuck or (calm and close and own.unseen < UNSEEN)):
        return False
    own.unseen += 1
    for i in range(q.size):
        out[i] = rows[FORCES, i] + rows[CHANGE, i]
    return True


@kernel
def update(step: Records, rows: Array, jacobian: Array, q: Array, forces: Array) -> int:
    """Compare computed forces with the prediction; SOLVABLE, NOT_SOLVED, or the index of a force that is not finite."""
    own, n = step[0], q.size
    status = first_not_finite(forces, forces)
    if status >= 0:
        return status
    if own.iteration >= 1 and own.known != 0:
        own.residual = _distance(forces, rows[FORCES], rows[CHANGE])
        if own.residual <= CONTRACTION * own.predicted:
            _bend(own, rows, jacobian, forces)
        ratio = own.residual / max(own.predicted, own.tolerance)  # below that contacts are not solved
        forgotten = 0.0 if own.iteration > 1 or not isfinite(own.ratio) else FORGET * own.ratio
        own.ratio, own.unseen = max(ratio, forgotten), 0
        if own.new != 0 and ratio > CONTRACTION:
            own.astray += 1
            if own.astray > MOST_ASTRAY and own.residual > own.loosest:
                status = NOT_SOLVED
    elif own.iteration == 0:
        rows[CHANGE] = 0.0
        own.moved = _distance(forces, rows[FORCES], rows[CHANGE])
    for i in range(n):
        rows[FORCES, i], rows[AT, i] = forces[i], q[i]
    return status


@kernel
def set_jacobian(step: Records, jacobian: Array, derivative: Array, by_q: float) -> None:
    """Take a new derivative of the forces with respect to by_q q."""
    own = step[0]
    for i in range(jacobian.shape[0]):
        for j in range(jacobian.shape[0]):
            jacobian[i, j] = derivative[i, j] / by_q
    own.ratio, own.new, own.known = float("inf"), 1, 1


@inlined
def _coordinate(body: int, rails: int, i: int) -> int:
    """The i-th coordinate of a body, behind its own those of the rails under it, which begin at ``rails``."""
    return BODY * body + i if i < BODY else rails + i - BODY


@kernel
def _bend(own: Record, rows: Array, jacobian: Array, forces: Array) -> None:
    """Broyden's update of the estimating Jacobian, body by body, a wheelset with the rails under it: the one that would
    have left nothing."""
    n = forces.size
    for b in range(own.bodies):
        rails = n - own.rails + RAILS * b
        count = BODY + (RAILS if rails < n else 0)
        whole = 0.0
        for j in range(count):
            c = _coordinate(b, rails, j)
            whole += rows[WEIGHTS, c] * rows[MOVED, c] ** 2
        whole = max(whole, 1e-300)
        for i in range(count):
            r = _coordinate(b, rails, i)
            missed = forces[r] - rows[FORCES, r] - rows[CHANGE, r]
            for j in range(count):
                c = _coordinate(b, rails, j)
                jacobian[r, c] += missed * (rows[WEIGHTS, c] * rows[MOVED, c] / whole)


@summing
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@summing
def _product(weights: Array, a: Array, b: Array) -> float:
    total = 0.0
    for i in range(weights.size):
        total += weights[i] * a[i] * b[i]
    return total


@summing
def _distance(a: Array, b: Array, c: Array) -> float:
    """Norm of a - b - c."""
    total = 0.0
    for i in range(a.size):
        total += (a[i] - b[i] - c[i]) ** 2
    return sqrt(total)
