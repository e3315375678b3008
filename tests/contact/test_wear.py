"""Laws of wear and fatigue, and what they take off a wheel and its rail in single poses."""

from math import pi

import numpy as np
import pytest
from support.contacts import bench, pair_model, settle, wheel_profile

from wrsim.contact.channels import WheelOnRail
from wrsim.contact.records import LOBE
from wrsim.contact.wear.laws import (
    DENSITY,
    LawName,
    WearSettings,
    brr,
    damage,
    fatigue_index,
    slip_along,
    traction_coefficient,
    usfd,
    wear_coefficient,
)
from wrsim.contact.wear.losses import Losses, _foot, ways
from wrsim.jit import Array, Records

PAIR = "S1002/60E1 1:40"
LAWS: tuple[LawName, ...] = ("usfd", "archard", "brr")
WAY = 3.0


def solved(wheel: WheelOnRail) -> tuple[Records, Records, Array, int]:
    """What the model of a wheel computed last."""
    a = wheel.model.arrays
    return a.patches, a.strips, a.pose, int(a.total.lobes)


def losses(yaw_mrad: float, *, lateral_mm: float = 0.0, step: float = 0.25e-3, **choices) -> tuple[Losses, float]:
    """What a wheel at this yaw loses over WAY, and its T-gamma."""
    choices = {"normal": "strips", "tangential": "fastrip", "strips": 20} | choices
    stand = bench(pair_model(PAIR, **choices))
    _, contact = settle(stand, 1e-3 * lateral_mm, 1e-3 * yaw_mrad, 80e3)
    idle = WheelOnRail(pair_model(PAIR, **choices), -1, 0.75, stand.wheels[0].rail_origin)
    lost = Losses(WearSettings(LAWS, step=step), [(stand.wheels[0], idle)], [np.array([WAY])])
    lost.store(0, 0, [solved(stand.wheels[0]), solved(idle)])
    return lost, contact.wear_number


def mass(lost: Losses) -> np.ndarray:
    """Of the wheel, by law [kg/m]."""
    return lost.channels()["wear_wheel_mass"][:, 0, 0].sum(axis=-1)


def test_usfd_has_three_branches_and_brr_the_areas_of_its_source() -> None:
    w = 1e6 * np.array([0.0, 5.0, 10.39, 10.41, 50.0, 77.2, 87.2])
    micrograms = np.array([0.0, 26.5, 55.067, 55.0, 55.0, 55.0, 55.0 + 619.0])
    np.testing.assert_allclose(usfd(w), 1e-3 * micrograms, rtol=1e-12)
    assert usfd(77.2e6 + 1.0) == pytest.approx(usfd(77.2e6), rel=1e-5)
    # a wheel of 920 mm loses .25 T / D, 25 / D and (1.19 T - 154) / D mm2 per km
    area = brr([40.0, 150.0, 300.0]) / DENSITY / (pi * 0.92)  # m2 per m
    np.testing.assert_allclose(1e9 * area, np.array([10.0, 25.0, 203.0]) / 920.0, rtol=1e-12)


def test_archard_follows_its_map_and_three_laws_agree_on_mild_wear() -> None:
    k = (1.0, 2.0, 3.0, 4.0)
    speeds, pressures = [0.1, 0.5, 0.9, 0.1, 0.5], [1e9, 1e9, 1e9, 2.3e9, 2.3e9]
    np.testing.assert_array_equal(wear_coefficient(speeds, pressures, 2.8e9, k), [1.0, 2.0, 3.0, 4.0, 4.0])
    assert WearSettings(("archard",)).coefficients == (5e-4, 35e-4, 5e-4, 350e-4)  # docs/user/wear.md
    # per metre and newton of T-gamma: 5.3e-9 kg, .25 pi mm3/km, and k/(mu H) of the mildest field
    rates = np.array([float(usfd(1.0)), float(brr(1.0)), DENSITY * 5e-4 / (0.35 * 2.8e9)])
    np.testing.assert_allclose(rates, [5.3e-9, 6.165e-9, 4.005e-9], rtol=1e-3)


@pytest.mark.parametrize("choices", [{"strips": 20}, {"strips": 40}, {"cells": 40}, {"tangential": "polach"}])
def test_mild_wear_is_a_rate_times_t_gamma_whatever_the_strips(choices: dict) -> None:
    """Below 10.4 N/mm2 everywhere USFD gives 5.3e-9 kg per metre and newton: .53 mg per metre at 100 N."""
    lost, wear = losses(3.0, **choices)
    assert wear > 5.0
    by_law = mass(lost)
    assert by_law[0] == pytest.approx(5.3e-9 * wear, rel=1e-12)
    assert by_law[2] == pytest.approx(float(brr(wear)), rel=1e-12)


def test_severe_wear_is_the_area_of_its_rate_and_losses_converge_in_strips_and_parts() -> None:
    """Where every strip slides at 10.4 to 77.2 N/mm2 the loss is 55e-3 kg per metre and square metre; the edges, where
    the pressure falls, stay below."""
    lost, wear = losses(60.0)
    area = lost._samples["lobes"].view(LOBE)[0]["area"].sum()
    by_law = mass(lost)
    assert 0.8 * 55e-3 * area < by_law[0] < 55e-3 * area
    assert by_law[0] < 5.3e-9 * wear
    # where all laws are in more than one branch
    few, many = (mass(losses(40.0, lateral_mm=4.0, strips=n)[0]) for n in (20, 80))
    np.testing.assert_allclose(few, many, rtol=0.02)


@pytest.mark.parametrize("step", [0.1e-3, 0.25e-3, 1e-3])
def test_mass_off_the_profiles_is_mass_lost(step: float) -> None:
    """Depth times ring and width of the places, and the same of the rail; wheel and rail lose the same."""
    lost, wear = losses(20.0, lateral_mm=5.0, step=step)
    channels, places = lost.channels(), lost.of_wheels[0][0]
    model = lost.wheels[0][0].model
    ring = 2.0 * pi * (model.radius - places.w) * places.width
    off_wheel = (channels["wear_wheel_depth"][:, 0, 0, : ring.size] * ring * DENSITY).sum(axis=-1)
    off_rail = channels["wear_rail_depth"][:, 0].sum(axis=-1) * lost.of_rails[0].width * DENSITY
    np.testing.assert_allclose(off_wheel, mass(lost), rtol=1e-12)
    np.testing.assert_allclose(off_rail, mass(lost), rtol=1e-12)
    energy = np.nansum(channels["wear_wheel_energy"][0, 0]) * places.width
    assert energy == pytest.approx(wear, rel=1e-12)


def test_what_the_flange_loses_is_told_apart() -> None:
    """Against the flange, and in the middle of the tread."""
    against = losses(5.0, lateral_mm=7.5)[0].channels()["wear_wheel_mass"][0, 0, 0]
    middle = losses(5.0)[0].channels()["wear_wheel_mass"][0, 0, 0]
    assert against[1] > against[0]
    assert middle[1] == 0.0 < middle[0]


def test_wear_lies_where_the_contact_is() -> None:
    """What is worn off lies within the patches on both profiles, to the width of the places."""
    lost, _ = losses(5.0)
    lobes = lost._samples["lobes"].view(LOBE)[0, : lost._samples["count"][0]]
    channels = lost.channels()
    model = lost.wheels[0][0].model
    for name, profile, arc, depth in (
        ("wheel", model.wheel, lobes["arc_wheel"], channels["wear_wheel_depth"][0, 0, 0]),
        ("rail", model.rail, lobes["arc_rail"], channels["wear_rail_depth"][0, 0]),
    ):
        u = channels[f"wear_{name}_u"][(0, 0) if name == "wheel" else 0]
        low, high = (profile.at(arc + lobes[end])[0] for end in ("start", "end"))
        worn = u[np.nan_to_num(depth) > 0.0]
        assert low.min() - 0.3e-3 < worn.min() < low.min() + 1.5e-3
        assert high.max() - 1.5e-3 < worn.max() < high.max() + 0.3e-3


def test_a_right_wheel_of_another_wheelset_loses_what_its_mirror_image_does() -> None:
    choices = {"normal": "strips", "tangential": "fastrip", "strips": 20}
    stand, still = (bench(pair_model(PAIR, **choices), sides=(-1,)) for _ in range(2))
    settle(stand, 0.0, -20e-3, 80e3)
    (right,), (idle,) = stand.wheels, still.wheels
    recorded = Losses(WearSettings(LAWS), [(idle, idle), (idle, right)], [np.array([WAY])] * 2)
    recorded.store(1, 0, [solved(idle), solved(right)])
    lost = recorded.channels()["wear_wheel_mass"].sum(axis=-1)
    np.testing.assert_allclose(lost[:, 1, 1], mass(losses(20.0)[0]), rtol=1e-6)
    assert (np.delete(lost.reshape(3, 4), 3, axis=1) == 0.0).all()


def test_samples_stand_for_the_whole_stretch_and_points_for_their_foot() -> None:
    distance = np.cumsum(np.array([5.0, 0.3, 0.1, 0.8, 0.2, 0.6]))
    assert ways(distance, (None, None)).sum() == pytest.approx(2.0, rel=1e-12)
    inside = ways(distance, (5.1, 6.33))
    assert inside.sum() == pytest.approx(1.23, rel=1e-12)
    assert inside[0] == pytest.approx(0.05) and inside[-1] == 0.0
    wheel = wheel_profile("S1002")
    arc = np.linspace(0.03, 0.12, 50)
    (u, w), (nu, nw) = wheel.at(arc), wheel.normal(arc)
    foot = _foot(wheel, arc + 2e-4, np.asarray(u + 1e-4 * nu), np.asarray(w + 1e-4 * nw))
    np.testing.assert_allclose(foot, arc, atol=1e-6)


def test_a_strip_slides_behind_its_zone_of_adhesion() -> None:
    """Carter: none, half and all of a strip slides; beyond that the slip evens out. Nothing jumps in between."""
    half = slip_along([0.5], 40)[0]
    assert (half[20:] == 0.0).all() and (np.diff(half[:20]) < 0.0).all()
    x = (np.arange(40) + 0.5) / 20.0 - 1.0
    np.testing.assert_allclose(slip_along([1.0], 40)[0], (1.0 - x) / (1.0 - x[0]), rtol=1e-12)
    np.testing.assert_allclose(slip_along([1e9], 40)[0], 1.0, rtol=1e-6)
    np.testing.assert_allclose(slip_along([1.0 - 1e-9], 40), slip_along([1.0 + 1e-9], 40), atol=1e-4)
    assert slip_along([0.0], 40)[0].tolist() == [1.0] + [0.0] * 39


def test_damage_rises_to_its_peak_and_fatigue_begins_at_the_limit_of_the_shakedown_map() -> None:
    damages = damage([0.0, 15.0, 40.0, 65.0, 120.0, 175.0, 275.0])
    np.testing.assert_allclose(damages, [0.0, 0.0, 5e-6, 1e-5, 5e-6, 0.0, -100.0 * 1e-5 / 110.0], atol=1e-20)
    assert (damages[-1] - damages[-2]) / 100.0 == pytest.approx(-9.09e-8, rel=1e-3)
    # in a Hertzian patch p0 = 3 N / (2 A); the limit is p0 / k = 1 / mu
    k, p0, area = 300e6, 1200e6, 1e-4
    normal = p0 * area / 1.5
    limit = k / p0
    used = traction_coefficient(limit * normal, 0.0, normal)
    assert fatigue_index(used, normal, area, k) == pytest.approx(0.0, abs=1e-15)
    assert fatigue_index(used + 0.1, normal, area, k) == pytest.approx(0.1)
    assert np.isnan(traction_coefficient(1.0, 0.0, 0.0))
