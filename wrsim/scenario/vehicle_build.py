"""The vehicle of a scenario: its file with what the scenario changes; a lone wheelset or a whole vehicle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.profile import Profile
from wrsim.scenario.loading import Scenario
from wrsim.vehicle.files import with_wheel
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.vehicle_files import load_any
from wrsim.vehicle.wheelset import SprungMass, Wheelset

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")


def vehicle_of(scenario: Scenario, files: list[Path]) -> tuple[Wheelset, Vehicle | None]:
    """The lone wheelset, or the first wheelset of the whole vehicle and the vehicle. ``files`` gains what was read.

    Raises InputError.
    """
    section = scenario.spec.vehicle
    file = scenario.find(("vehicle", "model"), section.model)
    files.append(file)
    model = load_any(file, scenario.finder)
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

    if isinstance(model, Vehicle):
        if section.sprung_mass_kg is not None:
            message = "is for a lone wheelset; the masses of a whole vehicle stand in its file"
            raise scenario.fault(("vehicle", "sprung_mass_kg"), message)
        model = model.with_wheelsets(changed)
        return model.wheelsets[0].wheelset, model
    if section.drive is not None:
        message = "is for whole vehicles; a lone wheelset runs in a frame of constant speed"
        raise scenario.fault(("vehicle", "drive"), message)
    wheelset = changed(model)
    if section.sprung_mass_kg is not None:
        wheelset = replace(wheelset, sprung=SprungMass(section.sprung_mass_kg, wheelset.sprung.height))
    return wheelset, None
