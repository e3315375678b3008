"""Rails on sleepers under the wheels of a vehicle: implicit steps of their motion.

The four systems M u_tt + C u_t + K u = B f of ``wrsim.track.sleepers`` (left and right rail vertically, sum
and difference of both laterally) are integrated by generalised alpha (Arnold and Bruls, Multibody System Dynamics 18
(2007), algorithm 1) with the step of the vehicle and more numerical damping. With c and d, the changes of u and u_t for
a change of u_tt, and with p and p_t, what the method predicts for u_tt = 0 at the end of the step,

    (M + d C + c K) u_tt = B f - C p_t - K p,

so the displacement of a rail under a wheel is affine in the force of the wheel at the end of the step:

    u = u* + g (f - f*)

with a force f* that the steps before foretell. g (2 x 2: lateral, vertical) is the wheel's own; it comes from the band
of the inverse. What f - f* does within the step to the rails under other wheels is left to its end, where all rails are
solved for all forces. The vehicle's step has u as an unknown, whose "force" is the acceleration

    u_tt + m (g (f - f*) - (u - u*)) / c

with its own c, so that the residual is 0 where the equation above holds. The mass m = c / g_bb of the rail in the step,
laterally c / g_nn, makes it a force. So contact and rail are solved together, implicitly.

u is the displacement by the shape functions of the wheel's element and that of the element between its nodes under the
wheel's own force (static, as of a beam clamped at its nodes), which the nodes do not know. The wheel pushes on the
rail's head so high above its shear centre, and beside its middle by the part of the force's moment: both twist the
rail.
"""

from math import hypot, inf

from wrsim.contact.records import LOBE, read_pose
from wrsim.jit import Array, Ints, Records, inlined, kernel, records, vector
from wrsim.jit.linalg import ZERO, Vec, add, cross, norm, scale, shifted, sub
from wrsim.jit.root import neighbours
from wrsim.track.banded import solve_bands, subtract_product
from wrsim.vehicle.dynamics.sleeper_rails import (
    P_A,
    P_T,
    U_T,
    U_TT,
    A,
    P,
    Pair,
    Rails,
    U,
    add_load,
    bent,
    compliances,
    place,
    read,
)
from wrsim.vehicle.dynamics.wheel_forces import ARRAYS, IN_CONTACT, LOBES, POSE, pose_on_rail, wheel_record, wheel_total

WIDEST = 0.04
"""Farthest from the rail's middle that a force acts [m]: half of a rail's head."""
TREND = 0.5
"""Part of the last change of the forces that is extrapolated to the next step."""
LEAST = 1e3
"""Vertical force [N] below which the place of a contact stays as it was."""
SHORTEST = 1e-4
"""Least way over which the slope of a rail under a wheel is a mean [m]."""


@kernel
def look_ahead(time: float, buffer: Array, index: Ints, rails: Rails) -> None:
    """Write where the wheels will be after a time [s], and where on the rail's head they push."""
    for i in range(rails.wheels.shape[0]):
        wheel, on_rail, total = wheel_record(buffer, index, i), rails.wheels[i], wheel_total(buffer, index, i)
        pose = vector(buffer, index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS], POSE)
        s = wheel.s + time * pose[6]
        distances = rails.along[0] if on_rail.side > 0.0 else rails.along[1]
        low, _high, _part = neighbours(distances, s)
        low = min(low, distances.shape[0] - 2)
        slope = (rails.along[2, low + 1] - rails.along[2, low]) / (distances[low + 1] - distances[low])
        on_rail.place, on_rail.speed = rails.along[2, low] + slope * (s - distances[low]), slope * pose[6]
        on_rail.step_distance = max(time * abs(on_rail.speed), SHORTEST)
        if on_rail.speed < 0.0:
            on_rail.step_distance = -on_rail.step_distance
        if total.Fb > LEAST:
            aside = (total.Mt + pose[1] * total.Fb - pose[2] * total.Fo) / total.Fb
            on_rail.offset = on_rail.side * min(max(aside, -WIDEST), WIDEST)


@kernel
def push_on(buffer: Array, index: Ints, rails: Rails) -> None:
    """Write the wheels' forces on the rails at the last evaluation to their records."""
    for i in range(rails.wheels.shape[0]):
        total, on_rail = wheel_total(buffer, index, i), rails.wheels[i]
        on_rail.push_n, on_rail.push_b = -on_rail.side * total.Fo, -total.Fb
        on_rail.last_n, on_rail.last_b = on_rail.push_n, on_rail.push_b


@kernel
def begin(method: Array, motion: Array, buffer: Array, index: Ints, rails: Rails) -> bool:
    """Begin a step with prepared factors: place the wheels; what the rails do under the forces that are foretold.

    method (10,): step [s], alpha_m, alpha_f, beta, gamma, changes c and d of u and u_t for a change of u_tt, 1 / c and
    d / c of the vehicle's method [1/s2, 1/s], place where the last wheel leaves the window [m]. motion (3, 2 wheels):
    receives displacements of the rails to the left and up in turn, and their velocities. Writes how the rail under a
    wheel yields to its record. Returns False, and has done nothing, where the window has to be moved.
    """
    look_ahead(method[0], buffer, index, rails)
    last = rails.wheels[0].place
    for i in range(rails.wheels.shape[0]):
        last = min(last, rails.wheels[i].place)
    if last >= method[9]:
        return False
    c, d = method[5], method[6]
    place(rails)
    for pair in (rails.vertical, rails.lateral):
        for r in range(2):
            _predict(method, pair, r)
    for i in range(rails.wheels.shape[0]):
        add_load(U_TT, i, rails.wheels[i].push_n, rails.wheels[i].push_b, rails.loads, rails)
    for pair in (rails.vertical, rails.lateral):
        solve_bands(pair.factors, pair.rows[:, U_TT])
    compliances(c, rails)
    for i in range(rails.wheels.shape[0]):
        on_rail, wheel = rails.wheels[i], wheel_record(buffer, index, i)
        p, a, p_t = read(P, i, rails.loads, rails), read(U_TT, i, rails.loads, rails), read(P_T, i, rails.loads, rails)
        u_n, u_b, u = p[0] + c * a[0], p[1] + c * a[1], read(U, i, rails.loads, rails)
        was_p, was_a = read(P, i, rails.behind, rails), read(U_TT, i, rails.behind, rails)
        was = read(U, i, rails.behind, rails)
        # means over the way and the step: what single places miss where the rail has kinks over sleepers
        slope_n = 0.5 * (u_n + u[0] - was_p[0] - c * was_a[0] - was[0]) / on_rail.step_distance
        slope_b = 0.5 * (u_b + u[1] - was_p[1] - c * was_a[1] - was[1]) / on_rail.step_distance
        bent_n, bent_b = bent(on_rail, on_rail.push_n, on_rail.push_b)
        on_rail.guess_n, on_rail.guess_b = u_n + bent_n, u_b + bent_b
        on_rail.rate_n = p_t[0] + d * a[0] + on_rail.speed * slope_n + (bent_n - on_rail.bent_n) / method[0]
        on_rail.rate_b = p_t[1] + d * a[1] + on_rail.speed * slope_b + (bent_b - on_rail.bent_b) / method[0]
        # where a force moves along, half of what its own compliance changes is its slope
        bent_n -= on_rail.before_nn * on_rail.push_n + on_rail.before_nb * on_rail.push_b
        bent_b -= on_rail.before_nb * on_rail.push_n + on_rail.before_bb * on_rail.push_b
        wheel.slope_n = slope_n + 0.5 * bent_n / on_rail.step_distance
        wheel.slope_b = slope_b + 0.5 * bent_b / on_rail.step_distance
        wheel.yield_nn, wheel.yield_nb, wheel.yield_bb = on_rail.nn, on_rail.nb, on_rail.bb
        wheel.rate_n, wheel.rate_b = 1.0 / on_rail.nn, 1.0 / on_rail.bb
        wheel.held_n, wheel.held_b = 1.0 - method[7] * on_rail.nn, 1.0 - method[7] * on_rail.bb
        wheel.free_n = wheel.held_n * on_rail.guess_n - on_rail.nn * on_rail.push_n - on_rail.nb * on_rail.push_b
        wheel.free_b = wheel.held_b * on_rail.guess_b - on_rail.nb * on_rail.push_n - on_rail.bb * on_rail.push_b
        motion[0, 2 * i], motion[0, 2 * i + 1] = on_rail.guess_n, on_rail.guess_b
        motion[1, 2 * i], motion[1, 2 * i + 1] = on_rail.rate_n, on_rail.rate_b
    return True


@kernel
def look_at_wheels(method: Array, motion: Array, buffer: Array, index: Ints, rails: Rails) -> None:
    """Better guesses of the end of a step, once the wheels are where they are foretold: each rail in balance with the
    force of its contact, linear in the changes since the last evaluation.

    Rail and wheel move by some 10 um from step to step; the force between them hangs on a small difference of both. A
    change of the gap along the normal of the contact changes the force by 3/2 of N over the approach (Hertz), one of
    the velocity across it by creep force over creep velocity. motion (3, 2 wheels): displacements, velocities,
    accelerations as of an iteration, changed.
    """
    for i in range(rails.wheels.shape[0]):
        wheel, arrays = wheel_record(buffer, index, i), index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS]
        last, lobes = read_pose(vector(buffer, arrays, POSE)), records(buffer, arrays, LOBES, LOBE)
        normal, point, stiffness, drag = ZERO, ZERO, 0.0, 0.0
        rails.wheels[i].across_n, rails.wheels[i].across_b = 1.0, 0.0
        for k in range(wheel_total(buffer, index, i).lobes):
            lobe = lobes[k]
            lobe_stiffness = 1.5 * lobe.N / lobe.approach if lobe.approach > 0.0 else 0.0
            creep = hypot(lobe.xi, lobe.eta) * abs(last.velocity.x)
            normal = add(normal, Vec(0.0, lobe_stiffness * lobe.no, lobe_stiffness * lobe.nb))
            point = shifted(point, lobe_stiffness, Vec(lobe.x, lobe.o, lobe.b))
            stiffness += lobe_stiffness
            drag += hypot(lobe.Fx, lobe.Fy) / creep if creep > 0.0 else 0.0
        if stiffness > 0.0:
            along, arm = scale(1.0 / norm(normal), normal), sub(scale(1.0 / stiffness, point), last.origin)
            pose, on_rail, side = pose_on_rail(buffer, index, i), rails.wheels[i], wheel.side
            turned = cross(cross(last.axle, sub(pose.axle, last.axle)), arm)
            moved = add(sub(pose.origin, last.origin), turned)
            faster = add(sub(pose.velocity, last.velocity), cross(sub(pose.omega, last.omega), arm))
            n, b = side * along.y, along.z
            on_rail.across_n, on_rail.across_b = b, -n
            gap = n * (side * moved.y - motion[0, 2 * i]) + b * (moved.z - motion[0, 2 * i + 1])
            slip = b * (side * faster.y - motion[1, 2 * i]) - n * (faster.z - motion[1, 2 * i + 1])
            gap *= 1.0 - 1.0 / (1.0 + stiffness * (n * n * on_rail.nn + 2.0 * n * b * on_rail.nb + b * b * on_rail.bb))
            drag *= method[8] * (b * b * on_rail.nn - 2.0 * n * b * on_rail.nb + n * n * on_rail.bb)
            slip *= (1.0 - 1.0 / (1.0 + drag)) / method[8]
            _correct(method, motion[:, 2 * i], n * gap + b * slip)
            _correct(method, motion[:, 2 * i + 1], b * gap - n * slip)


@kernel
def hold(
    first: bool, tolerance: float, method: Array, last: Array, unknowns: tuple[Array, Array, Array], wheels: Records
) -> bool:
    """Hold an iteration of Newton's method between two that led to each other; returns whether one was held.

    Creep forces saturate: from either side of the slip at which they reverse, an iteration leads to the other side, for
    ever. They fall with the slip, so across the normal of the contact the end of the step lies between. An iteration
    that leads out goes to the middle instead (Newton's method with bisection: Press and others, Numerical Recipes,
    section 9.4), the second one on the same side to that end itself, which the other unknowns may have moved. Changes
    of a force by less than the tolerance [N] do not count.

    first: of this step; last (2 wheels,): displacements of the rails at the last iteration; unknowns: these, velocities
    and accelerations at this one, changed.
    """
    q, q_t, q_tt = unknowns
    held = False
    for i in range(wheels.shape[0]):
        on_rail, n, b = wheels[i], 2 * i, 2 * i + 1
        if first:
            on_rail.lower, on_rail.upper, on_rail.bracketed = -inf, inf, 0.0
        previous = on_rail.across_n * last[n] + on_rail.across_b * last[b]
        current = on_rail.across_n * q[n] + on_rail.across_b * q[b]
        if abs(current - previous) <= tolerance * on_rail.nn:
            continue
        leads = 1.0 if current > previous else -1.0
        if leads > 0.0:
            on_rail.lower, on_rail.upper = previous, on_rail.upper if on_rail.upper > previous else inf
        else:
            on_rail.lower, on_rail.upper = on_rail.lower if on_rail.lower < previous else -inf, previous
        middle = 0.5 * (on_rail.lower + on_rail.upper)
        if on_rail.lower <= current <= on_rail.upper:
            on_rail.bracketed = 0.0
            continue
        end = on_rail.upper if leads > 0.0 else on_rail.lower
        more, on_rail.bracketed = (end, 0.0) if on_rail.bracketed == leads else (middle, leads)
        more -= current
        for k, part in ((n, on_rail.across_n), (b, on_rail.across_b)):
            q[k] += part * more
            q_t[k] += method[8] * part * more
            q_tt[k] += method[7] * part * more
        held = True
    return held


@inlined
def _correct(method: Array, unknown: Array, more: float) -> None:
    """Change displacement, velocity and acceleration together."""
    unknown[0] += more
    unknown[1] += method[8] * more
    unknown[2] += method[7] * more


@kernel
def end(method: Array, motion: Array, buffer: Array, index: Ints, rails: Rails) -> None:
    """End a step. motion (1, 2 wheels) or more: displacements of the rails under the wheels at its end, to the left and
    up in turn. Their velocities stay those of the step: its forces belong to them."""
    c, d, later = method[5], method[6], (1.0 - method[2]) / (1.0 - method[1])
    for pair in (rails.vertical, rails.lateral):
        pair.rows[:, A] = 0.0  # for the correction
    for i in range(rails.wheels.shape[0]):
        on_rail = rails.wheels[i]
        n, b = motion[0, 2 * i] - on_rail.guess_n, motion[0, 2 * i + 1] - on_rail.guess_b
        whole = on_rail.nn * on_rail.bb - on_rail.nb * on_rail.nb
        more_n, more_b = (on_rail.bb * n - on_rail.nb * b) / whole, (on_rail.nn * b - on_rail.nb * n) / whole
        add_load(A, i, more_n, more_b, rails.loads, rails)
        more_n, more_b = on_rail.push_n + more_n, on_rail.push_b + more_b
        on_rail.push_n = more_n + TREND * (more_n - on_rail.last_n)
        on_rail.push_b = more_b + TREND * (more_b - on_rail.last_b)
        on_rail.last_n, on_rail.last_b = more_n, more_b
        on_rail.bent_n, on_rail.bent_b = bent(on_rail, more_n, more_b)
        wheel = wheel_record(buffer, index, i)
        wheel.rate_n = wheel.rate_b = 0.0
    for pair in (rails.vertical, rails.lateral):
        solve_bands(pair.factors, pair.rows[:, A])
        for r in range(2):
            system = pair.rows[r]
            for j in range(system.shape[1]):
                system[U_TT, j] += system[A, j]
                system[U, j] = system[P, j] + c * system[U_TT, j]
                system[U_T, j] = system[P_T, j] + d * system[U_TT, j]
                system[A, j] = system[P_A, j] + later * system[U_TT, j]


@kernel
def _predict(method: Array, pair: Pair, r: int) -> None:
    """Write what the method predicts, and given forces - C p_t - K p to the row of accelerations."""
    h, am, af, beta, gamma = method[0], method[1], method[2], method[3], method[4]
    system, drag = pair.rows[r], pair.drag[r]
    for j in range(system.shape[1]):
        a = (af * system[U_TT, j] - am * system[A, j]) / (1.0 - am)
        system[P, j] = system[U, j] + h * system[U_T, j] + h * h * ((0.5 - beta) * system[A, j] + beta * a)
        system[P_T, j] = system[U_T, j] + h * ((1.0 - gamma) * system[A, j] + gamma * a)
        system[P_A, j] = a
        system[U_TT, j] = pair.forces[r, j] - drag[j] * system[P_T, j]
    subtract_product(pair.damping[r], system[P_T], system[U_TT])
    subtract_product(pair.stiffness[r], system[P], system[U_TT])
