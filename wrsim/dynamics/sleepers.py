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

from math import hypot, inf, sqrt
from typing import NamedTuple

from wrsim.contact.records import LOBE, read_pose
from wrsim.dynamics.wheel_forces import ARRAYS, IN_CONTACT, LOBES, POSE, pose_on_rail, wheel_record, wheel_total
from wrsim.jit import Array, Ints, Record, Records, inlined, kernel, record, records, vector
from wrsim.jit.linalg import ZERO, Vec, add, cross, norm, scale, shifted, sub
from wrsim.jit.root import neighbours
from wrsim.track.banded import factorise_bands, invert_band, quadratic_form, solve_bands, subtract_product

TIE = record(
    "side place speed offset push_n push_b last_n last_b guess_n guess_b rate_n rate_b nn nb bb own_nn own_nb own_bb"
    " before_nn before_nb before_bb way bent_n bent_b across_n across_b low high led"
)
"""A wheel on its rail: +1 left, -1 right; distance along the centre line [m] and speed [m/s] at the end of the step;
how far to the left of the rail's middle it pushes [m]; its force on the rail to the left and up that is foretold for
the end of the step, and that at the last step's end [N]; displacement [m] and velocity [m/s] of the rail under it with
that force; compliance g, and the part of it that is the element's between its nodes, here and a way behind [m/N]; the
way of the step [m]; what that part is bent at the last step's end [m]; direction across the normal of the contact, the
displacements along it between which this step's end lies [m], and where Newton's method was led past one of them."""

U, U_T, U_TT, A, P, P_T, P_A = range(7)
"""Rows of a system: displacements, velocities, accelerations and those of the method; what it predicts."""
ROWS = 7

WIDEST = 0.04
"""Farthest from the rail's middle that a force acts [m]: half of a rail's head."""
TREND = 0.5
"""Part of the last change of the forces that is extrapolated to the next step."""
LEAST = 1e3
"""Vertical force [N] below which the place of a contact stays as it was."""
SHORTEST = 1e-4
"""Least way over which the slope of a rail under a wheel is a mean [m]."""


class Pair(NamedTuple):
    """Two systems of the same layout: ``own`` unknowns a node in ``numbers`` (own, elements a bay). bands (2, n, k +
    1): mass, damping, stiffness, factors, the band of the inverse; drag (2, n): dampers of the end zones; given (2, n):
    forces of what moves below; rows (2, ROWS, n); bending (2, elements) [N m2]; shear (1,) [N]."""

    numbers: Ints
    mass: Array
    damping: Array
    stiffness: Array
    factors: Array
    inverse: Array
    drag: Array
    given: Array
    rows: Array
    bending: Array
    shear: Array


class Loads(NamedTuple):
    """Load vectors of all wheels. numbers (wheels, 3, 6): of a vertical force in the vertical system, and of a lateral
    and a vertical one in the lateral systems; places (wheels, 2, 6) of these."""

    numbers: Array
    places: Ints


class Rails(NamedTuple):
    """Vertical and lateral systems; nodes (n,) [m]; ties of the wheels; loads at their places, and a way behind these;
    head (2,): height of the head above the shear centre [m], torsional stiffness G J [N m2]; along (3, m): distances
    along the left, along the right rail, along the centre line."""

    vertical: Pair
    lateral: Pair
    nodes: Array
    ties: Records
    loads: Loads
    behind: Loads
    head: Array
    along: Array


@kernel
def look_ahead(time: float, buffer: Array, index: Ints, rails: Rails) -> None:
    """Write to the ties where the wheels will be after a time [s], and where on the rail's head they push."""
    for i in range(rails.ties.shape[0]):
        wheel, tie, total = wheel_record(buffer, index, i), rails.ties[i], wheel_total(buffer, index, i)
        pose = vector(buffer, index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS], POSE)
        s = wheel.s + time * pose[6]
        own = rails.along[0] if tie.side > 0.0 else rails.along[1]
        low, _high, _part = neighbours(own, s)
        low = min(low, own.shape[0] - 2)
        slope = (rails.along[2, low + 1] - rails.along[2, low]) / (own[low + 1] - own[low])
        tie.place, tie.speed = rails.along[2, low] + slope * (s - own[low]), slope * pose[6]
        tie.way = max(time * abs(tie.speed), SHORTEST)
        if tie.speed < 0.0:
            tie.way = -tie.way
        if total.Fb > LEAST:
            aside = (total.Mt + pose[1] * total.Fb - pose[2] * total.Fo) / total.Fb
            tie.offset = tie.side * min(max(aside, -WIDEST), WIDEST)


@kernel
def push_on(buffer: Array, index: Ints, rails: Rails) -> None:
    """Write the wheels' forces on the rails at the last evaluation to the ties."""
    for i in range(rails.ties.shape[0]):
        total, tie = wheel_total(buffer, index, i), rails.ties[i]
        tie.push_n, tie.push_b = -tie.side * total.Fo, -total.Fb
        tie.last_n, tie.last_b = tie.push_n, tie.push_b


@kernel
def place(rails: Rails) -> None:
    """Load vectors and own compliances of all wheels at their places, and a way behind these."""
    for i in range(rails.ties.shape[0]):
        tie = rails.ties[i]
        tie.before_nn, tie.before_nb, tie.before_bb = _load(i, tie.place - tie.way, rails.behind, rails)
        tie.own_nn, tie.own_nb, tie.own_bb = _load(i, tie.place, rails.loads, rails)


@kernel
def _load(i: int, at: float, loads: Loads, rails: Rails) -> tuple[float, float, float]:
    """Load vectors of a wheel at a place [m]; returns the compliance of its element between the nodes [m/N]."""
    tie, load, places = rails.ties[i], loads.numbers[i], loads.places[i]
    low, _high, _part = neighbours(rails.nodes, at)
    e = min(low, rails.nodes.shape[0] - 2)
    length = rails.nodes[e + 1] - rails.nodes[e]
    xi = (at - rails.nodes[e]) / length
    rail = 0 if tie.side > 0.0 else 1
    head, twisting, offset = rails.head[0], rails.head[1], tie.offset
    v_bending, l_bending = rails.vertical.bending[rail, e], rails.lateral.bending[0, e]
    v_shear, l_shear = rails.vertical.shear[0], rails.lateral.shear[0]
    _shapes(xi, length, 12.0 * v_bending / (v_shear * length * length), load[0])
    _shapes(xi, length, 12.0 * l_bending / (l_shear * length * length), load[1])
    for k in range(4):
        load[2, k] = 0.0
    load[1, 4], load[1, 5] = -head * (1.0 - xi), -head * xi
    load[2, 4], load[2, 5] = offset * (1.0 - xi), offset * xi
    for j, numbers in enumerate((rails.vertical.numbers, rails.lateral.numbers)):
        first, second = _node(numbers, e), _node(numbers, e + 1)
        for k in range(2):
            places[j, k], places[j, 2 + k] = first + k, second + k
        places[j, 4], places[j, 5] = first + 2, second + 2  # of a lateral one
    before, after = xi * length, (1.0 - xi) * length
    twist = before * after / (length * twisting)
    n, v = _between(before, after, l_bending, l_shear), _between(before, after, v_bending, v_shear)
    return n + head * head * twist, -head * offset * twist, v + offset * offset * twist


@kernel
def prepare(of_mass: float, of_damping: float, of_stiffness: float, rails: Rails) -> None:
    """Factors and the band of the inverse of a sum of the matrices."""
    _prepare(of_mass, of_damping, of_stiffness, rails.vertical)
    _prepare(of_mass, of_damping, of_stiffness, rails.lateral)


@kernel
def rest(speed_too: bool, rails: Rails) -> None:
    """Static displacements under the ties' forces, by prepared factors of the stiffness; speed_too: velocities of
    what moves along with the wheels, else none."""
    for pair in (rails.vertical, rails.lateral):
        pair.rows[:] = 0.0
    for i in range(rails.ties.shape[0]):
        tie = rails.ties[i]
        _add(U, i, tie.push_n, tie.push_b, rails.loads, rails)
        if speed_too:
            rate = tie.speed / tie.way
            _add(U_T, i, rate * tie.push_n, rate * tie.push_b, rails.loads, rails)
            _add(U_T, i, -rate * tie.push_n, -rate * tie.push_b, rails.behind, rails)
    for pair in (rails.vertical, rails.lateral):
        solve_bands(pair.factors, pair.rows[:, U])
        solve_bands(pair.factors, pair.rows[:, U_T])
    for i in range(rails.ties.shape[0]):
        tie = rails.ties[i]
        tie.bent_n, tie.bent_b = _bent(tie, tie.push_n, tie.push_b)


@kernel
def compliances(of_inverse: float, rails: Rails) -> None:
    """Write the compliances g of all wheels: of_inverse B^T S^-1 B, and the own ones between the nodes."""
    for i in range(rails.ties.shape[0]):
        tie, load, places = rails.ties[i], rails.loads.numbers[i], rails.loads.places[i]
        rail = 0 if tie.side > 0.0 else 1
        bb = quadratic_form(rails.vertical.inverse[rail], places[0, :4], load[0, :4], load[0, :4])
        nn = nb = 0.0
        for r in range(2):
            band = rails.lateral.inverse[r]
            nn += 0.5 * quadratic_form(band, places[1], load[1], load[1])
            nb += 0.5 * quadratic_form(band, places[1], load[1], load[2])
            bb += 0.5 * quadratic_form(band, places[1], load[2], load[2])
        tie.nn, tie.nb = of_inverse * nn + tie.own_nn, of_inverse * nb + tie.own_nb
        tie.bb = of_inverse * bb + tie.own_bb


@kernel
def begin(method: Array, found: Array, buffer: Array, index: Ints, rails: Rails) -> bool:
    """Begin a step with prepared factors: place the wheels; what the rails do under the forces that are foretold.

    method (10,): step [s], alpha_m, alpha_f, beta, gamma, changes c and d of u and u_t for a change of u_tt, 1 / c and
    d / c of the vehicle's method [1/s2, 1/s], place where the last wheel leaves the window [m]. found (3, 2 wheels):
    receives displacements of the rails to the left and up in turn, and their velocities. Writes how the rail under a
    wheel yields to its record. Returns False, and has done nothing, where the window has to be moved.
    """
    look_ahead(method[0], buffer, index, rails)
    last = rails.ties[0].place
    for i in range(rails.ties.shape[0]):
        last = min(last, rails.ties[i].place)
    if last >= method[9]:
        return False
    c, d = method[5], method[6]
    place(rails)
    for pair in (rails.vertical, rails.lateral):
        for r in range(2):
            _predict(method, pair, r)
    for i in range(rails.ties.shape[0]):
        _add(U_TT, i, rails.ties[i].push_n, rails.ties[i].push_b, rails.loads, rails)
    for pair in (rails.vertical, rails.lateral):
        solve_bands(pair.factors, pair.rows[:, U_TT])
    compliances(c, rails)
    for i in range(rails.ties.shape[0]):
        tie, wheel = rails.ties[i], wheel_record(buffer, index, i)
        p, a, p_t = read(P, i, rails.loads, rails), read(U_TT, i, rails.loads, rails), read(P_T, i, rails.loads, rails)
        u_n, u_b, u = p[0] + c * a[0], p[1] + c * a[1], read(U, i, rails.loads, rails)
        was_p, was_a = read(P, i, rails.behind, rails), read(U_TT, i, rails.behind, rails)
        was = read(U, i, rails.behind, rails)
        # means over the way and the step: what single places miss where the rail has kinks over sleepers
        slope_n = 0.5 * (u_n + u[0] - was_p[0] - c * was_a[0] - was[0]) / tie.way
        slope_b = 0.5 * (u_b + u[1] - was_p[1] - c * was_a[1] - was[1]) / tie.way
        bent_n, bent_b = _bent(tie, tie.push_n, tie.push_b)
        tie.guess_n, tie.guess_b = u_n + bent_n, u_b + bent_b
        tie.rate_n = p_t[0] + d * a[0] + tie.speed * slope_n + (bent_n - tie.bent_n) / method[0]
        tie.rate_b = p_t[1] + d * a[1] + tie.speed * slope_b + (bent_b - tie.bent_b) / method[0]
        # where a force moves along, half of what its own compliance changes is its slope
        bent_n -= tie.before_nn * tie.push_n + tie.before_nb * tie.push_b
        bent_b -= tie.before_nb * tie.push_n + tie.before_bb * tie.push_b
        wheel.slope_n, wheel.slope_b = slope_n + 0.5 * bent_n / tie.way, slope_b + 0.5 * bent_b / tie.way
        wheel.yield_nn, wheel.yield_nb, wheel.yield_bb = tie.nn, tie.nb, tie.bb
        wheel.rate_n, wheel.rate_b = 1.0 / tie.nn, 1.0 / tie.bb
        wheel.held_n, wheel.held_b = 1.0 - method[7] * tie.nn, 1.0 - method[7] * tie.bb
        wheel.free_n = wheel.held_n * tie.guess_n - tie.nn * tie.push_n - tie.nb * tie.push_b
        wheel.free_b = wheel.held_b * tie.guess_b - tie.nb * tie.push_n - tie.bb * tie.push_b
        found[0, 2 * i], found[0, 2 * i + 1] = tie.guess_n, tie.guess_b
        found[1, 2 * i], found[1, 2 * i + 1] = tie.rate_n, tie.rate_b
    return True


@kernel
def look_at_wheels(method: Array, found: Array, buffer: Array, index: Ints, rails: Rails) -> None:
    """Better guesses of the end of a step, once the wheels are where they are foretold: each rail in balance with the
    force of its contact, linear in the changes since the last evaluation.

    Rail and wheel move by some 10 um from step to step; the force between them hangs on a small difference of both. A
    change of the gap along the normal of the contact changes the force by 3/2 of N over the approach (Hertz), one of
    the velocity across it by creep force over creep velocity. found (3, 2 wheels): displacements, velocities,
    accelerations as of an iteration, changed.
    """
    for i in range(rails.ties.shape[0]):
        wheel, arrays = wheel_record(buffer, index, i), index[i * ARRAYS + IN_CONTACT : (i + 1) * ARRAYS]
        last, lobes = read_pose(vector(buffer, arrays, POSE)), records(buffer, arrays, LOBES, LOBE)
        normal, point, stiffness, drag = ZERO, ZERO, 0.0, 0.0
        rails.ties[i].across_n, rails.ties[i].across_b = 1.0, 0.0
        for k in range(wheel_total(buffer, index, i).lobes):
            lobe = lobes[k]
            own = 1.5 * lobe.N / lobe.approach if lobe.approach > 0.0 else 0.0
            creep = hypot(lobe.xi, lobe.eta) * abs(last.velocity.x)
            normal = add(normal, Vec(0.0, own * lobe.no, own * lobe.nb))
            point = shifted(point, own, Vec(lobe.x, lobe.o, lobe.b))
            stiffness += own
            drag += hypot(lobe.Fx, lobe.Fy) / creep if creep > 0.0 else 0.0
        if stiffness > 0.0:
            along, arm = scale(1.0 / norm(normal), normal), sub(scale(1.0 / stiffness, point), last.origin)
            pose, tie, side = pose_on_rail(buffer, index, i), rails.ties[i], wheel.side
            turned = cross(cross(last.axle, sub(pose.axle, last.axle)), arm)
            moved = add(sub(pose.origin, last.origin), turned)
            faster = add(sub(pose.velocity, last.velocity), cross(sub(pose.omega, last.omega), arm))
            n, b = side * along.y, along.z
            tie.across_n, tie.across_b = b, -n
            gap = n * (side * moved.y - found[0, 2 * i]) + b * (moved.z - found[0, 2 * i + 1])
            slip = b * (side * faster.y - found[1, 2 * i]) - n * (faster.z - found[1, 2 * i + 1])
            gap *= 1.0 - 1.0 / (1.0 + stiffness * (n * n * tie.nn + 2.0 * n * b * tie.nb + b * b * tie.bb))
            drag *= method[8] * (b * b * tie.nn - 2.0 * n * b * tie.nb + n * n * tie.bb)
            slip *= (1.0 - 1.0 / (1.0 + drag)) / method[8]
            _correct(method, found[:, 2 * i], n * gap + b * slip)
            _correct(method, found[:, 2 * i + 1], b * gap - n * slip)


@kernel
def hold(
    first: bool, tolerance: float, method: Array, last: Array, unknowns: tuple[Array, Array, Array], ties: Records
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
    for i in range(ties.shape[0]):
        tie, n, b = ties[i], 2 * i, 2 * i + 1
        if first:
            tie.low, tie.high, tie.led = -inf, inf, 0.0
        was, at = tie.across_n * last[n] + tie.across_b * last[b], tie.across_n * q[n] + tie.across_b * q[b]
        if abs(at - was) <= tolerance * tie.nn:
            continue
        leads = 1.0 if at > was else -1.0
        if leads > 0.0:
            tie.low, tie.high = was, tie.high if tie.high > was else inf
        else:
            tie.low, tie.high = tie.low if tie.low < was else -inf, was
        if tie.low <= at <= tie.high:
            tie.led = 0.0
            continue
        end = tie.high if leads > 0.0 else tie.low
        more, tie.led = (end, 0.0) if tie.led == leads else (0.5 * (tie.low + tie.high), leads)
        more -= at
        for k, part in ((n, tie.across_n), (b, tie.across_b)):
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
def end(method: Array, found: Array, buffer: Array, index: Ints, rails: Rails) -> None:
    """End a step. found (1, 2 wheels) or more: displacements of the rails under the wheels, to the left and up in turn,
    that the vehicle's step has found. Their velocities stay those of the step: its forces belong to them."""
    c, d, later = method[5], method[6], (1.0 - method[2]) / (1.0 - method[1])
    for pair in (rails.vertical, rails.lateral):
        pair.rows[:, A] = 0.0  # for the correction
    for i in range(rails.ties.shape[0]):
        tie = rails.ties[i]
        n, b = found[0, 2 * i] - tie.guess_n, found[0, 2 * i + 1] - tie.guess_b
        whole = tie.nn * tie.bb - tie.nb * tie.nb
        more_n, more_b = (tie.bb * n - tie.nb * b) / whole, (tie.nn * b - tie.nb * n) / whole
        _add(A, i, more_n, more_b, rails.loads, rails)
        more_n, more_b = tie.push_n + more_n, tie.push_b + more_b
        tie.push_n, tie.push_b = more_n + TREND * (more_n - tie.last_n), more_b + TREND * (more_b - tie.last_b)
        tie.last_n, tie.last_b = more_n, more_b
        tie.bent_n, tie.bent_b = _bent(tie, more_n, more_b)
        wheel = wheel_record(buffer, index, i)
        wheel.rate_n = wheel.rate_b = 0.0
    for pair in (rails.vertical, rails.lateral):
        solve_bands(pair.factors, pair.rows[:, A])
        for r in range(2):
            own = pair.rows[r]
            for j in range(own.shape[1]):
                own[U_TT, j] += own[A, j]
                own[U, j] = own[P, j] + c * own[U_TT, j]
                own[U_T, j] = own[P_T, j] + d * own[U_TT, j]
                own[A, j] = own[P_A, j] + later * own[U_TT, j]


@inlined
def _bent(tie: Record, push_n: float, push_b: float) -> tuple[float, float]:
    """How far a wheel's force bends its element between the nodes [m]."""
    return tie.own_nn * push_n + tie.own_nb * push_b, tie.own_nb * push_n + tie.own_bb * push_b


@kernel
def _prepare(of_mass: float, of_damping: float, of_stiffness: float, pair: Pair) -> None:
    for r in range(2):
        a, k = pair.factors[r], pair.factors.shape[2] - 1
        for i in range(a.shape[0]):
            for j in range(k + 1):
                a[i, j] = of_mass * pair.mass[r, i, j] + of_damping * pair.damping[r, i, j]
                a[i, j] += of_stiffness * pair.stiffness[r, i, j]
            a[i, k] += of_damping * pair.drag[r, i]
        factorise_bands(a)
        invert_band(a, pair.inverse[r])


@kernel
def _predict(method: Array, pair: Pair, r: int) -> None:
    """Write what the method predicts, and given forces - C p_t - K p to the row of accelerations."""
    h, am, af, beta, gamma = method[0], method[1], method[2], method[3], method[4]
    own, drag = pair.rows[r], pair.drag[r]
    for j in range(own.shape[1]):
        a = (af * own[U_TT, j] - am * own[A, j]) / (1.0 - am)
        own[P, j] = own[U, j] + h * own[U_T, j] + h * h * ((0.5 - beta) * own[A, j] + beta * a)
        own[P_T, j] = own[U_T, j] + h * ((1.0 - gamma) * own[A, j] + gamma * a)
        own[P_A, j] = a
        own[U_TT, j] = pair.given[r, j] - drag[j] * own[P_T, j]
    subtract_product(pair.damping[r], own[P_T], own[U_TT])
    subtract_product(pair.stiffness[r], own[P], own[U_TT])


@kernel
def _add(row: int, i: int, push_n: float, push_b: float, loads: Loads, rails: Rails) -> None:
    """Add a wheel's force to a row of all systems."""
    own, places, side = loads.numbers[i], loads.places[i], rails.ties[i].side
    vertical = rails.vertical.rows[0 if side > 0.0 else 1, row]
    for k in range(4):
        vertical[places[0, k]] += own[0, k] * push_b
    for r in range(2):
        lateral, share = rails.lateral.rows[r, row], sqrt(0.5) * (1.0 if r == 0 else side)
        for k in range(6):
            lateral[places[1, k]] += share * (own[1, k] * push_n + own[2, k] * push_b)


@kernel
def read(row: int, i: int, loads: Loads, rails: Rails) -> tuple[float, float]:
    """What a row of all systems gives for a wheel where its loads are, to the left and up; without its own displacement
    between the nodes."""
    own, places, side = loads.numbers[i], loads.places[i], rails.ties[i].side
    vertical = rails.vertical.rows[0 if side > 0.0 else 1, row]
    n = b = 0.0
    for k in range(4):
        b += own[0, k] * vertical[places[0, k]]
    for r in range(2):
        lateral, share = rails.lateral.rows[r, row], sqrt(0.5) * (1.0 if r == 0 else side)
        for k in range(6):
            n += share * own[1, k] * lateral[places[1, k]]
            b += share * own[2, k] * lateral[places[1, k]]
    return n, b


@kernel
def _node(numbers: Ints, node: int) -> int:
    """Place of a node's first unknown; see ``wrsim.track.sleepers.Layout``."""
    own, elements = numbers[0], numbers[1]
    bay, inner = node // elements, node % elements
    return bay * (own * elements + 1) + (1 + inner * own if inner > 0 else 0)


@kernel
def _shapes(x: float, length: float, phi: float, value: Array) -> None:
    """Shape functions of an element in bending at the part x of its length."""
    one = 1.0 / (1.0 + phi)
    value[0] = one * (1.0 - 3.0 * x * x + 2.0 * x * x * x + phi * (1.0 - x))
    value[1] = one * length * (x - 2.0 * x * x + x * x * x + 0.5 * phi * (x - x * x))
    value[2] = one * (3.0 * x * x - 2.0 * x * x * x + phi * x)
    value[3] = one * length * (x * x * x - x * x - 0.5 * phi * (x - x * x))


@inlined
def _between(a: float, b: float, bending: float, shear: float) -> float:
    """Static deflection under a unit force on a beam clamped at both ends, a behind one and b ahead of the other [m/N],
    of least energy of all reactions."""
    whole, across = a + b, (a + b) ** 3 / (12.0 * bending) + (a + b) / shear
    reaction = (b * b * (3.0 * a + b) / (12.0 * bending) + b / shear) / across
    return b * b * b * (whole / 3.0 - 0.25 * b) / (bending * whole) + b / shear - reaction * reaction * across
