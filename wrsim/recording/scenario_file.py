"""A recorded track as files of a scenario: track, irregularities, and a scenario that runs on them."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from wrsim.errors import InputError
from wrsim.inputs.checking import check_value
from wrsim.inputs.toml_files import write_toml
from wrsim.inputs.values import number
from wrsim.recording.design import FORMS, Plateau
from wrsim.recording.reading import recording_from
from wrsim.recording.restoring import Restored, restore
from wrsim.recording.tables import LONGEST_BAND
from wrsim.track.cant import PIVOTS, cant_base
from wrsim.track.irregularities import smooth_step
from wrsim.track.segments import Arc, Transition
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

TRACK, IRREGULARITIES, SCENARIO, COLUMNS = "track.toml", "irregularities.csv", "scenario.toml", "columns.toml"
RESERVE = 15.0
"""From the start of the first straight or arc to that of the run [m]: a vehicle reaches behind its origin."""
EVEN, RISE = 30.0, 50.0
"""Where the irregularities begin behind that, and over which length they rise [m]: a run starts from steady motion."""
ROOM = 40.0
"""Shortest straight or arc that a run starts on [m]."""
FALL = 20.0
"""Length over which the irregularities end [m]."""
DEFICIENCY = 0.1
"""Cant deficiency of the speed unless given [m]."""
FASTEST, SLOWEST = 160.0, 20.0
"""Limits of that speed [km/h]."""


def start_of(restored: Restored) -> Plateau:
    """The straight or arc that a run starts on."""
    long_enough = [p for p in restored.plateaus if p.end - p.start >= ROOM]
    return (long_enough or list(restored.plateaus))[0]


def usual_speed(restored: Restored) -> float:
    """The speed [km/h] at which no arc has more than 100 mm of cant deficiency, within limits and in steps of 5."""
    columns = restored.recording.columns
    base = cant_base(columns.gauge_mm, columns.cant_base_mm)
    speeds = [FASTEST]
    for p in restored.plateaus:
        if not p.is_straight:
            inward = max(p.cant * math.copysign(1.0, p.curvature) + DEFICIENCY, 0.0)
            speeds.append(3.6 * math.sqrt(inward / base * STANDARD_GRAVITY / abs(p.curvature)))
    return max(SLOWEST, 5.0 * math.floor(min(speeds) / 5.0))


def track_file(restored: Restored, date: str) -> str:
    """The track file; date: of today, as 2026-11-22."""
    recording = restored.recording
    track: dict[str, Any] = {"gauge_mm": recording.columns.gauge_mm, "rail": "rails/60E1.toml", "inclination": "1:40"}
    if recording.columns.cant_base_mm is not None:
        track["cant_base_mm"] = recording.columns.cant_base_mm
    if recording.columns.pivot != PIVOTS[0]:
        track["pivot"] = recording.columns.pivot
    track["segments"] = [*_segments(restored)]
    track["irregularities"] = [{"kind": "table", "file": IRREGULARITIES, "fade_m": FALL}]
    name = recording.path.stem
    end = recording.start + recording.length
    head = (
        f"# Made by wrsim recording from {recording.path.name}, {recording.start:.10g} to {end:.10g} m, which is 0 to "
        f"{recording.length:.10g} m here.\n# The rail and its inclination are not in a recording: set your own.\n"
    ) + noted(restored)
    source = f"wrsim recording, from {recording.path.name}"
    day = f"date = {date}\n"  # dates of TOML have no quotes
    return head + write_toml({"name": name, "source": source}) + day + "\n" + write_toml({"track": track})


def noted(restored: Restored) -> str:
    """What was assumed and done, as comments of a file."""
    return "".join(f"# {note}\n" for note in restored.notes)


def _segments(restored: Restored) -> Iterator[dict[str, Any]]:
    for segment in restored.segments:
        length = {"length_m": round(float(segment.length), 3)}
        if isinstance(segment, Arc):
            arc: dict[str, Any] = {"kind": "arc", "radius_m": float(f"{segment.radius:.7g}"), **length}
            arc["cant_mm"] = round(1e3 * segment.cant, 3)
            if segment.gauge_widening:
                arc["gauge_widening_mm"] = round(1e3 * segment.gauge_widening, 3)
            yield arc
        elif isinstance(segment, Transition):
            yield {"kind": "transition", **length, "form": segment.form}
        else:
            yield {"kind": "straight", **length}


def irregularity_rows(restored: Restored) -> Iterator[list[str]]:
    """The table of irregularities, its header first; even where a run starts."""
    s = restored.recording.distance
    window = smooth_step((s - start_of(restored).start - EVEN) / RISE)
    columns = ["distance_m"]
    values = [s]
    for i, side in enumerate(("left", "right")):
        for way, shape in (("lateral", restored.lateral), ("vertical", restored.vertical)):
            columns.append(f"{side}_{way}_mm")
            values.append(1e3 * window * shape[i])
    yield columns
    for row in np.stack(values, axis=1).tolist():
        yield [f"{row[0]:.4f}", *(f"{v:.4f}" for v in row[1:])]


def scenario_file(restored: Restored, vehicle: str, speed: float) -> str:
    """A scenario that runs over the whole of it."""
    start = start_of(restored).start + RESERVE
    data: dict[str, Any] = {
        "title": f"over {restored.recording.path.stem}, as recorded",
        "analysis": "curving",
        "vehicle": {"model": vehicle, "speed_kmh": speed},
        "track": {"file": TRACK},
        "run": {"start_distance_m": round(start, 3)},
    }
    return f"# Made by wrsim recording from {restored.recording.path.name}: wrsim run {SCENARIO}\n" + write_toml(data)


def restored_track(
    file: Path, columns: Path | None, chord: tuple[float, float] | None, band: str | None,
    part: tuple[float | None, float | None], wavelengths: tuple[float, float], amplification: float, transitions: str,
) -> Restored:  # fmt: skip
    """The track of a recording, from the options of ``wrsim recording`` [m].

    columns: column map; chord, band: how alignment and level were measured without a map; part: from and to;
    wavelengths: those wanted; amplification: maximum gain of the inverse filter; transitions: "clothoid",
    "bloss", "either". Raises InputError.
    """
    check_value(Literal["D1", "D2", "D3"] | None, band, "--band")
    check_value(Literal["clothoid", "bloss", "either"], transitions, "--transitions")
    if chord is not None and band is not None:
        raise InputError("--band: cannot be given with --chord-m")
    if columns is not None and (chord is not None or band is not None):
        option = "--band" if chord is None else "--chord-m"
        raise InputError(f"{option}: how alignment and level were measured is in {columns}")
    for length in chord or ():
        check_value(Annotated[float, number(0.2, 30, "m")], length, "--chord-m")
    check_value(Annotated[float, number(1, 1000)], amplification, "--amplification")
    for length in wavelengths:
        check_value(Annotated[float, number(0.5, LONGEST_BAND, "m")], length, "--wavelength-m")
    if not wavelengths[0] < wavelengths[1]:
        raise InputError(f"--wavelength-m {wavelengths[0]:g} {wavelengths[1]:g}: must rise")
    if part[0] is not None and part[1] is not None and not part[0] < part[1]:
        raise InputError(f"--from-m {part[0]:g} --to-m {part[1]:g}: must rise")
    read = recording_from(file, columns, chord=chord, band=band, part=part, bridge=wavelengths[0])
    forms = tuple(form for form in FORMS if transitions in (form, "either"))
    return restore(read, wavelengths, amplification, forms)
