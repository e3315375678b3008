"""The steady motion that a run starts from: rolling straight, or curving with all poses held.

Where no search finds it in a curve, the vehicle runs in from straight track: into a full curve through a long
transition of its own; into a transition, where nothing is steady, along the track itself.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from wrsim.analysis.contacts import contact_at, force_law, held_by
from wrsim.analysis.motion.derailment import derailed, pushed
from wrsim.analysis.motion.messages import NoSteadyMotion
from wrsim.core.track import path as path_kernels
from wrsim.errors import SimulationError
from wrsim.geometry.track.segments import Arc, Straight, Transition
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation import steady_state as steady
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.step_size import implicit_step
from wrsim.simulation.system import Array, BodySystem
from wrsim.vehicle.vehicle import Vehicle

State = tuple[Array, Array]

LOGGER = logging.getLogger("wrsim.start")
"""Reports at level INFO how the search for the motion at the start goes; an empty line at the end."""

PLAY = 12e-3  # farthest lateral shift of the wheelsets at which a search begins, more by half the gauge widening [m]
SHIFT = 1e-3  # between two shifts at which a search begins [m]

STEADY_ENOUGH = 4e-3
"""Unbalanced part of the load of one wheelset with which a run may start after running in: patches that appear and
vanish let forces jump, and a balance may lie inside of the jump."""

MOST_AFTER_RUN = 10
"""Iterations of Newton's method from a motion that has run in: it finds the balance in a few of them or not at all."""

EXACT = 1e-5  # unbalanced part of the weight with the exact contact solver, which iterates
EASE = 3.0  # time in the transition, at least [s], ...
SETTLE = 3.0  # ... and in the full curve before the motion is taken as steady [s]
MARGIN = 2.0  # beyond the centres of the first and the last of a vehicle's parts [m]
EVEN = 1e-9  # curvature, and change of it, that does not count [1/m]
APART = 1.0  # between the places at which straight track is looked for [m]
SAMPLES = 0.1  # time between two samples of the run [s]


def shifts(setup: Setup[RunPlan], direction: float) -> list[Array]:
    """Lateral shifts of the wheelsets (wheelsets,) at the start of the run from which a search begins [m].

    From the middle towards ``direction``: in a curve a wheelset held hard against yaw does not find its way to the
    outer rail by itself, nor down a canted track to the inner one, nor to where a load pushes it. Without a direction
    to either side. And each towards its smaller wheel, if it has one: there, in the end on the root of the flange, both
    roll alike.
    """
    widening = float(setup.track.gauge(setup.plan.start)) - setup.track.nominal_gauge
    radii = np.array([[m.wheelset.left.radius, m.wheelset.right.radius] for m in setup.vehicle.wheelsets])
    smaller = np.sign(radii[:, 1] - radii[:, 0])
    sides = [np.sign(direction)] if direction != 0.0 else [1.0, -1.0]
    ways = [*(np.full(len(radii), side) for side in sides), smaller]
    steps = np.arange(SHIFT, PLAY + 0.5 * max(widening, 0.0), SHIFT)
    return [np.zeros(len(radii)), *(step * way for step in steps for way in ways if way.any())]


def first_steady(
    law: VehicleOnTrack, shifts: Sequence[Array], tolerance: float = steady.TOLERANCE
) -> steady.Equilibrium:
    """The steady motion that the first of these shifts leads to. Raises what stopped the search from the first one."""
    problems = []
    for shift in shifts:
        try:
            law.look_near(law.start)
            lowered = steady.lower_on_rails(law, *design_state(law, lateral=shift))
            return steady.steady_state(law, lowered, tolerance=tolerance)
        except SimulationError as fault:
            problems.append(fault)
    raise problems[0]


def enough(setup: Setup[RunPlan]) -> float:
    """``STEADY_ENOUGH`` as a part of the weight of the whole vehicle."""
    return STEADY_ENOUGH / len(setup.vehicle.wheelsets)


def start_state(setup: Setup[RunPlan], law: VehicleOnTrack) -> State:
    """State (q, q_t) from which a run starts: steady motion in the track as it is at the start.

    If the search from the middle does not find it in a curve, the vehicle is run in from straight track; its last state
    is accepted if it is steady enough. In a transition nothing is steady: there it runs along its track. Then come
    searches from other shifts; on straight track the best of them is taken. With the exact contact solver the search
    goes on from what a fast model finds. Motors and brakes do nothing yet. Raises NoSteadyMotion.
    """
    setup = replace(setup, vehicle=replace(setup.vehicle, efforts=(), slip_control=None))
    near = replace(setup, contact=setup.contact.fast())
    fast = force_law(near, law.speed, held_by(setup))
    try:
        found = _found(near, fast)
        if near.contact != setup.contact:
            held = force_law(setup, law.speed, held_by(setup))
            with suppress(SimulationError):  # the fast model's state is near enough to start from
                found = steady.steady_state(held, (found.q, found.q_t), tolerance=EXACT, max_iterations=8, near=fast)
    finally:
        LOGGER.info("")
    law.look_near(law.start)
    return found.q, found.q_t


def _found(setup: Setup[RunPlan], law: VehicleOnTrack) -> steady.Equilibrium:
    curvature = float(setup.track.curvature(setup.plan.start))
    ways = _ways(setup)
    problems: list[SimulationError] = []
    near: list[steady.Equilibrium] = []

    def searched(ways: list[Array]) -> steady.Equilibrium | None:
        for shift in ways:
            LOGGER.info("steady motion at the start: from %.0f mm aside", 1e3 * float(np.abs(shift).max()))
            try:
                near.append(on_the_rails(law, _from_shift(setup, law, shift)))
                if near[-1].residual <= steady.TOLERANCE:
                    return near[-1]
            except SimulationError as fault:
                problems.append(fault)
        return None

    # in a transition wheels rise and fall with the cant: poses that are held are no motion there
    straight = straight_before(setup)
    if straight is None and (found := searched(ways[:1])):
        return found
    if straight is None and law.speed > 0.0 and any(m.wheelset.independent for m in law.vehicle.wheelsets):
        return on_the_rails(law, _relaxed(setup, law))
    if curvature != 0.0 or straight is not None:
        try:
            return _reached(setup, law, straight)
        except SimulationError as fault:
            problems.insert(0, fault)
    if setup.vehicle.members and curvature == 0.0:
        ways = ways[:1]  # each vehicle has been looked for from all of its own
    if found := searched(ways[1:] if straight is None else ways[:1]):
        return found
    if curvature == 0.0 and straight is None and near:
        return min(near, key=lambda one: one.residual)
    raise NoSteadyMotion.of(problems[0])


def _ways(setup: Setup[RunPlan]) -> list[Array]:
    """The shifts towards where curve or loads push the vehicle. Raises NoSteadyMotion where they overturn it."""
    curvature, aside = float(setup.track.curvature(setup.plan.start)), pushed(setup, setup.plan.speed).left
    return shifts(setup, -curvature if curvature != 0.0 else aside)


def _from_shift(setup: Setup[RunPlan], law: VehicleOnTrack, shift: Array) -> steady.Equilibrium:
    """The steady motion that Newton's method finds with the wheelsets so far aside; of a train first each vehicle by
    itself, in its own place, on straight track also from its other shifts, then all of them together with the forces of
    their couplings."""
    if not setup.vehicle.members:
        return first_steady(law, [shift], enough(setup))
    q, q_t = np.zeros((2, law.size))
    for k, places in enumerate(law.coordinates_of_units(alone=True)):
        alone = replace(setup, vehicle=setup.vehicle.alone(k))
        aside = shift[list(setup.vehicle.units[k].wheelsets)]
        ways = [aside] if setup.track.curvature(setup.plan.start) else [aside, *_ways(alone)[1:]]
        own = first_steady(force_law(alone, law.speed, held_by(alone)), ways, enough(alone))
        q[places], q_t[places] = own.q, own.q_t
    q_t[law.sliders] = 0.0  # friction goes on from the design position, as it did in each vehicle
    return steady.steady_state(law, (q, q_t), tolerance=enough(setup))


def _relaxed(setup: Setup[RunPlan], law: VehicleOnTrack) -> steady.Equilibrium:
    """The steady motion of a vehicle with independent wheels, which creeps to its flanges. Raises NoSteadyMotion."""
    LOGGER.info("steady motion at the start: wheels creep to their flanges")
    law.look_near(law.start)
    try:
        near = steady.relaxed_state(law, steady.lower_on_rails(law, *design_state(law)))
        return steady.steady_state(law, (near.q, near.q_t), tolerance=enough(setup))
    except SimulationError as fault:
        raise NoSteadyMotion.of(fault) from None


def _reached(setup: Setup[RunPlan], law: VehicleOnTrack, straight: float | None) -> steady.Equilibrium:
    """The motion that a vehicle has come to from straight track: into a curve as that of the start, and steady there,
    or along the track from a straight place [m] into its transition. Raises NoSteadyMotion where it does not arrive."""
    held = replace(setup, vehicle=setup.vehicle.loaded_as_at(setup.plan.start))
    if straight is None:
        near = steady.steady_state(law, _run_in(held), tolerance=enough(setup), max_iterations=MOST_AFTER_RUN)
        return on_the_rails(law, near)
    # it ends some millimetres off the start: moved there as a whole, the vehicle would not suit the changing track
    plan = replace(setup.plan, start=straight, end=setup.plan.start, profile=None)
    _, q, q_t = _run(replace(held, plan=plan))
    return on_the_rails(law, steady.Equilibrium(q, q_t, steady.SteadyMotion(law).largest(q, q_t)))


def on_the_rails(law: VehicleOnTrack, found: steady.Equilibrium) -> steady.Equilibrium:
    """The state itself. Raises NoSteadyMotion when a wheel has left its rail."""
    law(0.0, found.q, found.q_t, np.zeros(law.size))
    off = derailed(law)
    if off is not None:
        raise NoSteadyMotion(off)
    return found


def _run_in(setup: Setup[RunPlan]) -> State:
    """State (q, q_t) at the start of a run in a full curve, reached through a long transition to its curvature."""
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
    law, q, q_t = _run(there)
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


def _run(there: Setup[RunPlan]) -> tuple[VehicleOnTrack, Array, Array]:
    """From steady motion run by the plan of ``there``: the law of forces, and the state at the end."""
    law = force_law(there, drive=held_by(there))
    q, q_t = start_state(there, law)
    system = BodySystem(law.bodies, law)
    step, weight = implicit_step(there.plan.speed, SAMPLES), there.vehicle.weight
    way = there.plan.end - there.plan.start
    motion = Integration(system, duration=there.plan.duration, step=step, weight=weight, sample_interval=SAMPLES,
        progress=lambda part, _: LOGGER.info("steady motion at the start: runs in, %.0f of %.0f m", part * way, way),
    ).run(q, q_t)  # fmt: skip
    if motion.status != "completed":
        raise NoSteadyMotion(SimulationError(f"the run into the curve stopped: {motion.reason}"))
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
