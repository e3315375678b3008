"""``wrsim plot``, ``profile`` and ``track``: pictures of results, profiles and tracks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli import options
from wrsim.cli.console import print_found
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import (  # fmt: skip
    At,
    BesideResult,
    Force,
    Json,
    Models,
    OneWheelset,
    ResultFile,
    ScenarioFile,
    into,
)


def plot(
    result: ResultFile,
    output: BesideResult = None,
    at: At = None,
    wheelset: OneWheelset = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw the pictures of a result; with --at the contact patches at chosen places only."""
    from wrsim.report.output_folder import folder_of_result, read, writing

    with reporting_errors(as_json), writing(force, of=result):
        from wrsim.report.outputs import draw_patches, draw_result
        from wrsim.results.wheelsets import wheelset_folder, wheelsets, worst_wheelset

        loaded = read(result)
        dataset, directory = loaded.dataset, output or folder_of_result(result)
        if wheelset is not None or at:
            dataset = loaded.wheelset(wheelset or worst_wheelset(dataset))
            if output is None:
                directory /= wheelset_folder(wheelsets(loaded.dataset), str(dataset["wheelset"].item()))
        files = draw_patches(dataset, at, directory) if at else draw_result(dataset, directory)
        print_found(as_json, {}, [], files)


def profile(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="Wheel or rail profile: TOML or points, such as wheels/S1002.toml.")
    ],
    output: Annotated[Path | None, into(metavar="PNG", help="Default: <name of FILE>.png here.")] = None,
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
    from wrsim.report.output_folder import writing

    with reporting_errors(as_json), writing(force, Path(file)):
        from wrsim.report.outputs import draw_model
        from wrsim.results.smoothing import profile_and_reports, smoothing_table

        picture = output or Path(Path(file).stem + ".png")
        options.check_ending("-o", picture, ".png")
        loaded, reports = profile_and_reports(file, kind, cutoff or [], models)
        files = [draw_model("profile", picture, loaded, reports)]
        numbers = {"smoothing": [r.numbers() for r in reports]} if reports else {}
        print_found(as_json, numbers, [smoothing_table(reports)] if reports else [], files)


def track(
    file: ScenarioFile,
    output: Annotated[Path | None, into(metavar="PNG", help="Default: <name of FILE>_track.png here.")] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw the track of a scenario: plan, curvature, cant, gauge, height, irregularities."""
    from wrsim.report.output_folder import writing

    with reporting_errors(as_json), writing(force, file):
        from wrsim.report.outputs import draw_model
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load

        picture = output or Path(f"{file.stem}_track.png")
        options.check_ending("-o", picture, ".png")
        print_found(as_json, {}, [], [draw_model("track", picture, build(load(file, models or ())).track)])
