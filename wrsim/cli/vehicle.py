"""``wrsim vehicle``: mass, wheel loads and modes of a vehicle, tests at rest, and what it looks like."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_lines, print_numbers
from wrsim.cli.errors import reporting_errors
from wrsim.cli.options import Force, Json, Models, check_ending, into
from wrsim.errors import InputError


def vehicle(
    file: Annotated[str, typer.Argument(metavar="FILE", help="Vehicle file, such as vehicles/manchester_1.toml.")],
    output: Annotated[Path | None, into(metavar="PNG|SVG", help="Draw it there, from three sides.")] = None,
    cant_deficiency: Annotated[
        float | None,
        typer.Option(metavar="MM", min=1.0, max=400.0, help="Static roll and unloading at this cant deficiency."),
    ] = None,
    twist: Annotated[
        float | None, typer.Option(metavar="PERMILLE", min=0.01, max=20.0, help="Wheel loads on track of this twist.")
    ] = None,
    twist_test: Annotated[
        bool, typer.Option("--twist-test", help="Wheel unloading on twisted track, there and back (EN 14363).")
    ] = False,
    twists: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="BODY BOGIE", help="Twists of that test in per mille; default: those of the standard."),
    ] = None,
    rotation_test: Annotated[
        bool, typer.Option("--rotation-test", help="Rotation resistance of its bogies: X factor (EN 14363).")
    ] = False,
    rotation_radius_m: Annotated[
        float, typer.Option(metavar="M", min=10.0, max=10_000.0, help="Radius of the curve of that test.")
    ] = 150.0,
    loops: Annotated[
        Path | None, typer.Option("--loops", metavar="PNG|SVG", help="Draw the loops of these two tests there.")
    ] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Print mass, centre, static wheel loads, natural modes and stationary tests of a vehicle; draw it."""
    from wrsim.report.output_folder import writing

    with reporting_errors(as_json), writing(force):
        from wrsim.analysis.stationary import at_rest
        from wrsim.scenario.vehicle_build import vehicle_model

        check_ending("-o", output, ".png", ".svg")
        check_ending("--loops", loops, ".png", ".svg")
        if twists is not None and not twist_test:
            raise InputError("--twists belongs to --twist-test")
        if loops is not None and not (twist_test or rotation_test):
            raise InputError("--loops draws those of --twist-test and --rotation-test: ask for one of them")
        loaded = vehicle_model(file, models)
        if loaded.members and (cant_deficiency or twist or twist_test or rotation_test):
            raise InputError(f"{file}: is a train; tests at rest are for one vehicle: give the file of one of them")
        found = at_rest.numbers_at_rest(loaded, cant_deficiency, twist)
        twisted, turned = at_rest.stationary_tests(loaded, twist_test, twists, rotation_test, rotation_radius_m)
        found |= at_rest.numbers_of_tests(loaded, twisted, turned)
        if output is not None or loops is not None:
            from wrsim.report.outputs import draw_loops, draw_model

            found |= {"picture": str(draw_model("vehicle", output, loaded))} if output else {}
            found |= {"loops": str(draw_loops(loaded, twisted, turned, loops))} if loops else {}
        print_numbers(as_json, found, at_rest.tables_at_rest(found))
        if not as_json:
            print_lines(*(found[key] for key in ("picture", "loops") if key in found))
