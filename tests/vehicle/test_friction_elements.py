"""Friction elements: Coulomb's law in closed forms, the circle in a plane, energy, both integrators, bad input."""

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.boxes import AT, FIXED, MASS, box, displaced, in_plane, motion, on_springs, slides, spring

from wrsim.core.body.friction import STUCK
from wrsim.errors import InputError
from wrsim.simulation import Integrator
from wrsim.simulation.force_law import force_derivative
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise, natural_modes
from wrsim.simulation.placement import design_state
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.elements import TRACK, Element, Normal, Slider, Strut, Triple
from wrsim.vehicle.loads import Load

INTEGRATORS: tuple[Integrator, ...] = ("rk44", "generalised-alpha")


def pushed(elements: tuple[Element, ...], force: Triple) -> VehicleOnTrack:
    """A box under a constant force: the weight along a slope."""
    return on_springs(replace(box(*elements), loads=(Load.constant("slope", "box", force, AT),)))


def accelerations(law: VehicleOnTrack, q: Any, q_t: Any) -> Any:
    out = np.zeros(law.size)
    law(0.0, q, q_t, out)
    return out


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_block_on_a_slope_stays_below_the_angle_of_friction_and_slides_above_it(integrator: Integrator) -> None:
    """With N = m g cos(a) it accelerates by g (sin(a) - mu cos(a)) where tan(a) > mu, and stays where not."""
    friction, k = 0.3, 4e6
    for slope in (0.27, 0.33):
        along, across = MASS * 9.81 * np.sin(slope), MASS * 9.81 * np.cos(slope)
        law = pushed((FIXED, slides(friction * across, k)), (along, 0.0, 0.0))
        q, q_t = design_state(law)
        if np.tan(slope) < friction:
            part = np.tan(slope) / friction  # of the bound: on the bend of the stick spring
            x = friction * across / k * (STUCK - (1.0 - STUCK) * np.log((1.0 - part) / (1.0 - STUCK)))
            q[6 + 1] += x
            q_t = law.settled_rates(q, q_t)
            assert abs(accelerations(law, q, q_t)[6 + 1]) < 1e-9 * along
            found = motion(law, q, q_t, 1.0, 1e-3, integrator)
            assert np.abs(found.q[:, 6 + 1] - q[6 + 1]).max() < 1e-9
        else:
            found = motion(law, q, q_t, 1.0, 1e-3, integrator)
            v, t = found.q_t[:, 6 + 1], found.times
            a = 9.81 * (np.sin(slope) - friction * np.cos(slope))
            late = t > 0.5
            np.testing.assert_allclose(np.gradient(v[late], t[late]), a, rtol=1e-4)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_block_that_is_pushed_and_sticks_again_loses_its_energy_to_the_slip(integrator: Integrator) -> None:
    """Kinetic energy = force times slip + what the stick spring keeps, whose swing is a part of it."""
    force, k, speed = 8e3, 2e6, 0.5
    law = on_springs(box(FIXED, slides(force, k)))
    q, q_t = design_state(law)
    q_t[6 + 1] = speed
    found = motion(law, q, q_t, 1.0, 5e-4, integrator)
    x, v, slip = found.q[:, 6 + 1] - q[6 + 1], found.q_t[:, 6 + 1], found.q_t[:, 12]
    kept = 0.5 * MASS * v**2 + 0.5 * k * (x - slip) ** 2
    pull = np.clip(k * (x - slip), -force, force)
    lost = np.concatenate([[0.0], np.cumsum(0.5 * (pull[1:] + pull[:-1]) * np.diff(slip))])
    energy = 0.5 * MASS * speed**2
    assert np.abs(kept + lost - energy).max() < 2e-3 * energy
    assert np.abs(k * (x - slip)).max() < 1.01 * force  # and what is felt of it is never beyond the bound
    stop = energy / force  # of a rigid slider
    assert slip[-1] == pytest.approx(stop, abs=force / k)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_swing_of_a_block_decays_by_the_same_length_every_period(integrator: Integrator) -> None:
    """4 F/k a period with rigid friction. With a stick stiffness s the elastic part 2 F/s of a stroke does not slip: a
    stroke loses A_n - A_n+1 = 2 F/k (1 - 2 F/(s (A_n + A_n+1)))."""
    force, k = 4e3, 4e5
    for stick, textbook in ((4e7, 0.01), (4e6, 0.1)):
        rails = spring(stiffness=(k, 0.0, 4e6), turning_stiffness=(4e6, 4e6, 4e6))
        law = on_springs(box(rails, slides(force, stick)))
        q, q_t = design_state(law)
        at = q[6 + 1]
        q[6 + 1] += 0.1
        found = motion(law, q, q_t, 1.6, 1e-3, integrator)
        x, v = found.q[:, 6 + 1] - at, found.q_t[:, 6 + 1]
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
        law = on_springs(box(FIXED, in_plane(force, k)))
        q, q_t = design_state(law)
        c, s = np.cos(turn), np.sin(turn)
        q_t[7], q_t[8] = 0.8 * c, 0.8 * s
        # a push across the way bends it
        push = Load.constant("push", "box", (-2e3 * s, 2e3 * c, 0.0), AT)
        law = on_springs(replace(law.vehicle, loads=(push,)))
        found = motion(law, q, q_t, 0.25, 5e-4, "rk44")
        x, v = found.q[:, 7:9] - found.q[0, 7:9], found.q_t[:, 7:9]
        paths.append(np.stack([c * x[:, 0] + s * x[:, 1], c * x[:, 1] - s * x[:, 0]]))
        pull = k * (x - found.q_t[:, 12:14])
        size = np.hypot(*pull.T)
        assert size.max() < 1.001 * force
        late = slice(200, None)
        along = np.sum((pull * v)[late], axis=1) / (size * np.hypot(*v.T))[late]
        assert along.min() > 0.999 and size[late].min() > 0.999 * force
    for path in paths[1:]:
        np.testing.assert_allclose(path, paths[0], atol=1e-9)


def test_friction_in_a_plane_along_an_axis_is_that_of_one_direction() -> None:
    force, k = 8e3, 2e6
    found = []
    for element in (slides(force, k, 1), in_plane(force, k)):
        law = on_springs(box(spring(stiffness=(0.0, 4e5, 4e6), turning_stiffness=(4e6, 4e6, 4e6)), element))
        q, q_t = design_state(law)
        q[8] += 0.1
        found.append(motion(law, q, q_t, 0.5, 5e-4, "rk44").q[:, 8])
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)


def test_friction_takes_power_whatever_its_bound_does() -> None:
    """Power into the element less the growth of what its spring stores is nowhere negative, also where the normal force
    has just fallen and the spring holds more than the bound."""
    rng = np.random.default_rng(3)
    for bound in (0.0, 3e3, 8e3):
        law = on_springs(box(FIXED, in_plane(bound, 2e6)))
        q, q_t = design_state(law)
        for _ in range(40):
            z, v = rng.normal(0.0, 3e-3, 2), rng.normal(0.0, 0.3, 2)
            q[7:9], q_t[7:9], q_t[12:14] = np.array((100.0, 0.0)) + z, v, 0.0
            out = accelerations(law, q, q_t)
            power, slip = -out[7:9] @ v, out[12:14]
            assert np.hypot(*out[7:9]) <= bound * (1.0 + 1e-12)
            assert power - 2e6 * z @ (v - slip) >= -1e-9 * abs(power)


def test_friction_between_bodies_keeps_momentum_and_its_derivatives_are_those_of_its_forces() -> None:
    """The Jacobian by differences of half the length is the same, stuck and in slip."""
    struts = tuple(
        replace(element, name=f"{i}", first="box", second="lid")
        for i, element in enumerate((slides(3e3, 2e6, 1), in_plane(4e3, 1e6), FIXED))
    )
    two = box(FIXED, *struts)
    lid = replace(two.bodies[0], name="lid")
    law = on_springs(replace(two, bodies=(*two.bodies, lid)))
    q, q_t = displaced(law)
    for stretched in (1e-4, 1.5e-3, 8e-3):
        q_t[18:] = law.settled_rates(q, q_t)[18:] * (1.0 - stretched)
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
    carries = spring(stiffness=(0.0, 0.0, vertical), turning_stiffness=(4e6, 4e6, 4e6))
    slider = Slider("coulomb", k, friction=friction, normal=Normal("spring", 1.5))
    link = Strut("link", "friction", TRACK, "box", (AT, AT), 0, slider=slider)
    vehicle = box(link, carries)
    law = on_springs(vehicle, gravity=vehicle.gravity)
    q, q_t = design_state(law)
    q_t[7] = 0.4
    q[7] += 0.05  # far in slip
    for lower in (0.0, 0.03, -0.05, -0.2):
        q[6] -= lower
        out = accelerations(law, q, q_t)
        load = max(0.0, MASS * vehicle.gravity + vertical * lower)
        assert -out[7] == pytest.approx(friction * 1.5 * load, rel=1e-12, abs=1e-9)
        q[6] += lower
    swapped = on_springs(replace(vehicle, elements=vehicle.elements[::-1]), gravity=vehicle.gravity)
    np.testing.assert_array_equal(accelerations(swapped, q, q_t), accelerations(law, q, q_t))


def test_friction_that_nothing_presses_together_is_refused() -> None:
    level = spring(name="level", stiffness=(1e6, 1e6, 0.0))
    for of, words in (("level", "carries nothing along z at rest"), ("levle", "there is no spring 'levle'.*level")):
        slider = Slider("coulomb", 1e6, friction=0.3, normal=Normal(of))
        link = Strut("link", "friction", TRACK, "box", (AT, AT), 0, slider=slider)
        with pytest.raises(InputError, match=words):
            on_springs(box(level, FIXED, link))


def test_in_small_motions_friction_sticks() -> None:
    """Natural modes and the linearised system have the stick stiffness, and no unknown of a slider."""
    stick = (4e6, 6e6)
    first = slides(1e3, stick[0], 0)
    second = replace(slides(1e3, stick[1], 1), name="other")
    law = on_springs(box(FIXED, first, second))
    modes = {mode.name: mode.frequency for mode in natural_modes(law.vehicle)}
    assert modes["box longitudinal"] == pytest.approx(np.sqrt(stick[0] / MASS) / (2.0 * np.pi), rel=1e-6)
    assert modes["box lateral"] == pytest.approx(np.sqrt(stick[1] / MASS) / (2.0 * np.pi), rel=1e-6)
    q, q_t = design_state(law)
    q[7] += 5e-3  # far in slip
    linear = linearise(law, law.bodies, q, law.settled_rates(q, q_t))
    assert linear.stiffness[7, 7] == pytest.approx(stick[0], rel=1e-6)
    assert len(linear.state_matrix) == 24


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_run_with_friction_that_is_cut_goes_on_to_the_bit(integrator: Integrator) -> None:
    """Everything that friction remembers stands in the state."""
    law = on_springs(box(spring(stiffness=(4e5, 4e5, 4e6), turning_stiffness=(4e6,) * 3), in_plane(4e3, 4e6)))
    q, q_t = design_state(law)
    q[7], q[8] = q[7] + 0.05, q[8] + 0.02
    whole = motion(law, q, q_t, 0.4, 1e-3, integrator)
    system = BodySystem(law.bodies, law)
    half = motion(law, q, q_t, 0.2, 1e-3, integrator)
    rest = Integration(system, start=0.2, duration=0.2, step=1e-3, integrator=integrator, weight=MASS * 0.01).run(
        half.q[-1], half.q_t[-1]
    )
    np.testing.assert_array_equal(rest.q[-1], whole.q[-1])
    np.testing.assert_array_equal(rest.q_t[-1], whole.q_t[-1])


def test_a_state_within_the_bounds_is_settled_already() -> None:
    """A search for steady motion that starts from a run's slips finds them as they were; one beyond the bound slips."""
    law = on_springs(box(FIXED, slides(8e3, 2e6, 0), replace(slides(4e3, 2e6, 1), name="other")))
    q, q_t = design_state(law)
    q[7], q[8], q_t[12:] = q[7] + 0.1, q[8] + 0.02, (0.0975, 0.015)
    found = law.settled_rates(q, q_t)
    np.testing.assert_allclose(found[12:], (0.0975, 0.018), atol=1e-12)
