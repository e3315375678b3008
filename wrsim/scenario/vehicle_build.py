"""The vehicle of a scenario: its file with what the scenario changes."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from operator import methodcaller
from pathlib import Path
from typing import Any

from wrsim.contact.profiles.models import changed_profile, load_profile
from wrsim.errors import InputError, suggest
from wrsim.inputs.changes import full_path, key_path
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.lookup import model_file, usual_finder
from wrsim.inputs.section import SIDES
from wrsim.scenario.loading import Scenario, own_path
from wrsim.scenario.merging import value_at
from wrsim.vehicle.assembly import Assembly, Place
from wrsim.vehicle.loads import CarriedMass, Effort, SlipControl
from wrsim.vehicle.out_of_round import parts_of
from wrsim.vehicle.preload import preloads, with_ballast
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.vehicle_files import Change, changed_tables, load_vehicle


def vehicle_model(name: str, models: Sequence[str | Path] | None) -> Vehicle:
    """A vehicle by the name of its file, looked up here and among the models. Raises InputError."""
    return load_vehicle(model_file(name, models), usual_finder(models))


def _changes_of(scenario: Scenario) -> list[Change]:
    return [
        Change(key, value, scenario.merged.owners.get(path := ("vehicle", "changes", key)) or scenario.locate(path))
        for key, value in scenario.spec.vehicle.changes.items()
    ]


def vehicle_tables(scenario: Scenario) -> dict[str, Any]:
    """The tables of the vehicle's file with what the scenario changes in it. Raises InputError."""
    reader = partial(changed_tables, changes=_changes_of(scenario))
    return scenario.read(("vehicle", "model"), scenario.spec.vehicle.model, reader)[0]


def wheel_tables(scenario: Scenario) -> dict[str, Any]:
    """The tables of the file of ``vehicle.wheel`` with what the scenario changes in it. Raises InputError."""
    section = scenario.spec.vehicle
    reader = partial(changed_profile, changes=section.wheel_changes)
    return scenario.read(("vehicle", "wheel"), str(section.wheel), reader)[0]


def given_value(scenario: Scenario, key: str) -> Any:
    """The value of a dotted key, in the scenario or in the vehicle's file; None where neither gives it."""
    path, tables = own_path(key), scenario.merged.data
    by_name = path[:2] == ("vehicle", "changes") and len(path) == 3
    if by_name:
        path, tables = key_path(str(path[2])), vehicle_tables(scenario)
    elif path[:2] == ("vehicle", "wheel_changes") and len(path) == 3 and scenario.spec.vehicle.wheel:
        path, tables = key_path(str(path[2])), wheel_tables(scenario)
    try:
        return value_at(tables, full_path(tables, path, by_name=by_name))
    except (InputError, LookupError, TypeError):
        return None


def vehicle_of(scenario: Scenario) -> Vehicle:
    """The vehicle with what the scenario changes. Raises InputError."""
    section = scenario.spec.vehicle
    vehicle = scenario.read(
        ("vehicle", "model"),
        section.model,
        partial(load_vehicle, find=scenario.finder, changes=_changes_of(scenario)),
    )
    for side in SIDES:
        (key, name), (_, radius) = section.of_side("wheel", side), section.of_side("radius_mm", side)
        profile = None
        if name is not None:
            back = vehicle.wheelsets[0].wheelset.back
            reader = partial(load_profile, kind="wheel", back=back, changes=section.wheel_changes)
            profile = scenario.read(("vehicle", key), name, reader)
        radius = radius / 1000.0 if radius else None
        with scenario.faults_at(("vehicle", key)):
            vehicle = vehicle.with_wheelsets(methodcaller("with_wheel", side, profile, radius))
    vehicle = _out_of_round(scenario, vehicle)
    if section.sprung_mass_kg is not None:
        if vehicle.bodies or len(vehicle.wheelsets) > 1:
            message = "is what a single wheelset carries; the masses of a vehicle with bodies are in its file"
            raise scenario.fault(("vehicle", "sprung_mass_kg"), message)
        height = vehicle.carried[0].height if vehicle.carried else 0.0
        carried = CarriedMass(vehicle.wheelsets[0].name, section.sprung_mass_kg, height)
        vehicle = replace(vehicle, carried=(carried,))
    return _in_wind(scenario, _with_efforts(scenario, _with_loads(scenario, vehicle)))


def _in_wind(scenario: Scenario, vehicle: Vehicle) -> Vehicle:
    """The vehicle with the loads of the wind along the track of its run."""
    wind, speed = scenario.spec.vehicle.wind, scenario.spec.vehicle.speed_kmh
    if wind is None:
        return vehicle
    if not vehicle.bodies or not isinstance(speed, float):
        message = "needs a vehicle with bodies and one speed_kmh, from which the angle of the air follows"
        raise scenario.fault(("vehicle", "wind"), message)
    places, left = (wind.begins_m, wind.peak_m), 1.0 if wind.towards == "left" else -1.0
    return wind.air().along_track(vehicle, wind.speed_m_s, *places, wind.gust is not None, speed / 3.6, left=left)


def _out_of_round(scenario: Scenario, vehicle: Vehicle) -> Vehicle:
    """The vehicle with wheels out of round as the scenario has it."""
    tables, names = scenario.spec.vehicle.out_of_round, [mounted.name for mounted in vehicle.wheelsets]
    for i, table in enumerate(tables):
        for name in table.on:
            _check_wheelset(scenario, ("vehicle", "out_of_round", i, "on"), name, names)
    if not tables:
        return vehicle

    def fault(place: KeyPath, message: str) -> InputError:
        return scenario.fault(("vehicle", "out_of_round", *place), message)

    wheelsets = []
    for mounted in vehicle.wheelsets:
        matching = [(i, table) for i, table in enumerate(tables) if not table.on or mounted.name in table.on]
        wheelset = mounted.wheelset
        for side in SIDES:
            wheel = getattr(wheelset, side)
            parts = parts_of(matching, side, wheel, scenario.finder.find, fault)
            wheelset = replace(wheelset, **{side: replace(wheel, out_of_round=parts)})
        wheelsets.append(replace(mounted, wheelset=wheelset))
    return replace(vehicle, wheelsets=tuple(wheelsets))


def _check_wheelset(scenario: Scenario, key: KeyPath, name: str, names: Sequence[str]) -> None:
    if name not in names:
        message = f"'{name}' is no wheelset; there is {', '.join(names)}{suggest(name, names)}"
        raise scenario.fault(key, message)


def _with_efforts(scenario: Scenario, vehicle: Vehicle) -> Vehicle:
    section, names = scenario.spec.vehicle, tuple(mounted.name for mounted in vehicle.wheelsets)
    efforts: list[Effort] = []
    for i, table in enumerate(section.efforts):
        for name in table.on or names:
            _check_wheelset(scenario, ("vehicle", "efforts", i, "on"), name, names)
            if table.wheel != "both" and vehicle.wheelsets[names.index(name)].wheelset.torsion is None:
                reason = f"is for wheels that turn on their own; those of '{name}' sit on a rigid axle"
                raise scenario.fault(("vehicle", "efforts", i, "wheel"), reason)
            efforts.append(table.effort(name))
    if section.brakes is not None:
        if vehicle.brakes is None:
            raise scenario.fault(("vehicle", "brakes"), "goes with the brake pipe of a train, [brakes] in its file")
        vehicle = replace(vehicle, brakes=replace(vehicle.brakes, steps=section.brakes.time_s_share))
        efforts += vehicle.braked_wheelsets
    control = section.slip_control
    if control is not None and any(effort.wheel != "both" for effort in efforts):
        message = "looks at axles: it cannot be combined with efforts on single wheels"
        raise scenario.fault(("vehicle", "slip_control"), message)
    limit = None if control is None else SlipControl(control.slip_kmh / 3.6, control.creepage)
    return replace(vehicle, efforts=tuple(efforts), slip_control=limit)


def _with_loads(scenario: Scenario, vehicle: Vehicle) -> Vehicle:
    """The vehicle with the loads and payloads of the scenario as well."""
    bodies = {body.name: body for body in vehicle.bodies}
    wheelsets = {mounted.name: mounted for mounted in vehicle.wheelsets}
    added = Assembly({}, {}, scenario.locate, bodies=bodies, wheelsets=wheelsets)
    added.add_loads(scenario.spec.vehicle, ("vehicle",), Place())
    for i, load in enumerate(added.loads):
        if load.name in (earlier.name for earlier in (*vehicle.loads, *added.loads[:i])):
            raise scenario.fault(("vehicle", "loads", i, "name"), "is the name of another load")
    with scenario.faults_at(("vehicle", "payloads")):
        vehicle = with_ballast(vehicle, added.ballast)
        loads, payloads = (*vehicle.loads, *added.loads), (*vehicle.payloads, *added.payloads)
        vehicle = replace(vehicle, loads=loads, payloads=payloads)
        if added.ballast or added.payloads:  # else its file has been checked
            preloads(vehicle)
    return vehicle
