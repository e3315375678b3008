"""[[track.irregularities]] and [[track.grades]]: where rails leave their designed place, how the line climbs."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from annotated_types import Predicate
from pydantic import Field

from wrsim.errors import InputError
from wrsim.inputs.section import Choice, Fault, Section, given
from wrsim.inputs.us_units import FOOT
from wrsim.inputs.values import List, Two, fields, number, positive, requirement, text
from wrsim.results.channels import table
from wrsim.track.irregularities import CHANNELS, Bump, Channel, Disturbance, Polygon, Rail, Shape
from wrsim.track.spectra import NAMES, Realisation
from wrsim.track.table import TrackTable
from wrsim.track.track import ROUNDING

Place = Annotated[float, number(0, 1e6, "m along the centre line")]
Band = Annotated[
    Two[Annotated[float, number(0.1, 1000, "m")]],
    Field(description="two rising wavelengths in m from 0.1 to 1000, such as [3, 70]"),
    Predicate(lambda band: band[0] < band[1]),
]
Channels = Annotated[List[Channel], Field(min_length=1), Predicate(lambda names: len(set(names)) == len(names))]


class GradeSection(Section, header="[[track.grades]]"):
    """From a distance on the track climbs or falls; a vertical curve leads over from the grade before."""

    from_m: Place
    """Where the grade begins, in plan; the tangents of the vertical curve meet there."""
    grade_permille: Annotated[float, number(-150, 150, "positive: uphill")]
    """Slope of the line from there on; positive climbs."""
    vertical_radius_m: Annotated[float, number(200, 1e7, "m, of the vertical curve at the change")] = 10_000.0
    """Radius of the vertical curve that leads over from the grade before."""


class IrregularityTable(Choice, header="[[track.irregularities]]"):
    """Where rails leave their designed place."""

    kind: str
    """Kind of irregularity."""

    def disturbances(self, length: float, file: Path) -> tuple[Disturbance, ...]:
        """On a track of this length [m]; file: that of a table. Raises InputError where it leaves the track."""
        raise NotImplementedError

    def label(self) -> str:
        """What a number in it assumes; empty where its keys say all."""
        return ""


class _Stretch(IrregularityTable):
    """Irregularities over a stretch of the track."""

    from_m: Place = 0.0
    """Where on the track they begin."""
    scale: Annotated[float, positive(100, "factor on all amplitudes")] = 1.0
    """Factor on all amplitudes."""
    fade_m: Annotated[float, number(0.01, 1000, "m over which they begin and end")] = 20.0
    """Length over which they begin and end smoothly."""


class SpectrumSection(_Stretch, kind="spectrum"):
    """Irregularities drawn from a spectrum."""

    spectrum: NAMES.key()  # type: ignore[valid-type]
    """Whose density, of which quality of track; docs/reference/spectra.md has them."""
    seed: Annotated[int, number(0, 2**31 - 1)]
    """Number that decides which of all tracks with this spectrum is drawn; the same seed gives the same track."""
    wavelength_m: Band = (3.0, 100.0)
    """Shortest and longest wave that are drawn."""
    channels: Channels = CHANNELS
    """Which of alignment, level, cross-level and gauge are drawn."""
    to_m: Place | None = None
    """Where they end; the end of the track unless given."""

    def disturbances(self, length: float, file: Path) -> tuple[Disturbance, ...]:
        end = _room(self.from_m, length if self.to_m is None else self.to_m, length, "to_m")
        long = self.wavelength_m[1]
        if end - self.from_m < long:
            room = f"from {self.from_m:g} to {end:g} m there is no room"
            raise InputError(f"{room} for the longest wavelength, {long:g} m (wavelength_m)")
        return self._drawn(end).disturbances()

    def label(self) -> str:
        return self._drawn(self.from_m).label()

    def _drawn(self, end: float) -> Realisation:
        short, long = self.wavelength_m
        return Realisation(
            self.spectrum, self.seed, short, long, self.from_m, end, self.scale, self.fade_m, self.channels
        )


class TableSection(_Stretch, kind="table"):
    """Measured irregularities from a CSV table."""

    file: Annotated[str, text('a CSV file such as "measured.csv"')]
    """Table of the measurement; docs/user/track.md has its columns."""
    wavelength_m: Band | None = None
    """Shortest and longest wave that are laid; all of them unless given."""

    def disturbances(self, length: float, file: Path) -> tuple[Disturbance, ...]:
        _room(self.from_m, length, length, "from_m")
        table = TrackTable.read(file)
        return table.disturbances(self.from_m, self.fade_m, self.scale, self.wavelength_m)


class _Defect(IrregularityTable):
    """One place: its middle, length, shape and size."""

    channel: ClassVar[Channel]
    sign: ClassVar[float] = 1.0

    at_m: Place
    """Middle of the defect."""
    length_m: Annotated[float, number(0.1, 1000, "m")]
    """Its length along the track."""
    amplitude_mm: Annotated[float, number(-200, 200, "mm")]
    """Its largest size; its sign is the side."""
    shape: Literal["1-cosine", "kink", "ramp"] = "1-cosine"
    """A smooth wave, a kink with its tip in the middle, or a ramp to a value that stays."""

    def disturbances(self, length: float, file: Path) -> tuple[Disturbance, ...]:
        begin, end = self.at_m - 0.5 * self.length_m, self.at_m + 0.5 * self.length_m
        if begin <= 0.0 or end >= length:
            place = f"at_m = {self.at_m:g}: goes from {begin:g} to {end:g} m"
            raise InputError(f"{place}; must lie on the track, which is {length:.6g} m long")
        size = self.sign * self.amplitude_mm / 1e3
        shape: Shape = Bump(begin, self.length_m, size)
        if self.shape == "kink":
            shape = Polygon.through((0.0, begin, self.at_m, end, length), (0.0, 0.0, size, 0.0, 0.0), ROUNDING)
        elif self.shape == "ramp":
            shape = Polygon.through((0.0, begin, end, length), (0.0, 0.0, size, size), ROUNDING)
        return (Disturbance.of(shape, self.channel, getattr(self, "rail", "both")),)


class DipSection(_Defect, kind="dip"):
    """The rails lie lower: amplitude positive downward; of one rail: a dipped joint."""

    channel = "level"
    sign = -1.0

    rail: Rail = "both"
    """Which rail lies lower; one alone is a dipped joint."""


class AlignmentSection(_Defect, kind="alignment"):
    """The rails lie aside: amplitude positive to the left."""

    channel = "alignment"

    rail: Rail = "both"
    """Which rail lies aside."""


class TwistSection(_Defect, kind="twist"):
    """The right rail lies higher than the left one by the amplitude, each by half of it."""

    channel = "cross-level"


class GaugeSection(_Defect, kind="gauge"):
    """The gauge is wider by the amplitude, each rail by half of it."""

    channel = "gauge"


INCH = 0.0254
MCAT: dict[str, tuple[tuple[Channel, float], ...]] = {
    "alinement": (("alignment", 1.0),), "gauge": (("gauge", 1.0),), "crosslevel": (("cross-level", 1.0),),
    "surface": (("level", -1.0),), "combined": (("alignment", 1.0), ("level", -1.0)),
}  # fmt: skip
"""Deviations of minimally compliant analytical track: channels and their signs."""
OF_CLASS = {
    (row["deviation"], row["course"], int(row["chord_ft"])): row
    for row in table("wrsim.scenario", "data/track_classes.csv")
}
"""Largest deviations [in] of the classes of track of 49 CFR 213, by deviation, course and chord."""


class McatSection(IrregularityTable, kind="mcat"):
    """Deviations of minimally compliant analytical track (49 CFR 213, Appendix D): waves as long as a chord, so that
    the mid-chord offset of that chord is the amplitude."""

    one_of = ("amplitude_mm track_class",)

    deviation: Literal[*MCAT]  # type: ignore[valid-type]
    """What deviates: rails to the left, wider, the right one higher, both lower; combined: to the left and lower."""
    chord_ft: Literal[31, 62, 124]
    """Length of the chord and of a wave in feet."""
    from_m: Place
    """Where the first wave begins."""
    waves: Annotated[int, number(1, 100)] = 1
    """How many waves follow each other: one is a single deviation."""
    rail: Rail = "both"
    """Which rail deviates."""
    amplitude_mm: Annotated[float, number(-200, 200, "mm")] | None = None
    """Mid-chord offset of a wave; of a combined one that of alinement."""
    surface_mm: Annotated[float, number(-200, 200, "mm")] | None = None
    """Mid-chord offset of the surface in a combined deviation."""
    track_class: Annotated[int, number(1, 9)] | None = None
    """Class of track whose largest deviation is laid, where wrsim knows it; else give amplitude_mm."""
    course: Literal["tangent", "curved"] = "tangent"
    """For which course of the track the class of track sets it."""
    scale: Annotated[float, number(-10, 10, "negative: to the other side")] = 1.0
    """Factor on the amplitude."""

    def consistency(self) -> Iterator[Fault]:
        if self.track_class is not None and self._of_class() is None:
            known = [str(c) for c in range(1, 10) if self._row().get(str(c))]
            have = f"has it of classes {', '.join(known)}" if known else "has none"
            message = f"{self.deviation}, {self.course}, chord {self.chord_ft} ft: the table of wrsim {have}"
            yield Fault("track_class", f"{message}; give amplitude_mm")
        if self.deviation == "combined" and self.surface_mm is None:
            yield Fault("surface_mm", f"must be {requirement(fields(type(self))['surface_mm'])}", missing=True)
        elif self.deviation != "combined" and self.surface_mm is not None:
            yield Fault("surface_mm", 'goes with deviation = "combined"')

    def _row(self) -> dict[str, str]:
        deviation = "alinement" if self.deviation == "combined" else self.deviation
        return OF_CLASS.get((deviation, self.course, self.chord_ft), {})

    def _of_class(self) -> float | None:
        """Amplitude of the class of track [mm]; None where it is unknown."""
        inches = self._row().get(str(self.track_class))
        return float(inches) * INCH * 1e3 if inches else None

    def disturbances(self, length: float, file: Path) -> tuple[Disturbance, ...]:
        wave = self.chord_ft * FOOT
        end = self.from_m + self.waves * wave
        if end >= length:
            place = f"from_m = {self.from_m:g}: goes from {self.from_m:g} to {end:g} m"
            raise InputError(f"{place}; must lie on the track, which is {length:.6g} m long")
        sizes = (given(self.amplitude_mm, self._of_class()), self.surface_mm or 0.0)
        return tuple(
            Disturbance.of(Bump(self.from_m + i * wave, wave, self.scale * sign * size / 1e3), channel, self.rail)
            for (channel, sign), size in zip(MCAT[self.deviation], sizes, strict=False)
            for i in range(self.waves)
        )


IrregularitySection = (
    SpectrumSection | TableSection | DipSection | AlignmentSection | TwistSection | GaugeSection | McatSection
)


def grades_in_order(raw: Any) -> Iterator[Fault]:
    """The grades of a raw table rise in distance."""
    row = [g.get("from_m") if isinstance(g, dict) else None for g in raw] if isinstance(raw, list) else []
    for i in range(1, len(row)):
        a, b = row[i - 1], row[i]
        if isinstance(a, (int, float)) and isinstance(b, (int, float)) and not b > a:
            yield Fault(("grades", i, "from_m"), f"must be above that of the grade before ({a:g})")


def _room(start: float, end: float, length: float, key: str) -> float:
    for name, place, beyond in (("from_m", start, start >= length), (key, end, end > length * (1.0 + 1e-9))):
        if beyond:
            raise InputError(f"{name} = {place:g}: must lie on the track, which is {length:.6g} m long")
    if end <= start:
        raise InputError(f"{key} = {end:g}: must be above from_m = {start:g}")
    return min(end, length)
