"""Steady analysis: the quasi-static equilibrium of a vehicle in many curves, found by Newton's method.

In a full curve nothing changes any more but the heading: the vehicle turns about the axis of the curve with poses held
(``dynamics.rigid_body``). Each is found as that at the start of a run. That it is stable, too, is not proved by it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.derailment import check_upright, contact_words, resultant, wheels_of
from wrsim.analysis.motion.messages import NoSteadyMotion, steady_words
from wrsim.analysis.motion.samples import stack_wheelsets
from wrsim.analysis.motion.start import start_state
from wrsim.analysis.progress import Progress, Report
from wrsim.contact.channels import contact_channels, remarks_channel
from wrsim.contact.patches import RawContacts
from wrsim.errors import SimulationError
from wrsim.results import Result, assemble
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.steady import SteadyPoint
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import poses_on_track
from wrsim.simulation.steady_state import SteadyMotion
from wrsim.simulation.system import Array
from wrsim.track.cant import cant_angle
from wrsim.track.segments import Arc
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

MARGIN = 20.0  # the arc goes on so far before and behind the vehicle [m]


def run_steady(setup: Setup, progress: Progress | None = None) -> Result:
    """Steady motion at every point of the scenario. Points without one carry a message; Ctrl-C keeps those solved.

    Raises SimulationError when no point has a steady motion.
    """
    vehicle, points, base = setup.vehicle, setup.plan.points, setup.track.cant_base
    count = len(vehicle.wheelsets)
    raw = [RawContacts.empty(len(points), 2, setup.contact.patch_count) for _ in range(count)]
    poses, left = np.full((len(points), count, 6), np.nan), np.full(len(points), np.nan)
    messages: list[str] = []
    remarks: list[str] = []
    known: list[CurveMotion] = []
    report = Report(progress)
    try:
        for i, point in enumerate(points):
            message = remark = ""
            try:
                motion = steady_in_curve(setup, point)
            except SimulationError as error:
                why = steady_words(NoSteadyMotion.of(error), vehicle)
                message = f"{why} (cant deficiency {1e3 * cant_deficiency(point, base):.0f} mm)"
                for contacts in raw:
                    contacts.clear(i)
            else:
                known.append(motion)
                left[i], remark = motion.left, contact_words(wheels_of(motion.law))
                _store(i, motion, raw, poses)
            messages.append(message)
            remarks.append(remark)
            report(len(messages) / len(points))
    except KeyboardInterrupt:
        if not messages:
            raise
    n = len(messages)
    if not known:
        raise SimulationError(f"none of the {n} curves has a steady motion; the first: {messages[0]}")
    _, lateral, height, yaw, roll, spin = np.moveaxis(poses[:n], 2, 0)
    wheels = known[-1].law.wheels
    of_wheelsets = [contact_channels(contacts.first(n), pair) for contacts, pair in zip(raw, wheels, strict=True)]
    channels: dict[str, Any] = {
        **{f"pose_{name}": np.array([getattr(p, name) for p in points[:n]]) for name in ("speed", "radius", "cant")},
        "cant_deficiency": [cant_deficiency(p, base) for p in points[:n]],
        "unbalanced": left[:n],
        "pose_message": np.array(messages),
        **remarks_channel(remarks),
        "lateral_shift": lateral,
        "vertical_shift": height - [m.wheelset.mean_radius for m in vehicle.wheelsets],
        "yaw": yaw,
        "roll": roll,
        "spin_rate": spin,
        **stack_wheelsets(of_wheelsets),
    }
    reason = f"interrupted by the user after {n} of {len(points)} curves" if n < len(points) else ""
    coords: dict[str, Any] = {"pose": [p.name for p in points[:n]], "wheelset": [m.name for m in vehicle.wheelsets]}
    return Result(assemble(coords, channels, setup.attributes(reason)))


def _store(i: int, motion: CurveMotion, raw: list[RawContacts], poses: Array) -> None:
    """Keep contacts and poses of all wheelsets in row i."""
    law = motion.law
    for w, (pair, mounted) in enumerate(zip(law.wheels, law.vehicle.wheelsets, strict=True)):
        for j, wheel in enumerate(pair):
            raw[w].store(i, j, wheel.model.arrays)
        q, q_t = (state[None, 6 * w : 6 * w + 6] for state in (motion.q, motion.q_t))
        poses[i, w] = np.ravel(poses_on_track(law.track.centre, q, q_t, law.start + mounted.x))


@dataclass(frozen=True)
class CurveMotion:
    """A vehicle in steady motion in a curve: its law and its state; left: largest force left over, part of weight."""

    law: VehicleOnTrack
    q: Array
    q_t: Array
    left: float


def cant_deficiency(point: SteadyPoint, base: float) -> float:
    """Cant that is missing for balance [m]; base: distance that cant is measured over [m]."""
    return base * point.speed**2 / (STANDARD_GRAVITY * abs(point.radius)) - point.cant


def steady_in_curve(setup: Setup, point: SteadyPoint) -> CurveMotion:
    """The vehicle in steady motion in the middle of a long arc. Raises SimulationError when there is none."""
    base, curvature = setup.track.cant_base, 1.0 / point.radius
    tilt = float(np.copysign(cant_angle(point.cant, base), point.cant * curvature))
    check_upright(resultant(setup.vehicle, 0.0, curvature, tilt, point.speed), base, curvature, setup.vehicle)
    law = _law(setup, point)
    q, q_t = start_state(replace(setup, track=law.track, plan=RunPlan(law.start, law.start, point.speed)), law)
    return CurveMotion(law, q, q_t, SteadyMotion(law).largest(q, q_t))


def _law(setup: Setup, point: SteadyPoint) -> VehicleOnTrack:
    """The force law of the vehicle in the middle of a long arc."""
    places = [part.centre[0] for part in setup.vehicle.parts]
    before, behind = MARGIN - min(places), MARGIN + max(places)
    track = setup.track.relaid([Arc(before + behind, point.radius, point.cant)])
    return force_law(replace(setup, track=track, plan=RunPlan(before, before, point.speed)))
