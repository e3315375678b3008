"""Profiles as workshops measure them: head wear by exact shifts, the hollow of a cone, scans of a folder, wheelsets."""

import json
from pathlib import Path

import numpy as np
import pytest
from support.commands import ok, refusal
from support.rows import rows_of

import wrsim
from wrsim import Profile, load_profile
from wrsim.analysis.profiles import measured_tables
from wrsim.contact.profiles.files import Reading
from wrsim.contact.profiles.flange import tread_hollow
from wrsim.contact.profiles.head_wear import head_wear
from wrsim.contact.profiles.sections import cone
from wrsim.contact.profiles.wear import Removal, worn

table = rows_of(__file__)

RAIL, WHEEL = load_profile("rails/60E1.toml"), load_profile("wheels/S1002.toml")
CROWN, CORNER, AXIS = 0.3, 0.013, np.array([-0.023016030, -0.014949147])  # arcs of 60E1, EN 13674-1


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.0, -1.5e-3), (2e-3, 0.0), (1.2e-3, -0.7e-3)])
def test_head_wear_of_a_shifted_rail_is_that_of_its_arcs(shift: tuple[float, float]) -> None:
    """W1 and W3 lie on the arcs of the crown and the corner, W2 on the corner, 14 mm below the unworn top."""
    wear, (du, dw) = head_wear(RAIL.shifted(*shift), RAIL), shift
    assert wear.vertical == pytest.approx(CROWN - np.sqrt(CROWN**2 - du**2) - dw, abs=1e-9)
    side, unworn = (AXIS[0] + m - np.sqrt(CORNER**2 - (0.014 + AXIS[1] + n) ** 2) for m, n in ((du, dw), (0, 0)))
    assert wear.lateral == pytest.approx(side - unworn, abs=1e-7)  # the standard's figures are rounded
    along = np.dot(shift, [-np.sqrt(0.5), np.sqrt(0.5)])
    reach = along + np.sqrt(CORNER**2 - (np.dot(shift, shift) - along**2))
    assert wear.corner == pytest.approx(CORNER - reach, abs=1e-9)


@pytest.mark.parametrize("offset", [2e-3, -2e-3])
def test_a_scan_beside_the_unworn_rail_is_known_by_its_field_side_which_wear_leaves_alone(offset: float) -> None:
    """The side leans by 1:20: vertical wear of d, that moves no side, is as good as a shift by d / 20."""
    gauge_side = worn(RAIL, [Removal("normal", 3e-3, -34e-3, 8e-3)], "worn")
    assert head_wear(gauge_side, RAIL).field == pytest.approx(0.0, abs=1e-9)
    assert head_wear(RAIL.shifted(offset, 0.0), RAIL).field == pytest.approx(-offset, abs=1e-9)
    tables = measured_tables({"scan": Reading(None, RAIL.shifted(offset, 0.0))}, [], RAIL, None)
    (note,) = [n for n in tables["rail"].notes if "scan" in n]
    assert f"its field side lies 2.00 mm {'outside' if offset > 0.0 else 'inside'} that of 60E1" in note


def test_a_narrower_rail_lacks_its_side_and_the_lip_of_a_grooved_one_is_no_corner() -> None:
    """Distances of gauge points from tops, uninclined: 60E1 35.981 mm, 54E1 34.995 mm."""
    wear = head_wear(load_profile("rails/54E1.toml"), RAIL)
    assert wear.lateral == pytest.approx((35.981 - 34.995) * 1e-3, abs=1e-6)
    assert wear.vertical == pytest.approx(0.0, abs=1e-12)
    grooved = load_profile("rails/grooved.toml")
    wear = head_wear(grooved.shifted(0.0, -1e-3), grooved)
    assert wear.vertical == pytest.approx(1e-3, abs=1e-9)
    assert 0.6e-3 < wear.corner < 1e-3  # cos 45 degrees of it, and the curvature of the corner


def test_the_hollow_of_a_cone_is_the_drop_behind_the_crest_of_its_bell() -> None:
    """w = g u + d cos^2(pi x / 2h): the slope vanishes where sin(pi x / h) = 2 g h / (pi d)."""
    slope, depth, half = 0.05, 2e-3, 20e-3
    new = cone("cone", "wheel", slope, -60e-3, 60e-3)
    assert tread_hollow(new) == 0.0 and tread_hollow(WHEEL) == 0.0
    wheel = worn(new, [Removal("vertical", depth, 5e-3, half)], "hollow")
    crest = np.arcsin(2.0 * slope * half / (np.pi * depth)) * half / np.pi
    crest, valley = np.array([crest, half - crest])
    drop = depth * (np.cos(np.pi * crest / 2 / half) ** 2 - np.cos(np.pi * valley / 2 / half) ** 2)
    assert tread_hollow(wheel) == pytest.approx(drop - slope * (valley - crest), abs=1e-7)


def written(profile: Profile, path: Path) -> None:
    rows, _ = profile.table(2e-4)
    points = "".join(f"{1e3 * u:.5f}\t{1e3 * w:.5f}\n" for u, w in rows[:, :2])
    path.write_text(f"ProgramName=MiniProf\nColumnDef=X,Y\n\n{points}", encoding="utf-8")


@pytest.fixture
def scans(tmp_path: Path) -> Path:
    folder = tmp_path / "scans"
    folder.mkdir()
    written(WHEEL, folder / "axle1_left.whl")
    written(worn(WHEEL, [Removal("vertical", 1e-3, 0.0, 25e-3)], "worn"), folder / "axle1_right.whl")
    written(RAIL.shifted(1e-3, -2e-3), folder / "km12.ban")
    (folder / "spoilt.whl").write_text("ProgramName=MiniProf\nColumnDef=X,Y\n\n1.0 x\n")
    return folder


@pytest.mark.usefixtures("sketched")
def test_a_folder_is_one_table_and_picture_a_kind_and_bad_files_are_named(scans: Path, tmp_path: Path) -> None:
    options = "--reference", "rails/60E1.toml", "--flange-back-mm", 1360.0, "-o", tmp_path / "all.png", "--json"
    answer = json.loads(ok("profile", scans, *map(str, options)).stdout)
    left, right = answer["wheels"]
    # EN 13715: 28 mm high, 32.5 mm thick; 5 mm of smoothing rounds the flank by some um
    assert (left["Sh_mm"], left["Sd_mm"]) == pytest.approx((28.0, 32.5), abs=0.01) and left["hollow_mm"] < 0.005
    assert right["Sh_mm"] == pytest.approx(29.0, abs=0.01) and right["hollow_mm"] > 0.4
    (rail,) = answer["rails"]
    assert rail["W1_mm"] == pytest.approx(2.0, abs=0.01)
    assert any("spoilt.whl:4: 'x' is not a number" in note for note in answer["notes"])
    (axle,) = answer["wheelsets"]
    assert axle["wheelset"] == "axle1" and axle["SR_mm"] == pytest.approx(1360.0 + left["Sd_mm"] + right["Sd_mm"])
    names = ["all_wheels.csv", "all_wheels.png", "all_rails.csv", "all_rails.png"]
    assert sorted(Path(file).name for file in answer["files"]) == sorted(names)
    assert (tmp_path / "all_wheels.csv").read_text().startswith("wheel,Sh_mm,Sd_mm,qR_mm,hollow_mm\n")


def test_conicity_and_pressure_of_a_table_are_those_of_the_pair() -> None:
    answer = wrsim.profiles(["wheels/S1002.toml", "wheels/cone_1in20.toml"], on="rails/60E1.toml")
    s1002, conical = answer["wheels"]
    alone = wrsim.conicity("wheels/S1002.toml", "rails/60E1.toml")
    assert s1002["equivalent_conicity_3_mm"] == pytest.approx(alone["equivalent_conicity"]["3_mm"], rel=1e-6)
    assert conical["equivalent_conicity_3_mm"] == pytest.approx(0.05, rel=0.02)
    assert conical["Sh_mm"] is None and any("no flange" in note for note in answer["notes"])
    assert 500.0 < s1002["p0_MPa"] < 1500.0 and 500.0 < conical["p0_MPa"] < 1500.0


@pytest.mark.parametrize(("options", "message"), table("options_that_have_no_use_are_answered"))
def test_options_that_have_no_use_are_answered(options: tuple[str, ...], message: str, tmp_path: Path) -> None:
    assert message in refusal("profile", *options, "-o", str(tmp_path / "p.png"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("file", "message"), [("rails/60E1.toml", "60E1 is a rail"), ("wheels/S1002.toml", "is a shape by formula")]
)
def test_an_alignment_onto_what_does_not_fit_is_refused(file, message):
    with pytest.raises(wrsim.InputError, match=f"^--align wheels/S1002.toml: .*{message}"):
        wrsim.profiles(file, align="wheels/S1002.toml")
