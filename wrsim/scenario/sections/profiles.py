"""[profiles]: how files of points are read that a scenario or its vehicle names."""

from contextlib import AbstractContextManager

from wrsim.contact.profiles.file_kinds import PointsKeys
from wrsim.contact.profiles.files import reading_as
from wrsim.inputs.section import Section


class PointsSection(PointsKeys, header="[profiles.wheel] or [profiles.rail]"):
    """How files of points of wheels or of rails are read, where they and profile files do not say it."""


class ProfilesSection(Section, header="[profiles]"):
    """How files of points are read that a scenario or its vehicle names directly."""

    wheel: PointsSection = PointsSection.model_construct()
    """Files of wheels."""
    rail: PointsSection = PointsSection.model_construct()
    """Files of rails."""

    def reading(self) -> AbstractContextManager[None]:
        """Within this block files are read so."""
        return reading_as({"wheel": self.wheel.options(), "rail": self.rail.options()})
