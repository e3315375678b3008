"""``wrsim vehicle``: mass, wheel loads and modes of a vehicle, and what it looks like."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, check_ending
from wrsim.cli.showing import print_json, print_table, print_title, say
from wrsim.cli.standing import (
    check_asked,
    leaning_facts,
    loops_picture,
    print_standing,
    rotation_facts,
    rotation_loops,
    twist_facts,
    twist_loop,
    twisted_facts,
    wheel_loads,
)
from wrsim.cli.storing import writing
from wrsim.errors import InputError

if TYPE_CHECKING:
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
        from wrsim.inputs.lookup import model_file, usual_finder
        from wrsim.vehicle.vehicle_files import load_vehicle

        check_ending("-o", output, ".png", ".svg")
        loaded = load_vehicle(model_file(file, models), usual_finder(models))
        check_ending("--loops", loops, ".png", ".svg")
        check_asked(twist_test, twists, rotation_test, loops)
        if loaded.members and (cant_deficiency or twist or twist_test or rotation_test):
            raise InputError(f"{file}: is a train; tests at rest are for one vehicle: give the file of one of them")
        found = facts_of(loaded, cant_deficiency, twist)
        twisted = twist_loop(loaded, twists) if twist_test else None
        turned = rotation_loops(loaded, rotation_radius_m) if rotation_test else ()
        if twisted is not None:
            found["twist_test"] = twist_facts(loaded, twisted)
        if turned:
            found["rotation_test"] = rotation_facts(turned)
        if output is not None:
            from wrsim.plots.vehicle import vehicle_picture

            found["picture"] = str(vehicle_picture(sketch_of(loaded), output))
        if loops is not None:
            found["loops"] = str(loops_picture(loaded, twisted, turned, loops))
        if as_json:
            print_json(found)
        else:
            _print(found)


def facts_of(vehicle: Vehicle, cant_deficiency: float | None = None, twist: float | None = None) -> dict[str, Any]:
    """What the command prints; cant_deficiency [mm], twist [per mille]: of the tests at rest, none unless given."""
    from wrsim.simulation.modes import natural_modes
    from wrsim.simulation.statics import standing

    trimmed = replace(vehicle, loads=())
    rest = standing(trimmed)
    facts = {
        "name": vehicle.name,
        "source": vehicle.source,
        "mass_kg": vehicle.mass,
        "centre_mm": [1e3 * float(c) for c in vehicle.centre],
        "bodies": [b.name for b in vehicle.bodies],
        "elements": len(vehicle.elements),
        **wheel_loads(vehicle, rest.wheel_loads),
        "modes": [
            {"frequency_Hz": mode.frequency, "damping": mode.damping, "motion": mode.name}
            for mode in natural_modes(trimmed)
        ],
    }
    if vehicle.loads:
        facts["under_loads"] = _under_loads(vehicle)
    if cant_deficiency is not None:
        facts["leaning"] = leaning_facts(trimmed, rest, cant_deficiency)
    if twist is not None:
        facts["twisted"] = twisted_facts(trimmed, rest, twist)
    return facts


def _under_loads(vehicle: Vehicle) -> dict[str, Any]:
    """How it stands under its loads; why not, where it does not."""
    from wrsim.errors import SimulationError
    from wrsim.simulation.statics import standing

    try:
        rest = standing(vehicle)
    except SimulationError as error:
        return {"problem": str(error)}
    stops = [
        {"name": e.name, "travel_mm": 1e3 * reading[e.travel_place], "force_kN": 1e-3 * reading[e.travel_place - 3]}
        for e, reading in zip(vehicle.elements, rest.readings.tolist(), strict=True)
        if e.limits and abs(reading[e.travel_place - 3]) > 0.0
    ]
    bodies = {
        body.name: {"lateral_mm": 1e3 * y, "vertical_mm": 1e3 * z, "roll_mrad": 1e3 * roll}
        for body, (y, z, roll) in zip(vehicle.bodies, rest.moved.tolist(), strict=True)
    }
    forces = {load.name: [1e-3 * f for f in load.largest] for load in vehicle.loads}
    return {"loads_kN": forces, **wheel_loads(vehicle, rest.wheel_loads), "bodies": bodies, "bump_stops": stops}


def _print(found: dict[str, Any]) -> None:
    print_title(found["name"])
    say(found["source"])
    x, y, z = (round(c, 3) + 0.0 for c in found["centre_mm"])
    say(f"mass {found['mass_kg']:.6g} kg, centre at x {x:g}, y {y:g}, z {z:g} mm")
    _print_wheel_loads(found, "static wheel loads")
    if "under_loads" in found:
        _print_under_loads(found["under_loads"])
    print_standing(found)
    modes = [[f"{m['frequency_Hz']:.3f}", f"{m['damping']:z.3f}", m["motion"]] for m in found["modes"]]
    if modes:
        title = "modes on its springs, wheelsets held"
        print_table(("Hz", "damping", "motion"), modes, title=title, left=("motion",))
    for key in ("picture", "loops"):
        if key in found:
            say(found[key])


def _print_wheel_loads(found: dict[str, Any], title: str) -> None:
    rows = [[name, f"{q['left']:.3f}", f"{q['right']:.3f}"] for name, q in found["wheel_loads_kN"].items()]
    rows.append(["together", f"{found['weight_kN']:.3f}", ""])
    print_table(("wheelset", "left kN", "right kN"), rows, title=title, left=("wheelset",))


def _print_under_loads(found: dict[str, Any]) -> None:
    if "problem" in found:
        say(found["problem"])
        return
    rows = [[name, *(f"{f:z.3f}" for f in force)] for name, force in found["loads_kN"].items()]
    print_table(("load", "x kN", "y kN", "z kN"), rows, title="loads, at their largest", left=("load",))
    _print_wheel_loads(found, "under the loads")
    rows = [
        [name, *(f"{moved[key]:z.2f}" for key in ("lateral_mm", "vertical_mm", "roll_mrad"))]
        for name, moved in found["bodies"].items()
    ]
    if rows:
        title = "bodies under the loads"
        print_table(("body", "lateral mm", "vertical mm", "roll mrad"), rows, title=title, left=("body",))
    stops = [[s["name"], f"{s['travel_mm']:.2f}", f"{s['force_kN']:.3f}"] for s in found["bump_stops"]]
    if stops:
        print_table(("bump stop", "travel mm", "force kN"), stops, title="bump stops in touch", left=("bump stop",))


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
