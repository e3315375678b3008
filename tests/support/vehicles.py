"""Whole vehicles on track, ready to be asked for forces, states and motions."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from support.runs import FAST, arc, straight, transition
from wrsim import Result, Straight, Track, Vehicle, contact_model, load, load_vehicle, run
from wrsim.inputs.lookup import Finder, shipped_models
from wrsim.scenario.build import Setup, build
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import BodySystem
from wrsim.track.segments import Segment
from wrsim.track.track import RailElasticity
from wrsim.vehicle.loads import Drive
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

ROOT = Path(__file__).parents[2]
COARSE = FAST | {"contact.strips": 15, "contact.cells": 8}


def read_vehicle(path: Path) -> Vehicle:
    """The vehicle of a file; models are the shipped ones and those beside it."""
    return load_vehicle(path, Finder((shipped_models(),)))


@cache
def shipped(name: str) -> Vehicle:
    """A shipped vehicle."""
    return read_vehicle(ROOT / f"models/vehicles/{name}.toml")


def manchester() -> Vehicle:
    """The coach of most tests."""
    return shipped("manchester_1")


@cache
def coaches(count: int, model: str = "manchester_1") -> Vehicle:
    """A train of coaches of a shipped model, coupled as in the shipped train."""
    text = (ROOT / "models/trains/manchester_3.toml").read_text(encoding="utf-8")
    text = text.replace('model = "vehicles/manchester_1', f'model = "vehicles/{model}')
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "train.toml"
        path.write_text(text.replace("count = 3", f"count = {count}"), encoding="utf-8")
        return read_vehicle(path)


@cache
def rails_and_contact() -> Setup:
    """S1002 on 60E1 1:40 with a coarse patch."""
    return build(load(ROOT / "scenarios/curve_r300.toml").with_values(COARSE))


@dataclass(frozen=True)
class Train:
    """A vehicle on its track."""

    law: VehicleOnTrack

    @property
    def system(self) -> BodySystem:
        """A new Exudyn system of it."""
        return BodySystem(self.law.bodies, self.law)


def on_track(
    vehicle: Vehicle,
    speed: float = 0.0,
    segments: Sequence[Segment] = (Straight(400.0),),
    start: float = 50.0,
    drive: Drive = "train",
    gravity: float = STANDARD_GRAVITY,
    heading: float = 0.0,
    structure: RailElasticity | None = None,
    threads: int = 1,
    stepped: bool = False,
) -> Train:
    """The vehicle on track of these segments, its origin at ``start`` [m]; speed [m/s]; rigid or elastic rails;
    stepped: for a Stepper."""
    setup = rails_and_contact()
    left, right = ((curve.outward, curve.height) for curve in (setup.track.left_curve, setup.track.right_curve))
    laid = {"cant_base": setup.track.cant_base, "heading": heading, "structure": structure}
    track = Track.build(segments, setup.track.nominal_gauge, left_offset=left, right_offset=right, **laid)
    contacts = []
    for mounted in vehicle.wheelsets:
        wheels = (mounted.wheelset.left, mounted.wheelset.right)
        models = [
            contact_model(wheel.profile, rail, wheel.radius, setup.contact, friction)
            for wheel, rail, friction in zip(wheels, setup.rails, setup.contact.friction, strict=True)
        ]
        contacts.append((models[0], models[1]))
    going = {"speed": speed, "start": start, "drive": drive, "gravity": gravity, "threads": threads}
    return Train(VehicleOnTrack(vehicle, track, contacts, **going, stepped=stepped))


SHORT = {"track.segments": [straight(22.0), transition(12.0), arc(14.0, 300.0, 60.0)]}
SHORT |= FAST | {"run.start_distance_m": 12.0, "run.output_interval_ms": 20.0}


@cache
def into_the_curve() -> Result:
    """The shipped vehicle from straight track into a curve."""
    return run(load(ROOT / "scenarios/manchester_r300.toml").with_values(SHORT))
