"""[ride]: which stretch of a run is evaluated, and how finely."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import number
from wrsim.scenario.sections.table import Table

Place = Annotated[float, number(-1e6, 1e6, "m along the centre line")]


class StretchTable(Table):
    """Base of tables that count over a stretch of the run."""

    from_m: Place | None = None
    """Where the stretch that counts begins, for each wheelset; where the run starts unless given."""
    to_m: Place | None = None
    """Where the stretch that counts ends; where the run ends unless given."""

    def consistency(self) -> Iterator[Fault]:
        """A stretch has a length."""
        if self.from_m is not None and self.to_m is not None and self.to_m <= self.from_m:
            yield Fault("to_m", f"must lie beyond from_m ({self.from_m:g} m)")


class RideSection(StretchTable):
    """Which stretch of a run is evaluated, and how finely; it leaves out where a run starts and ends."""

    header: ClassVar[str] = "[ride]"
    aliases: ClassVar[dict[str, str]] = {"from_m": "start_m", "to_m": "end_m", "resolution_Hz": "df_Hz"}

    resolution_Hz: Annotated[float, number(0.001, 10, "Hz")] = 0.1
    """Distance between two lines of the spectra."""
