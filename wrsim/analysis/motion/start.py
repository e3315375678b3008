"""The steady motion that a run starts from: rolling straight, or curving with all poses held."""

from __future__ import annotations

import logging
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import force_law, held_by
from wrsim.analysis.motion.derailment import derailed, pushed
from wrsim.analysis.motion.messages import NoSteadyMotion
from wrsim.analysis.motion.run_in import run_in, run_up, straight_before
from wrsim.errors import SimulationError
from wrsim.simulation.design import design_state
from wrsim.simulation.state import (
    TOLERANCE,
    Equilibrium,
    SteadyMotion,
    lower_on_rails,
    relaxed_state,
    steady_state,
)

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.scenario.sections.run import RunPlan
    from wrsim.simulation.law import VehicleOnTrack
    from wrsim.simulation.system import Array

    State = tuple[Array, Array]

LOGGER = logging.getLogger("wrsim.start")
"""Says at level INFO how the search for the motion at the start goes; an empty line at the end."""

PLAY = 12e-3
"""Farthest lateral shift of the wheelsets at which a search begins, more by half the gauge widening [m]."""

SHIFT = 1e-3
"""Between two shifts at which a search begins [m]."""

STEADY_ENOUGH = 4e-3
"""Unbalanced part of the load of one wheelset with which a run may start after running in: patches that appear and
vanish let forces jump, and a balance may lie inside of the jump."""

EXACT = 1e-5
"""Unbalanced part of the weight with the exact contact solver, which iterates."""


def shifts(setup: Setup[RunPlan], direction: float) -> list[Array]:
    """Lateral shifts of the wheelsets (wheelsets,) at the start of the run from which a search begins [m].

    From the middle towards ``direction``: in a curve a wheelset held hard against yaw does not find its way to the
    outer rail by itself, nor down a canted track to the inner one, nor to where a load pushes it. Then each towards its
    smaller wheel, if it has one: there, in the end on the root of the flange, both roll alike.
    """
    widening = float(setup.track.gauge(setup.plan.start)) - setup.track.nominal_gauge
    radii = np.array([[m.wheelset.left.radius, m.wheelset.right.radius] for m in setup.vehicle.wheelsets])
    smaller = np.sign(radii[:, 1] - radii[:, 0])
    ways = [np.full(len(radii), np.sign(direction)), smaller]
    steps = np.arange(SHIFT, PLAY + 0.5 * max(widening, 0.0), SHIFT)
    return [np.zeros(len(radii)), *(step * way for way in ways if way.any() for step in steps)]


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
    try:
        return _start_state(replace(setup, vehicle=setup.vehicle.coasting), law)
    finally:
        LOGGER.info("")


def _start_state(setup: Setup[RunPlan], law: VehicleOnTrack) -> State:
    """See ``start_state``; nothing drives or brakes the vehicle."""
    near = replace(setup, contact=setup.contact.fast())
    fast = force_law(near, law.speed, held_by(setup))
    found = _found(near, fast)
    if near.contact != setup.contact:
        held = force_law(setup, law.speed, held_by(setup))
        with suppress(SimulationError):  # the fast model's state is near enough to start from
            found = steady_state(held, (found.q, found.q_t), tolerance=EXACT, max_iterations=8, near=fast)
    law.look_near(law.start)
    return found.q, found.q_t


def _found(setup: Setup[RunPlan], law: VehicleOnTrack) -> Equilibrium:
    curvature = float(setup.track.curvature(setup.plan.start))
    aside = pushed(setup, law.speed).left
    ways = shifts(setup, -curvature if curvature != 0.0 else aside)
    problems: list[SimulationError] = []
    near: list[Equilibrium] = []

    def searched(ways: list[Array]) -> Equilibrium | None:
        for shift in ways:
            LOGGER.info("steady motion at the start: from %.0f mm aside", 1e3 * float(np.abs(shift).max()))
            try:
                found = on_the_rails(law, _from_shift(setup, law, shift))
                if found.residual <= TOLERANCE:
                    return found
                near.append(found)
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
    if found := searched(ways[1:] if straight is None else ways[:1]):
        return found
    if curvature == 0.0 and straight is None and near:
        return min(near, key=lambda one: one.residual)
    raise NoSteadyMotion.of(problems[0])


def _from_shift(setup: Setup[RunPlan], law: VehicleOnTrack, shift: Array) -> Equilibrium:
    """The steady motion that Newton's method finds with the wheelsets so far aside; of a train first each vehicle by
    itself, in its own place, then all of them together with the forces of their couplings."""
    law.look_near(law.start)
    if not setup.vehicle.members:
        return steady_state(law, lower_on_rails(law, *design_state(law, lateral=shift)), tolerance=enough(setup))
    q, q_t = np.zeros((2, law.size))
    for k, places in enumerate(law.coordinates_of_units(alone=True)):
        alone = replace(setup, vehicle=setup.vehicle.alone(k))
        aside = shift[list(setup.vehicle.units[k].wheelsets)]
        own = _from_shift(alone, force_law(alone, law.speed, held_by(alone)), aside)
        q[places], q_t[places] = own.q, own.q_t
    q_t[law.sliders] = 0.0  # friction goes on from the design position, as it did in each vehicle
    return steady_state(law, (q, q_t), tolerance=enough(setup))


def _relaxed(setup: Setup[RunPlan], law: VehicleOnTrack) -> Equilibrium:
    """The steady motion of a vehicle with independent wheels, which creeps to its flanges. Raises NoSteadyMotion."""
    LOGGER.info("steady motion at the start: wheels creep to their flanges")
    law.look_near(law.start)
    try:
        near = relaxed_state(law, lower_on_rails(law, *design_state(law)))
        return steady_state(law, (near.q, near.q_t), tolerance=enough(setup))
    except SimulationError as fault:
        raise NoSteadyMotion.of(fault) from None


def _reached(setup: Setup[RunPlan], law: VehicleOnTrack, straight: float | None) -> Equilibrium:
    """The motion that a vehicle has come to from straight track: into a curve as long as that of the start, and steady
    there, or along the track from a straight place [m] into its transition."""
    held = replace(setup, vehicle=setup.vehicle.loaded_as_at(setup.plan.start))
    if straight is None:
        return on_the_rails(law, steady_state(law, run_in(held, start_state), tolerance=enough(setup)))
    q, q_t = run_up(held, straight, start_state)
    return on_the_rails(law, Equilibrium(q, q_t, SteadyMotion(law).largest(q, q_t), 0))


def on_the_rails(law: VehicleOnTrack, found: Equilibrium) -> Equilibrium:
    """The state itself. Raises NoSteadyMotion when a wheel has left its rail."""
    law(0.0, found.q, found.q_t, np.zeros(law.size))
    off = derailed(law)
    if off is not None:
        raise NoSteadyMotion(off)
    return found
