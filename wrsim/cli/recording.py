"""``wrsim recording``: from the CSV of a track recording car to a scenario."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures
from wrsim.cli.showing import print_json, print_table, say
from wrsim.cli.storing import writing
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.geometry.recording.restoring import Restored

LONGEST_BAND = 500.0
VEHICLE = "vehicles/manchester_1.toml"


def recording(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Table of a recording (CSV).")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: <name of FILE> here.")
    ] = None,
    columns: Annotated[
        Path | None,
        typer.Option(metavar="TOML", help="Column map; default: the TOML of FILE's name beside it, or columns' names."),
    ] = None,
    chord_m: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="BEHIND AHEAD", help="Chord of alignment and level, where no map says it."),
    ] = None,
    band: Annotated[
        str | None, typer.Option(metavar="D1|D2|D3", help="Inertial band of alignment and level, where no map says it.")
    ] = None,
    wavelength_m: Annotated[
        tuple[float, float], typer.Option(metavar="SHORT LONG", help="Waves of alignment and level that are wanted.")
    ] = (3.0, 70.0),
    amplification: Annotated[float, typer.Option(help="Largest factor with which a wave of a chord is undone.")] = 8.0,
    transitions: Annotated[
        str, typer.Option(metavar="clothoid|bloss|either", help="Their form; either: the one that comes nearer.")
    ] = "either",
    from_m: Annotated[float | None, typer.Option(help="Take the recording from this distance on.")] = None,
    to_m: Annotated[float | None, typer.Option(help="Take it up to this distance.")] = None,
    vehicle: Annotated[
        str, typer.Option(metavar="MODEL", help="Vehicle of the scenario.")
    ] = "vehicles/manchester_1.toml",
    speed_kmh: Annotated[
        float | None, typer.Option(help="Speed of the scenario; default: 100 mm of cant deficiency, 160 at most.")
    ] = None,
    models: Models = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Make a track, its irregularities and a scenario of a track recording car's table (docs/recording.md)."""
    beside = file.with_suffix(".toml")
    chosen = columns if columns is not None else beside if beside.is_file() else None
    with reporting_errors(as_json), writing(force, *([file] if chosen is None else [file, chosen])):
        from wrsim.geometry.recording.design import FORMS
        from wrsim.geometry.recording.recording import read_recording
        from wrsim.geometry.recording.restoring import restore
        from wrsim.inputs.checking import check_value
        from wrsim.inputs.values import number

        if band is not None and band not in ("D1", "D2", "D3"):
            raise InputError(f"--band {band}: must be D1, D2 or D3")
        if chord_m is not None and band is not None:
            raise InputError("--band: cannot stand next to --chord-m")
        if chosen is not None and (chord_m is not None or band is not None):
            raise InputError(
                f"--{'band' if chord_m is None else 'chord-m'}: {chosen} says how alignment and level were measured"
            )
        for length in chord_m or ():
            check_value(Annotated[float, number(0.2, 30, "m")], length, "--chord-m")
        check_value(Annotated[float, number(1, 1000)], amplification, "--amplification")
        for length in wavelength_m:
            check_value(Annotated[float, number(0.5, LONGEST_BAND, "m")], length, "--wavelength-m")
        if not wavelength_m[0] < wavelength_m[1]:
            raise InputError(f"--wavelength-m {wavelength_m[0]:g} {wavelength_m[1]:g}: must rise")
        read = read_recording(file, chosen, chord=chord_m, band=band, part=(from_m, to_m))
        forms = FORMS if transitions == "either" else tuple(form for form in FORMS if form == transitions)
        if not forms:
            raise InputError(f"--transitions {transitions}: must be clothoid, bloss or either")
        restored = restore(read, wavelength_m, amplification, forms)
        directory = output or Path(file.stem)
        files = _write(restored, directory, vehicle, speed_kmh, models, pictures)
        if as_json:
            print_json({**_numbers(restored), "files": [str(f) for f in files]})
            return
        _print(restored)
        say(f"{len(files)} files in {directory}; run it with: wrsim run {directory / 'scenario.toml'}")


def _write(
    restored: Restored, directory: Path, vehicle: str, speed: float | None, models: list[Path] | None, pictures: bool
) -> list[Path]:
    """All files, none of them before it is sure that no file of the user's stands in the way."""
    from wrsim.results import write_atomically
    from wrsim.results.files import KEEPER, as_csv
    from wrsim.scenario import recorded
    from wrsim.scenario.build import build
    from wrsim.scenario.loading import load

    texts = {
        recorded.COLUMNS: recorded.columns_file(restored).encode(),
        recorded.IRREGULARITIES: as_csv(recorded.irregularity_rows(restored)),
        recorded.TRACK: recorded.track_file(restored, datetime.date.today().isoformat()).encode(),
        recorded.SCENARIO: recorded.scenario_file(restored, vehicle, speed or recorded.usual_speed(restored)).encode(),
    }
    keeper = KEEPER.get()
    for name in (*texts, "recording.png"):
        if keeper is not None:
            keeper.check(directory / name)
    files = [write_atomically(directory / name, text) for name, text in texts.items()]
    build(load(directory / recorded.SCENARIO, models or ()))  # it says what of the track or the vehicle cannot be
    if pictures:
        from wrsim.plots import save
        from wrsim.plots.recording import recording_figure

        files.append(save(recording_figure(restored), directory / "recording.png"))
    return files


def _numbers(restored: Restored) -> dict[str, Any]:
    """What --json tells."""
    read = restored.recording
    return {
        "from_m": read.start,
        "length_m": read.length,
        "step_m": read.step,
        "guessed": read.guessed,
        "columns": [{"column": c.column, "is": c.words()} for c in read.columns.channels],
        "unused": list(read.unused),
        "undone": [
            {
                "column": c.column,
                "wavelengths_m": [[low, None if high > LONGEST_BAND else high] for low, high in i.kept().tolist()],
                "largest_factor": i.largest(),
                "noise_factor": i.noise(read.step),
            }
            for c, i in restored.inverses
        ],
        "segments": [
            {k: v for k, v in vars(s).items() if v} | {"kind": type(s).__name__.lower()} for s in restored.segments
        ],
        "notes": list(restored.notes),
    }


def _print(restored: Restored) -> None:
    from wrsim.geometry.track.segments import Arc, Transition

    read = restored.recording
    by_column = {c.column: i for c, i in restored.inverses}
    rows = []
    for c in read.columns.channels:
        inverse = by_column.get(c.column)
        kept = "" if inverse is None else ", ".join(_range(*each) for each in inverse.kept().tolist()) or "none"
        factors = ["", ""] if inverse is None else [f"{inverse.largest():.2g}", f"{inverse.noise(read.step):.2g}"]
        rows.append([c.column, c.words(), kept, *factors])
    title = "columns, told from their names" if read.guessed else "columns"
    heads = ("column", "is", "waves that come back (m)", "largest factor", "of noise")
    print_table(heads, rows, title=title, left=heads[:2], width=150)
    if read.unused:
        say(f"not used: {', '.join(read.unused)}")
    at, design = 0.0, []
    for s in restored.segments:
        cells = [f"{read.start + at:.1f}", type(s).__name__.lower(), f"{s.length:.1f}", "", "", ""]
        if isinstance(s, Transition):
            cells[3] = s.form
        elif isinstance(s, Arc):
            cells[3:5] = f"R {s.radius:.1f}", f"{1e3 * s.cant:.1f}"
            cells[5] = f"{1e3 * s.gauge_widening:.1f}" if s.gauge_widening else ""
        design.append(cells)
        at += s.length
    print_table(("from m", "design", "length m", "", "cant mm", "wider mm"), design, left=("design",))
    for note in restored.notes:
        say(f"note: {note}")


def _range(low: float, high: float) -> str:
    return f"from {low:.3g}" if high > LONGEST_BAND else f"{low:.3g} to {high:.3g}"
