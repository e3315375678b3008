"""``wrsim recording``: from the CSV of a track recording car to a scenario."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures
from wrsim.cli.showing import print_json, print_tables, say
from wrsim.cli.storing import writing
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.geometry.recording.restoring import Restored


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
        from wrsim.results.recording import LONGEST_BAND, recording_numbers, recording_tables

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
            print_json({**recording_numbers(restored), "files": [str(f) for f in files]})
            return
        print_tables(recording_tables(restored))
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
