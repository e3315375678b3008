"""Every shipped scenario and model works; a few numbers of the scenarios are pinned.

Long scenarios run in short: a run that starts in a full curve starts in steady curving (`docs/runs.md`), so that half a
metre there shows what the whole run comes to. The numbers are those of the day of writing, to two or three digits;
pressures, widths, angles and T-gamma those of the half-space solver at the same pose and load (`wrsim resolve`).
Better numerics move them by less than the tolerances; what moves them by more has changed the physics.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.runs import ROOT, SCENARIOS

from wrsim.analysis import run
from wrsim.errors import InputError
from wrsim.inputs.lookup import Finder
from wrsim.scenario.build import build
from wrsim.scenario.loading import load, load_text
from wrsim.scenario.plausibility import facts
from wrsim.vehicle.vehicle_files import load_vehicle

FILES = sorted(SCENARIOS.glob("*.toml"))
MODELS = ROOT / "models"

NUMBERS = 0.02  # relative tolerance of pinned numbers, see above


@cache
def in_the_curve(name: str, arc: int = 0) -> xr.Dataset:
    """The first moment of a scenario that is started in the middle of one of its arcs."""
    scenario = load(SCENARIOS / f"{name}.toml")
    arcs = [f for f in build(scenario).track.features() if f.kind == "arc"]
    middle = 0.5 * (arcs[arc].start + arcs[arc].end)
    values = {"run.start_distance_m": middle, "run.distance_m": 0.5, "output.patches_at_m": [middle]}
    result = run(scenario.with_values(values))
    assert result.status == "completed"
    assert (result.dataset["T_gamma"].values >= 0.0).all()
    return result.wheelset().isel(time=0)


def of_wheels(sample: xr.Dataset, name: str, factor: float = 1.0) -> list[float]:
    """A channel of the left and the right wheel, of patches the first, in units of ``1 / factor``."""
    values = sample[name].values
    return list(factor * (values[:, 0] if values.ndim == 2 else values))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_scenario_is_valid_and_says_what_it_comes_to(file):
    scenario = load(file)
    setup = build(scenario)
    assert setup.title and setup.title == scenario.title
    assert facts(setup)
    assert load_text(scenario.text, folder=SCENARIOS).spec == scenario.spec  # as a result carries it
    assert scenario.text.startswith("#") or "base" in file.read_text() or "file =" in file.read_text()  # comments teach


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_scenario_runs_in_short(file):
    scenario = load(file)
    values: dict[str, Any] = {}
    if scenario.analysis in ("curving", "ride"):
        start = scenario.spec.run.start_distance_m
        short = {"run.distance_m": 0.3} if scenario.spec.run.time_s is None else {"run.time_s": 0.04}
        values = short | {"output.patches_at_m": [start + 0.2]}
    if scenario.analysis == "stability":
        values = {"stability.speed_kmh": 100, "stability.nonlinear": False}
    if scenario.analysis == "steady":
        values = {"steady.radius_m": 2000, "steady.speed_kmh": 80}
    result = run(scenario.with_values(values))
    assert result.status == "completed"
    assert result.summary()["status"] == "completed"
    if scenario.analysis == "stability":
        assert result.dataset["growth_max"].item() < 0.0
        return
    if scenario.analysis == "conicity":  # no forces
        assert np.isfinite(result.dataset["equivalent_conicity"].values).all()
        return
    assert np.isfinite(result.dataset["Q"].values).all()
    assert (result.dataset["T_gamma"].values >= -1e-30).all()  # creep forces never do positive work; at rest round-off


def test_the_300_m_curve():
    sample = in_the_curve("curve_r300")
    # free to steer: outward by 5 mm, nearly radial; tread and flange root of the outer wheel share the load
    assert 1e3 * sample["lateral_shift"].item() == pytest.approx(-5.06, rel=NUMBERS)
    assert abs(sample["yaw"].item()) < 0.3e-3
    assert of_wheels(sample, "Q", 1e-3) == pytest.approx([49.6, 59.7], rel=NUMBERS)
    assert of_wheels(sample, "Y", 1e-3) == pytest.approx([1.43, 4.59], rel=0.05)  # exact: inner 1.446
    assert list(sample["n_patches"].values) == [1, 2]
    angles = np.degrees(np.sort(sample["contact_angle"].sel(wheel="right").values[:2]))
    assert angles == pytest.approx([7.4, 17.3], abs=0.3)
    p0 = sample["p0"].values
    assert [*p0[:1, 0], *p0[1, :2]] == pytest.approx([942.4e6, 880.1e6, 2246.6e6], rel=0.01)  # exact


def test_the_sharp_curve_is_conformal_contact_on_the_flange_root():
    sample = in_the_curve("curve_r150_sharp")
    assert 1e3 * sample["lateral_shift"].item() == pytest.approx(-8.72, rel=NUMBERS)
    assert 1e3 * sample["yaw"].item() == pytest.approx(-8.45, rel=NUMBERS)  # 1.28 m / 150 m but for the springs
    assert of_wheels(sample, "Q", 1e-3) == pytest.approx([49.3, 59.9], rel=NUMBERS)
    assert of_wheels(sample, "Y", 1e-3) == pytest.approx([17.6, 20.0], rel=0.03)
    outer = sample.sel(wheel="right").isel(patch=0)
    assert int(outer["n_patches"]) == 1  # one patch from the throat of the root up its flank
    assert np.degrees(outer["contact_angle"].item()) == pytest.approx(30.06, abs=0.5)
    # angles are those of strips' middles, of exact rows likewise
    assert np.degrees(outer["contact_angle_min"].item()) == pytest.approx(22.24, abs=0.6)
    assert np.degrees(outer["contact_angle_max"].item()) == pytest.approx(70.69, abs=0.6)
    assert 1e3 * outer["width"].item() == pytest.approx(11.30, rel=0.03)
    # exact; strips give 1.6 % more
    assert 1e-6 * outer["p0"].item() == pytest.approx(1321.7, rel=0.018)
    assert outer["T_gamma"].item() == pytest.approx(279.8, rel=0.08)


def test_grease_on_the_gauge_corner_saves_wear_and_costs_steering():
    dry, greased = in_the_curve("curve_r150_sharp"), in_the_curve("curve_r150_lubricated")
    # the outer wheel slides on grease; with it goes its share of the longitudinal forces that steer the wheelset
    assert of_wheels(greased, "T_gamma")[1] == pytest.approx(91.6, rel=0.05)
    assert of_wheels(greased, "T_gamma")[1] < 0.5 * of_wheels(dry, "T_gamma")[1]
    assert of_wheels(greased, "X", 1e-3) == pytest.approx([0.90, -0.70], abs=0.1)
    assert of_wheels(greased, "X")[0] < 0.4 * of_wheels(dry, "X")[0]
    # the inner rail's top is dry (0.4 and not 0.35): it pushes the wheelset outward a little harder
    assert of_wheels(greased, "Y", 1e-3) == pytest.approx([19.8, 22.2], rel=0.03)


def test_both_curves_of_the_s_show_the_same_on_opposite_wheels():
    first, second = in_the_curve("s_curve", 0), in_the_curve("s_curve", 1)
    assert 1e3 * first["lateral_shift"].item() == pytest.approx(-5.13, rel=NUMBERS)
    assert second["lateral_shift"].item() == pytest.approx(-first["lateral_shift"].item(), rel=1e-6)
    for name in ("Y", "Q", "contact_angle", "p0", "T_gamma"):
        assert of_wheels(second, name) == pytest.approx(of_wheels(first, name)[::-1], rel=1e-6), name
    assert of_wheels(first, "Y_over_Q") == pytest.approx([0.0272, 0.0772], rel=0.05)


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


def test_the_worn_pair_in_the_sharp_curve_touches_in_the_worn_root():
    sample = in_the_curve("curve_r150_worn")
    assert 1e3 * sample["lateral_shift"].item() == pytest.approx(-9.36, rel=NUMBERS)
    assert of_wheels(sample, "Q", 1e-3) == pytest.approx([49.4, 59.9], rel=NUMBERS)
    assert of_wheels(sample, "Y", 1e-3) == pytest.approx([16.3, 18.6], rel=0.03)
    outer = sample.sel(wheel="right")
    assert int(outer["n_patches"]) == 2  # root and flank
    assert np.degrees(outer["contact_angle"].values[:2]) == pytest.approx([32.5, 68.5], abs=1.0)
    assert np.degrees(outer["contact_angle_variation"].values[0]) == pytest.approx(8.1, abs=0.8)
    assert 1e-6 * outer["p0"].values[:2] == pytest.approx([3138.0, 1200.0], rel=0.03)


def test_the_hollow_wheel_jumps_over_its_hollow_and_fits_the_worn_corner():
    dataset = run(load(SCENARIOS / "static_worn.toml")).wheelset()
    assert (dataset["pose_message"].values == "").all()
    straight = dataset.isel(pose=np.flatnonzero(dataset["yaw"].values == 0.0))
    shift, angle = 1e3 * straight["lateral_shift"].values, np.degrees(straight["contact_angle"].values[:, 0, 0])
    assert (angle[shift <= -3.0] < 0.0).all() and (angle[shift >= -2.0] > 9.0).all()
    at_7 = int(np.argmin(np.abs(shift - 7.0)))
    assert np.degrees(straight["contact_angle_variation"].values[at_7, 0, 0]) > 15.0
    # the corner takes a share, and the pressure falls
    assert 1e-6 * straight["p0"].values[[at_7 - 1, at_7], 0, 0] == pytest.approx([2238.3, 1944.9], rel=0.01)


def test_bare_arcs_are_placed_by_their_origins():
    # CONTACT 25.2 on the curved surface, 0.707 mm and 17 kN: p0 891.8 MPa, resultant 23200 N, contact angle over 21.2
    # degrees
    pose = run(load(SCENARIOS / "static_rail_corner.toml")).wheelset().isel(pose=2, wheel=0)
    assert pose["load"].item() == pytest.approx(16970.563)
    assert np.hypot(pose["Y"].item(), pose["Q"].item()) == pytest.approx(23200.0, rel=0.01)
    assert 1e-6 * pose["p0"].values[0] == pytest.approx(891.8, rel=0.01)
    assert np.degrees(pose["contact_angle_variation"].values[0]) == pytest.approx(21.2, rel=0.07)  # of strips' middles
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


@pytest.mark.parametrize("file", sorted(MODELS.glob("vehicles/*")), ids=lambda f: f.stem)
def test_every_shipped_vehicle_loads(file: Path):
    vehicle = load_vehicle(file, Finder((MODELS,)))
    assert vehicle.name and vehicle.source
    assert 40e3 < vehicle.weight / len(vehicle.wheelsets) < 250e3
