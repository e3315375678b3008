"""Steady analysis: the quasi-static equilibrium of a vehicle in many curves, found by Newton's method.

In a full curve nothing changes any more but the heading: the vehicle turns about the axis of the curve with poses held
(``core.body.rigid_body``). The search goes from curve to curve; only what it does not reach so is run in by
integration. That a motion found is stable, too, is not proved by it.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.derailment import check_upright, contact_words, resultant, wheels_of
from wrsim.analysis.motion.messages import NoSteadyMotion, steady_words
from wrsim.analysis.motion.result import stack_wheelsets
from wrsim.analysis.motion.start import enough, on_the_rails, start_state
from wrsim.analysis.progress import Progress, Report
from wrsim.contact.channels import contact_channels, remarks_channel
from wrsim.contact.patches import RawContacts
from wrsim.errors import SimulationError
from wrsim.geometry.track.segments import Arc
from wrsim.results import Result, assemble
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.steady import SteadyPoint
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import carried_over, poses_on_track
from wrsim.simulation.steady_state import Equilibrium, SteadyMotion, steady_state
from wrsim.simulation.system import Array
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

MARGIN = 20.0  # the arc goes on so far before and behind the vehicle [m]
ALMOST_STRAIGHT = 2e4  # radius of the curve that the way to others begins with [m]
SMALLEST_STEP = 1.0 / 32.0  # part of the way from curve to curve below which the search gives up
BALANCED, NEARLY = 1e-8, 1e-4  # forces left over, as parts of the weight: good; good enough not to look elsewhere

NUDGES = (1e-5, -1e-5, 1e-4, -1e-4, 5e-4, -5e-4)
"""Lateral shifts of the wheelsets from which the search begins again where it has got stuck beside a jump [m]."""

MOST_ITERATIONS = 15  # of Newton's method on the way


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
    known: list[Found] = []
    report = Report(progress)
    try:
        for i, point in enumerate(points):
            message = remark = ""
            try:
                found = steady_in_curve(setup, point, known)
                on_the_rails(found.law, Equilibrium(found.q, found.q_t, found.left))
            except SimulationError as error:
                why = steady_words(NoSteadyMotion.of(error), vehicle)
                message = f"{why} (cant deficiency {1e3 * cant_deficiency(point, base):.0f} mm)"
                for own in raw:
                    own.clear(i)
            else:
                known.append(found)
                left[i], remark = found.left, contact_words(wheels_of(found.law))
                _store(i, found, raw, poses)
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
    of_wheelsets = [contact_channels(own.first(n), pair) for own, pair in zip(raw, known[-1].law.wheels, strict=True)]
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


def _store(i: int, found: Found, raw: list[RawContacts], poses: Array) -> None:
    """Keep contacts and poses of all wheelsets in row i."""
    law = found.law
    for w, (pair, mounted) in enumerate(zip(law.wheels, law.vehicle.wheelsets, strict=True)):
        for j, wheel in enumerate(pair):
            raw[w].store(i, j, wheel.model.arrays)
        own = slice(6 * w, 6 * w + 6)
        poses[i, w] = np.ravel(
            poses_on_track(law.track.centre, found.q[None, own], found.q_t[None, own], law.start + mounted.x)
        )


@dataclass(frozen=True)
class Found:
    """A vehicle in steady motion in a curve: its law and its state; left: largest force left over, part of weight."""

    point: SteadyPoint
    law: VehicleOnTrack
    q: Array
    q_t: Array
    left: float


def cant_deficiency(point: SteadyPoint, base: float) -> float:
    """Cant that is missing for balance [m]; base: distance that cant is measured over [m]."""
    return base * point.speed**2 / (STANDARD_GRAVITY * abs(point.radius)) - point.cant


def steady_in_curve(setup: Setup, point: SteadyPoint, solved: Sequence[Found] = ()) -> Found:
    """The vehicle in steady motion in the middle of a long arc; solved: curves at hand to go on from.

    The way goes from the nearest curve of the same hand, or from one next to straight, to this one in steps that are
    halved where the search loses the motion; what it does not reach so is run in (``analysis.motion.start``).
    Raises SimulationError when there is no steady motion.
    """
    base, curvature = setup.track.cant_base, 1.0 / point.radius
    tilt = float(np.copysign(np.arcsin(point.cant / base), point.cant * curvature))
    acting = resultant(setup.vehicle, 0.0, curvature, tilt, point.speed)
    check_upright(acting, base, curvature, setup.vehicle)
    if any(mounted.wheelset.independent for mounted in setup.vehicle.wheelsets):
        return _from_design(setup, point)  # between flanges nothing leads from curve to curve
    same = [found for found in solved if found.point.radius * point.radius > 0.0]
    try:
        if same:
            near = min(same, key=lambda found: _apart(found.point, point))
        else:
            begin = replace(point, radius=float(np.copysign(ALMOST_STRAIGHT, point.radius)), cant=0.0)
            near = _from_design(setup, begin)
        found = _continued(setup, near, point)
    except SimulationError:
        return _from_design(setup, point)
    for nudge in NUDGES:
        if found.left <= BALANCED:
            break
        q = found.q.copy()
        q[6 * np.arange(len(found.law.vehicle.wheelsets)) + 2] += nudge
        with suppress(SimulationError):
            again = steady_state(found.law, (q, found.q_t), tolerance=enough(setup))
            if again.residual < found.left:
                found = replace(found, q=again.q, q_t=again.q_t, left=again.residual)
    if found.left > NEARLY:
        with suppress(SimulationError):
            found = min(found, _from_design(setup, point), key=lambda motion: motion.left)
    return found


def _apart(a: SteadyPoint, b: SteadyPoint) -> float:
    """How unlike two curves are."""
    return abs(1.0 / a.radius - 1.0 / b.radius) / 1e-3 + abs(a.cant - b.cant) / 0.1 + abs(a.speed - b.speed) / 20.0


def _continued(setup: Setup, near: Found, point: SteadyPoint) -> Found:
    """From one curve to another. Raises SimulationError where the steps become too small."""
    start, at, step = near.point, 0.0, 1.0
    while at < 1.0:
        to = min(at + step, 1.0)
        between = SteadyPoint(
            point.name,
            1.0 / ((1.0 - to) / start.radius + to / point.radius),
            (1.0 - to) * start.cant + to * point.cant,
            (1.0 - to) * start.speed + to * point.speed,
        )
        law = _law(setup, between)
        try:
            guess = carried_over(near.law, near.q, near.q_t, law)
            found = steady_state(law, guess, max_iterations=MOST_ITERATIONS, tolerance=enough(setup))
        except SimulationError:
            step *= 0.5
            if step < SMALLEST_STEP:
                raise
        else:
            near = Found(point if to == 1.0 else between, law, found.q, found.q_t, found.residual)
            at, step = to, 2.0 * step
    return near


def _from_design(setup: Setup, point: SteadyPoint) -> Found:
    """As a run starts: from the design position, or run in from straight track."""
    law = _law(setup, point)
    there = replace(setup, track=law.track, plan=RunPlan(law.start, law.start, point.speed))
    q, q_t = start_state(there, law)
    return Found(point, law, q, q_t, SteadyMotion(law).largest(q, q_t))


def _law(setup: Setup, point: SteadyPoint) -> VehicleOnTrack:
    """The force law of the vehicle in the middle of a long arc."""
    places = [part.centre[0] for part in setup.vehicle.parts]
    before, behind = MARGIN - min(places), MARGIN + max(places)
    track = setup.track.relaid([Arc(before + behind, point.radius, point.cant)])
    return force_law(replace(setup, track=track, plan=RunPlan(before, before, point.speed)))
