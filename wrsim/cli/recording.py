"""``wrsim recording``: from the CSV of a track recording car to a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_found, print_lines
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures, into


def recording(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Table of a recording (CSV).")],
    output: Annotated[Path | None, into(metavar="DIR", help="Default: <name of FILE> here.")] = None,
    columns: Annotated[
        Path | None,
        typer.Option(metavar="TOML", help="Column map; default: the TOML of FILE's name beside it, or columns' names."),
    ] = None,
    chord_m: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="BEHIND AHEAD", help="Chord of alignment and level, where no map gives it."),
    ] = None,
    band: Annotated[
        str | None, typer.Option(metavar="D1|D2|D3", help="Inertial band of alignment and level, if no map gives it.")
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
    from wrsim.report.output_folder import writing

    beside = file.with_suffix(".toml")
    chosen = columns if columns is not None else beside if beside.is_file() else None
    with reporting_errors(as_json), writing(force, *([file] if chosen is None else [file, chosen])):
        from wrsim.report.outputs import write_recording
        from wrsim.results.recording import recording_numbers, recording_tables
        from wrsim.scenario.recorded import restored_track

        restored = restored_track(file, chosen, chord_m, band, (from_m, to_m), wavelength_m, amplification, transitions)
        directory = output or Path(file.stem)
        files = write_recording(restored, directory, vehicle, speed_kmh, models or (), pictures)
        print_found(as_json, recording_numbers(restored), recording_tables(restored), files, directory)
        if not as_json:
            print_lines(f"run it with: wrsim run {directory / 'scenario.toml'}")
