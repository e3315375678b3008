"""How a vehicle gets into a curve when no search finds its steady motion: it runs in from straight track.

Into a full curve through a long transition of its own; into a transition, where nothing is steady, along the track
itself."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_at, force_law, held_by
from wrsim.analysis.motion.messages import NoSteadyMotion, RunInStopped
from wrsim.core.track import path as path_kernels
from wrsim.geometry.track.segments import Arc, Straight, Transition
from wrsim.simulation.integrate import Integration
from wrsim.simulation.step import implicit_step
from wrsim.simulation.system import System

if TYPE_CHECKING:
    from collections.abc import Callable

    from wrsim.scenario.build import Setup
    from wrsim.scenario.sections.run import RunPlan
    from wrsim.simulation.law import VehicleOnTrack
    from wrsim.simulation.system import Array
    from wrsim.vehicle.vehicle import Vehicle

    State = tuple[Array, Array]

LOGGER = logging.getLogger("wrsim.start")

EASE = 3.0
"""Time in the transition, at least [s], ..."""

SETTLE = 3.0
"""... and in the full curve before the motion is taken as steady [s]."""

MARGIN = 2.0
"""Beyond the centres of the first and the last of a vehicle's parts [m]."""

EVEN = 1e-9
"""Curvature, and change of it, that does not count [1/m]."""

APART = 1.0
"""Between the places at which straight track is looked for [m]."""

SAMPLES = 0.1
"""Time between two samples of the run [s]."""


def run_in(setup: Setup[RunPlan], start_of: Callable[[Setup, VehicleOnTrack], State]) -> State:
    """State (q, q_t) at the start of a run in a full curve, reached through a long transition to its curvature.

    start_of(setup, law): steady motion on straight track. Raises NoSteadyMotion when the run does not arrive.
    """
    track, run, vehicle = setup.track, setup.plan, setup.vehicle
    behind, ahead = _reach(vehicle)
    curvature = float(track.curvature(run.start))
    ease, settle = max(EASE * run.speed, 20.0), SETTLE * run.speed + behind
    bend = Arc(
        settle + behind + ahead,
        1.0 / curvature,
        cant=float(np.copysign(1.0, curvature) * track.cant(run.start)),
        gauge_widening=float(track.gauge(run.start)) - track.nominal_gauge,
    )
    there = replace(
        setup,
        track=track.relaid([Straight(behind + ahead), Transition(ease), bend]),
        contact=contact_at(setup, run.start),
        plan=replace(run, start=behind, end=behind + ahead + ease + settle, profile=None),
    )
    law, q, q_t = _run(there, start_of)
    return _moved(law, law.distance - vehicle.parts[vehicle.reference].centre[0], setup, q, q_t)


def straight_before(setup: Setup[RunPlan]) -> float | None:
    """Distance at which the whole vehicle is last on straight track before its run starts, if that is in a transition
    [m]; None where the curvature under it does not change or no straight track lies behind."""
    track, start = setup.track, setup.plan.start
    behind, ahead = _reach(setup.vehicle)
    places = np.arange(start + ahead, 0.0, -APART)
    curvature = track.curvature(places)
    if np.ptp(curvature[places >= start - behind]) < EVEN:
        return None
    bent = places[np.abs(curvature) > EVEN]
    gaps = np.flatnonzero(-np.diff(bent, append=0.0) > behind + ahead + APART)
    return float(bent[gaps[0]] - APART - ahead) if gaps.size else None


def _reach(vehicle: Vehicle) -> tuple[float, float]:
    """How far the track under a vehicle goes behind its origin and ahead of it, with some room [m]."""
    places = [part.centre[0] for part in vehicle.parts]
    return MARGIN - min(places), MARGIN + max(places)


def run_up(setup: Setup[RunPlan], straight: float, start_of: Callable[[Setup, VehicleOnTrack], State]) -> State:
    """State (q, q_t) at the start of a run in a transition, reached along the track from a straight place [m] behind.

    It may be some millimetres off the start: moved there as a whole, the vehicle would not suit the changing track.
    start_of(setup, law): steady motion there. Raises NoSteadyMotion when the run does not arrive.
    """
    run = setup.plan
    there = replace(setup, plan=replace(run, start=straight, end=run.start, profile=None))
    return _run(there, start_of)[1:]


def _run(
    there: Setup[RunPlan], start_of: Callable[[Setup, VehicleOnTrack], State]
) -> tuple[VehicleOnTrack, Array, Array]:
    """Run as ``there`` says: the law of forces, and the state at the end."""
    law = force_law(there, drive=held_by(there))
    q, q_t = start_of(there, law)
    system = System(law.bodies, law)
    step, weight = implicit_step(there.plan.speed, SAMPLES), there.vehicle.weight
    way = there.plan.end - there.plan.start
    motion = Integration(system, duration=there.plan.duration, step=step, weight=weight, sample_interval=SAMPLES,
        progress=lambda part, _: LOGGER.info("steady motion at the start: runs in, %.0f of %.0f m", part * way, way),
    ).run(q, q_t)  # fmt: skip
    if motion.status != "completed":
        raise NoSteadyMotion(RunInStopped(motion.reason))
    law.look_near(there.plan.end)
    law(motion.end, motion.q[-1], motion.q_t[-1], np.zeros(law.size))
    return law, motion.q[-1], motion.q_t[-1]


def _moved(law: VehicleOnTrack, distance: float, setup: Setup[RunPlan], q: Array, q_t: Array) -> State:
    """The state as if the vehicle's origin were at the start of the run, on another curve of equal shape."""
    frames = [
        path_kernels.frame_at(path.curve, s)
        for path, s in ((law.track.centre, distance), (setup.track.centre, setup.plan.start))
    ]
    old, new = (frame.origin for frame in frames)
    headings = [np.arctan2(frame.t.y, frame.t.x) for frame in frames]
    turn = headings[1] - headings[0]
    c, s = np.cos(turn), np.sin(turn)
    q, q_t = q.copy(), q_t.copy()
    n = 6 * len(law.bodies)
    for state, centre, target in ((q, old, new), (q_t, np.zeros(3), np.zeros(3))):
        own = state[:n].reshape(-1, 6)
        x, y = own[:, 1] - centre[0], own[:, 2] - centre[1]
        own[:, 1], own[:, 2] = target[0] + c * x - s * y, target[1] + s * x + c * y
        own[:, 0] += target[2] - centre[2]
    q[:n].reshape(-1, 6)[:, 3] += turn
    return q, q_t
