"""From strips to resultants: sums on the wheel's surface, creepages from rigid motion, power, damping."""

import numpy as np
import pytest
from support.contacts import HALF_SPACING, RADIUS, columns, finite, pair_model, rail_origin, strips_of

from wrsim.contact.channels import WheelOnRail, wheel_outline
from wrsim.contact.settings import HalfSpaceSettings

SPEED = 20.0
PLACES = [(0.0, 0.0), (6e-3, 0.003), (7.5e-3, -0.01)]


def evaluate(model, lateral, yaw, depth=1e-4, extra=(0.0, 0.0, 0.0), spin=(0.0, 0.0)):
    """A rolling wheel pressed in below its first touch; extra velocity, extra turning about t and b."""
    o, _ = rail_origin(model.rail)
    axle = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    origin = np.array([0.0, HALF_SPACING + lateral - o, RADIUS + 0.02])
    while (closest := model.evaluate(origin, axle).closest) > 0.0:
        origin[2] -= max(closest, 1e-6)
    origin[2] -= depth
    velocity = np.array([SPEED, 0.0, 0.0]) + extra
    omega = 1.002 * SPEED / RADIUS * axle + [spin[0], 0.0, spin[1]]
    return model.evaluate(origin, axle, velocity, omega), origin, velocity, omega


def on_wheel(strips, origin):
    """Where strips lie on the wheel's undeformed surface, from its profile origin, (n, 3) in (t, o, b)."""
    return columns(strips, "x o b") - 0.5 * strips["penetration"][:, None] * axes(strips)[0] - origin


def axes(strips):
    """Unit vectors of every strip: normal, tangent outward; (n, 3)."""
    zero = np.zeros(len(strips))
    return np.stack([zero, strips["no"], strips["nb"]], 1), np.stack([zero, strips["nb"], -strips["no"]], 1)


@pytest.mark.parametrize(("lateral", "yaw"), PLACES)
def test_forces_act_on_the_undeformed_surface_of_the_wheel(lateral, yaw):
    contact, origin, _, _ = evaluate(pair_model("S1002/60E1 1:40"), lateral, yaw)
    strips = strips_of(contact)
    normal, outward = axes(strips)
    force = strips["N"][:, None] * normal + strips["Fy"][:, None] * outward
    force[:, 0] += strips["Fx"]
    moment = np.cross(on_wheel(strips, origin), force) + strips["Mz"][:, None] * normal
    np.testing.assert_allclose(contact.force, force.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(contact.moment, moment.sum(axis=0), rtol=1e-11)
    # patches: sums, spin moment about the main point along its normal, extremes
    for lobe, rows in zip(contact.patches, contact.strips, strict=True):
        assert lobe["N"] == pytest.approx(rows["N"].sum(), rel=1e-12)
        assert lobe["area"] == pytest.approx((2.0 * rows["a"] * rows["ds"]).sum(), rel=1e-12)
        assert lobe["length"] == pytest.approx(2.0 * rows["a"].max(), rel=1e-12)
        assert lobe["p0"] >= rows["p"].max()
        np.testing.assert_allclose(rows["N"], 0.5 * np.pi * rows["a"] * rows["p"] * rows["ds"])
        n, e = axes(rows)
        creep = rows["Fy"][:, None] * e
        creep[:, 0] += rows["Fx"]
        main = columns(lobe, "x o b")
        about_main = np.cross(columns(rows, "x o b") - main, creep) + rows["Mz"][:, None] * n
        along = about_main.sum(axis=0) @ [0.0, lobe["no"], lobe["nb"]]
        assert lobe["Mz"] == pytest.approx(along, rel=1e-9, abs=1e-9)
        angles = np.arctan2(-rows["no"], rows["nb"])
        # the kernel halves the angle of a normal that beside a join is a unit vector to 6e-7 only
        assert (lobe["angle_min"], lobe["angle_max"]) == pytest.approx((angles.min(), angles.max()), abs=1e-6)


@pytest.mark.parametrize("normal", ["kik-piotrowski", "strips"])
@pytest.mark.parametrize("lateral", [0.0, 3e-3, 6e-3])
def test_a_wheel_rolls_freely_on_its_undeformed_radius(normal, lateral):
    # identical bodies stretch alike in their contact: CONTACT's creepages are (V - omega r) / V with this r, too
    model = pair_model("S1002/60E1 1:40", normal=normal)
    contact, *_ = evaluate(model, lateral, 0.0)
    for lobe in contact.patches:
        radius = RADIUS - model.wheel.at(lobe["arc_wheel"])[1]
        expected = SPEED * (1.0 - 1.002 * radius / RADIUS) / np.hypot(SPEED, 0.05)
        assert lobe["xi"] == pytest.approx(expected, abs=1e-7)  # half the approach would make 1e-4


@pytest.mark.parametrize(("lateral", "yaw"), PLACES)
def test_creepages_are_the_rigid_motion_at_each_strip_over_the_speed(lateral, yaw):
    contact, origin, velocity, omega = evaluate(
        pair_model("S1002/60E1 1:40"), lateral, yaw, extra=(0.0, 0.05, 0.0), spin=(0.1, 0.2)
    )
    strips = strips_of(contact)
    normal, outward = axes(strips)
    motion = velocity + np.cross(omega, on_wheel(strips, origin))
    # below 50 mm/s creepages are regularised: the speed is sqrt(V^2 + 0.05^2)
    speed = np.hypot(SPEED, 0.05)
    np.testing.assert_allclose(strips["xi"], motion[:, 0] / speed, rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(strips["eta"], (motion * outward).sum(axis=1) / speed, rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(strips["phi"], normal @ omega / speed, rtol=1e-9)
    assert np.ptp(strips["phi"]) > 0.0  # spin varies along a curved patch


EXACT = {"normal": "half-space", "half_space": HalfSpaceSettings(resolution=12), "tangential": "fastsim"}


@pytest.mark.parametrize(("lateral", "yaw", "choices"), [*((*place, {}) for place in PLACES), (*PLACES[1], EXACT)])
def test_wear_number_times_speed_is_the_power_that_creep_forces_take(lateral, yaw, choices):
    rolling, _, velocity, omega = evaluate(pair_model("S1002/60E1 1:40", **choices), lateral, yaw)
    plain, *_ = evaluate(pair_model("S1002/60E1 1:40", **choices | {"tangential": "none"}), lateral, yaw)
    power = (rolling.force - plain.force) @ velocity + (rolling.moment - plain.moment) @ omega
    assert rolling.wear_number > 0.0
    # 1e-8: the power is a small difference of large terms
    assert power == pytest.approx(-rolling.wear_number * np.hypot(SPEED, 0.05), rel=1e-8)
    assert plain.wear_number == 0.0


def test_at_standstill_everything_is_finite_and_the_drawn_wheel_stands_where_it_is():
    model = pair_model("S1002/60E1 1:40")
    _, origin, _, _ = evaluate(model, 2e-3, 0.0)
    contact = model.evaluate(origin)
    assert finite(contact.patches)
    assert contact.force[0] == 0.0
    assert contact.wear_number == 0.0
    for rows in (*contact.strips, contact.patches):
        assert not np.any(columns(rows, "xi eta phi"))
    model = pair_model("S1002/60E1 1:40")
    _, origin, *_ = evaluate(model, 2e-3, 0.0)
    across, up = wheel_outline(WheelOnRail(model, 1, HALF_SPACING, (0.0, 0.0)))
    u, w = model.wheel.at(np.linspace(0.0, model.wheel.length, across.size))
    # the back of the flange is cut off at its highest point
    seen = slice(int(np.argmax(w[: w.argmin() + 1])), None)
    np.testing.assert_allclose(across[seen] - origin[1], u[seen], atol=1e-7)
    np.testing.assert_allclose(up[seen] - origin[2] + RADIUS, w[seen], atol=1e-7)


DAMPING = 2.0


@pytest.mark.parametrize(("lateral", "yaw"), PLACES)
def test_damping_is_nothing_without_a_rate_of_approach(lateral, yaw):
    # the tangent plane may slide: velocities that leave the main point's normal velocity zero
    plain = evaluate(pair_model("S1002/60E1 1:40"), lateral, yaw)[0]
    damped, origin, velocity, omega = evaluate(pair_model("S1002/60E1 1:40", damping=DAMPING), lateral, yaw)
    closing = damped.patches["closing"]
    for lobe, rate in zip(damped.patches, closing, strict=True):
        main = columns(lobe, "x o b") - origin
        normal = np.array([0.0, lobe["no"], lobe["nb"]])
        assert rate == pytest.approx(-(velocity + np.cross(omega, main)) @ normal, abs=1e-9)
    # a rolling wheel of revolution closes at no rate: what is left is the strip that stands for the main point
    assert np.abs(closing).max() < 1e-6 * SPEED
    ratio = damped.patches["N"] / plain.patches["N"]
    np.testing.assert_allclose(ratio, 1.0 + DAMPING * closing, rtol=1e-12)


@pytest.mark.parametrize("rate", [-0.3, -0.1, 0.1, 1.0])
def test_damping_multiplies_the_force_by_one_plus_the_rate(rate):
    down = (0.0, 0.0, -rate)
    plain = evaluate(pair_model("S1002/60E1 1:40"), 2e-3, 0.0, extra=down)[0].patches[0]
    damped = evaluate(pair_model("S1002/60E1 1:40", damping=DAMPING), 2e-3, 0.0, extra=down)[0].patches[0]
    assert damped["closing"] == pytest.approx(rate * damped["nb"], abs=1e-3)
    factor = 1.0 + DAMPING * damped["closing"]
    assert damped["N"] / plain["N"] == pytest.approx(factor, rel=1e-12)
    assert damped["p0"] / plain["p0"] == pytest.approx(factor, rel=1e-12)
    assert damped["area"] == plain["area"]


@pytest.mark.parametrize("rate", [-0.6, -2.0, -50.0])
def test_damping_never_pulls(rate):
    model = pair_model("S1002/60E1 1:40", damping=DAMPING)
    contact, *_ = evaluate(model, 2e-3, 0.0, extra=(0.0, 0.0, -rate))
    assert len(contact.patches) > 0
    assert (contact.patches["N"] == 0.0).all()
    assert not contact.force.any() and not contact.moment.any()
    assert contact.wear_number == 0.0
    assert model.arrays.total["patches"] == 0.0
