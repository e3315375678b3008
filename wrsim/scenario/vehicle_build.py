"""The vehicle of a scenario: its file with what the scenario changes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.profile import Profile
from wrsim.scenario.loading import Scenario
from wrsim.vehicle.files import with_wheel
from wrsim.vehicle.vehicle import CarriedMass, Vehicle
from wrsim.vehicle.vehicle_files import load_vehicle
from wrsim.vehicle.wheelset import Wheelset

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")


def vehicle_of(scenario: Scenario, files: list[Path]) -> Vehicle:
    """The vehicle with what the scenario changes. ``files`` gains what was read. Raises InputError."""
    section = scenario.spec.vehicle
    file = scenario.find(("vehicle", "model"), section.model)
    files.append(file)
    vehicle = load_vehicle(file, scenario.finder)
    new: dict[Side, tuple[Profile | None, float | None]] = {}
    for side in SIDES:
        own = section.wheel_left if side == "left" else section.wheel_right
        key, name = (f"wheel_{side}", own) if own is not None else ("wheel", section.wheel)
        profile = None
        if name is not None:
            files.append(scenario.find(("vehicle", key), name))
            profile = load_profile(files[-1], "wheel")
        radius = section.radius_left_mm if side == "left" else section.radius_right_mm
        radius = section.radius_mm if radius is None else radius
        new[side] = profile, None if radius is None else radius / 1000.0

    def changed(wheelset: Wheelset) -> Wheelset:
        for side in SIDES:
            wheelset = with_wheel(wheelset, side, *new[side])
        return wheelset

    vehicle = vehicle.with_wheelsets(changed)
    if section.sprung_mass_kg is not None:
        if vehicle.bodies or len(vehicle.wheelsets) > 1:
            message = "is what a single wheelset carries; the masses of a vehicle with bodies stand in its file"
            raise scenario.fault(("vehicle", "sprung_mass_kg"), message)
        height = vehicle.carried[0].height if vehicle.carried else 0.0
        carried = CarriedMass(vehicle.wheelsets[0].name, section.sprung_mass_kg, height)
        vehicle = replace(vehicle, carried=(carried,))
    return vehicle
