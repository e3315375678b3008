"""Civil files: one line in three formats, the track of it, the way back, and what is refused."""

import math
import random
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from support.commands import ok, refusal
from support.runs import ROOT
from support.scenario_texts import STATIC, edited

import wrsim
from wrsim.errors import InputError
from wrsim.plots.track import height
from wrsim.scenario.build import build
from wrsim.scenario.track_build import track_model
from wrsim.track.alignment import Cant, Plan, Profile, alignment_laws
from wrsim.track.cant import Pivot
from wrsim.track.civil import ENDINGS, ifc
from wrsim.track.civil.files import read_alignment
from wrsim.track.civil.ifc import ifc_text
from wrsim.track.civil.landxml import landxml_text
from wrsim.track.civil.line import RAILS, CivilLine, ramp_of
from wrsim.track.forms import FORMS
from wrsim.track.track import Track

MIXED_LINE = ROOT / "models/tracks/mixed_line.toml"
TABLES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
TEXTS = {kind: TABLES[kind].strip() + "\n" for kind in ("ifc", "landxml", "railml")}


def written(folder: Path, kind: str, text: str | None = None, name: str = "line") -> Path:
    path = folder / f"{name}.{kind}"
    path.write_text(TEXTS[kind] if text is None else text, encoding="utf-8")
    return path


def test_one_line_in_three_formats_is_one_track(tmp_path: Path) -> None:
    level = re.sub("(?s)<Cant .*</Cant>", "", TEXTS["landxml"])  # as railML, which has no cant
    paths = [*(written(tmp_path, kind) for kind in TEXTS), written(tmp_path, "landxml", level, "level")]
    tracks = [track_model(path) for path in paths]
    s = np.linspace(0.0, 300.0, 601)
    for first_format, another in ((0, 1), (2, 3)):
        for law in ("curvature", "cant", "grade"):
            values = [getattr(tracks[i], law)(s) for i in (first_format, another)]
            np.testing.assert_allclose(*values, rtol=0.0, atol=1e-9)
    first = tracks[0]
    assert first.curvature(150.0) == pytest.approx(1.0 / 300.0, rel=1e-4)  # to the left
    assert first.cant(150.0) == pytest.approx(0.1)  # with the right rail higher
    assert first.alignment is not None and first.alignment.name == "Gleis Ä'1'"
    assert [f.kind for f in first.features()] == ["straight", "transition", "arc", "transition", "straight"]


@pytest.mark.parametrize(("old", "new"), TABLES["dialects"])
def test_what_programs_write_differently_is_one_track(tmp_path: Path, old: str, new: str) -> None:
    assert old in TEXTS["landxml"]
    first = track_model(written(tmp_path, "landxml"))
    variant = track_model(written(tmp_path, "landxml", TEXTS["landxml"].replace(old, new), "other"))
    s = np.linspace(0.0, first.length, 501)
    assert np.abs(variant.centre_line.position(s) - first.centre_line.position(s)).max() < 1e-4  # angles of 1 mm points
    np.testing.assert_allclose(variant.cant(s), first.cant(s), rtol=0.0, atol=1e-9)
    assert (variant.nominal_gauge, variant.cant_base) == pytest.approx((1.435, 1.5))
    assert first.alignment is not None and variant.alignment is not None
    assert variant.alignment.origin == pytest.approx(first.alignment.origin, abs=1e-9)


def test_cant_is_held_beyond_its_stations(tmp_path: Path) -> None:
    station = '<CantStation station="1260" appliedCant="0" curvature="cw"/>'
    track = track_model(written(tmp_path, "landxml", TEXTS["landxml"].replace(station, "")))
    assert track.cant(np.array([150.0, 299.0])) == pytest.approx([0.1, 0.1])


def test_lengths_lie_in_plan_and_the_line_climbs(tmp_path: Path) -> None:
    line = read_alignment(written(tmp_path, "landxml"))
    track = track_model(written(tmp_path, "landxml"))
    ends = track.centre_line.position(np.array([0.0, track.length]))
    plan = line.level(1.5).position(np.array([0.0, 300.0]))
    assert np.linalg.norm(np.diff(ends[:, :2], axis=0)) == pytest.approx(np.linalg.norm(np.diff(plan[:, :2], axis=0)))
    top = 0.004 * 150.0 - 5000.04 * (1.0 - math.cos(math.atan(0.004)))  # of the circle, below the point of intersection
    middle = track.centre_line.position(np.array([0.5 * track.length]))[0, 2]
    assert middle == pytest.approx(top + 0.05, abs=1e-6)  # the low rail stays in the profile, the middle rises by half


def long_line(turn: Pivot) -> CivilLine:
    """Transitions of all forms between curves to both sides, cant about a point, parabolas and circles."""
    plan, cant, place, before = [Plan(40.0)], [Cant(0.0, 40.0, (0.0, 0.0), (0.0, 0.0))], 40.0, 0.0
    for form, after in zip(FORMS, (1 / 400, 1 / 900, -1 / 500, 0.0, 1 / 600, 0.0, 1 / 450), strict=True):
        height = 1.8 if form == "viennese" else None
        plan += [Plan(100.0, before, after, form, height), Plan(30.0, after, after)]
        rails = [RAILS[turn](30.0 * k) for k in (before, after)]
        cant += [Cant(place, 100.0, rails[0], rails[1], ramp_of(form)), Cant(place + 100.0, 30.0, rails[1], rails[1])]
        place, before = place + 130.0, after
    row = [(0.0, 200.0, 0.005, 0.005), (200.0, 80.0, 0.005, -0.006), (280.0, 120.0, -0.006, 0.002)]
    profile, height = [], 71.0
    for (start, length, *slopes), form in zip(row, ("parabola", "circle", "parabola"), strict=True):
        profile.append(Profile(start, length, *slopes, form, height))
        height = profile[-1].end_height
    rows = tuple(plan), tuple(profile), tuple(cant)
    return CivilLine("all 'forms' \\ ü", "", *rows, (3e5, 5e6, 0.7), 1.5, 1.435)


@pytest.mark.parametrize("turn", RAILS)
@pytest.mark.parametrize("ending", ["ifc", "xml"])
def test_a_file_gives_back_the_line_within_a_nanometre(tmp_path: Path, ending: str, turn: Pivot) -> None:
    line = long_line(turn)
    text = ifc_text(line, 1.5, "2026-11-29") if ending == "ifc" else landxml_text(line, 1.5, 1.435, "2026-11-29")
    again = read_alignment(written(tmp_path, ending, text))
    assert (again.name, again.cant_base) == (line.name, 1.5)
    assert again.origin == pytest.approx(line.origin, abs=1e-9)
    tracks = [Track.from_laws(each.laws(1.5)[0]) for each in (line, again)]
    s = np.linspace(0.0, tracks[0].length, 1500)
    places = [track.centre_line.position(s) for track in tracks]
    np.testing.assert_allclose(places[1], places[0], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(tracks[1].cant(s), tracks[0].cant(s), rtol=0.0, atol=1e-9)
    assert np.ptp(places[0][:, 2]) > 0.5 and np.ptp(tracks[0].cant(s)) > 0.1


@pytest.mark.parametrize("pivot", ["low rail", "high rail"])
def test_a_track_with_reverse_curves_in_a_vertical_curve_is_exported_exactly(tmp_path: Path, pivot: str) -> None:
    (tmp_path / "own.toml").write_text(TABLES["own"].replace("low rail", pivot))
    track = track_model(tmp_path / "own.toml")
    for ending in ("ifc", "xml"):
        answer = ok("track", tmp_path / "own.toml", "-o", tmp_path / f"own.{ending}").output
        assert "lengths and radii in plan" in answer
        again = track_model(tmp_path / f"own.{ending}")
        s = np.linspace(0.0, track.length, 500)
        away = again.centre_line.position(s) - track.centre_line.position(s)
        assert np.abs(away).max() < 1e-9
        np.testing.assert_allclose(again.cant(s), track.cant(s), rtol=0.0, atol=1e-9)
        refused = refusal("track", tmp_path / f"own.{ending}", "-o", tmp_path / f"own.{ending}")
        assert "would be written over" in refused


def test_cant_is_exported_on_a_profile_as_ifc_has_it(tmp_path: Path) -> None:
    # ISO 16739-1:2024, IfcAlignment: a layout is of plan, of plan and profile, or of plan, profile and cant
    level = replace(long_line("centre line"), profile=())
    text = ifc_text(level, 1.5, "2026-11-29")
    assert text.count("IFCALIGNMENTVERTICAL(") == text.count("IFCALIGNMENTCANT(") == 1
    assert "IFCALIGNMENTVERTICAL(" not in ifc_text(replace(level, cant=()), 1.5, "2026-11-29")
    again = Track.from_laws(read_alignment(written(tmp_path, "ifc", text)).laws(1.5)[0])
    assert np.ptp(again.centre_line.position(np.linspace(0.0, again.length, 100))[:, 2]) < 1e-9


def test_what_segments_do_not_fit_is_said_with_their_file(tmp_path: Path) -> None:
    track = tmp_path / "bend.toml"
    track.write_text(edited(TABLES["own"], 'form = "helmert"', 'form = "viennese"'))
    said = refusal("track", track)
    assert said.startswith(f"{track}:") and "track.segments: segment" in said and "centre_of_gravity_height_m" in said


def test_the_rounding_of_kinks_of_cant_is_said_and_is_no_more(tmp_path: Path) -> None:
    track, sharp = (track_model(written(tmp_path, "ifc")), read_alignment(written(tmp_path, "ifc")))
    raw, _ = alignment_laws(sharp.plan, sharp.cant_rows(), sharp.profile_rows(), 1.5, rounding=1e-6)
    s = np.linspace(0.0, 300.0, 30_001)
    away = np.abs(track.cant(s) - raw.cant(s))
    assert away.max() == pytest.approx(3.0 / 16.0 * 0.1 / 60.0, rel=1e-3)  # of the jump of the slope, over 1 m
    assert away[np.abs(s[:, None] - raw.cant.breaks).min(axis=1) > 1.001].max() < 1e-9
    assert "kinks rounded over 1 m to either side, by up to 0.31 mm" in track.assumptions


def test_a_file_that_is_neither_scenario_nor_track_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "other.toml").write_text('a = 1\nb = "x"\n[contact]\nfriction = 0.3\n')
    said = refusal("track", tmp_path / "other.toml")
    assert "has neither [track] nor analysis" in said and len(said.strip().splitlines()) == 1


@pytest.mark.parametrize(("kind", "old", "new", "metre"), TABLES["units"])
def test_units_of_length_scale_the_line(tmp_path: Path, kind: str, old: str, new: str, metre: float) -> None:
    """Only the straight of the file remains, where angles and cant say nothing."""
    text = TEXTS[kind].replace(old, new)
    assert text != TEXTS[kind]
    text = re.sub(r"(?s)<Spiral.*</Cant>", "</CoordGeom>", text)
    text = text.replace("(#31,#32,#33,#34,#35)", "(#31)").replace("(#11,#12,#13)", "(#11)")
    line = read_alignment(written(tmp_path, kind, text))
    assert line.length == pytest.approx(40.0 * metre, rel=1e-12)
    assert line.laws(1.5)[0].curvature.end == pytest.approx(line.length)


@pytest.mark.parametrize(("kind", "old", "new", "message"), TABLES["refusals"])
def test_what_is_no_track_is_refused_by_file_and_line(
    tmp_path: Path, kind: str, old: str, new: str, message: str
) -> None:
    assert old in TEXTS[kind]
    path = written(tmp_path, kind, TEXTS[kind].replace(old, new, 1))
    with pytest.raises(InputError) as refused:
        read_alignment(path).laws(1.5)
    assert message in str(refused.value) and str(refused.value).startswith(str(path))
    place = str(refused.value)[len(str(path)) :]
    assert re.match(r":\d+: ", place) or "FILE_SCHEMA" in place or "unit of length" in place


def test_an_entity_bomb_and_a_deep_file_are_refused(tmp_path: Path) -> None:
    entities = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 10}">' for i in range(1, 10))
    bomb = f'<!DOCTYPE x [<!ENTITY e0 "ha">{entities}]><LandXML>&e9;</LandXML>'
    for text, message in ((bomb, "DOCTYPE"), ("<a>" * 101, "in each other"), ("<LandXML>", "no whole XML")):
        with pytest.raises(InputError, match=message):
            read_alignment(written(tmp_path, "xml", text))
    deep = TEXTS["ifc"].replace("IFCRATIOMEASURE(-0.004)", "(" * 40 + ")" * 40)
    with pytest.raises(InputError, match="cannot be read"):
        read_alignment(written(tmp_path, "ifc", deep))


def test_the_number_of_entities_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ifc, "MOST_ENTITIES", 20)
    with pytest.raises(InputError, match="more than 20 entities"):
        read_alignment(written(tmp_path, "ifc"))


def test_one_of_several_alignments_is_chosen_by_its_name(tmp_path: Path) -> None:
    another = TEXTS["railml"].replace("<horizontalCurves>", TABLES["second_curve"])
    path = written(tmp_path, "railml", another)
    with pytest.raises(InputError, match='choose one by alignment_name: "ne2", "line"'):
        read_alignment(path)
    with pytest.raises(InputError, match="did you mean 'line'"):
        read_alignment(path, "lime")
    assert read_alignment(path, "ne2").length == 70.0


@pytest.mark.parametrize("kind", TEXTS)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, kind: str) -> None:
    chance, text = random.Random(61), TEXTS[kind]
    for _ in range(60):
        a, b = sorted(chance.randrange(len(text)) for _ in range(2))
        number = chance.choice(list(re.finditer(r"-?\d+\.?\d*", text)))
        value = chance.choice(["nan", "1e999", "-1", "0", "$", "#7", "", "'", "<", "1e-300"])
        damaged = chance.choice([
            text[:a], text[:a] + text[b:], text[:a] + chance.choice("#'(;<>&\"0-e") + text[a + 1 :],
            text[: number.start()] + value + text[number.end() :],
        ])  # fmt: skip
        try:
            law, _ = read_alignment(written(tmp_path, kind, damaged)).laws(1.5)
            assert np.isfinite(law.curvature.pieces.c).all() and np.isfinite(law.cant.pieces.c).all()
        except InputError as error:
            assert str(tmp_path) in str(error)


def test_an_unsymmetrical_parabola_of_equal_halves_is_a_parabola(tmp_path: Path) -> None:
    circle = 'CircCurve length="40.0" radius="5000.039999680003"'
    heights = []
    for i, curve in enumerate(('ParaCurve length="40"', 'UnsymParaCurve lengthIn="20" lengthOut="20"', "halves")):
        halves = 'UnsymParaCurve lengthIn="10" lengthOut="30"'
        text = TEXTS["landxml"].replace(circle, halves if curve == "halves" else curve)
        text = text.replace("</CircCurve>", f"</{'ParaCurve' if i == 0 else 'UnsymParaCurve'}>")
        law, _ = read_alignment(written(tmp_path, "landxml", text)).laws(1.5)
        heights.append(Track.from_laws(law).centre_line.position(np.linspace(0.0, 300.0, 401))[:, 2])
    np.testing.assert_allclose(heights[1], heights[0], rtol=0.0, atol=1e-9)
    # below the intersection by L1 L2 J / (2 (L1 + L2)): 40 mm in the middle of equal halves, 30 mm in unequal ones
    assert heights[2][200] - heights[0][200] == pytest.approx(0.010, abs=1e-5)


@pytest.mark.parametrize("text", ["/*" * 60_000, "'" * 60_001, "#1=A(" * 30_000, "#1=A('" * 30_000])
def test_text_that_never_ends_is_refused_in_one_pass(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError):
        read_alignment(written(tmp_path, "ifc", TEXTS["ifc"].replace("DATA;", "DATA;" + text)))


@pytest.mark.parametrize("kind", TEXTS)
def test_a_scenario_runs_on_a_civil_file_and_its_result_names_it(tmp_path: Path, kind: str) -> None:
    assert set(ENDINGS) >= {f".{kind}"}
    written(tmp_path, kind)
    scenario = wrsim.load_text(edited(STATIC, "[track]\n", f'[track]\nfile = "line.{kind}"\n'), tmp_path)
    setup = build(scenario)
    assert setup.track.length == pytest.approx(300.002, abs=1e-3)
    assert f"of line.{kind}, 300 m in plan" in str(setup.attributes()["alignment"])
    assert any(str(tmp_path) in str(file) for file in setup.files)


def test_a_gauge_that_contradicts_the_scenario_is_refused(tmp_path: Path) -> None:
    written(tmp_path, "landxml", TEXTS["landxml"].replace('gauge="1.435"', 'gauge="1.0"'))
    scenario = wrsim.load_text(edited(STATIC, "[track]\n", '[track]\nalignment = "line.landxml"\n'), tmp_path)
    with pytest.raises(InputError, match=r"its gauge is 1000 mm, track\.gauge_mm is 1435"):
        build(scenario)


def test_laws_do_not_depend_on_where_the_line_lies() -> None:
    line = long_line("centre line")
    moved = replace(line, origin=(0.0, 0.0, 0.0))
    first, second = line.laws(1.5)[0], moved.laws(1.5)[0]
    assert np.array_equal(first.curvature.pieces.c, second.curvature.pieces.c)


@pytest.mark.parametrize("ending", ["docx", "railml"])
def test_a_picture_or_a_file_of_another_kind_is_refused(tmp_path: Path, ending: str) -> None:
    said = refusal("track", MIXED_LINE, "-o", tmp_path / f"line.{ending}")
    assert f"line.{ending}: must end in .png" in said
    assert not list(tmp_path.iterdir())


def test_the_picture_names_each_grade_once_where_the_plan_has_joints_on_it() -> None:
    axes = Figure().subplots()
    height(axes, track_model(MIXED_LINE))
    assert [text.get_text() for text in axes.texts] == ["+2 ‰", "+12 ‰", "\N{MINUS SIGN}9 ‰", "+0 ‰"]
