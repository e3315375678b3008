"""Every shipped scenario and model works, and contacts in its curves are those of the half-space solver.

A run that starts in a full curve starts in steady curving (`docs/user/runs.md`): half a metre there shows what the run
comes to. Pressures, widths and angles are those of the half-space solver at the same pose and load (`wrsim resolve`).
"""

from functools import cache
from math import radians
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.runs import SCENARIOS

from wrsim import InputError, load, load_text, run
from wrsim.scenario.build import build
from wrsim.scenario.plausibility import facts

FILES = sorted(SCENARIOS.glob("*.toml"))
RUN = {
    "curve_r150_lubricator", "equilibrium_s1002", "independent_wheels", "manchester_twist", "motor_coach",
    "stability_manchester", "static_measured", "steady_manchester",
}  # fmt: skip
"""What the suite runs here: one of each kind; most of the others are run by tests of what is in them."""


@cache
def in_the_curve(name: str, arc: int = 0) -> xr.Dataset:
    """The first moment of a scenario that is started in the middle of one of its arcs."""
    scenario = load(SCENARIOS / f"{name}.toml")
    arcs = [f for f in build(scenario).track.features() if f.kind == "arc"]
    middle = 0.5 * (arcs[arc].start + arcs[arc].end)
    values = {"run.start_distance_m": middle, "run.distance_m": 0.05, "output.patches_at_m": [middle]}
    result = run(scenario.with_values(values))
    assert result.status == "completed"
    assert (result.dataset["T_gamma"].values >= 0.0).all()
    return result.wheelset().isel(time=0)


def of_each(left_out: set[str]) -> pytest.MarkDecorator:
    """All shipped scenarios; those left out of the suite are in the campaign."""
    marks = [(pytest.mark.campaign,) if file.stem in left_out else () for file in FILES]
    return pytest.mark.parametrize(
        "file",
        [
            pytest.param(file, marks=marks_of_file, id=file.stem)
            for file, marks_of_file in zip(FILES, marks, strict=True)
        ],
    )


@of_each({"crossing"})  # in the suite: its sections (test_fixed_crossing)
def test_every_scenario_can_be_read_says_what_it_comes_to_and_teaches(file):
    scenario = load(file)
    setup = build(scenario)
    assert setup.title == scenario.title != "" and facts(setup)
    assert load_text(scenario.text, folder=SCENARIOS).spec == scenario.spec  # as a result carries it
    assert scenario.text.startswith("#") or "base" in file.read_text() or "file =" in file.read_text()  # comments teach


@of_each({file.stem for file in FILES} - RUN)
def test_every_scenario_runs_in_short(file):
    scenario = load(file)
    values: dict[str, Any] = {}
    if scenario.analysis in ("curving", "ride"):
        start = scenario.spec.run.start_distance_m
        short = {"run.distance_m": 0.3} if scenario.spec.run.time_s is None else {"run.time_s": 0.04}
        values |= short | {"output.patches_at_m": [start + 0.2]}
    if scenario.analysis != "static":
        values |= {"contact.strips": 12, "contact.cells": 6}
    if scenario.analysis == "stability":
        values |= {"stability.speed_kmh": 100, "stability.nonlinear": False}
    if scenario.analysis == "steady":
        values |= {"steady.radius_m": 2000, "steady.speed_kmh": 80, "contact.normal": "kik-piotrowski"}
    if scenario.analysis == "climb":
        values |= {"climb.angle_of_attack_mrad": 10, "climb.longest_m": 2}
    result = run(scenario.with_values(values))
    assert result.status == result.summary()["status"] == "completed"
    if scenario.analysis == "stability":
        assert result.dataset["growth_max"].item() < 0.0
        return
    if scenario.analysis in ("climb", "overturning"):
        numbers = {"climb": "climb_distance", "overturning": "wheel_unloading"}[scenario.analysis]
        assert np.isfinite(result.dataset[numbers].values).all()
        return
    if scenario.analysis == "conicity":  # no forces
        assert np.isfinite(result.dataset["equivalent_conicity"].values).all()
        return
    assert np.isfinite(result.dataset["Q"].values).all()
    assert (result.dataset["T_gamma"].values >= -1e-30).all()  # creep forces never do positive work; at rest round-off


def deg(*angles: float) -> np.ndarray:
    return np.radians(angles)


EXACT = [
    # free to steer: tread and flange root of the outer wheel share the load
    ("curve_r300", "left", "p0", [942.4e6], {"rel": 0.01}),
    ("curve_r300", "right", "p0", [880.1e6, 2246.6e6], {"rel": 0.01}),
    ("curve_r300", "right", "contact_angle", deg(7.4, 17.3), {"abs": radians(0.3)}),
    # one conformal patch from the throat of the root up its flank; with 24 to 90 elements over it
    ("curve_r150_sharp", "right", "p0", [1342.5e6], {"rel": 0.005}),
    ("curve_r150_sharp", "right", "contact_angle", deg(29.89), {"abs": radians(0.1)}),
    ("curve_r150_sharp", "right", "contact_angle_min", deg(22.16), {"abs": radians(0.5)}),
    ("curve_r150_sharp", "right", "contact_angle_max", deg(70.65), {"abs": radians(0.1)}),
    ("curve_r150_sharp", "right", "width", [11.30e-3], {"rel": 0.01}),
    # root and flank
    ("curve_r150_worn", "right", "p0", [3138e6, 1200e6], {"rel": 0.03}),
    ("curve_r150_worn", "right", "contact_angle", deg(32.5, 68.5), {"abs": radians(1.0)}),
]
"""Scenario, wheel, channel of its patches, the half-space solver's values, how near."""


@pytest.mark.parametrize(("name", "wheel", "channel", "values", "near"), EXACT)
def test_contacts_in_curves_are_those_of_the_exact_solver(name, wheel, channel, values, near):
    wheel_data = in_the_curve(name).sel(wheel=wheel)
    assert int(wheel_data["n_patches"]) == len(values)
    patch_values = wheel_data[channel].values[: len(values)]
    order = np.argsort(wheel_data["contact_angle"].values[: len(values)])
    assert patch_values[order] == pytest.approx(np.asarray(values), **near)


def test_grease_on_the_gauge_corner_saves_wear_and_costs_steering():
    dry, greased = (in_the_curve(f"curve_r150_{name}") for name in ("sharp", "lubricated"))
    # the outer wheel slides on grease; with it goes its share of the longitudinal forces that steer the wheelset
    assert greased["T_gamma"].values[1] < 0.5 * dry["T_gamma"].values[1]
    assert greased["X"].values[0] < 0.4 * dry["X"].values[0]
    # the inner rail's top is dry (0.4 and not 0.35): it pushes the wheelset outward a little harder
    assert 1.0 < greased["Y"].values[0] / dry["Y"].values[0] < 0.4 / 0.35


def test_the_static_scenario_moves_the_contact_from_field_side_to_flange():
    dataset = run(load(SCENARIOS / "static_s1002.toml")).wheelset()
    assert dataset.sizes["pose"] == 42
    assert (dataset["pose_message"].values == "").all()
    straight = dataset.isel(pose=np.flatnonzero(dataset["yaw"].values == 0.0))
    shift, angle = straight["lateral_shift"].values, straight["contact_angle"].values[:, 0, 0]
    # the right wheel: to the right (negative) is towards its flange, whose flank has 70 degrees; beyond it climbs
    assert np.degrees(angle.max()) == pytest.approx(70.0, abs=0.1)
    assert shift[np.argmax(angle)] == pytest.approx(-8e-3)
    assert 1e3 * straight["vertical_shift"].values[shift < -8.5e-3].min() > 5.0
    assert (np.diff(angle[(shift > -7.5e-3) & (shift < 1.5e-3)]) < 0.0).all()
    assert np.abs(straight["Q"].values / 60e3 - 1.0).max() < 1e-6
    centred = straight.isel(pose=int(np.argmin(np.abs(shift))))
    assert 1e-6 * centred["p0"].values[0, 0] == pytest.approx(785.8, rel=0.03)


def test_the_hollow_wheel_jumps_over_its_hollow_and_fits_the_worn_corner():
    dataset = run(load(SCENARIOS / "static_worn.toml")).wheelset()
    assert (dataset["pose_message"].values == "").all()
    straight = dataset.isel(pose=np.flatnonzero(dataset["yaw"].values == 0.0))
    shift, angle = 1e3 * straight["lateral_shift"].values, np.degrees(straight["contact_angle"].values[:, 0, 0])
    assert (angle[shift <= -3.0] < 0.0).all() and (angle[shift >= -2.0] > 9.0).all()
    at_7 = int(np.argmin(np.abs(shift - 7.0)))
    assert np.degrees(straight["contact_angle_variation"].values[at_7, 0, 0]) > 15.0
    # the corner takes a share, and the pressure falls; by the exact solver. The second peak stands between two of 16
    # strips, 0.014 low; by 40 of them 0.002
    assert 1e-6 * straight["p0"].values[[at_7 - 1, at_7], 0, 0] == pytest.approx([2238.3, 1944.5], rel=0.015)


def test_bare_arcs_are_placed_by_their_origins():
    # CONTACT 25.2 on the curved surface, 0.707 mm and 17 kN: p0 891.8 MPa, resultant 23200 N, contact angle over 21.2
    # degrees
    pose = run(load(SCENARIOS / "static_rail_corner.toml")).wheelset().isel(pose=2, wheel=0)
    assert pose["load"].item() == pytest.approx(16970.563)
    assert np.hypot(pose["Y"].item(), pose["Q"].item()) == pytest.approx(23200.0, rel=0.01)
    assert 1e-6 * pose["p0"].values[0] == pytest.approx(891.8, rel=0.01)
    count = pose["n_strips"].values[0]  # even strips: from edge to edge, not from middle to middle
    turned = np.degrees(pose["contact_angle_variation"].values[0]) * count / (count - 1)
    assert turned == pytest.approx(21.2, rel=0.02)
    # ball in a groove, CONTACT: approach 22.37 um, p0 530 MPa
    pose = run(load(SCENARIOS / "static_deep_groove.toml")).wheelset().isel(pose=0, wheel=0)
    assert 1e6 * pose["approach"].values[0] == pytest.approx(22.37, rel=0.015)
    assert 1e-6 * pose["p0"].values[0] == pytest.approx(530.0, rel=0.01)
    assert pose["contact_angle"].values[0] == pytest.approx(0.0, abs=1e-6)


def test_rails_without_a_gauge_point_are_told_how_to_stand():
    scenario = load(SCENARIOS / "static_rail_corner.toml").with_values({"track.gauge_between": "gauge points"})
    with pytest.raises(InputError, match=r'no gauge point.*gauge_between = "origins"'):
        build(scenario)
    with pytest.raises(InputError, match=r'gauge_between = "origins": may be "origins" with analysis = "static" only'):
        load(SCENARIOS / "curve_r300.toml").with_values({"track.gauge_between": "origins"})
