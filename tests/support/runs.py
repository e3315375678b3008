"""Short runs of shipped wheelsets and of conical ones, with the full contact model in the loop."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from support.held import held_state
from wrsim import Arc, ContactSettings, Profile, Track, Vehicle, contact_model, load, load_profile
from wrsim.analysis.contacts import force_law
from wrsim.scenario.build import Setup, build
from wrsim.simulation.bodies import Solid
from wrsim.simulation.integrate import Integration, Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import TrackPoses, design_state, poses_on_track
from wrsim.simulation.steady_state import Equilibrium
from wrsim.simulation.step_size import SAFETY, round_step, stable_step
from wrsim.simulation.system import BodySystem
from wrsim.track.segments import Segment
from wrsim.vehicle.elements import Triple
from wrsim.vehicle.vehicle import single_wheelset
from wrsim.vehicle.wheelset import STANDARD_GRAVITY, Wheel, Wheelset

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[2]
SCENARIOS = ROOT / "scenarios"
STEERING = "vehicles/wheelset_s1002_steering.toml"
LEADING = "vehicles/wheelset_s1002_leading.toml"
FAST = {"contact.normal": "kik-piotrowski", "contact.tangential": "fastsim", "contact.strips": 12, "contact.cells": 6}
"""The fastest contact with creep forces, for laws of the motion that hold with any."""


def straight(length: float) -> dict[str, Any]:
    """A segment as in a scenario file."""
    return {"kind": "straight", "length_m": length}


def transition(length: float) -> dict[str, Any]:
    """A segment as in a scenario file."""
    return {"kind": "transition", "length_m": length}


def arc(length: float, radius: float, cant_mm: float = 0.0, widening_mm: float = 0.0) -> dict[str, Any]:
    """A segment as in a scenario file."""
    return {"kind": "arc", "length_m": length, "radius_m": radius, "cant_mm": cant_mm, "gauge_widening_mm": widening_mm}


def setup_of(
    segments: Sequence[Mapping[str, Any]],
    speed: float,
    vehicle: str = STEERING,
    start: float = 0.0,
    values: Mapping[str, Any] | None = None,
) -> Setup:
    """A run of an S1002 wheelset on 60E1 1:40 along the given track; speed [m/s]; values: further keys."""
    keys = {"vehicle.model": vehicle, "vehicle.speed_kmh": 3.6 * speed, "track.segments": list(segments)}
    keys |= {"output.patches_at_m": [start], "run.start_distance_m": start}
    return build(load(SCENARIOS / "curve_r300.toml").with_values(keys | dict(values or {})))


def relaid(setup: Setup, heading: float = 0.0, start: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Setup:
    """The same run on the same track, laid in another direction from another point."""
    return _on(setup, setup.track.segments, heading, start)


def mirrored(setup: Setup) -> Setup:
    """The same run on the mirrored track."""
    turned = [replace(s, radius=-s.radius) if isinstance(s, Arc) else s for s in setup.track.segments]
    return _on(setup, turned, 0.0, (0.0, 0.0, 0.0))


def _on(setup: Setup, segments: Sequence[Segment], heading: float, start: tuple[float, float, float]) -> Setup:
    track = setup.track
    offsets = [(c.outward, c.height) for c in (track.left_curve, track.right_curve)]
    sides = {"left_offset": offsets[0], "right_offset": offsets[1], "cant_base": track.cant_base}
    return replace(setup, track=Track.build(segments, track.nominal_gauge, heading=heading, start=start, **sides))


RADIUS = 0.46
CONICITY = 0.05
CROWN = 0.3
HALF_TOPS = 0.75  # from the centre line to the tops of the rails
HALF_CONTACTS = HALF_TOPS - CROWN * CONICITY  # to the contacts of the centred wheelset: on the inner side of the tops
AXLE_LOAD = 100e3


@cache
def cone() -> Profile:
    """The shipped conical wheel 1:20, without flange."""
    return load_profile(ROOT / "models/wheels/cone_1in20.toml")


@cache
def crown() -> Profile:
    """The shipped rail of one arc of 300 mm."""
    return load_profile(ROOT / "models/rails/crown_300.toml")


@dataclass(frozen=True)
class Ride:
    """A wheelset on its track, ready to be placed and run."""

    law: VehicleOnTrack

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle, of one wheelset."""
        return self.law.vehicle

    @property
    def track(self) -> Track:
        """Its track."""
        return self.law.track

    @property
    def body(self) -> Solid:
        """The rigid body of the wheelset."""
        return Solid.of_wheelset(self.vehicle.wheelsets[0].wheelset)

    @property
    def system(self) -> BodySystem:
        """A new Exudyn system of it."""
        return BodySystem(self.law.bodies, self.law)

    def steady(self, unknowns: Sequence[str], lateral: float = 0.0, equations: Sequence[str] = ()) -> Equilibrium:
        """The steady motion at the start, found from a pose at a lateral shift [m]."""
        q, q_t = design_state(self.law, lateral=lateral)
        return held_state(self.law, q, q_t, unknowns, equations)

    def run(self, q: Array, q_t: Array, duration: float, step: float | None = None, every: float = 5e-3) -> Motion:
        """Integrate from a state at the start; the step by default as an analysis chooses it."""
        system = self.system
        if step is None:
            step = round_step(SAFETY * stable_step(system, q, q_t))
        self.law.set_search_start(self.law.start)
        motion = Integration(system, duration=duration, step=step, integrator="rk44", sample_interval=every).run(q, q_t)
        assert motion.status == "completed", motion.reason
        return motion

    def poses(self, motion: Motion) -> TrackPoses:
        """Poses of a motion against the track."""
        return poses_on_track(self.track.centre, motion.q, motion.q_t, self.law.start)


def ride(setup: Setup) -> Ride:
    """The wheelset of a set-up on its track."""
    return Ride(force_law(setup))


def cone_ride(
    segments: Sequence[Segment],
    speed: float,
    *,
    start: float = 1.0,
    stiffness: Triple = (0.0, 0.0, 0.0),
    mass: float = 1813.0,
    settings: ContactSettings | None = None,
) -> Ride:
    """A conical wheelset (Manchester mass and inertia, 100 kN) on crowned rails, by default without suspension."""
    wheel = Wheel(cone(), RADIUS)
    wheelset = Wheelset("conical", mass, (1120.0, 112.0, 1120.0), 2.0 * HALF_TOPS, wheel, wheel)
    carried = AXLE_LOAD / STANDARD_GRAVITY - mass
    vehicle = single_wheelset(wheelset, stiffness=stiffness, carried_mass=carried)
    track = Track.build(segments, 2.0 * HALF_TOPS)
    settings = settings or ContactSettings()
    models = [contact_model(cone(), crown(), RADIUS, settings, 0.35) for _ in range(2)]
    return Ride(VehicleOnTrack(vehicle, track, [(models[0], models[1])], speed=speed, start=start))
