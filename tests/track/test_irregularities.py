"""Grades, irregularities, spectra and measured tables: where the rails really lie."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from support import scenario_texts as texts
from support.rows import rows_of

from wrsim import Arc, InputError, Straight, Track, Transition, load, load_text, run
from wrsim.scenario.build import build
from wrsim.track.alignment import vertical_profile
from wrsim.track.irregularities import WEIGHTS, Bump, Disturbance, Polygon, Sampled
from wrsim.track.segments import Grade, Segment
from wrsim.track.spectra import CHINA_HIGH_SPEED, NAMES, SPECTRA, Realisation
from wrsim.track.table import TrackTable

table = rows_of(__file__)

OUT, UP = 0.043, 0.01
CURVE: tuple[Segment, ...] = (
    Straight(30.0), Transition(40.0), Arc(40.0, 300.0, 0.1, 0.01), Transition(40.0, "bloss"), Straight(30.0),
)  # fmt: skip
OFFSETS = {"left_offset": (OUT, UP), "right_offset": (OUT, UP)}


def offsets(track: Track, side: str, s: np.ndarray) -> np.ndarray:
    """Rail against the centre line in the axes of the cross-section: (n, 3) along t, n, b."""
    frame = track.centre.frame(s)
    rail = getattr(track, side).position(track.rail_distance(side, s))
    return np.einsum("nij,nj->ni", frame[:, 1:], rail - frame[:, 0])


def test_a_track_on_a_grade_climbs_by_its_sine_and_has_its_lengths_and_radii_in_plan() -> None:
    track = Track.build(CURVE, grades=[Grade(0.0, 0.04)], **OFFSETS)
    angle = math.atan(0.04)
    assert track.centre.position(np.array([100.0]))[0, 2] == pytest.approx(100.0 * math.sin(angle), abs=1e-9)
    assert track.centre.length == pytest.approx(sum(s.length for s in CURVE) / math.cos(angle), abs=1e-9)
    level, s = Track.build(CURVE), np.linspace(0.0, 180.0, 61)
    away = track.centre_line.position(s / math.cos(angle)) - level.centre_line.position(s)
    assert np.abs(away[:, :2]).max() < 1e-10
    assert [f.end * math.cos(angle) for f in track.features()] == pytest.approx([f.end for f in level.features()])
    assert track.heading(track.length) == pytest.approx(Track.build(CURVE).heading(track.length), rel=1e-15)
    assert track.grade(50.0) == pytest.approx(0.04, rel=1e-15)


def test_a_vertical_curve_is_a_circle_between_its_grades() -> None:
    radius, down, up = 2000.0, -0.01, 0.03
    track = Track.build([Straight(400.0)], grades=[Grade(0.0, down), Grade(200.0, up, radius)])
    half = radius * math.tan(0.5 * (math.atan(up) - math.atan(down)))  # the tangents meet at 200 m in plan
    ends = 200.0 / math.cos(math.atan(down)) - half + np.array([0.0, radius * (math.atan(up) - math.atan(down))])
    s = np.array([ends[0], ends.mean(), ends[1]])
    x, _, z = track.centre_line.position(s).T
    # all points of a sag curve lie one radius below its centre
    start = np.array([x[0] - radius * math.sin(math.atan(down)), z[0] + radius * math.cos(math.atan(down))])
    assert np.hypot(x - start[0], z - start[1]) == pytest.approx(radius, rel=1e-12)
    inside = track.centre.table[(track.centre.table[:, 0] > x[0] + 1.0) & (track.centre.table[:, 0] < x[2] - 1.0)]
    assert np.linalg.norm(inside[:, 8:11], axis=1) == pytest.approx(1.0 / radius, rel=1e-9)


@pytest.mark.parametrize("side, sign", [("left", 1.0), ("right", -1.0)])
def test_rail_rows_are_derivatives_of_a_canted_uneven_rail_in_a_climbing_curve(side: str, sign: float) -> None:
    """Against p = r + d n + h b differentiated numerically, everything together."""
    k = 2.0 * math.pi / 9.0
    s = np.linspace(0.0, 180.0, 1441)
    uneven = [
        Disturbance.of(Sampled.through(s, 5e-3 * np.sin(k * s), 20.0, 9.0), "alignment"),
        Disturbance.of(Sampled.through(s, 4e-3 * np.cos(k * s), 20.0, 9.0), "cross-level"),
    ]
    grades = [Grade(0.0, 0.02), Grade(90.0, -0.03, 1000.0)]
    track = Track.build(CURVE, grades=grades, irregularities=uneven, rounding=5.0, heading=1.0, **OFFSETS)

    def place(s: np.ndarray) -> np.ndarray:
        t = track.centre_line.tangent(s)
        left = np.cross([0.0, 0.0, 1.0], t)
        left /= np.linalg.norm(left, axis=1)[:, None]
        roll = track.left_curve.roll(s)[0][:, None]
        n, b = np.cos(roll) * left + np.sin(roll) * np.cross(t, left), None
        b = np.cross(t, n)
        lateral, vertical = track.irregularity(side, s)
        widening = track.left_curve.widening(s)
        d = sign * (0.5 * (1.435 + widening) + OUT) + lateral
        return track.centre_line.position(s) + d[:, None] * n + (UP + vertical)[:, None] * b

    path = getattr(track, side)
    s = getattr(track, f"{side}_curve").distance(np.arange(path.table.shape[0]) * path.step)
    # the difference quotients must not reach over places where the slope of curvature, cant or pitch jumps
    jumps = np.array([30, 35, 25, 70, 65, 75, 110, 105, 115, 150, 145, 155, 65.0, 115.0, 90 - 25, 90 + 25])
    smooth = (np.abs(s[:, None] - jumps).min(axis=1) > 0.3) & (s > 1.0) & (s < 179.0)
    e = 1e-3
    p0, p1, p2 = place(s[smooth] - e), place(s[smooth]), place(s[smooth] + e)
    first, second = (p2 - p0) / (2.0 * e), (p2 - 2.0 * p1 + p0) / e**2
    rate = np.linalg.norm(first, axis=1)[:, None]
    tangent = first / rate
    bend = (second - np.sum(second * tangent, axis=1)[:, None] * tangent) / rate**2
    table = path.table[smooth]
    assert np.abs(table[:, 0:3] - p1).max() < 1e-11
    assert np.abs(table[:, 3:6] - tangent).max() < 1e-8  # e^2 p''' / 6
    assert np.abs(table[:, 8:11] - bend).max() < 2e-5  # rounding: 1e-13 / e^2, and a spline's third derivative jumps
    # rows at even steps of the rail's own length
    rail_distance = track.rail_distance(side, s)
    assert rail_distance == pytest.approx(np.arange(len(rail_distance)) * path.step, abs=1e-9)


@pytest.mark.parametrize("grades, message", table("a_grade_that_cannot_be_is_named"))
def test_a_grade_that_cannot_be_is_named(grades: list[list[float]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        vertical_profile([Grade(*grade) for grade in grades], 180.0)


MCAT = """
[[track.irregularities]]
kind = "mcat"
from_m = 30
"""


def mcat(keys: str) -> Track:
    """A straight track of 200 m with deviations."""
    ahead, _, behind = texts.CURVE.partition("[[track.segments]]")
    behind = behind[behind.index("\n[", behind.rindex("[[track.segments]]")) :]
    straight = '[[track.segments]]\nkind = "straight"\nlength_m = 200\n'
    return build(load_text(ahead + straight + behind + MCAT + keys, ".")).track


@pytest.mark.parametrize("chord", [31, 62, 124])
@pytest.mark.parametrize(
    "deviation, offset",
    [
        ("alinement", lambda left, right: (left[:, 0] + right[:, 0]) / 2),
        ("gauge", lambda left, right: left[:, 0] - right[:, 0]),
        ("crosslevel", lambda left, right: right[:, 1] - left[:, 1]),
        ("surface", lambda left, right: -(left[:, 1] + right[:, 1]) / 2),
    ],
)
def test_the_mid_chord_offset_of_a_deviation_on_its_own_chord_is_its_amplitude(chord, deviation, offset) -> None:
    track = mcat(f'deviation = "{deviation}"\nchord_ft = {chord}\nwaves = 3\namplitude_mm = 12\n')
    length = chord * 0.3048
    middles = 30.0 + length * (np.arange(3) + 0.5)

    def deviation_at(s: np.ndarray) -> np.ndarray:
        return offset(*(np.column_stack(track.irregularity(side, s)) for side in ("left", "right")))

    ordinates = deviation_at(middles) - 0.5 * (
        deviation_at(middles - 0.5 * length) + deviation_at(middles + 0.5 * length)
    )
    assert ordinates == pytest.approx([0.012] * 3, abs=1e-9)
    assert deviation_at(np.array([29.9, 30.1 + 3 * length])) == pytest.approx([0.0, 0.0], abs=1e-4)


def test_a_combined_deviation_moves_one_rail_out_and_down() -> None:
    track = mcat(
        'deviation = "combined"\nchord_ft = 62\ntrack_class = 7\ncourse = "curved"\nsurface_mm = 9\n'
        'rail = "left"\nscale = 0.5\n'
    )
    middle = np.array([30.0 + 31 * 0.3048])
    assert np.ravel(track.irregularity("left", middle)) == pytest.approx([0.5 * 12.7e-3, -4.5e-3], abs=1e-9)
    assert np.ravel(track.irregularity("right", middle)) == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("keys, message", table("a_deviation_that_cannot_be_is_told_in_one_line"))
def test_a_deviation_that_cannot_be_is_told_in_one_line(keys: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        mcat(keys)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("channel, rail, left, right", table("every_channel_moves_the_rails_it_names"))
def test_every_channel_moves_the_rails_it_names(channel, rail, left, right) -> None:
    size = 8e-3
    bump = Disturbance.of(Bump(80.0, 20.0, size), channel, rail)
    plain, uneven = (Track.build(CURVE, irregularities=i, **OFFSETS) for i in ((), (bump,)))
    s = np.array([60.0, 90.0, 120.0])
    for side, weights in (("left", left), ("right", right)):
        moved = offsets(uneven, side, s) - offsets(plain, side, s)
        expected = np.outer([0.0, size, 0.0], (0.0, *weights))
        assert np.abs(moved - expected).max() < 1e-9  # the tables against the exact rail
    assert uneven.gauge(90.0) - plain.gauge(90.0) == pytest.approx(size * (left[0] - right[0]), abs=1e-15)
    assert uneven.irregularity("right", 90.0)[1] - uneven.irregularity("left", 90.0)[1] == pytest.approx(
        size * (right[1] - left[1]), abs=1e-15
    )
    assert uneven.is_uneven and not plain.is_uneven


@pytest.mark.parametrize(
    "shape",
    [
        Bump(10.0, 8.0, 5e-3),
        Polygon.through([0.0, 10.0, 14.0, 18.0, 30.0], [0.0, 0.0, 5e-3, 0.0, 0.0], 1.0),
        Sampled.through(np.linspace(0.0, 30.0, 61), np.sin(np.linspace(0.0, 6.0, 61)), 5.0, 4.0),
    ],
    ids=["bump", "kink", "spline"],
)
def test_slope_and_curvature_of_a_shape_are_its_derivatives(shape) -> None:
    s = np.linspace(0.7, 29.3, 777)
    e = 1e-5
    jumps = shape.breaks() if not isinstance(shape, Sampled) else np.linspace(0.0, 30.0, 61)
    s = s[np.abs(s[:, None] - jumps).min(axis=1) > 2.0 * e]
    value, slope, bend = shape.jet(s)
    low, high = shape.jet(s - e), shape.jet(s + e)
    assert (high[0] - low[0]) / (2.0 * e) == pytest.approx(slope, abs=1e-8)
    assert (high[1] - low[1]) / (2.0 * e) == pytest.approx(bend, abs=1e-7)
    assert np.abs(value).max() > 4e-3
    for order in range(3):
        assert np.array_equal(shape.jet(s, order)[: order + 1], (value, slope, bend)[: order + 1])


@pytest.fixture(scope="module")
def long_track() -> Track:
    """10 km on ERRI B176 high, waves of 1 to 100 m."""
    drawn = Realisation("ERRI-high", 7, 1.0, 100.0, 0.0, 10_000.0).disturbances()
    return Track.build([Straight(10_000.0)], irregularities=drawn)


def third_octaves(values: np.ndarray, step: float, shortest: float, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Wave numbers (n + 1,) that part the band into third octaves, and the variance in each (n,)."""
    count = int(3.0 * math.log2(longest / shortest))
    edges = 2.0 * math.pi / longest * 2.0 ** (np.arange(count + 1) / 3.0)
    lines = np.abs(np.fft.rfft(values)) ** 2 * 2.0 / values.size**2
    numbers = 2.0 * math.pi * np.fft.rfftfreq(values.size, step)
    return edges, np.array([lines[(numbers >= a) & (numbers < b)].sum() for a, b in pairwise(edges)])


def test_third_octaves_of_the_rails_hold_the_spectrum_within_1_db(long_track: Track) -> None:
    step = 0.125
    s = np.arange(0.0, 10_000.0, step)
    # from where the rails lie, not from what was drawn
    left, right = offsets(long_track, "left", s), offsets(long_track, "right", s)
    measured = {
        "alignment": 0.5 * (left[:, 1] + right[:, 1]),
        "level": 0.5 * (left[:, 2] + right[:, 2]),
        "cross-level": right[:, 2] - left[:, 2],
    }
    for channel, rail_rows in measured.items():
        edges, densities = third_octaves(rail_rows, step, 1.25, 100.0)
        bands = [np.linspace(a, b, 201) for a, b in pairwise(edges)]
        wanted = np.array([np.trapezoid(SPECTRA["ERRI-high"].densities[channel](w), w) for w in bands])
        assert np.abs(10.0 * np.log10(densities / wanted)).max() < 1.0, channel
    gauge = left[:, 1] - right[:, 1]
    assert np.abs(gauge - gauge[0]).max() < 1e-8  # B176 has none; what is left are the rows


@pytest.mark.parametrize("name", SPECTRA)
def test_a_line_of_one_period_has_the_rms_of_the_density_over_its_band(name: str) -> None:
    """4096 samples are 16 of the longest waves: the sum of the lines then has exactly their variance."""
    line = Realisation(name, 3, 2.0, 64.0, 0.0, 4095.0 / 4.0, fade=1e-3)
    drawn = {each.weights: each.shape for each in line.disturbances()}
    assert len(drawn) == len(SPECTRA[name].densities)
    s, edges = np.arange(4096) / 4.0, (2.0 * math.pi / 64.0, math.pi)
    for channel, density in SPECTRA[name].densities.items():
        values = drawn[WEIGHTS[channel]].jet(s)[0]
        jumps = [2.0 * math.pi * f for rows in CHINA_HIGH_SPEED.values() for f in rows[0]]  # only China-HSR has them
        within = sorted(w for w in jumps if edges[0] < w < edges[1])
        integral = math.sqrt(quad(lambda w, of=density: float(of(np.array(w))), *edges, points=within, limit=200)[0])
        # 1e-3: quadrature of a line within which the density jumps, and the two samples that fade out
        assert np.sqrt(np.mean(values**2)) == pytest.approx(integral, rel=2e-3), channel
        assert SPECTRA[name].rms(channel, (2.0, 64.0)) == pytest.approx(integral, rel=1e-3)


def test_published_points_of_spectra_and_their_units() -> None:
    """SNCF: A at n = 0 (Berawi, thesis, Porto, over 1/m); TB/T 3352: 0.458 mm2/(1/m) at f = 0.1 per m, level;
    German gauge and cross-level have one shape; names of other authors are understood."""
    w = 2.0 * math.pi * np.array([1e-9, 0.1])
    assert SPECTRA["SNCF-good"].densities["level"](w)[0] == pytest.approx(0.509 * 308e-6 / (2.0 * math.pi), rel=1e-6)
    level = SPECTRA["China-HSR"].densities["level"](w)[1]
    assert level * 2.0 * math.pi * 1e6 == pytest.approx(1.9784e-2 / 0.1**1.3643, rel=1e-12)
    german = SPECTRA["German-low"].densities
    assert german["cross-level"](w) / german["gauge"](w) == pytest.approx(4.0 * 4.032 / 0.532, rel=1e-4)
    assert {name: NAMES.understood(name) for name in ("AAR-5", "tb/t 3352", "ERRI B176 low", "fra 6")} == {
        "AAR-5": "FRA-5", "tb/t 3352": "China-HSR", "ERRI B176 low": "ERRI-low", "fra 6": "FRA-6",
    }  # fmt: skip


def test_the_same_seed_gives_the_same_track_to_the_bit_and_another_seed_another(long_track: Track) -> None:
    def track(seed: int) -> Track:
        drawn = Realisation("FRA-4", seed, 3.0, 60.0, 0.0, 300.0).disturbances()
        return Track.build(CURVE, irregularities=drawn)

    drawn_first, drawn_again, other_seed = track(3), track(3), track(4)
    for side in ("left", "right"):
        assert getattr(drawn_first, side).table.tobytes() == getattr(drawn_again, side).table.tobytes()
        assert (
            np.abs(getattr(drawn_first, side).table[100:200, 2] - getattr(other_seed, side).table[100:200, 2]).max()
            > 1e-4
        )


def test_irregularities_begin_gently_and_are_rougher_the_lower_their_class() -> None:
    drawn = Realisation("FRA-1", 1, 3.0, 60.0, 50.0, 150.0, fade=20.0).disturbances()
    track = Track.build(CURVE, irregularities=drawn)
    s = np.array([0.0, 49.9, 50.01, 149.99, 150.1, 180.0])
    assert np.abs(track.irregularity("left", s)).max() < 1e-9
    assert np.abs(track.irregularity("left", np.linspace(70.0, 130.0, 50))).max() > 1e-3
    w = 2.0 * math.pi / np.array([20.0])
    for channel in ("alignment", "level"):
        densities = [SPECTRA[f"FRA-{i}"].densities[channel](w)[0] for i in range(1, 7)]
        assert (np.diff(densities) < 0.0).all()


def test_rows_too_coarse_for_the_waves_and_bands_finer_than_the_table_are_refused(tmp_path: Path) -> None:
    drawn = Realisation("ERRI-low", 1, 1.0, 60.0, 0.0, 180.0).disturbances()
    with pytest.raises(InputError, match=r"row_distance_m = 0\.5 is too coarse .* need 0\.25"):
        Track.build(CURVE, irregularities=drawn, step=0.5)
    s = np.arange(0.0, 100.0, 1.0)
    file = write_table(tmp_path / "t.csv", {"distance_m": s, "level_mm": np.sin(s / 5.0)})
    with pytest.raises(InputError, match="rows are up to 1 m apart and resolve no waves shorter than 2 m"):
        TrackTable.read(file).disturbances(0.0, 10.0, band=(1.0, 50.0))
    with pytest.raises(InputError, match="has no geometry"):
        TrackTable.read(file).laws(1.435)


def write_table(path: Path, columns: dict[str, np.ndarray]) -> Path:
    rows = np.column_stack(list(columns.values()))
    path.write_text(
        ",".join(columns) + "\n" + "\n".join(",".join(f"{v:.9g}" for v in row) for row in rows) + "\n", encoding="utf-8"
    )
    return path


def test_a_track_laid_from_its_own_measurement_is_the_same_track(tmp_path: Path) -> None:
    drawn = Realisation("ERRI-low", 5, 4.0, 60.0, 0.0, 180.0).disturbances()
    track = Track.build(CURVE, grades=[Grade(0.0, 0.01)], irregularities=drawn, **OFFSETS)
    s = np.linspace(0.0, 180.0, 721)
    lateral, vertical = zip(*(track.irregularity(side, s) for side in ("left", "right")), strict=True)
    table = TrackTable.read(
        write_table(
            tmp_path / "t.csv",
            {
                "distance_m": 4711.0 + s,
                "curvature_per_km": 1e3 * track.curvature(s),
                "cant_mm": 1e3 * track.cant(s),
                "gauge_mm": 1e3 * (1.435 + track.left_curve.widening(s)),
                "grade_permille": 1e3 * track.grade(s),
                "left_lateral_mm": 1e3 * lateral[0],
                "right_lateral_mm": 1e3 * lateral[1],
                "left_vertical_mm": 1e3 * vertical[0],
                "right_vertical_mm": 1e3 * vertical[1],
            },
        )
    )
    again = Track.from_laws(table.laws(1.435), 1.435, irregularities=table.disturbances(0.0, 1e-3), **OFFSETS)
    places = np.linspace(1.0, 179.0, 400)
    for side in ("left", "right"):
        design_frame = getattr(track, side).frame(track.rail_distance(side, places))
        table_frame = getattr(again, side).frame(again.rail_distance(side, places))
        # curvature of the Bloss ramp is taken as straight over 0.25 m: 3e-7 1/m, over 40 m twice integrated
        assert np.abs(design_frame[:, 0] - table_frame[:, 0]).max() < 2e-4
        assert np.abs(design_frame[:, 1:] - table_frame[:, 1:]).max() < 1e-4
        assert np.abs(offsets(track, side, places) - offsets(again, side, places)).max() < 5e-6


def test_a_table_is_filtered_to_the_band_asked_for(tmp_path: Path) -> None:
    s = np.arange(0.0, 1000.0, 0.25)
    short, middle, long = (np.sin(2.0 * math.pi * s / wave) for wave in (1.5, 12.0, 200.0))
    file = write_table(tmp_path / "t.csv", {"distance_m": s, "level_mm": 3.0 * short + 2.0 * middle + 10.0 * long})
    (level,) = TrackTable.read(file).disturbances(0.0, 20.0, band=(3.0, 70.0))
    inner = slice(800, -800)
    # half a percent of the waves outside gets through, the ones inside stay
    assert np.abs(1e3 * level.shape.jet(s)[0] - 2.0 * middle)[inner].max() < 0.1


@pytest.mark.parametrize("text, message", table("a_faulty_table_is_told_with_its_line"))
def test_a_faulty_table_is_told_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "t.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        TrackTable.read(file)


SCENARIO = "\n" + texts.CURVE.partition("kind")[0].replace("= 54", "= 72") + 'kind = "straight"\nlength_m = 200\n'
"""Straight track, on which a wheelset runs at 20 m/s."""


def told(tmp_path: Path, text: str) -> str:
    """What a scenario with this text is refused with."""
    file = tmp_path / "s.toml"
    file.write_text(SCENARIO + text)
    with pytest.raises(InputError) as error:
        build(load(file))
    return str(error.value)


def test_defects_and_grades_of_a_file_lie_on_its_track() -> None:
    uneven = [
        {"kind": "dip", "rail": "left", "at_m": 50, "length_m": 4, "amplitude_mm": 5},
        {"kind": "alignment", "at_m": 80, "length_m": 10, "amplitude_mm": 3, "shape": "kink"},
        {"kind": "twist", "at_m": 120, "length_m": 6, "amplitude_mm": 4, "shape": "ramp"},
        {"kind": "gauge", "at_m": 100, "length_m": 10, "amplitude_mm": 6},
    ]
    keys = {"track.grades": [{"from_m": 0, "grade_permille": 10}], "track.irregularities": uneven}
    track = build(load_text(SCENARIO).with_values(keys)).track
    assert track.grade(70.0) == pytest.approx(0.01)
    assert track.irregularity("left", 50.0)[1] == pytest.approx(-5e-3)
    assert track.irregularity("right", 50.0)[1] == 0.0
    # a kink is rounded by 3/16 of its change of slope, 2 * 3 mm / 5 m, over 1 m
    assert track.irregularity("right", 80.0)[0] == pytest.approx(3e-3 - 3.0 / 16.0 * 2.0 * 3e-3 / 5.0, rel=1e-9)
    left, right = (track.irregularity(side, np.array([110.0, 130.0, 199.0]))[1] for side in ("left", "right"))
    assert right - left == pytest.approx([0.0, 4e-3, 4e-3])
    assert track.gauge(100.0) == pytest.approx(1.441)


def test_a_track_file_lies_beneath_the_keys_of_the_scenario(tmp_path: Path) -> None:
    lines = SCENARIO.split("[track]")
    (tmp_path / "line.toml").write_text('name = "l"\nsource = "s"\ndate = 2026-01-01\n[track]' + lines[1])
    file = tmp_path / "s.toml"
    file.write_text(lines[0] + '[track]\nfile = "line.toml"\ninclination = "1:20"\n')
    scenario = load(file)
    assert scenario.spec.track.gauge_mm == 1435.0 and scenario.spec.track.inclination == 0.05
    # the text that a result carries is whole
    assert build(load_text(scenario.text)).track.length == 200.0
    (tmp_path / "line.toml").write_text('name = "l"\nsource = "s"\ndate = 2026-01-01\n[track]\ngauge_mn = 1435\n')
    with pytest.raises(InputError, match=r"line\.toml:5: track\.gauge_mn = 1435: unknown key; did you mean 'gauge_mm'"):
        load(file)
    file.write_text(lines[0] + '[track]\nfile = "lime.toml"\n')
    with pytest.raises(
        InputError, match=r's\.toml:8: track\.file = "lime\.toml": not found .* did you mean "line\.toml"'
    ):
        load(file)


def test_a_track_file_lies_over_the_line_of_a_base_and_of_what_it_is_set_in(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text(SCENARIO + "[[track.grades]]\nfrom_m = 150\ngrade_permille = 3\n")
    bend = '[track]\n[[track.segments]]\nkind = "straight"\nlength_m = 250\n'
    (tmp_path / "bend.toml").write_text('name = "l"\nsource = "s"\ndate = 2026-01-01\n' + bend)
    child = tmp_path / "child.toml"
    child.write_text('base = "base.toml"\n[track]\nfile = "bend.toml"\ninclination = "1:20"\n')
    for of_bend in (
        load(child),
        load(tmp_path / "base.toml").with_set(["track.inclination=1:20", "track.file=bend.toml"]),
        load(tmp_path / "base.toml").with_values({"track.inclination": "1:20", "track.file": "bend.toml"}),
    ):
        track = of_bend.spec.track
        assert track.segments[0].length_m == 250.0 and not track.grades
        assert track.inclination == 0.05 and track.gauge_mm == 1435.0
        assert load_text(of_bend.text).spec.track == track
    longer = load(child).with_values({"track.segments[0].length_m": 260.0, "track.file": "bend.toml"})
    assert longer.spec.track.segments[0].length_m == 260.0
    with pytest.raises(InputError, match=r'track\.file = "bent\.toml": not found .* did you mean "bend\.toml"'):
        load(child).with_set(["track.file=bent.toml"])


UNEVEN, GRADE = "[[track.irregularities]]\nkind = ", "[[track.grades]]\nfrom_m = 9\ngrade_permille = 3\n"


@pytest.mark.parametrize("text, message", table("a_fault_in_a_track_is_told_where_it_stands"))
def test_a_fault_in_a_track_is_told_where_it_stands(tmp_path: Path, text: str, message: str) -> None:
    assert message in told(tmp_path, text)


def test_a_wheelset_follows_a_dip_and_tells_where_its_rails_were() -> None:
    defect = '[[track.irregularities]]\nkind = "dip"\nat_m = 40\nlength_m = 20\namplitude_mm = 6\n'
    text = SCENARIO + defect + "[run]\nstart_distance_m = 29\ndistance_m = 13\n"
    dataset = run(load_text(text)).wheelset()
    distance = dataset["distance"].values
    fallen = dataset["rail_vertical"].values
    dip = np.where(np.abs(distance - 40.0) < 10.0, -3e-3 * (1.0 + np.cos(0.1 * math.pi * (distance - 40.0))), 0.0)
    assert fallen == pytest.approx(np.column_stack([dip, dip]), abs=1e-12)
    # the wheels stay on the rails: contact springs give some 10 um, the slope of the rails less
    sunk = dataset["vertical_shift"].values - dataset["vertical_shift"].values[0]
    assert np.abs(sunk - dip).max() < 30e-6
    contact = dataset["z_contact"].values[:, :, 0]
    assert contact - contact[0] == pytest.approx(fallen, abs=30e-6)
    # in the trough the wheelset's own mass is thrown up by V^2 z'': 1813 kg 400 m2/s2 3e-3 (pi/10)^2 / m
    load = dataset["Q"].values.sum(axis=1)
    expected = 1813.0 * 400.0 * 3e-3 * (0.1 * math.pi) ** 2
    assert load[np.argmin(np.abs(distance - 40.0))] - load[0] == pytest.approx(expected, rel=0.05)


LINE = """
title = "a long line"
analysis = "curving"
[vehicle]
model = "vehicles/manchester_1.toml"
speed_kmh = 100
[track]
gauge_mm = 1435
rail = "rails/60E1.toml"
inclination = "1:40"
[[track.segments]]
kind = "straight"
length_m = 3000
[[track.irregularities]]
kind = "spectrum"
spectrum = "ERRI-low"
seed = 1
[run]
"""


def test_a_run_has_the_track_that_it_passes_alone_and_the_same_numbers_there() -> None:
    """Tables end 100 to 200 m beyond the front of the vehicle; their rows are those of the whole track."""
    short = build(load_text(LINE + "distance_m = 50")).track
    whole = replace(short, reach=np.inf)
    rows = short.left.table.shape[0]
    assert short.left.step == whole.left.step and 200.0 < rows * short.left.step < 205.0
    assert np.abs(short.left.table - whole.left.table[:rows]).max() < 1e-12
    assert np.abs(short.centre.table - whole.centre.table[: short.centre.table.shape[0]]).max() == 0.0


def test_a_run_that_starts_within_irregularities_starts_on_even_track() -> None:
    """They fade in over the vehicle's length ahead of its first axle; beyond that they are those of the track."""
    setup = build(load_text(LINE + "start_distance_m = 500\ndistance_m = 50"))
    front = 500.0 + max(mounted.x for mounted in setup.vehicle.wheelsets)
    faded, plain = setup.track.left_curve.irregularity, build(load_text(LINE + "distance_m = 600")).track
    before, behind = np.linspace(480.0, front, 50), np.linspace(front + 30.0, 560.0, 50)
    assert not any(np.abs(part(before)).max() for part in (faded.lateral, faded.vertical))
    assert np.array(faded.vertical(behind)) == pytest.approx(np.array(plain.left_curve.irregularity.vertical(behind)))
    s, h = np.linspace(front + 1.0, front + 18.0, 40), 1e-4
    value, slope, bend = faded.lateral(s)
    (late, rate, _), (early, before_rate, _) = faded.lateral(s + h), faded.lateral(s - h)
    assert (late - early) / (2.0 * h) == pytest.approx(slope, abs=1e-8) and np.ptp(value) > 1e-4
    assert (rate - before_rate) / (2.0 * h) == pytest.approx(bend, abs=1e-7)
    note = str(setup.attributes()["irregularities"])
    assert f"from {front:g} m on" in note and "ERRI-low" in note and "not in this spectrum: gauge" in note
    assert "fade in" not in build(load_text(LINE.replace("seed = 1", "seed = 1\nfrom_m = 11"))).irregularities
