"""Equivalent conicity: EN 15302's tables, cones, mirrored and unequal wheels, the command."""

import json
import shutil
from functools import cache
from math import atan
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk
from support.commands import ok, refusal
from support.rows import rows_of
from support.runs import ROOT

from wrsim import InputError, Profile, Result, load, load_profile, run
from wrsim.analysis.conicity.conicity import equivalent_conicity, wheelset_conicity
from wrsim.analysis.conicity.pairs import conicity_map
from wrsim.contact.profiles.check_rail import with_check_rail
from wrsim.contact.profiles.flange import FLANGE_FROM
from wrsim.contact.profiles.models import readings_in
from wrsim.contact.profiles.sections import ProfileArc, ProfileLine, circle, cone, profile_from_sections
from wrsim.results.conicity import steering_summary
from wrsim.results.tables import tables
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.vehicle.wheelset import Wheel, Wheelset

table = rows_of(__file__)

DATA = Path(__file__).parents[1] / "data"
E = np.genfromtxt(DATA / "en15302_conicity.csv", delimiter=",", comments="#", skip_header=2)
CROWN, RADIUS, HALF_TOPS = 0.02, 0.46, 0.75
ROUND = circle("round rail", "rail", CROWN, 0.0199)
ROUND_GAUGE = 2.0 * (HALF_TOPS + ROUND.gauge_point()[0])
"""Gauge that puts the tops of round rails 1.5 m apart."""


@cache
def pair(wheel: str, rail: str):
    """Shipped profiles."""
    models = ROOT / "models"
    return load_profile(models / "wheels" / f"{wheel}.toml"), load_profile(models / "rails" / f"{rail}.toml")


def swing(profiles, gauge: float, radii: tuple[float, float], roll: str, amplitudes):
    """Dataset of a wheelset with the profile origins 1.5 m apart."""
    wheel, rail = profiles
    wheelset = Wheelset("w", 1.0, (1.0, 1.0, 1.0), 1.5, Wheel(wheel, radii[0]), Wheel(wheel, radii[1]))
    return wheelset_conicity(wheelset, (rail, rail), gauge, ConicityPlan(tuple(amplitudes), roll), "test").wheelset()


@pytest.mark.parametrize("column, right", [(1, 0.460), (2, 0.459)], ids=["E1", "E5"])
def test_the_tables_of_en_15302_are_met(column, right):
    wheel, rail = (load_profile(DATA / f"en15302_{kind}_A.csv", kind) for kind in ("wheel", "rail"))
    conicities = swing((wheel, rail), 1.43516, (0.460, right), "none", 1e-3 * E[:, 0])["equivalent_conicity"].values
    error = np.abs(conicities - E[:, column])
    assert (error <= np.minimum(0.05, 0.5 * E[:, column])).all()  # the standard's own tolerance
    middle = (E[:, 0] >= 2.0) & (E[:, 0] <= 5.0)
    assert error[middle].max() < 0.01


def flat_headed() -> Profile:
    """A rail with a straight head of 46 mm between two corners of 13 mm."""
    head, corner, foot = 0.023, 0.013, -0.036
    pieces = [
        ProfileLine(-head - corner, foot, -head - corner, -corner),
        ProfileArc(-head, -corner, corner, 0.5 * np.pi, 0.0),
        ProfileLine(-head, 0.0, head, 0.0),
        ProfileArc(head, -corner, corner, 0.0, -0.5 * np.pi),
        ProfileLine(head + corner, -corner, head + corner, foot),
    ]
    return profile_from_sections("flat", "rail", pieces)


def test_a_swing_beyond_the_known_shifts_or_over_a_hill_has_no_conicity():
    shift = np.linspace(-8e-3, 5e-3, 14)  # of a cone 1:20; known farther on one side
    swung = equivalent_conicity(shift, 0.1 * shift, 0.46, [4.9e-3, 5.1e-3])
    assert swung.conicity == pytest.approx([0.05, np.nan], rel=1e-6, nan_ok=True)
    # two wells: delta r falls through zero in the middle; small swings about one of them, none of 4 mm
    y = np.linspace(-8e-3, 8e-3, 1601)
    swung = equivalent_conicity(y, 1e4 * y * (y - 3e-3) * (y + 4e-3), 0.46, [0.2e-3, 2.9e-3])
    assert swung.equilibrium == pytest.approx(-4e-3, abs=1e-6)
    assert np.isfinite(swung.conicity[0]) and np.isnan(swung.conicity[1])


@pytest.mark.parametrize(("rail", "gauge"), [(ROUND, ROUND_GAUGE), (flat_headed(), 1.435)], ids=["round", "flat"])
@pytest.mark.parametrize("slope", [0.025, 0.2])
def test_a_cone_gives_its_own_conicity(slope, rail, gauge):
    wheel = cone("cone", "wheel", slope, -0.06, 0.06)
    swung = swing((wheel, rail), gauge, (RADIUS, RADIUS), "none", 1e-3 * np.array([0.5, 3.0, 7.0]))
    assert swung["equivalent_conicity"].values == pytest.approx(slope, rel=1e-9)
    wavelength = 2.0 * np.pi * np.sqrt(RADIUS * HALF_TOPS / slope)
    assert rail is not ROUND or swung["conicity_wavelength"].values == pytest.approx(wavelength, rel=1e-9)
    assert swung.attrs["equilibrium_shift_m"] == pytest.approx(0.0, abs=1e-12)
    linear = 2.0 * slope * swung["lateral_shift"].values
    assert swung["rolling_radius_difference"].values == pytest.approx(linear, abs=1e-12)


@pytest.mark.parametrize("height", [0.0, 0.02])
def test_a_check_rail_leaves_the_conicity_of_its_rail(height):
    wheel, rail = pair("S1002", "60E1")
    rails = rail.inclined(1 / 40), with_check_rail(rail.inclined(1 / 40), 0.041, height)
    conicities = [
        swing((wheel, profile), 1.435, (RADIUS, RADIUS), "none", [3e-3])["equivalent_conicity"] for profile in rails
    ]
    assert conicities[1].values == pytest.approx(conicities[0].values, rel=1e-9)


@pytest.mark.parametrize("slope", [0.0, 0.05])
def test_a_wheel_that_touches_its_rail_along_a_line_is_refused(slope):
    wheel = cone("cone", "wheel", slope, -0.06, 0.06)
    with pytest.raises(InputError, match="'cone' touches profile 'flat' along a line of 46"):
        swing((wheel, flat_headed().inclined(slope)), 1.435, (RADIUS, RADIUS), "none", [3e-3])


@pytest.mark.parametrize("roll", ["rail-top", "centre"])
def test_a_cone_that_rolls_follows_wickens(roll):
    # derived in tests/simulation/test_energy.py: the centre has the conicity
    # lambda (l + Rr lambda) / (l - r0 lambda); the point at the rail tops shifts by l / (l - r0 lambda) times as much
    slope = 0.05
    contact = HALF_TOPS - CROWN * slope
    expected = slope * (contact + CROWN * slope) / (contact - (RADIUS * slope if roll == "centre" else 0.0))
    wheel = cone("cone", "wheel", slope, -0.06, 0.06)
    swung = swing((wheel, ROUND), ROUND_GAUGE, (RADIUS, RADIUS), roll, [1e-3, 4e-3])
    # small angles: lambda and phi are taken for their tangents and sines
    assert swung["equivalent_conicity"].values == pytest.approx(expected, rel=3e-3)


def test_unequal_wheels_swing_about_the_place_where_they_roll_alike_if_there_is_one():
    slope = 0.05
    wheel = cone("cone", "wheel", slope, -0.06, 0.06)
    swung = swing((wheel, ROUND), ROUND_GAUGE, (0.4602, 0.4598), "none", [3e-3])
    # r_left - r_right = 0.4 mm + 2 lambda y = 0
    assert swung.attrs["equilibrium_shift_m"] == pytest.approx(-0.4e-3 / (2.0 * slope), rel=1e-6)
    assert swung["equivalent_conicity"].values == pytest.approx(slope, rel=1e-9)
    wheel = cone("cylinder", "wheel", 0.0, -0.06, 0.06)
    with pytest.raises(InputError, match="no place to swing about"):
        swing((wheel, ROUND), ROUND_GAUGE, (0.461, 0.459), "none", [3e-3])


def test_the_wavelength_of_a_nonlinear_swing_is_that_of_its_elliptic_integral():
    # delta r = 2 k y^3: Duffing's equation, wavelength 4 K(1/2) / (a sqrt(c)), c = 2 k / (2 e r0)
    k, a = 2000.0, 4e-3
    y = np.linspace(-6e-3, 6e-3, 4001)
    swung = equivalent_conicity(y, 2.0 * k * y**3, 0.46, a)
    c = 2.0 * k / (1.5 * 0.46)
    # spacing of 3 um: piecewise linear to 1e-6
    assert swung.wavelength[0] == pytest.approx(4.0 * ellipk(0.5) / (a * np.sqrt(c)), rel=2e-6)


@pytest.mark.usefixtures("sketched")
def test_the_scenario_and_the_command_tell_the_same(tmp_path):
    result = run(load(ROOT / "scenarios" / "conicity_s1002.toml"))
    assert result.summary()["wheelsets"]["wheelset"]["equivalent_conicity"]["3_mm"] == pytest.approx(0.174, abs=2e-3)
    assert len(tables(result.dataset)["conicity"]) == 1 + result.dataset.sizes["amplitude"]
    picture, table = tmp_path / "conicity.png", tmp_path / "conicity.csv"
    told = ok("conicity", "wheels/S1002.toml", "rails/60E1.toml", "--json", "-o", tmp_path)
    answer = json.loads(told.output)
    values = result.wheelset()["equivalent_conicity"].values
    assert answer["tan_gamma_e"] == pytest.approx(values.tolist(), rel=1e-9)
    assert picture.is_file()
    assert table.read_text().splitlines()[0] == "amplitude_mm,equivalent_conicity,conicity_wavelength_m"
    loaded = Result.load(result.save(tmp_path / "result.nc"))
    assert loaded.dataset.identical(result.dataset)


@pytest.mark.parametrize("arguments, message", table("the_command_refuses_what_it_cannot_use"))
def test_the_command_refuses_what_it_cannot_use(arguments, message):
    told = refusal("conicity", "wheels/S1002.toml", "rails/60E1.toml", *arguments.split())
    assert message in " ".join(told.split())


# Maps of the equivalent conicity over gauge and profiles: cones, what gauge and spacing mean together, folders.
MODELS = ROOT / "models"
SCANS = ROOT / "scenarios" / "measured"
S1002 = {"S1002": load_profile(MODELS / "wheels/S1002.toml")}
RAILS = {"60E1": load_profile(MODELS / "rails/60E1.toml").inclined(1 / 40)}


def test_of_gauge_and_spacing_only_the_play_counts_and_for_a_cone_not_even_that():
    cones = {f"{c}": cone(f"cone {c}", "wheel", c, -0.04, 0.06) for c in (0.05, 0.1)}
    mapped = conicity_map(cones, RAILS, [1.43, 1.44], lambda *_: 1.5, 0.46)
    assert mapped.pairs == (("0.05", "60E1"), ("0.1", "60E1"))
    assert mapped.conicity == pytest.approx(np.tile([[0.05], [0.1]], 2), rel=0.02)  # a sixtieth of 1.5 m either way
    assert mapped.nonlinearity == pytest.approx(np.zeros((2, 2)), abs=1e-3)
    wide = conicity_map(S1002, RAILS, [1.433, 1.436], lambda *_: 1.5, 0.46)
    moved = conicity_map(S1002, RAILS, [1.431, 1.434], lambda *_: 1.498, 0.46)
    assert moved.conicity == pytest.approx(wide.conicity, rel=1e-9)
    assert wide.conicity[0, 0] > 1.2 * wide.conicity[0, 1]  # S1002 on 60E1 falls with the gauge


def test_a_folder_gives_its_profiles_of_a_kind_and_names_what_is_none(tmp_path):
    assert list(readings_in(SCANS, "wheel")[0]) == ["wheel"]
    assert list(readings_in(SCANS, "rail")[0]) == ["rail"]  # rail.toml describes rail.csv
    assert list(readings_in(SCANS, None)[0]) == ["rail", "wheel"]
    with pytest.raises(InputError, match=r"has no wheel profiles \(files that end in \.toml or \.ban"):
        readings_in(tmp_path, "wheel")
    for name in ("broken.whl", *(f"broken_{i}.whl" for i in range(3))):
        (tmp_path / name).write_text("no numbers\n")
    with pytest.raises(InputError, match=r"has no wheel profiles(?s:.*)broken\.whl"):
        readings_in(tmp_path, "wheel")
    shutil.copy(SCANS / "wheel.whl", tmp_path)
    readings, faults = readings_in(tmp_path, "wheel")
    assert (
        list(readings) == ["wheel"]
        and len(faults) == 1
        and "broken.whl, broken_0.whl, broken_1.whl and 1 more:" in faults[0]
    )


# Radial steering index: cones by hand, sides that differ, what is asked for wrongly.
def conicity_of(wheels, flange_from=FLANGE_FROM, rail=ROUND, gauge=ROUND_GAUGE, curves=()):
    wheelset = Wheelset("w", 1.0, (1.0, 1.0, 1.0), 1.5, *(Wheel(wheel, RADIUS) for wheel in wheels))
    plan = ConicityPlan((3e-3, 7e-3), "none", curves, flange_from)
    return wheelset_conicity(wheelset, (rail, rail), gauge, plan, "test").wheelset()


def steering(wheels, **options):
    """The index in one curve: its numbers, and those of the wheelset."""
    summary = steering_summary(conicity_of(wheels, **options))
    return summary["radial_steering"][0], summary


def test_a_cone_steers_radially_at_e_r0_over_r_times_its_slope():
    slope = 0.2
    wheel = cone("cone", "wheel", slope, -0.06, 0.06)
    reach = float(conicity_of((wheel, wheel))["lateral_shift"].max())
    for radius in (300.0, 2000.0):
        index, _ = steering((wheel, wheel), curves=(radius,))
        assert index["needed_mm"] == pytest.approx(1.5e3 * RADIUS / radius)
        assert index["available_mm"] == pytest.approx(2e3 * slope * reach, rel=1e-6)
        assert index["q_E"] == pytest.approx(0.75 * RADIUS / (radius * slope * reach), rel=1e-6)
        by_hand = 0.75e3 * RADIUS / (radius * slope)
        assert index["shift_mm"] == (pytest.approx(by_hand, rel=1e-6) if by_hand <= 1e3 * reach else None)


def test_a_cone_as_steep_as_a_flange_is_one():
    wheel = cone("cone", "wheel", 0.2, -0.06, 0.06)
    angle = atan(0.2)
    assert steering((wheel, wheel), flange_from=1.01 * angle, curves=(300.0,))[0]["available_mm"] > 0.0
    index, summary = steering((wheel, wheel), flange_from=0.99 * angle, curves=(300.0,))
    assert index["available_mm"] == 0.0 and index["q_E"] is None and summary["smallest_radial_curve_m"] is None


def test_the_less_able_side_counts_and_mirrored_wheelsets_are_alike():
    wheel, rail, worn = S1002["S1002"], RAILS["60E1"], S1002["S1002"].shifted(dw=1e-3)
    pairs = ((wheel, wheel), (wheel, worn), (worn, wheel))
    new_pair, first, second = (steering(pair, rail=rail, gauge=1.435, curves=(400.0,))[0] for pair in pairs)
    assert first["available_mm"] == pytest.approx(second["available_mm"], abs=2e-2)
    assert first["q_E"] > new_pair["q_E"]
