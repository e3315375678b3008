"""A vehicle at rest: masses, wheel loads, natural modes, stationary tests."""

from pathlib import Path
from typing import Annotated

from wrsim.api import options
from wrsim.api.options import Argument, Option, documented, into
from wrsim.api.outcome import Outcome
from wrsim.errors import InputError, SimulationError


@documented
def stationary(
    vehicle: Annotated[options.VehicleLike, Argument("Vehicle, such as vehicles/manchester_1.toml.", "FILE", kind=str)],
    *,
    cant_deficiency: Annotated[
        float | None, Option("Roll and unloading at this cant deficiency.", "MM", 1.0, 400.0)
    ] = None,
    twist: Annotated[float | None, Option("Wheel loads on track of this twist.", "PERMILLE", 0.01, 20.0)] = None,
    twist_test: Annotated[bool, Option("Wheel unloading on twisted track, there and back (EN 14363).")] = False,
    twists: Annotated[
        tuple[float, float] | None, Option("Twists of that test in per mille; default: of the standard.", "BODY BOGIE")
    ] = None,
    rotation_test: Annotated[bool, Option("Rotation resistance of the bogies: X factor (EN 14363).")] = False,
    rotation_radius_m: Annotated[float, Option("Radius of the curve of that test.", "M", 10.0, 10_000.0)] = 150.0,
    amplitude_mm: Annotated[
        float, Option("Travel at which dampers and friction are linearised.", least=1e-3, most=1000.0)
    ] = 1.0,
    frequency_Hz: Annotated[float, Option("Frequency of that travel.", least=0.01, most=1000.0)] = 1.0,
    picture: Annotated[Path | None, into("Drawing of the vehicle from three sides.", "PNG|SVG|PDF")] = None,
    loops: Annotated[Path | None, Option("Drawing of the loops of these two tests.", "PNG|SVG|PDF")] = None,
    campbell: Annotated[
        Path | None, Option("Drawing of the frequencies of elastic axles over the speed.", "PNG|SVG|PDF")
    ] = None,
    models: options.Models = (),
) -> Outcome:
    """Mass, centre, static wheel loads, natural modes and stationary tests of a vehicle; draws it.

    Returns
    -------
    Outcome
        With ``["warnings"]`` of implausible values.

    Raises
    ------
    InputError, SimulationError
        For a vehicle file that cannot be used, and for options that do not go together; for a vehicle that does not
        come to rest, with what of it is implausible.
    """
    from wrsim.analysis.stationary import at_rest
    from wrsim.scenario.plausibility import vehicle_warnings
    from wrsim.scenario.vehicle_build import vehicle_model
    from wrsim.vehicle.equivalent import Stroke

    if twists is not None and not twist_test:
        raise InputError("--twists belongs to --twist-test")
    if loops is not None and not (twist_test or rotation_test):
        raise InputError("--loops draws those of --twist-test and --rotation-test: ask for one of them")
    loaded = vehicle_model(vehicle, list(models)) if isinstance(vehicle, str) else vehicle
    if loaded.members and (cant_deficiency or twist or twist_test or rotation_test):
        raise InputError(f"{vehicle}: is a train; tests at rest are for one vehicle: give the file of one of them")
    doubts, stroke = vehicle_warnings(loaded), Stroke(amplitude_mm / 1e3, frequency_Hz)
    try:
        numbers = at_rest.numbers_at_rest(loaded, cant_deficiency, twist, stroke) | {"warnings": doubts}
    except SimulationError as error:  # what is implausible is most likely why
        raise SimulationError("\n".join((str(error), *doubts))) from None
    tested, twisted, turned = at_rest.stationary_tests(loaded, twist_test, twists, rotation_test, rotation_radius_m)
    numbers |= tested
    if campbell is not None and not numbers["axles"]:
        raise InputError("--campbell draws elastic axles: this vehicle has none; [wheelset.axle] gives them")
    drawn: dict[str, Path] = {}
    if picture is not None or loops is not None or campbell is not None:
        from wrsim.report.outputs import draw_loops, draw_model

        if picture is not None:
            drawn["picture"] = draw_model("vehicle", picture, loaded)
        if loops is not None:
            drawn["loops"] = draw_loops(loaded, twisted, turned, loops)
        if campbell is not None:
            drawn["campbell"] = draw_model("campbell", campbell, loaded.name, numbers["axles"])
    numbers |= {name: str(path) for name, path in drawn.items()}
    return Outcome(at_rest.tables_at_rest(numbers), numbers, list(drawn.values()), (twisted, turned))
