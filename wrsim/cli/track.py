"""``wrsim track``: a picture of the track of a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, check_ending
from wrsim.cli.showing import print_files
from wrsim.cli.storing import writing


def track(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Scenario file (TOML).")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="PNG", help="Default: <name of FILE>_track.png here.")
    ] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Draw the track of a scenario: plan, curvature, cant, gauge, height, irregularities."""
    with reporting_errors(as_json), writing(force, file):
        picture = output or Path(f"{file.stem}_track.png")
        check_ending("-o", picture, ".png")
        from wrsim.plots.style import save
        from wrsim.plots.track import track_figure
        from wrsim.scenario.build import build
        from wrsim.scenario.loading import load

        setup = build(load(file, models or ()))
        print_files([save(track_figure(setup.track), picture)], as_json)
