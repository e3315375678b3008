"""Track from the recording car: what chords and inertial systems measured comes back, and the design with it."""

from contextlib import nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt
from support.commands import ok, refusal
from support.rows import rows_of
from support.runs import FAST, SCENARIOS

from wrsim import Arc, InputError, Straight, Track, Transition, load, run
from wrsim.inputs.toml_files import write_toml
from wrsim.recording import restoring
from wrsim.recording.columns import ChannelSection
from wrsim.recording.dropouts import bridged, codes, spikes
from wrsim.recording.names import guessed
from wrsim.recording.reading import recording_from
from wrsim.recording.restoring import Restored, restore
from wrsim.recording.scenario_file import track_file
from wrsim.recording.systems import BaseDifference, Chord, Inertial, InverseFilter, Plain, band_window, filtered
from wrsim.scenario.build import build
from wrsim.track.cant import Pivot
from wrsim.track.segments import Segment
from wrsim.track.spectra import Realisation

table = rows_of(__file__)

Array = NDArray[np.float64]

D1 = (3.0, 25.0)
BAND, AMPLIFICATION = (3.0, 70.0), 8.0
ENDS = 110.0  # [m]; so far the unknown beyond the ends of a record reaches into it
LINE: list[Segment] = [
    Straight(260.0), Transition(80.0), Arc(200.0, 600.0, 0.1, 0.005), Transition(90.0), Straight(120.0),
    Transition(70.0), Arc(180.0, -900.0, 0.06), Transition(100.0), Straight(260.0),
]  # fmt: skip
CAR_COLUMNS = ("curvature_per_km", "cant_mm", "gauge_mm")


@dataclass(frozen=True)
class Car:
    """Runs along a track with a row every ``step`` [m]; noise: standard deviation of each length that it measures
    [m]."""

    track: Track
    step: float = 0.25
    noise: float = 0.0
    margin: float = 30.0
    seed: int = 1

    @property
    def distance(self) -> Array:
        """Of the rows [m]: where every chord lies on the track."""
        return np.arange(self.margin, self.track.length - self.margin, self.step)

    def frames(self, side: str, s: Array) -> Array:
        """Points and axes (r, t, n, b) of a rail beside the centre line's distances s, (n, 4, 3)."""
        path = {"left": self.track.left, "right": self.track.right}[side]
        return path.frame(self.track.rail_distance(side, s))

    def versine(self, side: str, behind: float, ahead: float) -> tuple[Array, Array]:
        """How far the rail lies to the left of and above a chord that ends on it [m], in the axes of its
        cross-section."""
        s = self.distance
        middle, rear, front = (self.frames(side, s + x) for x in (0.0, -behind, ahead))
        along = front[:, 0] - rear[:, 0]
        along /= np.linalg.norm(along, axis=1)[:, None]
        off = middle[:, 0] - rear[:, 0]
        off -= np.sum(off * along, axis=1)[:, None] * along
        return np.sum(off * middle[:, 2], axis=1), np.sum(off * middle[:, 3], axis=1)

    def curvature(self, base: float) -> Array:
        """Of the circle through three points of the middle between the rails, ``base`` [m] from the first to the last,
        seen from above."""
        points = [
            0.5 * sum(self.frames(side, self.distance + x)[:, 0, :2] for side in ("left", "right"))
            for x in (-0.5 * base, 0.0, 0.5 * base)
        ]
        a, b, c = points[1] - points[0], points[2] - points[1], points[2] - points[0]
        cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        return 2.0 * cross / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1) * np.linalg.norm(c, axis=1))

    def cant(self) -> Array:
        """Height of the right rail above the left one, by both rails' points, over the cant base [m]."""
        track = self.track
        left, right = (self.frames(side, self.distance)[:, 0] for side in ("left", "right"))
        between = left - right
        wide = np.linalg.norm(between, axis=1)
        return -between[:, 2] / wide * track.cant_base

    def gauge(self) -> Array:
        """Between the gauge points [m]."""
        return self.track.gauge(self.distance)

    def write(self, path: Path, columns: dict[str, Array], digits: int = 6) -> Path:
        """A CSV of these columns, in mm but for distance_m and curvature_per_km; lengths with the car's noise."""
        random = np.random.default_rng(self.seed)
        rows = {"distance_m": self.distance}
        for name, values in columns.items():
            if name.startswith("curvature"):
                rows[name] = 1e3 * values
            else:
                rows[name] = 1e3 * (values + self.noise * random.standard_normal(values.size))
        text = [",".join(rows)] + [
            ",".join(f"{v:.{digits}f}" for v in row) for row in np.stack([*rows.values()], axis=1)
        ]
        path.write_text("\n".join(text) + "\n", encoding="utf-8")
        return path


def shipped_line() -> tuple[Car, dict[str, Array]]:
    """The car and the columns of ``scenarios/recorded/line.csv``: a left curve of 500 m, a chord of 4 + 6 m.

    Write it anew by ``car.write(path, columns, 2)``."""
    line = [Straight(180.0), Transition(60.0), Arc(140.0, 500.0, 0.11, 0.005), Transition(60.0), Straight(160.0)]
    uneven = Realisation("FRA-5", 4, 3.0, 60.0, 0.0, 600.0, 0.7, 20.0).disturbances()
    apart = (0.0325, 0.0)
    car = Car(Track.build(line, irregularities=uneven, left_offset=apart, right_offset=apart), 0.5, 30e-6)
    columns = {"curvature_per_km": car.curvature(20.0), "cant_mm": car.cant(), "gauge_mm": car.gauge()}
    for side in ("left", "right"):
        columns[f"alignment_{side}_mm"], columns[f"level_{side}_mm"] = car.versine(side, 4.0, 6.0)
    return car, columns


@cache
def line(spectrum: str = "ERRI-low", pivot: Pivot = "centre line") -> Track:
    """Curves of both hands and forms, with the spectrum's waves of 3 to 70 m; the rails' tops 1.5 m apart, where cant
    counts."""
    uneven = Realisation(spectrum, 7, 3.0, 70.0, 0.0, sum(s.length for s in LINE), 1.0, 20.0).disturbances()
    apart = (0.0325, 0.0)
    return Track.build(LINE, irregularities=uneven, left_offset=apart, right_offset=apart, pivot=pivot)


@cache
def geometry(car: Car) -> dict[str, Array]:
    return dict(zip(CAR_COLUMNS, (car.curvature(20.0), car.cant(), car.gauge()), strict=True))


@cache
def versines(car: Car, behind: float, ahead: float) -> dict[str, Array]:
    sides = {side: car.versine(side, behind, ahead) for side in ("left", "right")}
    return {f"{kind}_{side}_mm": sides[side][i] for i, kind in enumerate(("alignment", "level")) for side in sides}


def column_map(path: Path, names: list[str], system: str, head: str = "") -> Path:
    """A column map for columns that are called as what they are."""
    text = head
    for name in ["distance_m", *names]:
        quantity = name.removesuffix("_mm").removesuffix("_m").removesuffix("_per_km")
        text += f'[[channels]]\ncolumn = "{name}"\nquantity = "{quantity}"\n'
        text += {"curvature": "base_m = 20\n", "twist": 'unit = "mm"\n'}.get(quantity, "")
        text += f"{system}\n" if quantity.startswith(("alignment", "level")) else ""
    path.write_text(text, encoding="utf-8")
    return path


def restored(folder: Path, car: Car, columns: dict[str, Array], system: str, head: str = "") -> Restored:
    """What comes back of a car's columns; head: of the column map."""
    table = car.write(folder / "line.csv", columns)
    columns_file = column_map(folder / "line.toml", list(columns), system, head)
    return restore(recording_from(table, columns_file), BAND, AMPLIFICATION)


def in_band(values: Array, step: float, *, without: tuple[float, float] | None = None) -> Array:
    """The waves of 3 to 25 m alone; without: wavelengths that do not count either."""

    def response(k: Array) -> NDArray[np.complex128]:
        cut = 0.0 if without is None else band_window(k, without)
        return (band_window(k, D1) * (1.0 - cut)).astype(complex)

    return filtered(values, step, response, 40.0)


def errors(restored_track: Restored, car: Car, without: tuple[float, float] | None = None) -> float:
    """Largest error of both rails, laterally and vertically, in 3 to 25 m and off the ends [m]."""
    inner = slice(int(ENDS / car.step), -int(ENDS / car.step))
    largest = 0.0
    for i, side in enumerate(("left", "right")):
        for ours, true in zip(
            (restored_track.lateral[i], restored_track.vertical[i]),
            car.track.irregularity(side, car.distance),
            strict=True,
        ):
            off = in_band(ours - true, car.step, without=without)[inner]
            assert np.abs(in_band(true, car.step)[inner]).max() > 1e-3  # there is something to find
            largest = max(largest, float(np.abs(off).max()))
    return largest


@pytest.fixture(scope="module")
def car() -> Car:
    return Car(line())


@pytest.fixture(scope="module")
def by_chord(car: Car, tmp_path_factory: pytest.TempPathFactory) -> Restored:
    return restored(tmp_path_factory.mktemp("chord"), car, geometry(car) | versines(car, 4.0, 6.0), "chord_m = [4, 6]")


def test_a_track_measured_by_a_chord_comes_back_within_a_tenth_of_a_millimetre(by_chord: Restored, car: Car) -> None:
    assert errors(by_chord, car) < 0.1e-3


def test_level_is_freed_of_ramps_about_the_pivot_of_their_cant(tmp_path: Path) -> None:
    car = Car(line(pivot="low rail"))
    columns = geometry(car) | versines(car, 4.0, 6.0)
    restored_track = restored(tmp_path, car, columns, "chord_m = [4, 6]", 'pivot = "low rail"\n')
    assert errors(restored_track, car) < 0.2e-3  # the outer rail has the whole ramp, about the centre line half of it
    assert 'pivot = "low rail"' in track_file(restored_track, "2026-01-31")
    assert errors(restored(tmp_path, car, columns, "chord_m = [4, 6]"), car) > 0.8e-3


def test_on_rough_track_design_and_what_is_left_together_come_back(tmp_path: Path) -> None:
    # nobody can tell the form of a transition there; what the fit takes for the design it does not leave over
    car = Car(line("FRA-5"))
    restored_track = restored(tmp_path, car, geometry(car) | versines(car, 4.0, 6.0), "chord_m = [4, 6]")
    s, x, track = car.distance, restored_track.recording.distance, car.track
    inner = slice(int(ENDS / car.step), -int(ENDS / car.step))
    curve = np.cumsum(np.cumsum(restored_track.law.curvature(x) - track.curvature(s))) * car.step**2
    for i, (side, sign) in enumerate((("left", 1.0), ("right", -1.0))):
        lateral, vertical = track.irregularity(side, s)
        wider, higher = restored_track.law.widening(x) - track.widening(s), restored_track.law.cant(x) - track.cant(s)
        for off in (
            restored_track.lateral[i] - lateral + curve + 0.5 * sign * wider,
            restored_track.vertical[i] - vertical - 0.5 * sign * higher,
        ):
            assert np.abs(in_band(off, car.step)[inner]).max() < 0.1e-3


def test_a_symmetric_chord_loses_its_half_and_gives_back_the_rest(car: Car, tmp_path: Path) -> None:
    restored_track = restored(tmp_path, car, geometry(car) | versines(car, 5.0, 5.0), "chord_m = [5, 5]")
    kept = next(i.kept() for c, i in restored_track.inverses if c.quantity == "level_left")
    assert len(kept) == 2 and kept[0, 1] < 5.0 < kept[1, 0] and kept[1, 1] > 50.0
    lost = (kept[0, 1] / 1.25, kept[1, 0] * 1.25)
    # 3.0 to 3.7 and 6.8 to 25 m are left to compare
    assert errors(restored_track, car, without=(lost[0], lost[1])) < 0.1e-3
    assert errors(restored_track, car) > 0.1e-3


def test_an_inertial_record_comes_back_as_it_is_without_the_design(car: Car, tmp_path: Path) -> None:
    # the curves leave their own waves in the band, where transitions begin and end
    ways = ((D1[1], "highpass"), (D1[0], "lowpass"))
    sections = np.concatenate([butter(4, 1.0 / x, way, fs=1.0 / car.step, output="sos") for x, way in ways])
    s, track = car.distance, car.track

    def recorded(shape: Array) -> Array:
        return np.asarray(sosfiltfilt(sections, shape, padlen=s.size // 2))

    curve = np.cumsum(np.cumsum(track.curvature(s) * np.cos(track.left_curve.roll(s)[0]))) * car.step**2
    up = np.cumsum(np.cumsum(track.curvature(s) * np.sin(track.left_curve.roll(s)[0]))) * car.step**2
    columns = {}
    shapes = np.array([track.irregularity(side, s) for side in ("left", "right")])  # rails, lateral and vertical
    for (side, sign), (lateral, vertical) in zip((("left", 1.0), ("right", -1.0)), shapes, strict=True):
        columns[f"alignment_{side}_mm"] = recorded(curve + sign * 0.5 * track.widening(s) + lateral)
        columns[f"level_{side}_mm"] = recorded(up - sign * 0.5 * track.cant(s) + vertical)
    assert np.abs(recorded(curve)).max() > 0.15e-3
    restored_track = restored(tmp_path, car, geometry(car) | columns, 'band = "D1"')
    inner = slice(int(ENDS / car.step), -int(ENDS / car.step))
    # gauge and cant know all waves; what is common to the rails is known in the system's band
    known = shapes + np.apply_along_axis(recorded, -1, shapes.mean(axis=0)) - shapes.mean(axis=0)
    for ours, true in zip((restored_track.lateral, restored_track.vertical), known.swapaxes(0, 1), strict=True):
        for off in ours - true:
            assert np.abs(in_band(off, car.step)[inner]).max() < 0.1e-3


def assert_design(restored_track: Restored, line: list[Segment], car: Car, places: float) -> None:
    """The segments of a line; places: tolerance of where they begin [m]."""
    assert [type(s) for s in restored_track.segments] == [type(s) for s in line]
    true = np.cumsum([s.length for s in line])[:-1] - car.margin
    np.testing.assert_allclose(np.cumsum([s.length for s in restored_track.segments])[:-1], true, atol=places)
    for a, b in zip(restored_track.segments, line, strict=True):
        if isinstance(a, Arc) and isinstance(b, Arc):
            assert a.radius == pytest.approx(b.radius, rel=2e-3)
            assert a.cant == pytest.approx(b.cant, abs=0.3e-3)
            assert a.gauge_widening == pytest.approx(b.gauge_widening, abs=0.1e-3)
        if isinstance(a, Transition) and isinstance(b, Transition):
            assert a.form == b.form


def test_the_design_comes_back(by_chord: Restored, car: Car) -> None:
    assert_design(by_chord, LINE, car, 1.5)


def test_bloss_curves_are_known_on_even_track(tmp_path: Path) -> None:
    line = [Transition(s.length, "bloss") if isinstance(s, Transition) else s for s in LINE]
    car = Car(Track.build(line, left_offset=(0.0325, 0.0), right_offset=(0.0325, 0.0)))
    assert_design(restored(tmp_path, car, geometry(car), ""), line, car, 0.5)


def test_noise_is_enlarged_by_no_more_than_is_said(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    noise = random.standard_normal(40_000)
    chords = Chord(4.0, 6.0), Chord(5.0, 5.0), Chord(1.3, 8.7)
    for system in (*chords, BaseDifference(3.0), Inertial(3.0, 25.0), Plain()):
        inverse = InverseFilter(system, BAND, AMPLIFICATION)
        k = np.linspace(1e-4, np.pi / 0.25, 300_001)
        assert np.abs(inverse.response(k)).max() <= min(AMPLIFICATION, 1.001 * inverse.largest() + 1e-12) * 1.001
        made = filtered(noise, 0.25, inverse.response, 120.0)[2000:-2000]
        assert made.std() == pytest.approx(inverse.noise(0.25), rel=0.1)
        kept = inverse.kept()
        inside = 2.0 * np.pi / np.concatenate([np.linspace(low, high, 50) for low, high in np.minimum(kept, 1e4)])
        if not isinstance(system, Inertial):
            np.testing.assert_allclose(inverse.response(inside) * system.response(inside), 1.0, atol=1e-6)


@pytest.mark.parametrize("system", [Chord(4.0, 6.0), Chord(5.0, 5.0)])
def test_a_chord_sees_waves_and_circles_as_geometry_says(system: Chord) -> None:
    a, b = system.behind, system.ahead
    s = np.linspace(0.0, 50.0, 11)
    for length in (3.3, 10.0, 400.0):
        k = 2.0 * np.pi / length
        versine = np.sin(k * s) - (b * np.sin(k * (s - a)) + a * np.sin(k * (s + b))) / (a + b)
        h = complex(system.response(np.array([k]))[0])
        np.testing.assert_allclose(versine, (h * np.exp(1j * k * s)).imag, atol=1e-12)
    # versine of a circle, y'' > 0: a b / (2 R) on the other side
    assert system.of_curvature(np.array([0.0, 1e-9])) == pytest.approx(-0.5 * a * b)
    near = system.of_curvature(np.array([0.99e-4, 1.01e-4]))
    assert abs(near[1] - near[0]) < 1e-3


def test_an_inertial_system_halves_a_wave_at_its_borders_and_versines_tell_curves(car: Car, tmp_path: Path) -> None:
    """Fourth order, forward and back."""
    lengths = np.array([1.5, 3.0, 8.7, 25.0, 50.0])
    gain = Inertial(3.0, 25.0).response(2.0 * np.pi / lengths)
    assert np.abs(gain) == pytest.approx([1.0 / 257.0, 0.5, 1.0, 0.5, 1.0 / 257.0], rel=1e-3)
    assert gain.imag == pytest.approx(0.0)
    columns = {k: v for k, v in (geometry(car) | versines(car, 4.0, 6.0)).items() if not k.startswith("curvature")}
    restored_track = restored(tmp_path, car, columns, "chord_m = [4, 6]")
    assert any("no curvature was recorded: it is that of the versines" in note for note in restored_track.notes)
    radii = [s.radius for s in restored_track.segments if isinstance(s, Arc)]
    assert radii == pytest.approx([600.0, -900.0], rel=5e-3)


def test_alignment_freed_of_its_curves_is_known_for_what_it_is(by_chord: Restored, car: Car, tmp_path: Path) -> None:
    even = Car(Track.build(LINE, left_offset=(0.0325, 0.0), right_offset=(0.0325, 0.0)))
    columns = versines(car, 4.0, 6.0)
    bare = {k: v - versines(even, 4.0, 6.0)[k] if k.startswith("alignment") else v for k, v in columns.items()}
    restored_track = restored(tmp_path, car, geometry(car) | bare, "chord_m = [4, 6]")
    assert any("is freed of the curves" in note for note in restored_track.notes)
    inner = slice(int(ENDS / car.step), -int(ENDS / car.step))
    # both took off the same curve, but for what its fit is off
    for ours, theirs in zip(restored_track.lateral, by_chord.lateral, strict=True):
        assert np.abs(in_band(ours - theirs, car.step)[inner]).max() < 0.1e-3


def test_recordings_that_tell_no_track_are_refused(car: Car, tmp_path: Path) -> None:
    turned = {k: -v if k.startswith("alignment") else v for k, v in versines(car, 4.0, 6.0).items()}
    with pytest.raises(
        InputError, match=r"column 'alignment_left_mm' holds -1\.00 of the versine of its curves: the sign"
    ):
        restored(tmp_path, car, geometry(car) | turned, "chord_m = [4, 6]")
    columns = geometry(car) | {"cant_mm": -car.cant()}
    restored_track = restored(tmp_path, car, columns, "")
    assert any("the cant leans outward in 2 of 2 curves" in note for note in restored_track.notes)
    columns = geometry(car)
    bent = {k: 1e3 * v if k.startswith("curvature") else v for k, v in columns.items()}  # 1/m taken for 1/km
    with pytest.raises(
        InputError, match=r"line.csv: 0 to [\d.]+ m: no track's design follows from these rows: segment"
    ):
        restored(tmp_path, car, bent, "")
    (tmp_path / "line.csv").write_text(rows())
    read = recording_from(tmp_path / "line.csv", band="D1")
    with pytest.raises(InputError, match=r"is 99\.75 m long; must be two of the longest waves wanted, 70 m each"):
        restore(read, BAND, AMPLIFICATION)
    with pytest.raises(InputError, match=r"rows 0\.25 m apart resolve no waves shorter than 1 m"):
        restore(read, (0.5, 25.0), AMPLIFICATION)


def test_twist_alone_tells_the_cross_level(car: Car, tmp_path: Path) -> None:
    s = car.distance
    cross, back = (
        car.track.irregularity("right", place)[1] - car.track.irregularity("left", place)[1] for place in (s, s - 3.0)
    )
    columns = {"twist_mm": cross - back}
    restored_track = restored(tmp_path, car, columns, "")
    inner = slice(int(ENDS / car.step), -int(ENDS / car.step))
    ours = restored_track.vertical[1] - restored_track.vertical[0]
    # a base of 3 m loses waves of 3 m
    off = in_band(ours - cross, car.step, without=(2.4, 4.4))[inner]
    assert np.abs(in_band(cross, car.step)[inner]).max() > 1e-3 > 10.0 * np.abs(off).max()


TABLE = "s_km;gauge (mm);level_left (mm);note\n" + "".join(
    f"{i / 4000:.5f};1435,{i % 7};0,{i % 5};x\n" for i in range(900)
)


def test_names_tell_what_columns_are(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(TABLE.replace("s_km", "km"))
    read = recording_from(tmp_path / "a.csv", band="D1")
    assert [(c.column, c.quantity, c.unit) for c in read.columns.channels] == [
        ("km", "distance", "km"), ("gauge (mm)", "gauge", "mm"), ("level_left (mm)", "level_left", "mm"),
    ]  # fmt: skip
    assert read.guessed and read.unused == ("note",)
    assert read.step == pytest.approx(0.25) and read.of("gauge")[0][1][3] == pytest.approx(1.4353)


QUANTITIES = table("quantities")


@pytest.mark.parametrize(("language", "sign", "encoding", "names"), table("languages"))
def test_a_recording_is_read_in_its_language_and_what_is_left_out_is_a_warning(
    language: str, sign: str, encoding: str, names: list[str], tmp_path: Path
) -> None:
    number = [f"{i / 4000:.5f}" for i in range(900)]
    rows = [[s, "1435.5", "20", "0.5", "1", "2", "3", "4", "0.2", "80", "30"] for s in number]
    text = "\n".join(sign.join(row) for row in rows)
    text = sign.join(names) + "\n" + (text.replace(".", ",") if sign == ";" else text) + "\n"
    (tmp_path / "line.csv").write_bytes(text.encode(encoding))
    read = recording_from(tmp_path / "line.csv")
    assert [c.quantity for c in read.columns.channels] == QUANTITIES
    values = [float(read.of(quantity)[0][1][0]) for quantity in QUANTITIES[1:]]
    assert values == pytest.approx([1.4355, 0.02, 0.5e-3, 1e-3, 2e-3, 3e-3, 4e-3, 3.0 * 0.2e-3])
    assert read.step == pytest.approx(0.25) and read.of("twist")[0][0].base == 3.0
    assert read.unused == tuple(names[-2:])
    answer = ok("recording", str(tmp_path / "line.csv"), "-o", str(tmp_path / "out"), "--no-pictures")
    assert f"line.csv: warning: columns left out: {names[-2]}, {names[-1]}" in answer.stderr
    assert names[-1] not in answer.stdout


@pytest.mark.parametrize(("name", "quantity"), table("names_of_the_trade_are_known"))
def test_names_of_the_trade_are_known(name: str, quantity: str) -> None:
    channels = guessed([name], "line.csv:1", (4.0, 6.0), None)
    assert [channel["quantity"] for channel in channels] == [quantity] * bool(quantity)
    assert not channels or ChannelSection.model_validate(channels[0]).quantity == quantity


MAP = """[[channels]]
column = "distance_m"
quantity = "distance"
[[channels]]
column = "level_mm"
quantity = "level"
"""
HEAD = "distance_m,level_mm\n"
BY_BAND, BY_CHORD = 'band = "D1"', "chord_m = [4, 6]"


def rows(**changed: Any) -> str:
    """A table whose fifth row (line 6) is changed."""
    cells = [[f"{0.25 * i:g}", "0.1"] for i in range(400)]
    for key, value in changed.items():
        cells[4][{"distance": 0, "level": 1}[key]] = value
    return HEAD + "".join(",".join(c) + "\n" for c in cells)


def test_a_segment_that_no_scenario_takes_is_refused(car: Car, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The longest one that ``run`` takes, here of 60 m; the straights of the car's track are longer."""
    monkeypatch.setattr(restoring, "LONGEST", 60.0)
    with pytest.raises(InputError, match=r"a segment of 0\.\d+ km follows.*at most 0.06 km.*--from-m, --to-m"):
        restored(tmp_path, car, geometry(car) | versines(car, 5.0, 5.0), "chord_m = [5, 5]")


@pytest.mark.parametrize(("text", "more", "message"), table("bad_recordings_are_refused"))
def test_bad_recordings_are_refused(text: str, more: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(text)
    (tmp_path / "line.toml").write_text(MAP + more + "\n")
    with pytest.raises(InputError) as error:
        recording_from(tmp_path / "line.csv", tmp_path / "line.toml")
    assert message in str(error.value), str(error.value)


@pytest.mark.parametrize(("header", "message"), table("names_that_do_not_tell_are_refused"))
def test_names_that_do_not_tell_are_refused(header: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(rows().replace(HEAD.strip(), header))
    with pytest.raises(InputError) as error:
        recording_from(tmp_path / "line.csv")
    assert message in str(error.value), str(error.value)


@cache
def field_line() -> dict[str, Array]:
    """Columns of a line [SI]: straight, 80 m of ramp to R 700 with 80 mm of cant, 300 m of it, and back; rows every
    0.5 m, their distances from 12.31 km on; degrees, versines and twists by their definitions."""
    x = np.arange(0.0, 900.0, 0.5)

    def curved(distance: Array) -> Array:
        return np.interp(distance, [200.0, 280.0, 580.0, 660.0], [0.0, 1.0, 1.0, 0.0])

    s, cant = 12310.0 + x, 0.08 * curved(x)
    feet = s / 0.3048
    return {
        "s": s, "falling": s, "feet": feet, "kilometres": s // 1e3, "metres": s % 1e3, "miles": feet // 5280.0,
        "yards": feet % 5280.0 / 3.0, "curvature": curved(x) / 700.0, "cant": cant, "gauge": 1.435 + 1e-3 * np.sin(x),
        "degrees": np.degrees(2.0 * np.arcsin(50.0 * 0.3048 * curved(x) / 700.0)), "flat": 0.1 * np.sin(x),
        "versine": (62.0 * 0.3048) ** 2 / 8.0 * curved(x) / 700.0 / 0.0254,
        "twist": (cant - 0.08 * curved(x - 3.0)) / 3.0, "twist_back": (0.08 * curved(x + 3.0) - cant) / 3.0,
        "warp": (cant - 0.08 * curved(x - 31.0 * 0.3048)) / 0.0254,
    }  # fmt: skip


def field_table(head: str, sign: str, columns: list[str]) -> str:
    """A table of its columns, written as ``name = column * factor|unit``."""
    values = field_line()
    texts = {
        "station": [f"{int(v // 1e3)}+{v % 1e3:06.2f}" for v in values["s"]],
        "station_ft": [f"{int(v // 100.0)}+{v % 100.0:08.5f}" for v in values["feet"]],
    }
    names, units, cells = [], [], []
    for column in columns:
        name, _, rest = column.rpartition(" = ")
        formula, _, unit = rest.partition("|")
        numbers = texts.get(formula) or [f"{v:.6f}" for v in eval(formula, {}, values)]
        names.append(name)
        units.append(unit)
        cells.append(numbers)
    rows = [[*row] for row in zip(*cells, strict=True)]
    if "falling" in columns[0]:
        rows.reverse()
    lines = [*([names, units] if any(units) else [names]), *rows]
    return head + "\n".join(sign.join(line) for line in lines) + "\n"


@pytest.mark.parametrize(("name", "head", "sign", "encoding", "columns", "note"), table("layouts"))
def test_layouts_of_the_field_give_the_line(
    name: str, head: str, sign: str, encoding: str, columns: list[str], note: str, tmp_path: Path
) -> None:
    (tmp_path / "line.csv").write_bytes(field_table(head, sign, columns).encode(encoding))
    restored_track = restore(recording_from(tmp_path / "line.csv"), BAND, AMPLIFICATION)
    assert (
        restored_track.recording.start == pytest.approx(12310.0, abs=0.01) and restored_track.recording.length > 899.0
    )
    (arc,) = (s for s in restored_track.segments if isinstance(s, Arc))
    assert (arc.radius, arc.cant) == pytest.approx((700.0, 0.08), rel=4e-3)
    assert [s.length for s in restored_track.segments] == pytest.approx([200.0, 80.0, 300.0, 80.0, 240.0], abs=1.5)
    assert note in "\n".join(restored_track.notes), restored_track.notes


def test_a_map_without_units_takes_those_of_the_table(tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(field_table("", ",", ["a = feet|ft", "b = cant * 1e2|cm"]))
    (tmp_path / "line.toml").write_text(
        '[[channels]]\ncolumn = "a"\nquantity = "distance"\n[[channels]]\ncolumn = "b"\nquantity = "cant"\n'
    )
    read = recording_from(tmp_path / "line.csv", tmp_path / "line.toml")
    assert read.start == pytest.approx(12310.0) and read.of("cant")[0][1].max() == pytest.approx(0.08)


def test_vertical_and_horizontal_versines_are_level_and_alignment_and_a_missing_cant_is_told(tmp_path: Path) -> None:
    for name, quantity in table("planes"):
        assert [c["quantity"] for c in guessed([name], "x", (5.0, 5.0), None)] == [quantity] * bool(quantity), name
    text = field_table("", ",", ["Distance [m] = s", "Curvature [1/km] = curvature * 1e3", "Gauge [mm] = gauge * 1e3"])
    (tmp_path / "line.csv").write_text(text)
    restored_track = restore(recording_from(tmp_path / "line.csv"), BAND, AMPLIFICATION)
    assert "no cant was recorded, nor twist: the cant of the curves is unknown and laid as 0" in restored_track.notes


FIELD = ["Distance [m] = s", "Curvature [1/km] = curvature * 1e3", "Cant [mm] = cant * 1e3", "Level D1 [mm] = flat"]


def test_dropouts_and_spikes_are_bridged_or_split_the_recording_and_are_told(tmp_path: Path) -> None:
    lines = field_table("", ",", FIELD).splitlines()
    cells = [line.split(",") for line in lines]
    for row, column, text in (
        *((100 + i, 3, "-999") for i in range(5)), *((200 + i, 2, "#N/A") for i in range(3)), (300, 3, "60"),
        (301, 3, "62"), (570, 2, "0"), *((500, i, "") for i in (1, 2, 3)),
    ):  # fmt: skip
        cells[row][column] = text
    del cells[600:604]  # rows are missing
    (tmp_path / "line.csv").write_text("\n".join(",".join(row) for row in cells))
    read = recording_from(tmp_path / "line.csv")
    assert read.length == pytest.approx(899.5) and read.step == pytest.approx(0.5)
    true = field_line()
    assert np.abs(read.of("level")[0][1] - 1e-3 * true["flat"]).max() < 0.15e-3
    assert np.abs(read.of("cant")[0][1] - true["cant"]).max() < 0.2e-3
    notes = "\n".join(read.notes)
    assert 'spikes are bridged (spikes = "keep" leaves them): 12459.5 m (Level D1 [mm]), 12594.5 m (Cant [mm])' in notes
    assert "bridged: 12359.5 m (Level D1 [mm]), 12409.5 m (Cant [mm]), 12459.5 m (Level D1 [mm]), 12559.5 m" in notes
    (tmp_path / "line.toml").write_text(write_toml(read.columns.model_dump(exclude_none=True) | {"spikes": "keep"}))
    kept = recording_from(tmp_path / "line.csv", tmp_path / "line.toml").of("level")[0][1]
    assert kept[299] == pytest.approx(0.06)
    for row in range(700, 720):
        cells[row][3] = "-999.00"
    (tmp_path / "line.csv").write_text("\n".join(",".join(row) for row in cells))
    read = recording_from(tmp_path / "line.csv")
    assert "split the recording (12310 to 12661" in "\n".join(read.notes) and read.length == pytest.approx(538.0)


@pytest.mark.parametrize(("kind", "limit"), [("level", 8.25e-3), ("cant", 16.5e-3), ("curvature", 1.2e-3)])
def test_a_spike_is_what_no_rail_can_follow_and_the_largest_bridge_is_a_wave(kind: str, limit: float) -> None:
    # rows 0.5 m apart: a yielding rail with a dipped joint, 0.5 (0.026 l + 0.02) l; 4e-5 / m behind 6 m of smoothing
    record = 1e-6 * np.random.default_rng(2).standard_normal(400)
    record[100], record[200], record[300:303] = 1.1 * limit, 0.8 * limit, 40.0 * limit
    assert np.flatnonzero(spikes(record, 0.5, kind)).tolist() == [100, 300, 301, 302]
    gaps = np.where(np.isin(np.arange(400), [*range(50, 57), *range(150, 158)]), np.nan, record)
    assert np.flatnonzero(np.isnan(bridged(0.5 * np.arange(400), gaps, 3.0))).tolist() == [*range(150, 158)]
    assert not codes(np.array([999.0, 1000.0, 1001.0] * 20)).any() and codes(np.array([1.0, 2.0, -999.0])).sum() == 1


@pytest.mark.parametrize(("off", "refused"), [(0.045, False), (0.055, True)])
def test_a_gauge_is_refused_beyond_50_mm(off: float, refused: bool, tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(field_table("", ",", ["Distance [m] = s", f"Gauge [m] = gauge + {off}"]))
    with pytest.raises(InputError, match=r"gauge_mm = 1490\?") if refused else nullcontext():
        recording_from(tmp_path / "line.csv")


@pytest.mark.parametrize(("name", "median", "factor", "message"), table("no_gauge"))
def test_a_gauge_that_is_none_is_told_by_its_column_before_anything_is_written(
    name: str, median: float, factor: float, message: str, tmp_path: Path
) -> None:
    values = f"(gauge - 1.435 + {median}) * {factor}"
    (tmp_path / "line.csv").write_text(field_table("", ",", ["Distance [m] = s", f"{name} = {values}"]))
    answer = refusal("recording", str(tmp_path / "line.csv"), "-o", str(tmp_path / "out"))
    assert f"line.csv:1: column '{name}'" in answer and message in answer
    assert answer.count("\n") == 1 and not (tmp_path / "out").exists()


def test_the_shipped_recording_is_that_of_the_car(tmp_path: Path) -> None:
    car, columns = shipped_line()
    anew = np.loadtxt(car.write(tmp_path / "line.csv", columns, 2), delimiter=",", skiprows=1)
    np.testing.assert_allclose(np.loadtxt(SCENARIOS / "recorded/line.csv", delimiter=",", skiprows=1), anew, atol=0.011)


def test_one_command_leads_from_a_recording_to_a_run(car: Car, by_chord: Restored, tmp_path: Path) -> None:

    folder, out = by_chord.recording.path, tmp_path / "out"
    asked = ["recording", str(folder), "-o", str(out), "--vehicle", "vehicles/wheelset_s1002.toml", "--no-pictures"]
    ended = ok(*asked)
    assert "3 to 57.9" in ended.output and "R 600" in ended.output
    scenario = load(out / "scenario.toml")
    track = build(scenario).track
    s = np.arange(200.0, 1100.0, 0.5)
    true = car.track.irregularity("left", s + car.margin)[0]
    assert np.abs(in_band(track.irregularity("left", s)[0] - true, 0.5)[160:-160]).max() < 0.1e-3
    result = run(scenario.with_values(FAST | {"run.start_distance_m": 300.0, "run.distance_m": 2.0}))
    assert result.status == "completed"
    (out / "track.toml").write_text("mine")
    assert "would be written over" in refusal(*asked)
    assert (out / "track.toml").read_text() == "mine"
