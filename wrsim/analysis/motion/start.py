"""The steady motion that a run starts from: rolling straight, or curving with the pose held."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.motion.derailment import flange_tip, gauge_face, off_the_rail
from wrsim.errors import SimulationError
from wrsim.geometry.track.segments import Arc
from wrsim.simulation.equilibrium import find_equilibrium
from wrsim.simulation.integrate import integrate
from wrsim.simulation.placement import place_on_track, poses_on_track
from wrsim.simulation.steady import SteadyMotion
from wrsim.simulation.step import step_for_speed
from wrsim.simulation.system import RigidBody, System
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array

    State = tuple[Array, Array]

ROLLING = ("z", "x", "y", "heading", "roll", "spin_rate")

PLAY = 12e-3
"""Farthest lateral shift at which the search for steady curving begins, more by half the gauge widening [m]."""

EXACT = 1e-5
"""Unbalanced part of the weight with the exact contact solver, which iterates."""

RUN_IN = 3.0
"""Time of running in on a long arc where the search alone finds nothing [s]."""

STEADY_ENOUGH = 1e-2
"""Unbalanced part of the weight with which a run may start after running in."""


def start_state(setup: Setup, law: WheelsetOnTrack) -> State:
    """State (q, q_t) from which a run starts: steady motion in the track as it is at the start.

    In a curve the search begins in the middle of the track and goes on further and further outward: a wheelset held
    hard against yaw does not find its way to the outer rail by itself. What is not found so is run in on a long arc
    of that curvature and cant, and taken as it comes if it has become steady: patches that appear and vanish let a
    force jump, and a balance may lie inside of the jump.
    Raises SimulationError when there is no steady motion.
    """
    curvature = float(setup.track.curvature(setup.run.start))
    play = PLAY + 0.5 * max(float(setup.track.gauge(setup.run.start)) - setup.track.nominal_gauge, 0.0)
    shifts = -np.copysign(np.arange(0.0, play, 1e-3), curvature) if curvature != 0.0 else np.zeros(1)
    problems = []
    for lateral in shifts:
        try:
            return _steady(setup, law, *_guess(setup, float(lateral)))
        except SimulationError as error:
            problems.append(error)
    if curvature != 0.0:
        try:
            return _settled(setup, law, *_run_in(setup, float(shifts[len(shifts) // 2])))
        except SimulationError as error:
            problems.append(error)
    run = setup.run
    curve = f" in a curve of {1.0 / abs(curvature):.4g} m radius" if curvature != 0.0 else ""
    advice = ": start the run before the curve to see what becomes of it" if curve else ""
    raise SimulationError(
        f"the run has no steady motion to start from at {run.start:g} m and {3.6 * run.speed:g} km/h{curve}{advice}. "
        f"The search ended with: {problems[-1]}"
    )


def exact_start(setup: Setup, law: WheelsetOnTrack, q: Array, q_t: Array) -> State:
    """The steady motion with the exact contact solver near that of a fast model; the given one if none is found."""
    steady = _motion(setup, law)
    weight = setup.wheelset.static_axle_load
    try:
        found = find_equilibrium(steady, q, q_t, ROLLING, weight=weight, tolerance=EXACT, max_iterations=8)
        return _on_the_rails(law, *steady.state(found.q, found.q_t))
    except SimulationError:
        return q, q_t


def _guess(setup: Setup, lateral: float) -> State:
    """A wheelset that follows the track at a lateral shift [m], with the yaw at which its bogie holds it."""
    run, radius = setup.run, setup.wheelset.mean_radius
    return place_on_track(
        setup.track.centre,
        run.start,
        speed=run.speed,
        height=radius,
        spin_rate=run.speed / radius,
        lateral=lateral,
        yaw=-setup.wheelset.suspension.ahead_of_bogie_centre * float(setup.track.curvature(run.start)),
    )


def _motion(setup: Setup, law: WheelsetOnTrack) -> SteadyMotion:
    """The law of steady motion at the start."""
    run = setup.run
    body = RigidBody.of(setup.wheelset)
    return SteadyMotion(law, body, setup.track.centre, speed=run.speed, distance=run.start)


def _steady(setup: Setup, law: WheelsetOnTrack, q: Array, q_t: Array) -> State:
    """The steady motion near a state at the start. Raises SimulationError when there is none."""
    steady = _motion(setup, law)
    found = find_equilibrium(steady, q, q_t, ROLLING, weight=setup.wheelset.static_axle_load)
    return _on_the_rails(law, *steady.state(found.q, found.q_t))


def _settled(setup: Setup, law: WheelsetOnTrack, q: Array, q_t: Array) -> State:
    """The steady motion near a state that is nearly steady, or that state itself.

    Raises SimulationError when the state is not steady enough.
    """
    try:
        return _steady(setup, law, q, q_t)
    except SimulationError:
        steady = _motion(setup, law)
        out = np.zeros(6)
        steady(0.0, q, q_t, out)
        if not np.abs(out).max() <= STEADY_ENOUGH * setup.wheelset.static_axle_load:
            raise
        return _on_the_rails(law, *steady.state(q, q_t))


def _on_the_rails(law: WheelsetOnTrack, q: Array, q_t: Array) -> State:
    """The state itself. Raises SimulationError when a wheel has left its rail."""
    law(0.0, q, q_t, np.zeros(6))
    for wheel in law.wheels:
        reason = off_the_rail(wheel, flange_tip(wheel.model.wheel), gauge_face(wheel.model.rail))
        if reason:
            raise SimulationError(reason)
    return q, q_t


def _run_in(setup: Setup, lateral: float) -> State:
    """The state at the start that a wheelset reaches by itself on a long arc as the track is at the start."""
    track, run, wheelset = setup.track, setup.run, setup.wheelset
    curvature = float(track.curvature(run.start))
    bend = Arc(
        RUN_IN * run.speed + 20.0,
        1.0 / curvature,
        cant=float(np.copysign(1.0, curvature) * track.cant(run.start)),
        gauge_widening=float(track.gauge(run.start)) - track.nominal_gauge,
    )
    arc = track.relaid([bend])
    there = replace(setup, track=arc, run=replace(run, start=10.0))
    law = WheelsetOnTrack(wheelset, arc, contact_models(there), speed=run.speed, start=10.0)
    q, q_t = _guess(there, lateral)
    q[0] -= 1e-4  # about where the rails carry it
    motion = integrate(
        System([RigidBody.of(wheelset)], law),
        q,
        q_t,
        duration=RUN_IN,
        step=step_for_speed(run.speed, wheelset),
        sample_interval=0.1,
    )
    if motion.status != "completed":
        raise SimulationError(motion.reason)
    poses = poses_on_track(arc.centre, motion.q, motion.q_t, 10.0)
    return place_on_track(
        track.centre,
        run.start,
        speed=run.speed,
        height=float(poses.height[-1]),
        spin_rate=float(poses.spin_rate[-1]),
        lateral=float(poses.lateral[-1]),
        yaw=float(poses.yaw[-1]),
        roll=float(poses.roll[-1]),
    )
