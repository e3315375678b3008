"""Rails on sleepers as systems under the forces of wheels: load vectors, static rest, compliances.

The four systems of ``wrsim.track.sleepers`` stand in two pairs of one layout. A wheel loads the nodes of the element
that it is on; between the nodes the element bends under the wheel's own force besides (``dynamics.sleepers``).
"""

from math import sqrt
from typing import NamedTuple

from wrsim.jit import Array, Ints, Record, Records, inlined, kernel, record
from wrsim.jit.root import neighbours
from wrsim.track.banded import factorise_bands, invert_band, quadratic_form, solve_bands

WHEEL_ON_RAIL = record("""
    side          [1]   +1 left, -1 right
    place         [m]   distance along the centre line at the end of the step
    speed         [m/s] speed along it
    offset        [m]   place of the force to the left of the rail's middle
    push_n        [N]   force on the rail to the left, foretold for the end of the step
    push_b        [N]   force upward, foretold
    last_n        [N]   force to the left at the end of the last step
    last_b        [N]   force upward then
    guess_n       [m]   displacement of the rail to the left with the foretold force
    guess_b       [m]   displacement upward with it
    rate_n        [m/s] velocity of the rail to the left with the foretold force
    rate_b        [m/s] velocity upward with it
    nn            [m/N] compliance g: lateral, ...
    nb            [m/N] ... coupling ...
    bb            [m/N] ... and vertical
    element_nn        [m/N] part of g of the element between its nodes: lateral, ...
    element_nb        [m/N] ... coupling ...
    element_bb        [m/N] ... and vertical
    before_nn     [m/N] that part a step's distance behind: lateral, ...
    before_nb     [m/N] ... coupling ...
    before_bb     [m/N] ... and vertical
    step_distance [m]   distance that the wheel rolls in the step
    bent_n        [m]   deflection of the element between its nodes at the last step's end, to the left
    bent_b        [m]   deflection upward
    across_n      [1]   direction across the normal of the contact, to the left
    across_b      [1]   and up
    lower         [m]   displacement along it, below which the end of the step does not lie
    upper         [m]   displacement above which it does not lie
    bracketed     [1]   bound beyond which the last iteration led: +1 upper, -1 lower, 0 none
""")
"""A wheel on its rail."""

U, U_T, U_TT, A, P, P_T, P_A = range(7)
"""Rows of a system: displacements, velocities, accelerations and those of the method; what it predicts."""
ROWS = 7


class Pair(NamedTuple):
    """Two systems of the same layout; numbers: unknowns of a node, elements of a bay. bands (2, n, k +
    1): mass, damping, stiffness, factors, the band of the inverse; drag (2, n): dampers of the end zones; forces (2,
    n): of what moves below; rows (2, ROWS, n); bending (2, elements) [N m2]; shear (1,) [N]."""

    numbers: Ints
    mass: Array
    damping: Array
    stiffness: Array
    factors: Array
    inverse: Array
    drag: Array
    forces: Array
    rows: Array
    bending: Array
    shear: Array


class Loads(NamedTuple):
    """Load vectors of all wheels. numbers (wheels, 3, 6): of a vertical force in the vertical system, and of a lateral
    and a vertical one in the lateral systems; places (wheels, 2, 6) of these."""

    numbers: Array
    places: Ints


class Rails(NamedTuple):
    """Vertical and lateral systems; nodes (n,) [m]; wheels: records WHEEL_ON_RAIL; loads at their places,
    and a step's distance behind; head (2,): height of the head above the shear centre [m], torsional stiffness G J
    [N m2]; along (3, m): distances along the left, along the right rail, along the centre line."""

    vertical: Pair
    lateral: Pair
    nodes: Array
    wheels: Records
    loads: Loads
    behind: Loads
    head: Array
    along: Array


@kernel
def place(rails: Rails) -> None:
    """Load vectors and compliances of the elements of all wheels at their places, and a step behind."""
    for i in range(rails.wheels.shape[0]):
        on_rail = rails.wheels[i]
        behind = on_rail.place - on_rail.step_distance
        on_rail.before_nn, on_rail.before_nb, on_rail.before_bb = _load(i, behind, rails.behind, rails)
        on_rail.element_nn, on_rail.element_nb, on_rail.element_bb = _load(i, on_rail.place, rails.loads, rails)


@kernel
def _load(i: int, distance: float, loads: Loads, rails: Rails) -> tuple[float, float, float]:
    """Load vectors of a wheel at a place [m]; returns the compliance of its element between the nodes [m/N]."""
    on_rail, load, places = rails.wheels[i], loads.numbers[i], loads.places[i]
    low, _high, _part = neighbours(rails.nodes, distance)
    e = min(low, rails.nodes.shape[0] - 2)
    length = rails.nodes[e + 1] - rails.nodes[e]
    xi = (distance - rails.nodes[e]) / length
    rail = 0 if on_rail.side > 0.0 else 1
    head, twisting, offset = rails.head[0], rails.head[1], on_rail.offset
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
def rest(speed_too: bool, rails: Rails) -> None:
    """Static displacements under the wheels' forces, by prepared factors of the stiffness; speed_too: velocities of
    what moves along with the wheels, else none."""
    for pair in (rails.vertical, rails.lateral):
        pair.rows[:] = 0.0
    for i in range(rails.wheels.shape[0]):
        on_rail = rails.wheels[i]
        add_load(U, i, on_rail.push_n, on_rail.push_b, rails.loads, rails)
        if speed_too:
            rate = on_rail.speed / on_rail.step_distance
            add_load(U_T, i, rate * on_rail.push_n, rate * on_rail.push_b, rails.loads, rails)
            add_load(U_T, i, -rate * on_rail.push_n, -rate * on_rail.push_b, rails.behind, rails)
    for pair in (rails.vertical, rails.lateral):
        solve_bands(pair.factors, pair.rows[:, U])
        solve_bands(pair.factors, pair.rows[:, U_T])
    for i in range(rails.wheels.shape[0]):
        on_rail = rails.wheels[i]
        on_rail.bent_n, on_rail.bent_b = bent(on_rail, on_rail.push_n, on_rail.push_b)


@kernel
def compliances(of_inverse: float, rails: Rails) -> None:
    """Write the compliances g of all wheels: of_inverse B^T S^-1 B, and the own ones between the nodes."""
    for i in range(rails.wheels.shape[0]):
        on_rail, load, places = rails.wheels[i], rails.loads.numbers[i], rails.loads.places[i]
        rail = 0 if on_rail.side > 0.0 else 1
        bb = quadratic_form(rails.vertical.inverse[rail], places[0, :4], load[0, :4], load[0, :4])
        nn = nb = 0.0
        for r in range(2):
            band = rails.lateral.inverse[r]
            nn += 0.5 * quadratic_form(band, places[1], load[1], load[1])
            nb += 0.5 * quadratic_form(band, places[1], load[1], load[2])
            bb += 0.5 * quadratic_form(band, places[1], load[2], load[2])
        on_rail.nn, on_rail.nb = of_inverse * nn + on_rail.element_nn, of_inverse * nb + on_rail.element_nb
        on_rail.bb = of_inverse * bb + on_rail.element_bb


@kernel
def add_load(row: int, i: int, push_n: float, push_b: float, loads: Loads, rails: Rails) -> None:
    """Add a wheel's force to a row of all systems."""
    vectors, places, side = loads.numbers[i], loads.places[i], rails.wheels[i].side
    vertical = rails.vertical.rows[0 if side > 0.0 else 1, row]
    for k in range(4):
        vertical[places[0, k]] += vectors[0, k] * push_b
    for r in range(2):
        lateral, share = rails.lateral.rows[r, row], sqrt(0.5) * (1.0 if r == 0 else side)
        for k in range(6):
            lateral[places[1, k]] += share * (vectors[1, k] * push_n + vectors[2, k] * push_b)


@kernel
def read(row: int, i: int, loads: Loads, rails: Rails) -> tuple[float, float]:
    """What a row of all systems gives for a wheel where its loads are, to the left and up; without its own displacement
    between the nodes."""
    vectors, places, side = loads.numbers[i], loads.places[i], rails.wheels[i].side
    vertical = rails.vertical.rows[0 if side > 0.0 else 1, row]
    n = b = 0.0
    for k in range(4):
        b += vectors[0, k] * vertical[places[0, k]]
    for r in range(2):
        lateral, share = rails.lateral.rows[r, row], sqrt(0.5) * (1.0 if r == 0 else side)
        for k in range(6):
            n += share * vectors[1, k] * lateral[places[1, k]]
            b += share * vectors[2, k] * lateral[places[1, k]]
    return n, b


@inlined
def bent(on_rail: Record, push_n: float, push_b: float) -> tuple[float, float]:
    """How far a wheel's force bends its element between the nodes [m]."""
    nn, nb, bb = on_rail.element_nn, on_rail.element_nb, on_rail.element_bb
    return nn * push_n + nb * push_b, nb * push_n + bb * push_b


@kernel
def _node(numbers: Ints, node: int) -> int:
    """Place of a node's first unknown; see ``wrsim.track.sleepers.Layout``."""
    unknowns, elements = numbers[0], numbers[1]
    bay, inner = node // elements, node % elements
    return bay * (unknowns * elements + 1) + (1 + inner * unknowns if inner > 0 else 0)


@kernel
def _shapes(x: float, length: float, phi: float, value: Array) -> None:
    """Shape functions of an element in bending at the part x of its length."""
    scale = 1.0 / (1.0 + phi)
    value[0] = scale * (1.0 - 3.0 * x * x + 2.0 * x * x * x + phi * (1.0 - x))
    value[1] = scale * length * (x - 2.0 * x * x + x * x * x + 0.5 * phi * (x - x * x))
    value[2] = scale * (3.0 * x * x - 2.0 * x * x * x + phi * x)
    value[3] = scale * length * (x * x * x - x * x - 0.5 * phi * (x - x * x))


@inlined
def _between(a: float, b: float, bending: float, shear: float) -> float:
    """Static deflection under a unit force on a beam clamped at both ends, a behind one and b ahead of the other [m/N],
    of least energy of all reactions."""
    whole, across = a + b, (a + b) ** 3 / (12.0 * bending) + (a + b) / shear
    reaction = (b * b * (3.0 * a + b) / (12.0 * bending) + b / shear) / across
    return b * b * b * (whole / 3.0 - 0.25 * b) / (bending * whole) + b / shear - reaction * reaction * across
