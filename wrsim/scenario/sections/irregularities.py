"""[[track.irregularities]] and [[track.grades]]: where rails leave their designed place, how the line climbs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from wrsim.errors import InputError
from wrsim.geometry.track.gradient import Grade
from wrsim.geometry.track.irregularities import CHANNELS, Bump, Channel, Disturbance, Polygon, Rail, Shape
from wrsim.geometry.track.spectra import SPECTRA, Realisation
from wrsim.geometry.track.table import TrackTable
from wrsim.geometry.track.track import ROUNDING
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import Annotation, Choice, Quantity, Series, Text, Whole

Place = Quantity(0, 1e6, example="m along the centre line")
DefectShape = Literal["1-cosine", "kink", "ramp"]
SHAPES: tuple[DefectShape, ...] = ("1-cosine", "kink", "ramp")
RAILS: tuple[Rail, ...] = ("both", "left", "right")
Find = Callable[[str], Path]
"""Finds a file by the name in a scenario."""


class Band(Annotation):
    """Shortest and longest wavelength."""

    def words(self) -> str:
        return "two rising wavelengths in m from 0.1 to 1000, such as [3, 70]"

    def check(self, value: Any) -> tuple[float, float]:
        if not isinstance(value, (list, tuple)) or len(value) != 2:
            raise self.refusal()
        low, high = Series(Quantity(0.1, 1000.0, example="m")).check(list(value))
        if not low < high:
            raise self.refusal()
        return low, high


class Words(Annotation):
    """A list of different words out of those allowed."""

    def __init__(self, allowed: tuple[str, ...]) -> None:
        self.allowed = allowed

    def words(self) -> str:
        return "a list of " + ", ".join(f'"{word}"' for word in self.allowed)

    def check(self, value: Any) -> tuple[str, ...]:
        if not isinstance(value, (list, tuple)) or not value:
            raise self.refusal()
        words = tuple(Choice(self.allowed).check(word) for word in value)
        if len(set(words)) != len(words):
            raise self.refusal()
        return words


class GradeSection(Section):
    """From a distance on the track climbs or falls; a vertical curve leads over from the grade before."""

    header: ClassVar[str] = "[[track.grades]]"
    aliases: ClassVar[dict[str, str]] = {"at_m": "from_m", "radius_m": "vertical_radius_m", "grade": "grade_permille"}

    from_m: Annotated[float, Place]
    grade_permille: Annotated[float, Quantity(-150, 150, example="positive: uphill")]
    vertical_radius_m: Annotated[float, Quantity(200, 1e7, example="m, of the vertical curve at the change")] = 10_000.0

    def to_geometry(self) -> Grade:
        """The same in SI units."""
        return Grade(self.from_m, self.grade_permille / 1e3, self.vertical_radius_m)


class SpectrumSection(Section):
    """Irregularities drawn from a spectrum."""

    header: ClassVar[str] = "[[track.irregularities]] with kind = spectrum"
    aliases: ClassVar[dict[str, str]] = {"band_m": "wavelength_m", "wavelengths_m": "wavelength_m", "name": "spectrum"}

    kind: Annotated[Literal["spectrum"], Choice(("spectrum",))]
    spectrum: Annotated[str, Choice(tuple(SPECTRA))]
    seed: Annotated[int, Whole(0, 2**31 - 1)]
    wavelength_m: Annotated[tuple[float, float], Band()] = (3.0, 100.0)
    channels: Annotated[tuple[Channel, ...], Words(CHANNELS)] = CHANNELS
    scale: Annotated[float, Quantity(above=0, high=100, example="factor on all amplitudes")] = 1.0
    from_m: Annotated[float, Place] = 0.0
    to_m: Annotated[float, Place] | None = None
    fade_m: Annotated[float, Quantity(above=0, high=1000, example="m over which they begin and end")] = 20.0

    def disturbances(self, length: float, find: Find) -> tuple[Disturbance, ...]:
        """On a track of this length [m]. Raises InputError when from_m and to_m leave it no room."""
        end = _room(self.from_m, length if self.to_m is None else self.to_m, length, "to_m")
        short, long = self.wavelength_m
        if end - self.from_m < long:
            raise InputError(
                f"from {self.from_m:g} to {end:g} m there is no room for the longest wavelength, {long:g} m "
                "(wavelength_m)"
            )
        drawn = Realisation(
            self.spectrum, self.seed, short, long, self.from_m, end, self.scale, self.fade_m, self.channels
        )
        return drawn.disturbances()


class TableSection(Section):
    """Measured irregularities from a CSV table."""

    header: ClassVar[str] = "[[track.irregularities]] with kind = table"
    aliases: ClassVar[dict[str, str]] = {"table": "file", "csv": "file", "band_m": "wavelength_m"}

    kind: Annotated[Literal["table"], Choice(("table",))]
    file: Annotated[str, Text('a CSV file such as "measured.csv"')]
    wavelength_m: Annotated[tuple[float, float], Band()] | None = None
    scale: Annotated[float, Quantity(above=0, high=100, example="factor on all amplitudes")] = 1.0
    from_m: Annotated[float, Place] = 0.0
    fade_m: Annotated[float, Quantity(above=0, high=1000, example="m over which they begin and end")] = 20.0

    def disturbances(self, length: float, find: Find) -> tuple[Disturbance, ...]:
        """As far as the table and the track go."""
        _room(self.from_m, length, length, "from_m")
        table = TrackTable.read(find(self.file))
        return table.disturbances(self.from_m, self.fade_m, self.scale, self.wavelength_m)


class _Defect(Section):
    """One place: its middle, length, shape and size."""

    aliases: ClassVar[dict[str, str]] = {"depth_mm": "amplitude_mm", "height_mm": "amplitude_mm", "distance_m": "at_m"}
    channel: ClassVar[Channel]
    sign: ClassVar[float] = 1.0

    at_m: Annotated[float, Place]
    length_m: Annotated[float, Quantity(0.1, 1000, example="m")]
    amplitude_mm: Annotated[float, Quantity(-200, 200, example="mm")]
    shape: Annotated[DefectShape, Choice(SHAPES)] = "1-cosine"

    @property
    def meant(self) -> Rail:
        """The rail that it is on."""
        return "both"

    def disturbances(self, length: float, find: Find) -> tuple[Disturbance, ...]:
        """Raises InputError when it leaves the track."""
        begin, end = self.at_m - 0.5 * self.length_m, self.at_m + 0.5 * self.length_m
        if begin <= 0.0 or end >= length:
            raise InputError(
                f"at_m = {self.at_m:g}: goes from {begin:g} to {end:g} m; must lie on the track, which is "
                f"{length:.6g} m long"
            )
        size = self.sign * self.amplitude_mm / 1e3
        shape: Shape
        if self.shape == "1-cosine":
            shape = Bump(begin, self.length_m, size)
        elif self.shape == "kink":
            shape = Polygon.through((0.0, begin, self.at_m, end, length), (0.0, 0.0, size, 0.0, 0.0), ROUNDING)
        else:
            shape = Polygon.through((0.0, begin, end, length), (0.0, 0.0, size, size), ROUNDING)
        return (Disturbance.of(shape, self.channel, self.meant),)


class DipSection(_Defect):
    """The rails lie lower: amplitude positive downward; of one rail: a dipped joint."""

    header: ClassVar[str] = "[[track.irregularities]] with kind = dip"
    channel: ClassVar[Channel] = "level"
    sign: ClassVar[float] = -1.0

    kind: Annotated[Literal["dip"], Choice(("dip",))]
    rail: Annotated[Rail, Choice(RAILS)] = "both"

    @property
    def meant(self) -> Rail:
        """The rail that it is on."""
        return self.rail


class AlignmentSection(_Defect):
    """The rails lie aside: amplitude positive to the left."""

    header: ClassVar[str] = "[[track.irregularities]] with kind = alignment"
    channel: ClassVar[Channel] = "alignment"

    kind: Annotated[Literal["alignment"], Choice(("alignment",))]
    rail: Annotated[Rail, Choice(RAILS)] = "both"

    @property
    def meant(self) -> Rail:
        """The rail that it is on."""
        return self.rail


class TwistSection(_Defect):
    """The right rail lies higher than the left one by the amplitude, each by half of it."""

    header: ClassVar[str] = "[[track.irregularities]] with kind = twist"
    channel: ClassVar[Channel] = "cross-level"

    kind: Annotated[Literal["twist"], Choice(("twist",))]


class GaugeSection(_Defect):
    """The gauge is wider by the amplitude, each rail by half of it."""

    header: ClassVar[str] = "[[track.irregularities]] with kind = gauge"
    channel: ClassVar[Channel] = "gauge"

    kind: Annotated[Literal["gauge"], Choice(("gauge",))]


IrregularitySection = SpectrumSection | TableSection | DipSection | AlignmentSection | TwistSection | GaugeSection
IRREGULARITIES: dict[str, Any] = {
    "spectrum": SpectrumSection,
    "table": TableSection,
    "dip": DipSection,
    "alignment": AlignmentSection,
    "twist": TwistSection,
    "gauge": GaugeSection,
}


def grades_in_order(raw: Any) -> Iterator[Fault]:
    """The grades of a raw table rise in distance."""
    row = [g.get("from_m") if isinstance(g, dict) else None for g in raw] if isinstance(raw, list) else []
    for i in range(1, len(row)):
        a, b = row[i - 1], row[i]
        if isinstance(a, (int, float)) and isinstance(b, (int, float)) and not b > a:
            yield Fault(("grades", i, "from_m"), f"must be above that of the grade before ({a:g})")


def _room(start: float, end: float, length: float, key: str) -> float:
    if start >= length:
        raise InputError(f"from_m = {start:g}: must lie on the track, which is {length:.6g} m long")
    if end > length * (1.0 + 1e-9):
        raise InputError(f"{key} = {end:g}: must lie on the track, which is {length:.6g} m long")
    if end <= start:
        raise InputError(f"{key} = {end:g}: must be above from_m = {start:g}")
    return min(end, length)
