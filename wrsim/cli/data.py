"""``wrsim profile``, ``track``, ``recording``, ``export``: data from and for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_found, print_lines
from wrsim.cli.errors import writing_files
from wrsim.cli.options import (
    PICTURES,
    BesideResult,
    Force,
    Json,
    Models,
    Pictures,
    ResultFile,
    ScenarioFile,
    check_ending,
    into,
)


def profile(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="Wheel or rail profile: TOML or points, such as wheels/S1002.toml.")
    ],
    output: Annotated[Path | None, into(metavar="PNG|SVG|PDF", help="Default: <name of FILE>.png here.")] = None,
    kind: Annotated[str | None, typer.Option(metavar="wheel|rail", help="For a file of two columns only.")] = None,
    cutoff: Annotated[
        list[float] | None,
        typer.Option(metavar="MM", help="Smooth measured points, halving waves of this length; up to four to compare."),
    ] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw a profile with its slope and curvature; of measured points also what smoothing did to them."""
    with writing_files(as_json, force, Path(file)):
        from wrsim.report.outputs import draw_model
        from wrsim.results.smoothing import profile_and_reports, smoothing_table

        picture = output or Path(Path(file).stem + ".png")
        check_ending("-o", picture, *PICTURES)
        loaded, reports = profile_and_reports(file, kind, cutoff or [], models)
        files = [draw_model("profile", picture, loaded, reports)]
        numbers = {"smoothing": [r.numbers() for r in reports]} if reports else {}
        print_found(as_json, numbers, [smoothing_table(reports)] if reports else [], files)


def track(
    file: ScenarioFile,
    output: Annotated[Path | None, into(metavar="PNG|SVG|PDF", help="Default: <name of FILE>_track.png here.")] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw the track of a scenario or of a track file: plan, curvature, cant, gauge, height, irregularities."""
    with writing_files(as_json, force, file):
        from wrsim.report.outputs import draw_model
        from wrsim.scenario.track_build import track_model

        picture = output or Path(f"{file.stem}_track.png")
        check_ending("-o", picture, *PICTURES)
        print_found(as_json, {}, [], [draw_model("track", picture, track_model(file, models or ()))])


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
    """Make a track, its irregularities and a scenario of a track recording car's table (docs/user/recording.md)."""
    beside = file.with_suffix(".toml")
    chosen = columns if columns is not None else beside if beside.is_file() else None
    with writing_files(as_json, force, *([file] if chosen is None else [file, chosen])):
        from wrsim.api import read_recording

        directory = output or Path(file.stem)
        found = read_recording(
            file, directory, columns=chosen, chord_m=chord_m, band=band, wavelength_m=wavelength_m,
            amplification=amplification, transitions=transitions, from_m=from_m, to_m=to_m, vehicle=vehicle,
            speed_kmh=speed_kmh, models=models or (), pictures=pictures,
        )  # fmt: skip
        print_found(as_json, found.numbers, found.tables, found.files, directory)
        if not as_json:
            print_lines(f"run it with: wrsim run {directory / 'scenario.toml'}")


def export(
    result: ResultFile,
    to: Annotated[
        str,
        typer.Option("--to", metavar="FORMAT,...", help="mat, csv, parquet, mdf, tables; one or more with commas."),
    ],
    output: BesideResult = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a result for other programs: MATLAB, CSV, Parquet, MDF (result.mat, .csv, .parquet, .mf4), all tables."""
    with writing_files(as_json, force, of=result):
        from wrsim import api

        print_found(as_json, {}, [], api.export(result, to, output).files)
