"""A vehicle at rest and in steady motion: weight, symmetry, load transfer."""

from dataclasses import replace

import numpy as np
import pytest
from support.vehicles import manchester, on_track

from wrsim.geometry.track.segments import Arc, Segment
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state, poses_on_track
from wrsim.simulation.steady_state import lower_on_rails, steady_state
from wrsim.vehicle.wheelset import STANDARD_GRAVITY, Wheelset


def wheel_loads(law: VehicleOnTrack) -> np.ndarray:
    """Vertical force of every wheel on its rail (wheelsets, 2) at the state asked for last [N]."""
    return np.array([[wheel.model.arrays.total.Fb for wheel in pair] for pair in law.wheels])


def test_mass_and_centre_are_the_sum_of_the_bodies() -> None:
    vehicle = manchester()
    assert vehicle.mass == 4 * 1813 + 2 * 2615 + 32000
    height = (4 * 1813 * 0.46 + 2 * 2615 * 0.6 + 32000 * 1.8) / vehicle.mass
    assert np.allclose(vehicle.centre, (0.0, 0.0, height), atol=1e-12)


@pytest.mark.parametrize("speed", [0.0, 30.0])
def test_wheel_loads_sum_to_the_weight_and_are_alike_on_both_sides(speed: float) -> None:
    law = on_track(manchester(), speed).law
    found = steady_state(law)
    law(0.0, found.q, found.q_t, np.zeros(law.size))
    loads = wheel_loads(law)
    assert loads.sum() == pytest.approx(law.vehicle.weight, rel=1e-8)
    assert np.allclose(loads[:, 0], loads[:, 1], rtol=1e-9)
    # at rest the springs hold the design position; the wheels sink into the rails alike
    assert speed > 0.0 or np.allclose(loads, law.vehicle.weight / 8.0, rtol=1e-9)


def test_design_position_is_the_position_of_rest() -> None:
    law = on_track(manchester()).law
    found = steady_state(law)
    heights = found.q[: 6 * 7 : 6]
    design = np.array([part.centre[2] for part in law.vehicle.parts])
    sunk = design - heights
    assert np.allclose(sunk, sunk[0], atol=1e-9)  # all alike, by the approach of wheel and rail
    assert 1e-4 < sunk[0] < 4e-4  # KP at 54.5 kN


def curved(radius: float, cant: float) -> list[Segment]:
    return [Arc(400.0, radius, cant=cant)]


def mirror(q: np.ndarray, bodies: int) -> np.ndarray:
    """Coordinates (or rates, or forces) seen in a mirror that exchanges left and right."""
    out = q.copy()
    own = out[: 6 * bodies].reshape(-1, 6)
    own[:, [2, 3, 4]] *= -1.0
    return out


def test_a_symmetric_vehicle_in_the_mirrored_curve_has_the_mirrored_forces() -> None:
    left, right = (on_track(manchester(), 25.0, curved(radius, 0.06)).law for radius in (800.0, -800.0))
    q, q_t = design_state(left)
    q, q_t = lower_on_rails(left, q, q_t)
    n = 6 * len(left.bodies)
    rng = np.random.default_rng(5)
    q[:n] += 1e-4 * rng.standard_normal(n)
    # the mirrored vehicle has its left elements on the right: exchange what differs from side to side
    a, b = np.zeros(left.size), np.zeros(left.size)
    left(0.0, q, q_t, a)
    right.look_near(50.0)
    right(0.0, mirror(q, len(left.bodies)), mirror(q_t, len(left.bodies)), b)
    assert np.abs(mirror(a, len(left.bodies))[:n] - b[:n]).max() < 1e-9 * np.abs(a).max()


def test_load_transfer_in_a_canted_curve_is_that_of_the_closed_form() -> None:
    """Moments about the track: sum b_i Q_i = sum m (a_q z + g_n y_o) + sum I omega kappa V, a_q the cant deficiency.

    b_i is the arm of a wheel's contact, y_o is how far the masses have swayed outward against the wheels; a curve so
    wide that nothing touches a flange.
    """
    radius, cant, speed = 2500.0, 0.08, 55.0
    law = on_track(manchester(), speed, curved(radius, cant), start=200.0).law
    q, q_t = design_state(law)
    q, q_t = lower_on_rails(law, q, q_t)
    found = steady_state(law, (q, q_t))
    law(0.0, found.q, found.q_t, np.zeros(law.size))
    angle = float(np.arcsin(cant / law.track.cant_base))
    centrifugal = speed**2 / radius
    deficiency = centrifugal * np.cos(angle) - STANDARD_GRAVITY * np.sin(angle)
    normal = STANDARD_GRAVITY * np.cos(angle) + centrifugal * np.sin(angle)
    parts = law.vehicle.parts
    moment = 0.0
    bend = np.mean([m.x**2 for m in law.vehicle.wheelsets])
    for i, part in enumerate(parts):
        own = slice(6 * i, 6 * i + 6)
        pose = poses_on_track(law.track.centre, found.q[None, own], found.q_t[None, own], 200.0 + part.centre[0])
        outward = -(pose.lateral[0] + (part.centre[0] ** 2 - bend) / (2.0 * radius))  # the curve is to the left
        moment += part.mass * (deficiency * pose.height[0] + normal * outward)
        if i < len(law.vehicle.wheelsets):
            moment += 112.0 * pose.spin_rate[0] * speed / radius
    transfer = 0.0
    for pair in law.wheels:
        for wheel in pair:
            a = wheel.model.arrays
            rows = a.patches[: a.total.lobes]
            contact = wheel.rail_origin[0] + np.average(rows["o"], weights=rows["N"])
            transfer -= wheel.side * a.total.Fb * contact
    assert transfer > 10e3
    assert transfer == pytest.approx(moment, rel=0.01)


def test_smaller_wheels_lower_the_whole_vehicle() -> None:
    def turned(wheelset: Wheelset) -> Wheelset:
        return replace(wheelset, left=replace(wheelset.left, radius=0.45), right=replace(wheelset.right, radius=0.45))

    law = on_track(manchester().with_wheelsets(turned)).law
    found = steady_state(law)
    law(0.0, found.q, found.q_t, np.zeros(law.size))
    assert wheel_loads(law).sum() == pytest.approx(law.vehicle.weight, rel=1e-8)
    assert found.q[6 * 4] == pytest.approx(1.8 - 0.01, abs=5e-4)
