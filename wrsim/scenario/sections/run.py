"""[run] and [output]: where a run along the track goes, and what is kept of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import List, number
from wrsim.scenario.sections.table import Table


class RunSection(Table):
    """Where a run along the track starts and ends, and its steps in time."""

    header: ClassVar[str] = "[run]"
    aliases: ClassVar[dict[str, str]] = {
        "duration_s": "time_s",
        "t_end_s": "time_s",
        "end_time_s": "time_s",
        "length_m": "distance_m",
        "dt_us": "step_us",
        "h_us": "step_us",
        "output_step_ms": "output_interval_ms",
        "sampling_ms": "output_interval_ms",
    }

    start_distance_m: Annotated[float, number(0, 1e6, "m along the centre line")] = 0.0
    distance_m: Annotated[float, number(0.01, 1e6, "m from the start")] | None = None
    time_s: Annotated[float, number(0.001, 1e5, "s from the start")] | None = None
    step_us: Annotated[int, number(1, 20_000)] | None = None
    output_interval_ms: Annotated[float, number(0.01, 10_000, "ms between two samples")] = 5.0

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """A distance or a time."""
        if "distance_m" in raw and "time_s" in raw:
            yield Fault("time_s", "cannot stand next to distance_m: give one of them")

    def consistency(self) -> Iterator[Fault]:
        """A sample needs at least one step."""
        if self.step_us is not None and self.step_us > self.output_interval_ms * 1000.0 * (1.0 + 1e-9):
            yield Fault("step_us", f"must be at most the output interval ({self.output_interval_ms:g} ms)")


class OutputSection(Table):
    """What is kept besides the channels."""

    header: ClassVar[str] = "[output]"
    aliases: ClassVar[dict[str, str]] = {"snapshots_m": "patches_at_m", "patches": "patches_at_m"}

    patches_at_m: List[Annotated[float, number(0, 1e6, "m along the centre line")]] | None = None
