"""Friction elements: Coulomb's law in closed forms, the circle in a plane, energy, both integrators, bad input."""

import itertools
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support import boxes
from support.boxes import element, motion
from support.commands import refusal
from support.runs import FAST
from support.vehicles import ROOT, manchester, shipped

import wrsim
from wrsim import InputError, load
from wrsim.analysis.contacts import force_law
from wrsim.scenario.build import build
from wrsim.simulation import Integrator
from wrsim.simulation.bodies import Solid, mass_matrix, velocity_forces
from wrsim.simulation.force_law import force_derivative
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise, natural_modes
from wrsim.simulation.placement import design_state
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.dynamics.friction import STUCK
from wrsim.vehicle.element_tables import KINDS, VEHICLE_AXES, Joint
from wrsim.vehicle.elements import TRACK, BilinearSpring, Element, Normal, Slider, Strut, Triple
from wrsim.vehicle.equivalent import Stroke
from wrsim.vehicle.loads import Load

INTEGRATORS: tuple[Integrator, ...] = ("rk44", "generalised-alpha")


def pushed(elements: tuple[Element, ...], force: Triple) -> VehicleOnTrack:
    """A box under a constant force: the weight along a slope."""
    return boxes.on_springs(replace(boxes.box(*elements), loads=(Load.constant("slope", "box", force, boxes.AT),)))


def accelerations(law: VehicleOnTrack, q: Any, q_t: Any) -> Any:
    out = np.zeros(law.size)
    law(0.0, q, q_t, out)
    return out


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_block_on_a_slope_stays_below_the_angle_of_friction_and_slides_above_it(integrator: Integrator) -> None:
    """With N = m g cos(a) it accelerates by g (sin(a) - mu cos(a)) where tan(a) > mu, and stays where not."""
    friction, k = 0.3, 4e6
    for slope in (0.27, 0.33):
        along, across = boxes.MASS * 9.81 * np.sin(slope), boxes.MASS * 9.81 * np.cos(slope)
        law = pushed((boxes.FIXED, boxes.slides(friction * across, k)), (along, 0.0, 0.0))
        q, q_t = design_state(law)
        if np.tan(slope) < friction:
            part = np.tan(slope) / friction  # of the bound: on the bend of the stick spring
            x = friction * across / k * (STUCK - (1.0 - STUCK) * np.log((1.0 - part) / (1.0 - STUCK)))
            q[6 + 1] += x
            q_t = law.relaxed_rates(q, q_t)
            assert abs(accelerations(law, q, q_t)[6 + 1]) < 1e-9 * along
            moved = motion(law, q, q_t, 1.0, 1e-3, integrator)
            assert np.abs(moved.q[:, 6 + 1] - q[6 + 1]).max() < 1e-9
        else:
            moved = motion(law, q, q_t, 1.0, 1e-3, integrator)
            v, t = moved.q_t[:, 6 + 1], moved.times
            a = 9.81 * (np.sin(slope) - friction * np.cos(slope))
            late = t > 0.5
            np.testing.assert_allclose(np.gradient(v[late], t[late]), a, rtol=1e-4)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_swing_of_a_block_decays_by_the_same_length_every_period(integrator: Integrator) -> None:
    """4 F/k a period with rigid friction. With a stick stiffness s the elastic part 2 F/s of a stroke does not slip: a
    stroke loses A_n - A_n+1 = 2 F/k (1 - 2 F/(s (A_n + A_n+1)))."""
    force, k = 4e3, 4e5
    for stick, textbook in ((4e7, 0.01), (4e6, 0.1)):
        rails = boxes.spring(stiffness=(k, 0.0, 4e6), turning_stiffness=(4e6, 4e6, 4e6))
        law = boxes.on_springs(boxes.box(rails, boxes.slides(force, stick)))
        q, q_t = design_state(law)
        rest = q[6 + 1]
        q[6 + 1] += 0.1
        moved = motion(law, q, q_t, 1.6, 1e-3, integrator)
        x, v = moved.q[:, 6 + 1] - rest, moved.q_t[:, 6 + 1]
        turns = np.flatnonzero(v[1:-1] * v[2:] < 0.0) + 1
        tops = np.abs(x[turns])[:3]
        assert len(tops) == 3
        for a, b in itertools.pairwise(tops):
            stroke = 2.0 * force / k * (1.0 - 2.0 * force / (stick * (a + b)))
            assert a - b == pytest.approx(stroke, rel=5e-3)
        assert tops[0] - tops[2] == pytest.approx(4.0 * force / k, rel=textbook)


def test_in_a_plane_friction_is_against_the_velocity_and_on_a_circle() -> None:
    """A block turned about the vertical slides alike, and in steady slip the force is F against the velocity."""
    force, k = 8e3, 2e6
    paths = []
    for turn in (0.0, 0.7, 2.1):
        law = boxes.on_springs(boxes.box(boxes.FIXED, boxes.in_plane(force, k)))
        q, q_t = design_state(law)
        c, s = np.cos(turn), np.sin(turn)
        q_t[7], q_t[8] = 0.8 * c, 0.8 * s
        # a push across the way bends it
        push = Load.constant("push", "box", (-2e3 * s, 2e3 * c, 0.0), boxes.AT)
        law = boxes.on_springs(replace(law.vehicle, loads=(push,)))
        moved = motion(law, q, q_t, 0.25, 5e-4, "rk44")
        x, v = moved.q[:, 7:9] - moved.q[0, 7:9], moved.q_t[:, 7:9]
        paths.append(np.stack([c * x[:, 0] + s * x[:, 1], c * x[:, 1] - s * x[:, 0]]))
        pull = k * (x - moved.q_t[:, 12:14])
        size = np.hypot(*pull.T)
        assert size.max() < 1.001 * force
        late = slice(200, None)
        along = np.sum((pull * v)[late], axis=1) / (size * np.hypot(*v.T))[late]
        assert along.min() > 0.999 and size[late].min() > 0.999 * force
    for path in paths[1:]:
        np.testing.assert_allclose(path, paths[0], atol=1e-9)


def test_friction_takes_power_whatever_its_bound_does() -> None:
    """Power into the element less the growth of what its spring stores is nowhere negative, also where the normal force
    has just fallen and the spring holds more than the bound."""
    rng = np.random.default_rng(3)
    for bound in (0.0, 3e3, 8e3):
        law = boxes.on_springs(boxes.box(boxes.FIXED, boxes.in_plane(bound, 2e6)))
        q, q_t = design_state(law)
        for _ in range(40):
            z, v = rng.normal(0.0, 3e-3, 2), rng.normal(0.0, 0.3, 2)
            q[7:9], q_t[7:9], q_t[12:14] = np.array((100.0, 0.0)) + z, v, 0.0
            out = accelerations(law, q, q_t)
            power, slip = -out[7:9] @ v, out[12:14]
            assert np.hypot(*out[7:9]) <= bound * (1.0 + 1e-12)
            taken = power - 2e6 * z @ (v - slip)
            assert taken >= -1e-9 * abs(power)
            loss = law.elements["loss"].sum()
            # no force beyond the bound takes power on the slip, be the spring as far out as it will
            assert 0.0 <= loss <= bound * np.hypot(*slip) * (1.0 + 1e-12)
            if 2e6 * np.hypot(*z) <= bound:
                assert loss == pytest.approx(taken, abs=1e-9 * abs(power))


def test_friction_between_bodies_keeps_momentum_and_its_derivatives_are_those_of_its_forces() -> None:
    """The Jacobian by differences of half the length is the same, stuck and in slip."""
    struts = tuple(
        replace(element, name=f"{i}", first="box", second="lid")
        for i, element in enumerate((boxes.slides(3e3, 2e6, 1), boxes.in_plane(4e3, 1e6), boxes.FIXED))
    )
    two = boxes.box(boxes.FIXED, *struts)
    lid = replace(two.bodies[0], name="lid")
    law = boxes.on_springs(replace(two, bodies=(*two.bodies, lid)))
    q, q_t = boxes.displaced(law)
    for stretched in (1e-4, 1.5e-3, 8e-3):
        q_t[18:] = law.relaxed_rates(q, q_t)[18:] * (1.0 - stretched)
        jacobian = force_derivative(law, q, q_t, 3, 0.0, 0.7, 300.0)
        out, column = np.zeros(law.size), np.zeros(law.size)
        for i in range(6, law.size):
            column[:] = 0.0
            by_q, by_q_t = (0.0 if i >= 18 else 0.7), 300.0
            h = (1e-7 if i >= 18 else 1e-6 if i % 6 in (1, 2, 3) else 1e-7) / 600.0
            for sign in (1.0, -1.0):
                a, b = q.copy(), q_t.copy()
                a[i] += sign * h * by_q
                b[i] += sign * h * by_q_t
                law(0.0, a, b, out)
                column += sign * out / (2.0 * h)
            np.testing.assert_allclose(jacobian[:, i], column, atol=2e-4 * np.abs(jacobian[:, i]).max())


def test_the_friction_of_a_link_follows_the_load_of_its_spring() -> None:
    """A body that bounces on its spring presses its friction together with mu times the spring's force, and not at all
    while the spring pulls."""
    vertical, k, friction = 4e5, 2e6, 0.3
    # along x, with the force of the vertical spring
    carries = boxes.spring(stiffness=(0.0, 0.0, vertical), turning_stiffness=(4e6, 4e6, 4e6))
    slider = Slider("coulomb", k, friction=friction, normal=Normal("spring", 1.5))
    link = Strut("link", "friction", TRACK, "box", (boxes.AT, boxes.AT), 0, slider=slider)
    vehicle = boxes.box(link, carries)
    law = boxes.on_springs(vehicle, gravity=vehicle.gravity)
    q, q_t = design_state(law)
    q_t[7] = 0.4
    q[7] += 0.05  # far in slip
    for lower in (0.0, 0.03, -0.05, -0.2):
        q[6] -= lower
        out = accelerations(law, q, q_t)
        load = max(0.0, boxes.MASS * vehicle.gravity + vertical * lower)
        assert -out[7] == pytest.approx(friction * 1.5 * load, rel=1e-12, abs=1e-9)
        q[6] += lower
    swapped = boxes.on_springs(replace(vehicle, elements=vehicle.elements[::-1]), gravity=vehicle.gravity)
    np.testing.assert_array_equal(accelerations(swapped, q, q_t), accelerations(law, q, q_t))


def test_what_nothing_presses_and_more_threads_than_cores_are_refused(monkeypatch) -> None:
    level = boxes.spring(name="level", stiffness=(1e6, 1e6, 0.0))
    for of, message in (("level", "carries nothing along z at rest"), ("levle", "there is no spring 'levle'.*level")):
        slider = Slider("coulomb", 1e6, friction=0.3, normal=Normal(of))
        link = Strut("link", "friction", TRACK, "box", (boxes.AT, boxes.AT), 0, slider=slider)
        with pytest.raises(InputError, match=message):
            boxes.on_springs(boxes.box(level, boxes.FIXED, link))
    with pytest.raises(InputError, match=r"threads: must be a whole number from 1 to \d+.*not 100000"):
        force_law(replace(build(load(SCENARIO).with_values(FAST)), threads=100_000))
    assert "threads: must be" in refusal("run", str(SCENARIO), "--threads", "100000")
    monkeypatch.setitem(sys.modules, "numba.np.ufunc.omppool", None)
    with pytest.raises(InputError, match="need OpenMP"):
        wrsim.run(load(SCENARIO), threads=2)


def test_in_small_motions_friction_sticks() -> None:
    """Natural modes and the linearised system have the stick stiffness, and no unknown of a slider."""
    stick = (4e6, 6e6)
    first = boxes.slides(1e3, stick[0], 0)
    second = replace(boxes.slides(1e3, stick[1], 1), name="other")
    law = boxes.on_springs(boxes.box(boxes.FIXED, first, second))
    modes = {mode.name: mode.frequency for mode in natural_modes(law.vehicle, Stroke(1e-4, 1.0))}
    assert modes["box longitudinal"] == pytest.approx(np.sqrt(stick[0] / boxes.MASS) / (2.0 * np.pi), rel=1e-6)
    assert modes["box lateral"] == pytest.approx(np.sqrt(stick[1] / boxes.MASS) / (2.0 * np.pi), rel=1e-6)
    q, q_t = design_state(law)
    q[7] += 5e-3  # far in slip
    linear = linearise(law, law.bodies, q, law.relaxed_rates(q, q_t), Stroke(1e-4, 1.0))
    assert linear.stiffness[7, 7] == pytest.approx(stick[0], rel=1e-6)
    assert len(linear.state_matrix) == 24


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_run_with_friction_that_is_cut_goes_on_to_the_bit(integrator: Integrator) -> None:
    """Everything that friction remembers stands in the state."""
    law = boxes.on_springs(
        boxes.box(boxes.spring(stiffness=(4e5, 4e5, 4e6), turning_stiffness=(4e6,) * 3), boxes.in_plane(4e3, 4e6))
    )
    q, q_t = design_state(law)
    q[7], q[8] = q[7] + 0.05, q[8] + 0.02
    whole = motion(law, q, q_t, 0.4, 1e-3, integrator)
    system = BodySystem(law.bodies, law)
    half = motion(law, q, q_t, 0.2, 1e-3, integrator)
    rest = Integration(system, start=0.2, duration=0.2, step=1e-3, integrator=integrator, weight=boxes.MASS * 0.01).run(
        half.q[-1], half.q_t[-1]
    )
    np.testing.assert_array_equal(rest.q[-1], whole.q[-1])
    np.testing.assert_array_equal(rest.q_t[-1], whole.q_t[-1])


# Leaf springs, rubber, air springs, nested springs and play: their loops against closed forms.
@pytest.mark.parametrize("turned", [False, True])
def test_a_spring_with_an_uneven_table_pushes_back_by_it_also_in_a_part_that_is_turned_round(turned: bool) -> None:
    keys = {"direction": "x", "travel_mm_force_kN": [[-50, -4], [0, 0], [20, 2], [50, 20]]}
    axes = replace(VEHICLE_AXES, signs=(-1.0, -1.0, 1.0)) if turned else VEHICLE_AXES
    law = boxes.on_springs(boxes.box(boxes.FIXED, element("tabulated-spring", axes, **keys)))
    for travel, force in ((-0.05, -4e3), (0.01, 1e3), (0.035, 11e3)):
        q, q_t = design_state(law)
        q[boxes.X] += -travel if turned else travel
        law(0.0, q, q_t, out := np.zeros(law.size))
        assert out[boxes.X] == pytest.approx(force if turned else -force, rel=1e-9)


K, LIMIT, X2 = 2e5, 3e3, 4e-3


@pytest.mark.parametrize("amplitude", [2e-3, 4e-3, 20e-3])
def test_the_loops_of_rubber_are_those_of_berg(amplitude: float) -> None:
    """Between the returns at (-a, -f0) and (a, f0) his stroke f = -f0 + s (F + f0)/(x2 (1 + f0/F) + s) closes where
    f0 = F (sqrt(x2^2 + 6 a x2 + a^2) - x2 - a)/(2 x2); its area 2 F (2 a - x2 (1 + m)^2 ln(1 + 2 a/(x2 (1 + m)))) with
    m = f0/F, both by integration of the stroke. Stiffness K + f0/a falls with the amplitude."""
    rubber = element(
        "rubber-spring", stiffness_kN_per_m=1e-3 * K, friction_force_kN=1e-3 * LIMIT, friction_travel_mm=1e3 * X2
    )
    travel, force = boxes.last_loop(boxes.on_springs(boxes.box(boxes.FIXED, rubber)), amplitude, loops=12, steps=200)
    a, x2 = amplitude, X2
    f0 = LIMIT * (np.sqrt(x2**2 + 6.0 * a * x2 + a**2) - x2 - a) / (2.0 * x2)
    m = f0 / LIMIT
    area = 2.0 * LIMIT * (2.0 * a - x2 * (1.0 + m) ** 2 * np.log(1.0 + 2.0 * a / (x2 * (1.0 + m))))
    assert force.max() == pytest.approx(K * a + f0, rel=2e-3)
    assert force.min() == pytest.approx(-K * a - f0, rel=2e-3)
    assert np.trapezoid(force, travel) == pytest.approx(area, rel=1e-2)
    up = np.gradient(travel) > 0.0
    s = travel[up] + a
    stroke = K * travel[up] - f0 + s * (LIMIT + f0) / (x2 * (1.0 + m) + s)
    np.testing.assert_allclose(force[up], stroke, atol=5e-3 * LIMIT)


@pytest.mark.parametrize("share", [False, True])
def test_the_loops_of_a_leaf_spring_are_those_of_fancher(share: bool) -> None:
    """Every stroke ends at F (1 - exp(-s/b)) + f exp(-s/b) of where it began, so the loop between -a and a has its
    corners at F tanh(a/b). As a share of the load the same, where the load hardly changes."""
    amplitude, distance = 8e-3, 3e-3
    if share:
        amplitude = 0.8e-3  # of 98 mm of static travel
        law = boxes.on_springs(
            boxes.box(
                boxes.spring(stiffness=(4e6, 4e6, 0.0), turning_stiffness=(4e6,) * 3),
                element("leaf-spring", direction="z", stiffness_kN_per_m=400, friction_share=0.1,
                        friction_travel_mm=1e3 * distance),
            ),
            gravity=9.80665,
        )  # fmt: skip
        limit = 0.1 * boxes.MASS * 9.80665
        q, q_t = design_state(law)
        for lower, sign in ((amplitude, 1.0), (-amplitude, -1.0)):
            q[boxes.Z] -= lower
            out = np.zeros(law.size)
            law(0.0, q, law.relaxed_rates(q, q_t), out)
            bound = limit + sign * 0.1 * 4e5 * amplitude
            virgin = bound * (1.0 - np.exp(-amplitude / distance * limit / bound))
            assert out[boxes.Z] == pytest.approx(sign * (4e5 * amplitude + virgin), rel=1e-9)
            q[boxes.Z] += lower
        return
    leaf = element(
        "leaf-spring", stiffness_kN_per_m=1e-3 * K, friction_force_kN=1e-3 * LIMIT, friction_travel_mm=1e3 * distance
    )
    travel, force = boxes.last_loop(boxes.on_springs(boxes.box(boxes.FIXED, leaf)), amplitude)
    corner = LIMIT * np.tanh(amplitude / distance)
    assert force.max() == pytest.approx(K * amplitude + corner, rel=2e-3)
    up = np.gradient(travel) > 0.0
    s = travel[up] + amplitude
    np.testing.assert_allclose(
        force[up], K * travel[up] + LIMIT - (LIMIT + corner) * np.exp(-s / distance), atol=5e-3 * LIMIT
    )


def test_an_air_spring_is_soft_when_slow_stiff_when_fast_and_damps_in_between() -> None:
    """Between K and K + series; a Maxwell part with a linear orifice has its largest loss, series/2, at series/c."""
    series, c, amplitude = 3e5, 6e4, 5e-3
    air = element(
        "air-spring", stiffness_kN_per_m=1e-3 * K, series_stiffness_kN_per_m=1e-3 * series,
        orifice_damping=1e-3 * c, orifice_exponent=1.0,
    )  # fmt: skip
    law = boxes.on_springs(boxes.box(boxes.FIXED, air))
    for part, stiffness, loss in ((0.02, K, None), (1.0, K + 0.5 * series, 0.5 * series), (50.0, K + series, None)):
        w = part * series / c
        times = np.linspace(0.0, 4.0 * 2.0 * np.pi / w, 2401)
        force = boxes.driven(law, lambda t, w=w: amplitude * np.sin(w * t), times)
        late = slice(1800, None)  # the last period
        inphase = 2.0 * np.trapezoid(force[late] * np.sin(w * times[late]), w * times[late]) / (2.0 * np.pi)
        quadrature = 2.0 * np.trapezoid(force[late] * np.cos(w * times[late]), w * times[late]) / (2.0 * np.pi)
        assert inphase / amplitude == pytest.approx(stiffness, rel=5e-3)
        if loss is not None:
            assert quadrature / amplitude == pytest.approx(loss, rel=5e-3)


def test_an_orifice_has_the_force_of_its_power_law() -> None:
    air = element(
        "air-spring", stiffness_kN_per_m=100, series_stiffness_kN_per_m=300, orifice_damping=50, orifice_exponent=1.8
    )
    velocity, force = np.transpose(air.damper_table)
    for v in (-0.5, 2e-3, 0.03, 1.0):
        assert np.interp(v, velocity, force) == pytest.approx(np.sign(v) * 5e4 * abs(v) ** 1.8, rel=3e-3)


def test_a_nest_of_springs_stands_on_its_line_where_its_load_is_and_never_pulls() -> None:
    k, inner, inner_from = 1e6, 1.5e6, 0.6 * boxes.MASS * 9.81
    more = {"second_stiffness": inner, "second_from": inner_from}
    nest = BilinearSpring("nest", "bilinear-spring", TRACK, "box", (boxes.AT, boxes.AT), 2, k, **more)
    for times in (0.5, 1.0):  # below and beyond the bend
        gravity = 9.81 * times
        vehicle = boxes.box(boxes.spring(stiffness=(4e6, 4e6, 0.0), turning_stiffness=(4e6,) * 3), nest)
        law = boxes.on_springs(replace(vehicle, gravity=gravity), gravity=gravity)
        q, q_t = design_state(law)
        weight = boxes.MASS * gravity
        compressed = min(weight, inner_from) / k + max(0.0, weight - inner_from) / (k + inner)
        for lower in (0.0, 5e-3, -5e-3, -compressed - 1e-3):
            total = max(0.0, compressed + lower)
            expected = k * total + inner * max(0.0, total - inner_from / k)
            q[boxes.Z] -= lower
            law(0.0, q, q_t, out := np.zeros(law.size))
            assert out[boxes.Z] == pytest.approx(expected - weight, abs=1e-6 * weight)
            q[boxes.Z] += lower
        (bounce,) = (mode for mode in natural_modes(law.vehicle) if mode.name == "box vertical")
        stiffness = k if times == 0.5 else k + inner
        assert bounce.frequency == pytest.approx(np.sqrt(stiffness / boxes.MASS) / (2.0 * np.pi), rel=1e-6)


def test_a_mass_between_two_stops_with_play_swings_with_the_time_that_it_flies() -> None:
    """Half a swing against either stop and the play at its speed: T = 2 pi sqrt(m/k) + 4 c/v."""
    k, play, speed = 4e6, 0.02, 0.5
    rod = KINDS["traction-rod"].model_validate(
        {
            "kind": "traction-rod", "name": "rod", "body": "track", "to": ["box"], "stiffness_kN_per_m": 1e-3 * k,
            "clearance_mm": 1e3 * play, "body_mm": [-3000, 0, 1e3 * boxes.HEIGHT], "to_mm": [0, 0, 1e3 * boxes.HEIGHT],
        }
    )  # fmt: skip
    law = boxes.on_springs(
        boxes.box(boxes.FIXED, rod.element(Joint("rod", "traction-rod", TRACK, "box"), VEHICLE_AXES))
    )
    q, q_t = design_state(law)
    place = q[boxes.X]
    q_t[boxes.X] = speed
    moved = motion(law, q, q_t, 1.3, 2e-4, "rk44")
    x = moved.q[:, boxes.X] - place - 1e-6
    crossings = moved.times[1:][(x[:-1] < 0.0) & (x[1:] >= 0.0)]
    assert len(crossings) >= 3
    period = 2.0 * np.pi * np.sqrt(boxes.MASS / k) + 4.0 * play / speed
    np.testing.assert_allclose(np.diff(crossings), period, rtol=3e-3)


# Suspension elements: laws that hold for every one of them, closed forms of simple systems; no rails needed.
@pytest.mark.parametrize("name", ["manchester_1", "cooperrider_bogie"])
def test_springs_have_a_potential_at_any_displacement(name: str) -> None:
    """The derivative of the generalised forces with respect to the coordinates is symmetric where nothing moves."""
    law = boxes.on_springs(shipped(name))
    q, q_t = boxes.displaced(law)
    q_t[: 6 * len(law.bodies)] = 0.0
    spins = range(5, 6 * len(law.vehicle.wheelsets), 6)  # which move no spring
    assert boxes.symmetric(boxes.derivatives(law, q, q_t, 6 * len(law.bodies)), *spins)


def test_elements_between_bodies_keep_momentum_and_angular_momentum() -> None:
    law = boxes.on_springs(manchester())
    q, q_t = boxes.displaced(law)
    law(0.0, q, q_t, np.zeros(law.size))
    boxes.moment_kept(law)


@pytest.mark.parametrize("damping", [5e2, 2e4, 5e5])
def test_a_mass_on_a_spring_and_a_damper_behind_a_spring_has_the_roots_of_its_cubic(damping: float) -> None:
    """m x_tt + k x + k_s (x - x_d) = 0, c x_d,t = k_s (x - x_d)."""
    k, series = 4e5, 6e5
    struts = Strut(
        "d", "damper", TRACK, "box", ((0.0, 0.0, boxes.HEIGHT),) * 2, 2, damping=damping, series_stiffness=series
    )
    modes = natural_modes(boxes.box(boxes.spring(stiffness=(1e7, 2e7, k)), struts))
    mode = next(m for m in modes if m.name == "box vertical")
    lag = damping / series
    roots = np.roots([boxes.MASS * lag, boxes.MASS, (k + series) * lag, k])
    root = roots[np.argmax(roots.imag)]
    assert mode.frequency == pytest.approx(abs(root) / (2.0 * np.pi), rel=1e-6)
    assert mode.damping == pytest.approx(-root.real / abs(root), rel=1e-6)


def test_a_flexible_column_bends_like_a_cantilever() -> None:
    """Shear stiffness 12 E I/h^3 and bending stiffness E I/h at its middle: the loaded end yields by F h^3/(3 E I)."""
    stiffness, h = 2e6, 0.6
    column = boxes.spring(
        (0.0, 0.0, boxes.HEIGHT - 0.5 * h),
        stiffness=(12.0 * stiffness / h**3, 12.0 * stiffness / h**3, 1e8),
        turning_stiffness=(stiffness / h, stiffness / h, 1e8),
        column=True,
    )
    vehicle = boxes.box(column)
    weightless = replace(vehicle, bodies=(replace(vehicle.bodies[0], mass=1e-3),))  # a load would push the column over
    law = boxes.on_springs(weightless)
    q, q_t = design_state(law)
    matrix = linearise(law, law.bodies, q, q_t).stiffness[6:12, 6:12]
    yields = np.linalg.inv(matrix)
    assert yields[2, 2] == pytest.approx(h**3 / (3.0 * stiffness), rel=1e-6)
    assert abs(yields[4, 2]) == pytest.approx(h**2 / (2.0 * stiffness), rel=1e-6)  # slope of the end


def test_a_bump_stop_follows_its_table_both_ways_and_goes_on_beyond_it() -> None:
    stop = next(e for e in manchester().elements if e.name == "front.lateral stop")
    assert isinstance(stop, Strut)
    assert stop.limits == (-0.065, 0.065)
    law = boxes.on_springs(boxes.box(replace(stop, first=TRACK, second="box"), boxes.spring(stiffness=(1.0, 0.0, 1e6))))
    q, q_t = design_state(law)
    out = np.zeros(law.size)
    for travel, force in ((0.02, 0.0), (0.03, 600.0), (0.0425, 5300.0), (0.065, 230e3), (0.066, 270160.0)):
        for side in (1.0, -1.0):
            q[6 + 2] = side * travel
            law(0.0, q, q_t, out)
            assert out[6 + 2] == pytest.approx(-side * force, rel=1e-9, abs=1e-9)


def test_the_bodies_of_exudyn_accelerate_as_mass_matrix_and_velocity_forces_say() -> None:
    body = Solid(10.0, (2.0, 3.0, 4.0))

    def twist(t: float, q: np.ndarray, q_t: np.ndarray, out: np.ndarray) -> None:
        out[:] = (1.0, 2.0, 3.0, 0.4, 0.5, 0.6)

    system = BodySystem([body], twist)
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.3, -0.5])
    q_t = np.array([0.0, 0.0, 0.0, 1.1, -0.7, 0.9])
    step = 1e-4
    motion = Integration(system, duration=2 * step, step=step, integrator="rk44").run(q, q_t)
    measured = (motion.q_t[2] - motion.q_t[0]) / (2 * step)
    out = np.zeros(6)
    twist(step, motion.q[1], motion.q_t[1], out)
    h = velocity_forces([body], motion.q[1], motion.q_t[1])
    middle = np.linalg.solve(mass_matrix([body], motion.q[1]), out - h)
    assert np.allclose(measured, middle, rtol=1e-6, atol=1e-6)


# Contacts that several threads compute side by side.
SCENARIO = ROOT / "scenarios/manchester_r300.toml"


def test_threads_change_no_bit():
    # strips start from their last answer, so that every state tells what the one before has left
    setup = build(load(SCENARIO).with_values({"contact.strips": 12, "run.start_distance_m": 70.0}))
    states = []
    for threads in (1, 2):
        law = force_law(replace(setup, threads=threads))
        q, q_t = design_state(law)
        wheels = slice(6 * len(law.wheels))
        rng, out = np.random.default_rng(3), np.zeros(law.size)
        law.follow(True)
        for _ in range(6):
            q[wheels] += 2e-5 * rng.standard_normal(q[wheels].shape)
            law(0.0, q, q_t, out)
            states.append(out.tobytes() + law.get_state().tobytes())
    assert states[:6] == states[6:]
    assert len(set(states)) == 6
