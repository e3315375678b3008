"""Files of points as programs and instruments write them: what is stated, assumed, and contradicted by the shape."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from support.profile_texts import (
    BACK,
    S1002,
    cases,
    guide,
    lines,
    measures,
    miniprof,
    moved,
    nodes,
    outcome,
    simpack,
    vampire,
)

from wrsim import InputError, load_profile
from wrsim.contact.profiles.files import read_points
from wrsim.contact.profiles.head_wear import head_wear
from wrsim.contact.profiles.wear import Removal, worn
from wrsim.contact.surfaces.rail_surface import read_sections
from wrsim.inputs.lookup import shipped_models
from wrsim.vehicle.out_of_round import read_wheel_sections

WHEEL, RAIL = load_profile("wheels/S1002.toml"), load_profile("rails/60E1.toml")
POINTS = nodes(WHEEL)
FACE = np.concatenate(
    [
        POINTS,
        [(60.0 + 4.0 * np.sin(a), POINTS[-1, 1] + 4.0 * (1.0 - np.cos(a))) for a in np.linspace(0.1, np.pi / 2, 16)],
        [(64.0, POINTS[-1, 1] + 4.0 + h) for h in np.arange(0.4, 36.0, 0.4)],
    ]
)
"""S1002 with its outer face: a corner of 4 mm and 36 mm up."""


@pytest.mark.parametrize("name", ["wheels/S1002_worn.toml", "rails/60E1_worn.toml"])
def test_a_profile_in_any_layout_is_right_or_refused(name, tmp_path):
    """Every layout at least once; all of them: campaigns/layouts.py."""
    profile = load_profile(name)
    outcomes = {case.label: outcome(case, profile, tmp_path) for case in cases(profile, 17)}
    refused = {label: reason for label, reason in outcomes.items() if reason != "right"}
    assert "wrong" not in refused.values() and len(refused) < 0.2 * len(outcomes)
    # what is refused has no unit, or the rail counts to the other side than its format does
    assert all("Is the unit right" in reason or "give field_side" in reason for reason in refused.values())


def test_the_page_shows_the_first_lines_of_each_layout_and_the_line_about_it(tmp_path):
    page = (Path(__file__).parents[2] / "docs/user/files_as_they_are.md").read_text(encoding="utf-8")
    shown = re.findall(r"^## (.+?)\n.*?^```text\n(.*?)^```\n\n> (.*?)$", page, re.MULTILINE | re.DOTALL)
    files = guide(WHEEL, load_profile("rails/60E1_worn.toml"))
    assert [heading for heading, _, _ in shown] == list(files)
    for heading, first, line in shown:
        name, text = files[heading]
        assert text.startswith(first)
        (tmp_path / name).write_text(text, encoding="utf-8")
        try:
            (note,) = read_points(tmp_path / name, "rail" if name.startswith("rail") else "wheel").profile.notes
        except InputError as error:
            note = f"refused: {error}".replace(f"{tmp_path}{os.sep}", "")
        assert note == line


@pytest.mark.parametrize("text", ["points", "MiniProf"])
def test_a_wheel_whose_tread_is_not_at_the_tape_circle_is_never_read_in_silence(text, write):
    for shift in (*range(-90, 91, 9), -4.0, 4.0, -1.5, 1.5, 66.0, 70.0, 74.0):
        points = moved(POINTS, shift)
        path = write(
            miniprof(points) if text == "MiniProf" else lines(points, "mm"), "w.whl" if text != "points" else "w.txt"
        )
        try:
            profile = read_points(path, "wheel").profile
        except InputError as error:
            assert "neither its tape circle nor its flange back" in str(error)
            assert "back_to_tape_circle_mm, origin, or shift_mm" in str(error)
            assert abs(shift) > 2.5 and abs(shift - BACK) > 2.5
            continue
        off = shift - BACK if shift > 50.0 else shift
        assert abs(off) <= 2.5 and profile.notes
        assert profile.u[0] == pytest.approx(1e-3 * (off - 70.0), abs=3e-4)  # smoothing shortens the end


def test_a_wheel_that_ends_before_its_back_tells_how_thick_its_flange_is(write):
    """The back is known from 70 degrees on: an arc of 20.5 mm ends 1.2 mm before it."""
    for end, note in ((-69.4, "the flange back is at -69.3 mm"), (-66.0, "so the flange is some 31 mm thick")):
        profile = read_points(write(lines(POINTS[POINTS[:, 0] > end], "mm"), "w.txt"), "wheel").profile
        assert note in profile.notes[0]
    for shift in (-14.0, 8.0):  # thinner than 20, thicker than 38 mm
        short = moved(POINTS[POINTS[:, 0] > -45.0], shift)
        with pytest.raises(InputError, match="the face of the flange lies at u"):
            read_points(write(lines(short, "mm"), "w.txt"), "wheel")


@pytest.mark.parametrize("shift", [50.0, 40.0, -50.0])
def test_a_shape_by_formula_with_its_flange_on_the_tape_circle_is_refused(shift, write):
    text = (shipped_models() / "wheels/tram.toml").read_text().replace("= -61.6", f"= {shift - 61.6}")
    with pytest.raises(InputError, match=r"u = 0 (is not on its tread|mm)"):
        load_profile(write(text, "wheel.toml"))


OUTER = {
    "wheel.csv": lambda: lines(FACE, "mm"),
    "wheel.whl": lambda: miniprof(FACE * (1.0, -1.0)),
    "wheel.prw": lambda: simpack(FACE * (1.0, -1.0), "mm", "wheel"),
}


@pytest.mark.parametrize("name", OUTER)
@pytest.mark.parametrize("mirrored", [1.0, -1.0])
def test_a_wheel_with_its_outer_face_has_its_flange_where_the_curve_turns_back(name, mirrored, write):
    text = lines(FACE * (mirrored, mirrored), "mm") if name == "wheel.csv" else OUTER[name]()
    reading = read_points(write(text, name), "wheel")
    assert measures(reading.close) == pytest.approx(S1002, abs=0.02)
    told = read_points(write(text, name), "wheel", origin="tape circle", back=0.07, measured=False, unit="mm")
    assert not [note for note in told.profile.notes if "tape circle" in note]


def test_a_stated_direction_is_never_overruled(write):
    path = write(lines(FACE, "mm"), "wheel.csv")
    assert measures(read_points(path, "wheel", heights="up", field_side="positive").profile) == pytest.approx(
        S1002, abs=0.01
    )
    with pytest.raises(InputError, match="flange points the wrong way up"):
        read_points(path, "wheel", heights="down")
    with pytest.raises(InputError, match="flange is on the field side"):
        read_points(path, "wheel", field_side="negative")


def test_miniprof_rails_count_to_the_gauge_side(write):
    """A bell of 3 mm on the gauge corner: W2 and W3 are those of the profile that was written."""
    high = worn(RAIL, [Removal("normal", 3e-3, -38e-3, 18e-3)], "high rail")
    expected = head_wear(high, RAIL)
    text = miniprof(nodes(high) * (-1.0, 1.0))
    reading = read_points(write(text, "high_rail.ban"))
    wear = head_wear(reading.close, RAIL)
    assert (wear.lateral, wear.corner) == pytest.approx((expected.lateral, expected.corner), abs=1e-5)
    assert reading.profile.notes == ("high_rail.ban: x to the gauge side, as its format has it (field_side)",)
    with pytest.raises(InputError, match=r"x counts to the gauge side .* by wear of 1\.\d mm in the mean it does not"):
        read_points(write(miniprof(nodes(high)), "high_rail.ban"))
    assert read_points(write(miniprof(nodes(high)), "high_rail.ban"), field_side="positive").profile.notes == ()


@pytest.mark.parametrize(
    ("rail", "reason"),
    [
        ("rails/60E1_worn.toml", "by wear of"), ("rails/60E1_check.toml", "by the groove"),
        ("rails/60E1.toml", "both sides alike"),
    ],
)  # fmt: skip
def test_a_rail_shows_its_gauge_side(rail, reason, write):
    profile = load_profile(rail)
    for side in (1.0, -1.0):
        read_profile = read_points(write(lines(nodes(profile) * (side, 1.0), "mm"), "rail.csv"), "rail").profile
        assert reason in read_profile.notes[0]
        assert read_profile.gauge_point() == pytest.approx(profile.gauge_point(), abs=1e-5)


def test_the_height_at_the_tape_circle_is_the_radius_there(write):
    right = read_points(write(lines(moved(POINTS, 0.0, 0.3), "mm"), "right.csv"), "wheel").profile
    assert float(right.at(right.arclength_of(0.0))[1]) == pytest.approx(0.0, abs=1e-12)
    assert "moved by -0.300 mm to height 0 at the tape circle" in right.notes[0]
    shifted = read_points(write(lines(POINTS, "mm"), "right.csv"), "wheel", shift=(0.0, 1e-3)).profile
    assert float(shifted.at(shifted.arclength_of(0.0))[1]) == pytest.approx(1e-3, abs=1e-12)


# Points: gaps, corners, dense ones, parts scanned twice.


def test_straight_parts_need_no_points_and_far_corners_are_rounded(write):
    """A tread with two chords of 12 mm and a chamfer; a rail with one chord down its side."""
    tread = POINTS[POINTS[:, 0] < 29.8]
    u, w = tread[-1]
    coarse = np.concatenate([tread, [(u + 12, w + 0.3), (u + 24, w + 0.6), (u + 29, w + 5.6)]])
    profile = read_points(write(lines(coarse, "mm"), "wheel.csv"), "wheel").profile
    assert measures(profile) == pytest.approx(S1002, abs=0.01)
    assert "rounded" in profile.notes[0] and "gaps of up to 12 mm filled" in profile.notes[0]
    for shift in (0.0, 6.0):  # where the curve turns a gap is a fault
        hole = np.abs(POINTS[:, 0] + 32.0 - shift) > 4.0
        with pytest.raises(InputError, match="too coarse"):
            read_points(write(lines(POINTS[hole], "mm"), "wheel.csv"), "wheel")
    side = nodes(RAIL)
    side = np.concatenate([side[side[:, 1] > -20.0], [(side[-1, 0] + 0.05, -32.0)]])
    assert read_points(write(lines(side, "mm"), "rail.csv"), "rail").profile.length > 0.1


def test_dense_points_are_smoothed_by_their_scatter(write):
    """A point every 10 um with four decimals; every 0.1 and 0.5 mm with three: curvature within 2 1/m."""
    for step, digits in ((5e-4, 3), (1e-5, 4), (1e-4, 3)):
        text = "".join(f"{u:.{digits}f},{w:.{digits}f}\n" for u, w in nodes(RAIL, step))
        profile = read_points(write(text, "rail.csv"), "rail").profile
        assert "the points scatter by" in profile.notes[0]
        places = np.array([-0.031, -0.018, 0.0, 0.005])  # some mm from where the curvature jumps
        expected = RAIL.curvature(RAIL.arclength_of(places))
        np.testing.assert_allclose(profile.curvature(profile.arclength_of(places)), expected, atol=2.0)
    with pytest.raises(InputError, match=r"Smooth them with measured = true \(--measured\)"):
        read_points(write(text, "rail.csv"), "rail", measured=False)
    assert read_points(write(text, "rail.csv"), "rail", measured=True).measured


def test_a_tip_that_is_scanned_twice_is_joined_with_a_note(write):
    tip = int(np.argmin(POINTS[:, 1]))
    rng = np.random.default_rng(7)
    for again in (tip - 20, tip - 3):
        twice = np.concatenate([POINTS[: tip + 10], moved(POINTS[again:], 0.0, 0.05)])
        twice = twice + 2e-3 * rng.normal(size=twice.shape)
        reading = read_points(write(miniprof(twice * (1.0, -1.0)), "wheel.whl"))
        assert any(word in reading.profile.notes[0] for word in ("scanned twice", "two scans"))
        assert measures(reading.close)[1:] == pytest.approx(S1002[1:], abs=0.05)
    far = np.concatenate([POINTS[: tip + 10], moved(POINTS[tip - 20 :], 0.0, 1.0)])
    with pytest.raises(InputError, match=r"goes back on itself|heights is unknown"):
        read_points(write(miniprof(far), "wheel.whl"))


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (lambda rows: "NaN,NaN\n" * 3 + rows, "3 lines without numbers at the ends"),
        (lambda rows: "x,y,z\n" + "".join(f"0.0,{row}\n" for row in rows.split()), "in mm"),
        (lambda rows: "".join(f"0.0,{row}\n" for row in rows.split()), "the first column is constant and left out"),
        (lambda rows: "".join(f"{row},1.0\n" for row in rows.split()), "the last column is constant and left out"),
        (lambda rows: "".join('"{}";"{}"\n'.format(*row.split(",")) for row in rows.split()), "in mm"),
    ],
)
def test_columns_that_hold_no_coordinate_and_ends_without_numbers_are_left_out(text, note, write):
    profile = read_points(write(text(lines(POINTS, "mm")), "w.csv"), "wheel").profile
    assert measures(profile) == pytest.approx(S1002, abs=0.01) and note in profile.notes[0]


def test_a_comment_is_no_name_and_vampire_takes_the_right_side(write):
    wheel = read_points(write(simpack(POINTS * (1.0, -1.0), "m", "wheel"), "LM_own.prw")).profile
    assert (wheel.name, wheel.source) == ("LM_own", "LM")
    vampires = read_points(write(vampire(POINTS, "wheel"), "own.whe")).profile
    assert measures(vampires) == pytest.approx(S1002, abs=0.01) and vampires.back == pytest.approx(0.07)
    sheet = write("", "sheet.txt")  # what a spreadsheet calls Unicode text
    sheet.write_bytes(f"y (mm)\tz (mm)\n{lines(POINTS, 'mm', chr(9), comma=True)}".encode("utf-16"))
    assert measures(read_points(sheet, "wheel").profile) == pytest.approx(S1002, abs=0.01)
    with pytest.raises(InputError, match=r"'furlong' is no known unit; allowed: m, mm, cm, in"):
        read_points(write("y [furlong],z [furlong]\n" + lines(POINTS, "mm"), "w.csv"), "wheel")


# Alignment


@pytest.mark.parametrize(("unworn", "du", "dw", "turn"), [(WHEEL, 3.0, -2.0, 8e-3), (RAIL, -2.0, 1.5, -12e-3)])
def test_a_scan_is_laid_on_the_unworn_profile_by_the_parts_that_do_not_wear(unworn, du, dw, turn, write):
    """A worn profile moved and turned: the scan comes back to where the worn profile lies; 3 um of noise."""
    bell = Removal("normal", 1.5e-3, -40e-3 if unworn.kind == "wheel" else -35e-3, 15e-3)
    worn_profile = worn(unworn, [bell, Removal("vertical", 1e-3, 0.0, 20e-3)], "worn")
    scan = nodes(worn_profile.rotated(turn).shifted(1e-3 * du, 1e-3 * dw))
    scan = scan + 3e-3 * np.random.default_rng(1).normal(size=scan.shape)
    name = "scan.whl" if unworn.kind == "wheel" else "scan.ban"
    text = miniprof(scan if unworn.kind == "wheel" else scan * (-1.0, 1.0))
    reading = read_points(write(text, name), align=unworn)
    assert "aligned on" in reading.profile.notes[0] and f"turned by {-1e3 * turn:.0f}" in reading.profile.notes[
        0
    ].replace(".", " ")
    level = float(worn_profile.at(worn_profile.arclength_of(0.0))[1]) if unworn.kind == "wheel" else 0.0
    if unworn.kind == "wheel":
        assert measures(reading.close) == pytest.approx(measures(worn_profile.shifted(0.0, -level)), abs=0.03)
    else:
        wear, expected = head_wear(reading.close, RAIL), head_wear(worn_profile, RAIL)
        assert (wear.vertical, wear.lateral) == pytest.approx((expected.vertical, expected.lateral), abs=0.05e-3)


# Lists of profiles


def slices(places, names, features=(), scale_name="U") -> str:
    rows = "".join(f"{place} '{name}'\n" for place, name in zip(places, names, strict=True))
    marks = "".join(
        f"{place} " + " ".join(map(str, marks_of_slice)) + "\n"
        for place, marks_of_slice in zip(places, features, strict=False)
    )
    count = len(features[0]) if features else 0
    head = (
        f"% own\n 0.0 1.0 {scale_name}_OFFSET, {scale_name}_SCALE\n {len(places)} NSLC\n {count} 0 0 NFEAT\n 1 METHOD\n"
    )
    return f"{head}\n{rows}\n{marks}"


def test_lists_of_profiles_are_sections_along_the_track_and_over_the_angle(write, tmp_path):
    for i in range(3):
        write(simpack(moved(nodes(RAIL) * (1.0, -1.0), 0.0, 0.2 * i), "mm", "rail"), f"rail_{i}.prr")
        write(simpack(moved(POINTS * (1.0, -1.0), 0.0, 0.1 * i), "mm", "wheel"), f"wheel_{i}.prw")
    places, marks = (-100.0, 0.0, 250.0), ((0.0, -1, 40.0, 133.3),) * 3
    path = write(slices(places, [f"rail_{i}.prr" for i in range(3)], marks), "rails.slcs")
    sections = read_sections(path)
    assert [section.distance for section in sections] == [-0.1, 0.0, 0.25]
    assert sections[1].features == pytest.approx((0.04, 0.04)) and sections[2].profile.top[1] == pytest.approx(-0.4e-3)
    wheels = write(slices((0.0, 1.0, 2.0), [f"wheel_{i}.prw" for i in range(3)], scale_name="TH"), "wheels.slcw")
    table = read_wheel_sections(wheels, WHEEL)
    np.testing.assert_allclose(table.angle, (0.0, 1.0, 2.0), atol=1e-12)
    with pytest.raises(InputError, match=r"is a list of sections along the track: table of"):
        load_profile(path, "rail")
    with pytest.raises(InputError, match=r"bad.slcs:\d+: the place and file of slice 2 of 3 expected here"):
        read_sections(
            write(slices(places, [f"rail_{i}.prr" for i in range(3)]).rsplit("0.0 'rail_1", 1)[0], "bad.slcs")
        )
