"""``wrsim conicity``: the equivalent conicity of any pair of profiles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_found
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures, into
from wrsim.errors import InputError


def conicity_command(
    wheel: Annotated[
        str, typer.Argument(metavar="WHEEL", help="Wheel profile, such as wheels/S1002.toml, or a folder of them.")
    ],
    rail: Annotated[
        str, typer.Argument(metavar="RAIL", help="Rail profile, such as rails/60E1.toml, or a folder of them.")
    ],
    gauge_mm: Annotated[float, typer.Option(min=400.0, max=2000.0, help="14 mm below the rail tops.")] = 1435.0,
    gauges_mm: Annotated[
        tuple[float, float, float] | None, typer.Option(metavar="FROM TO STEP", help="A map over the gauge instead.")
    ] = None,
    flange_back_mm: Annotated[float, typer.Option(min=300.0, max=1900.0, help="Between the flange backs.")] = 1360.0,
    inclination: Annotated[str, typer.Option(help='Of the rails: 1:40, 1:20 ... or "none".')] = "1:40",
    radius_mm: Annotated[float, typer.Option(min=100.0, max=1500.0, help="Of both wheels at the tape circle.")] = 460.0,
    diameters_mm: Annotated[
        tuple[float, float] | None, typer.Option(metavar="LEFT RIGHT", help="In place of --radius-mm.")
    ] = None,
    wheel_right: Annotated[str | None, typer.Option(metavar="WHEEL", help="Where the right wheel differs.")] = None,
    rail_right: Annotated[str | None, typer.Option(metavar="RAIL", help="Where the right rail differs.")] = None,
    roll: Annotated[str, typer.Option(help="none (EN 15302), rail-top or centre: see docs/conicity.md.")] = "none",
    curve_m: Annotated[
        list[float] | None, typer.Option(metavar="RADIUS", help="Radial steering index in this curve; may be repeated.")
    ] = None,
    flange_from_deg: Annotated[float, typer.Option(help="For that: contact angle where the flange begins.")] = 40.0,
    models: Models = None,
    output: Annotated[Path | None, into(metavar="DIR", help="Write a table, every 0.1 mm, and pictures there.")] = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Rolling radius difference, contact angles and equivalent conicity (EN 15302) of a wheelset on its rails."""
    from wrsim.report.output_folder import writing

    with reporting_errors(as_json), writing(force):
        from wrsim.analysis.conicity.pairs import Pairing
        from wrsim.report.outputs import write_conicity, write_conicity_map
        from wrsim.results.conicity import conicity_numbers
        from wrsim.results.render import as_records

        pairing, files = Pairing(flange_back_mm / 1e3, inclination, roll, models or ()), []
        if gauges_mm is not None or Path(wheel).is_dir() or Path(rail).is_dir():
            if diameters_mm or wheel_right or rail_right or curve_m:
                refused = "--diameters-mm, -right and --curve-m"
                raise InputError(f"a map is of wheelsets with like wheels on like rails, at any radius: no {refused}")
            over = pairing.map(wheel, rail, gauges_mm or (gauge_mm, gauge_mm, 1.0), radius_mm / 1e3)
            tables = [over.table()]
            numbers = {"title": over.title, "map": as_records(over.table()), "gaps": list(over.reasons)}
            files = write_conicity_map(over, output, pictures) if output else []
        else:
            left, right = diameters_mm or (2.0 * radius_mm, 2.0 * radius_mm)
            wheels, rails = (wheel, wheel_right or wheel), (rail, rail_right or rail)
            diameters = (left / 1e3, right / 1e3)
            found = pairing.conicity(wheels, rails, gauge_mm / 1e3, diameters, curve_m or (), flange_from_deg)
            tables, numbers = found.numbers(), {"title": found.title, **conicity_numbers(found)}
            files = write_conicity(found, output, pictures) if output else []
        print_found(as_json, numbers, tables, files)
