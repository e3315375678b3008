"""``wrsim assess``, ``ride``, ``conicity``, ``vehicle``: a run by EN 14363, comfort, profiles, vehicles at rest."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.console import print_error, print_found, print_lines, print_numbers
from wrsim.cli.errors import writing_files
from wrsim.cli.options import (
    PICTURES,
    BesideResult,
    Force,
    Json,
    Models,
    Pictures,
    ResultFile,
    SectionsOf,
    check_ending,
    into,
)
from wrsim.errors import InputError


def assess_command(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="Runs: files, folders, cut off or not. Several count as one test."),
    ],
    output: BesideResult = None,
    scenario: SectionsOf = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Assess a run: EN 14363 quantities section by section, limits and margins; writes tables and pictures.

    Sections of several runs of one vehicle count together; they need a folder to write to (-o).
    """
    with writing_files(as_json, force, *results[1:], of=results[0]):
        from wrsim.analysis.assessment import assess as assessed
        from wrsim.report.output_folder import folder_of_result, names_apart, naming, read
        from wrsim.report.outputs import write_assessment
        from wrsim.results.assessment import assessment_dict, assessment_numbers
        from wrsim.scenario.loading import load
        from wrsim.scenario.sections.assessment import AssessmentSection

        names = names_apart(results, output)
        settings = None if scenario is None else load(scenario).table(AssessmentSection).settings()
        loaded = [read(path) for path in results]
        with naming(*results):
            found = assessed(loaded, settings, names)
        directory = output or folder_of_result(results[0])
        files = write_assessment(found, directory, pictures)
        print_found(as_json, assessment_dict(found), assessment_numbers(found), files, directory)


def ride(
    result: ResultFile,
    output: BesideResult = None,
    scenario: SectionsOf = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Ride: accelerations at the points of a vehicle, their spectra, third-octaves and comfort."""
    with writing_files(as_json, force, of=result):
        from wrsim.analysis.ride import evaluate_ride
        from wrsim.report.output_folder import folder_of_result, naming, read
        from wrsim.report.outputs import write_ride
        from wrsim.scenario.loading import load
        from wrsim.scenario.sections.run import RideSection

        loaded, section = read(result), None if scenario is None else load(scenario).table(RideSection)
        with naming(result):
            found = evaluate_ride(loaded, section)
        directory = output or folder_of_result(result)
        files = write_ride(found, directory, pictures)
        print_found(as_json, found.as_dict(), [found.table()], files, directory)


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
    roll: Annotated[str, typer.Option(help="none (EN 15302), rail-top or centre: see docs/user/conicity.md.")] = "none",
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
    with writing_files(as_json, force):
        from wrsim.analysis.conicity.pairs import Pairing
        from wrsim.report.outputs import write_conicity, write_conicity_map
        from wrsim.results.conicity import conicity_numbers
        from wrsim.results.table import as_records

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
            tables, numbers = found.numbers(), {"title": found.title, **conicity_numbers(found.wheelset())}
            files = write_conicity(found, output, pictures) if output else []
        print_found(as_json, numbers, tables, files)


def vehicle(
    file: Annotated[str, typer.Argument(metavar="FILE", help="Vehicle file, such as vehicles/manchester_1.toml.")],
    output: Annotated[Path | None, into(metavar="PNG|SVG|PDF", help="Draw it there, from three sides.")] = None,
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
        Path | None, typer.Option("--loops", metavar="PNG|SVG|PDF", help="Draw the loops of these two tests there.")
    ] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Print mass, centre, static wheel loads, natural modes and stationary tests of a vehicle; draw it."""
    with writing_files(as_json, force):
        from wrsim.analysis.stationary import at_rest
        from wrsim.scenario.plausibility import vehicle_warnings
        from wrsim.scenario.vehicle_build import vehicle_model

        check_ending("-o", output, *PICTURES)
        check_ending("--loops", loops, *PICTURES)
        if twists is not None and not twist_test:
            raise InputError("--twists belongs to --twist-test")
        if loops is not None and not (twist_test or rotation_test):
            raise InputError("--loops draws those of --twist-test and --rotation-test: ask for one of them")
        loaded = vehicle_model(file, models)
        if loaded.members and (cant_deficiency or twist or twist_test or rotation_test):
            raise InputError(f"{file}: is a train; tests at rest are for one vehicle: give the file of one of them")
        warned = vehicle_warnings(loaded)
        for words in [] if as_json else warned:
            print_error(f"{file}: warning: {words}")
        found = at_rest.numbers_at_rest(loaded, cant_deficiency, twist)
        asked = twist_test, twists, rotation_test, rotation_radius_m
        found["warnings"] = warned
        tested, twisted, turned = at_rest.stationary_tests(loaded, *asked)
        found |= tested
        if output is not None or loops is not None:
            from wrsim.report.outputs import draw_loops, draw_model

            found |= {"picture": str(draw_model("vehicle", output, loaded))} if output else {}
            found |= {"loops": str(draw_loops(loaded, twisted, turned, loops))} if loops else {}
        print_numbers(as_json, found, at_rest.tables_at_rest(found))
        if not as_json:
            print_lines(*(found[key] for key in ("picture", "loops") if key in found))
