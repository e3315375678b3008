"""The vehicle of a scenario: its file with what the scenario changes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from wrsim.geometry.profile.models import load_profile
from wrsim.scenario.loading import Scenario
from wrsim.vehicle.files import with_wheel
from wrsim.vehicle.vehicle import CarriedMass, Vehicle
from wrsim.vehicle.vehicle_files import load_vehicle

SIDES = ("left", "right")


def vehicle_of(scenario: Scenario, files: list[Path]) -> Vehicle:
    """The vehicle with what the scenario changes. ``files`` gains what was read. Raises InputError."""
    section = scenario.spec.vehicle
    file = scenario.find(("vehicle", "model"), section.model)
    files.append(file)
    with scenario.naming(("vehicle", "model")):
        vehicle = load_vehicle(file, scenario.finder)
    for side in SIDES:
        (key, name), (_, radius) = section.of_side("wheel", side), section.of_side("radius_mm", side)
        profile = None
        if name is not None:
            files.append(scenario.find(("vehicle", key), name))
            with scenario.naming(("vehicle", key)):
                profile = load_profile(files[-1], "wheel")
        radius = radius / 1000.0 if radius else None
        vehicle = vehicle.with_wheelsets(partial(with_wheel, side=side, profile=profile, radius=radius))
    if section.sprung_mass_kg is not None:
        if vehicle.bodies or len(vehicle.wheelsets) > 1:
            message = "is what a single wheelset carries; the masses of a vehicle with bodies stand in its file"
            raise scenario.fault(("vehicle", "sprung_mass_kg"), message)
        height = vehicle.carried[0].height if vehicle.carried else 0.0
        carried = CarriedMass(vehicle.wheelsets[0].name, section.sprung_mass_kg, height)
        vehicle = replace(vehicle, carried=(carried,))
    return vehicle
