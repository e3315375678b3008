"""[profiles]: how files of points are read that a scenario or its vehicle names."""

from contextlib import AbstractContextManager
from typing import Annotated, Literal

from wrsim.contact.profiles.file_kinds import BackToTapeCircle
from wrsim.contact.profiles.files import HEIGHTS, ORIGINS, SIDES, reading_as
from wrsim.contact.profiles.formats import METRES
from wrsim.inputs.section import Section
from wrsim.inputs.values import positive


class PointsSection(Section, header="[profiles.wheel] or [profiles.rail]"):
    """How files of points of wheels or of rails are read, where they and profile files do not say it."""

    unit: Literal[*METRES] | None = None  # type: ignore[valid-type]
    """Unit of the coordinates."""
    heights: Literal[*HEIGHTS] | None = None  # type: ignore[valid-type]
    """Which way heights grow."""
    field_side: Literal[*SIDES] | None = None  # type: ignore[valid-type]
    """Sign of lateral coordinates on the field side."""
    origin: Literal[*ORIGINS] | None = None  # type: ignore[valid-type]
    """Where the lateral coordinate of wheels is zero."""
    back_to_tape_circle_mm: BackToTapeCircle | None = None
    """Distance of the tape circle of wheels from the flange back."""
    measured: bool | None = None
    """Whether points are smoothed, or interpolated."""
    cutoff_mm: Annotated[float, positive(100.0)] | None = None
    """Length of the waves that smoothing halves."""

    def options(self) -> dict[str, object]:
        """Options of `read_points`."""
        lengths = {"cutoff": self.cutoff_mm, "back": self.back_to_tape_circle_mm}
        choices = {key: getattr(self, key) for key in ("unit", "heights", "field_side", "origin", "measured")}
        return choices | {key: None if mm is None else 1e-3 * mm for key, mm in lengths.items()}


class ProfilesSection(Section, header="[profiles]"):
    """How files of points are read that a scenario or its vehicle names directly."""

    wheel: PointsSection = PointsSection()
    """Files of wheels."""
    rail: PointsSection = PointsSection()
    """Files of rails."""

    def reading(self) -> AbstractContextManager[None]:
        """Within this block files are read so."""
        return reading_as({"wheel": self.wheel.options(), "rail": self.rail.options()})
