"""``wrsim vehicle``: mass, wheel loads and modes of a vehicle, and what it looks like."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, check_ending
from wrsim.cli.showing import print_json, print_tables, say
from wrsim.cli.storing import writing
from wrsim.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wrsim.analysis.stationary.rotation_test import RotationTest
    from wrsim.analysis.stationary.twist_test import TwistTest
    from wrsim.plots.vehicle import VehicleSketch
    from wrsim.vehicle.vehicle import Vehicle


def vehicle(
    file: Annotated[str, typer.Argument(metavar="FILE", help="Vehicle file, such as vehicles/manchester_1.toml.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="PNG|SVG", help="Draw it there, from three sides.")
    ] = None,
    cant_deficiency: Annotated[
        float | None,
        typer.Option("--cant-deficiency", metavar="MM", min=1.0, max=400.0, help="How it leans with so much of it."),
    ] = None,
    twist: Annotated[
        float | None,
        typer.Option("--twist", metavar="PERMILLE", min=0.01, max=20.0, help="Its wheel loads on so twisted a track."),
    ] = None,
    twist_test: Annotated[
        bool, typer.Option("--twist-test", help="Unloading of its wheels on twisted track, there and back (EN 14363).")
    ] = False,
    twists: Annotated[
        tuple[float, float] | None,
        typer.Option(
            metavar="BODY BOGIE", help="Twists of that test in per mille; those of the standard unless given."
        ),
    ] = None,
    rotation_test: Annotated[
        bool, typer.Option("--rotation-test", help="Resistance of its bogies against rotation: X factor (EN 14363).")
    ] = False,
    rotation_radius_m: Annotated[
        float, typer.Option(metavar="M", min=10.0, max=10_000.0, help="Of the curve that this test turns to.")
    ] = 150.0,
    loops: Annotated[
        Path | None, typer.Option("--loops", metavar="PNG|SVG", help="Draw the loops of these two tests there.")
    ] = None,
    models: Models = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Print mass, centre, static wheel loads and natural modes of a vehicle; draw it.

    With --cant-deficiency, --twist, --twist-test and --rotation-test also what an acceptance measures on it standing
    still: sway, wheel unloading and the resistance of its bogies against rotation.
    """
    with reporting_errors(as_json), writing(force):
        from wrsim.analysis.stationary import at_rest
        from wrsim.inputs.lookup import model_file, usual_finder
        from wrsim.vehicle.vehicle_files import load_vehicle

        check_ending("-o", output, ".png", ".svg")
        loaded = load_vehicle(model_file(file, models), usual_finder(models))
        check_ending("--loops", loops, ".png", ".svg")
        check_asked(twist_test, twists, rotation_test, loops)
        if loaded.members and (cant_deficiency or twist or twist_test or rotation_test):
            raise InputError(f"{file}: is a train; tests at rest are for one vehicle: give the file of one of them")
        found = at_rest.facts_at_rest(loaded, cant_deficiency, twist)
        twisted = at_rest.twist_loop(loaded, twists) if twist_test else None
        turned = at_rest.rotation_loops(loaded, rotation_radius_m) if rotation_test else ()
        if twisted is not None:
            found["twist_test"] = at_rest.twist_facts(loaded, twisted)
        if turned:
            found["rotation_test"] = at_rest.rotation_facts(turned)
        if output is not None:
            from wrsim.plots.vehicle import vehicle_picture

            found["picture"] = str(vehicle_picture(sketch_of(loaded), output))
        if loops is not None:
            found["loops"] = str(loops_picture(loaded, twisted, turned, loops))
        if as_json:
            print_json(found)
        else:
            print_tables(at_rest.tables_at_rest(found))
            for key in ("picture", "loops"):
                if key in found:
                    say(found[key])


def check_asked(twist_test: bool, twists: tuple[float, float] | None, rotation_test: bool, loops: Path | None) -> None:
    """Raise InputError for options without the test that they belong to, and for twists beyond all tracks."""
    from wrsim.errors import InputError

    if twists is not None and not twist_test:
        raise InputError("--twists belongs to --twist-test")
    if loops is not None and not (twist_test or rotation_test):
        raise InputError("--loops draws those of --twist-test and --rotation-test: ask for one of them")
    for twist in twists or ():
        if not 0.0 <= twist <= 20.0:
            raise InputError(f"--twists {twist:g}: must be from 0 to 20 per mille")


def loops_picture(vehicle: Vehicle, twisted: TwistTest | None, turned: Sequence[RotationTest], path: Path) -> Path:
    """Draw the loops of the tests."""
    from math import degrees

    from wrsim.plots import save
    from wrsim.plots.stationary import Loop, loops_figure

    found = []
    if twisted is not None:
        wheels = [
            (f"{m.name} {side}", 1e-3 * twisted.wheel_loads[:, i, k])
            for i, m in enumerate(vehicle.wheelsets[: (len(vehicle.wheelsets) + 1) // 2])
            for k, side in enumerate(("left", "right"))
        ]
        found.append(Loop("part of the full twists", "wheel load Q [kN]", [(n, twisted.part, q) for n, q in wheels]))
    if turned:
        first = turned[0].bogie
        lines = [
            (f"{degrees(test.rate):g} deg/s", [degrees(a) for a in test.angle], 1e-3 * test.moment)
            for test in turned
            if test.bogie == first
        ]
        found.append(Loop(f"angle of {first.frame} [deg]", "moment [kNm]", lines))
    return save(loops_figure(vehicle.name, found), path)


def sketch_of(vehicle: Vehicle) -> VehicleSketch:
    """The vehicle as a drawing takes it; bodies become the boxes of equal mass and inertia."""
    from wrsim.plots.vehicle import BoxSketch, ElementSketch, VehicleSketch, WheelSketch
    from wrsim.vehicle.couplings import GLYPHS
    from wrsim.vehicle.elements import KINDS

    wheels = [
        WheelSketch((mounted.x, side * 0.5 * mounted.wheelset.profile_spacing, mounted.height), wheel.radius)
        for mounted in vehicle.wheelsets
        for side, wheel in ((1.0, mounted.wheelset.left), (-1.0, mounted.wheelset.right))
    ]
    known = {kind: table.glyph for kind, table in KINDS.items()} | GLYPHS
    glyphs = [(element, known[element.kind]) for element in vehicle.elements]
    elements = [ElementSketch(element.kind, element.points, *glyph) for element, glyph in glyphs if glyph is not None]
    points = [point.at for point in vehicle.points]
    boxes = [BoxSketch(body.name, body.centre, body.box) for body in vehicle.bodies]
    return VehicleSketch(vehicle.name, boxes, wheels, elements, points)
