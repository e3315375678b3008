"""The steady motion that a run starts from: rolling straight, or curving with all poses held; in a transition, where
nothing is steady, the motion that the vehicle has come to along its track from straight."""

import logging
from contextlib import suppress
from dataclasses import replace

import numpy as np

from wrsim.analysis.contacts import force_law, held_by
from wrsim.analysis.motion.derailment import derailed, resultant_at_start
from wrsim.analysis.motion.messages import NoSteadyMotion
from wrsim.errors import SimulationError
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation import steady_state as steady
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.step_size import implicit_step
from wrsim.simulation.system import Array, BodySystem

State = tuple[Array, Array]

LOGGER = logging.getLogger("wrsim.start")
"""Reports at level INFO how the search for the motion at the start goes; an empty line at the end."""

STEADY_ENOUGH = 4e-3
"""Unbalanced part of the load of one wheelset with which a run may start: patches that appear and vanish let forces
jump, and a balance may lie inside of the jump."""

EXACT = 1e-5  # unbalanced part of the weight with the exact contact solver, which iterates
MARGIN = 2.0  # beyond the centres of the first and the last of a vehicle's parts [m]
EVEN = 1e-9  # curvature, and change of it, that does not count [1/m]
APART = 1.0  # between the places at which straight track is looked for [m]
SAMPLES = 0.1  # time between two samples of the run [s]


def start_state(setup: Setup[RunPlan], law: VehicleOnTrack) -> State:
    """State (q, q_t) from which a run starts: steady motion in the track as it is at the start.

    In a transition nothing is steady: the vehicle runs there along its track from where that is straight. With the
    exact contact solver the search goes on from what a fast model finds. Motors and brakes do nothing yet. Raises
    NoSteadyMotion.
    """
    setup = replace(setup, vehicle=replace(setup.vehicle, efforts=(), slip_control=None))
    near = replace(setup, contact=setup.contact.fast())
    fast = force_law(near, law.speed, held_by(setup))
    try:
        equilibrium = _steady_start(near, fast)
        if near.contact != setup.contact:
            held = force_law(setup, law.speed, held_by(setup))
            with suppress(SimulationError):  # the fast model's state is near enough to start from
                state = equilibrium.q, equilibrium.q_t
                equilibrium = steady.steady_state(held, state, tolerance=EXACT, max_iterations=8, near=fast)
    except SimulationError as fault:
        raise NoSteadyMotion.of(fault) from None
    finally:
        LOGGER.info("")
    law.set_search_start(law.start)
    return equilibrium.q, equilibrium.q_t


def _steady_start(setup: Setup[RunPlan], law: VehicleOnTrack) -> steady.Equilibrium:
    resultant_at_start(setup, setup.plan.speed)  # not overturned
    straight = straight_before(setup)
    if straight is not None:
        with suppress(SimulationError):
            return on_the_rails(law, _come_along(setup, law, straight))
    enough = STEADY_ENOUGH / len(setup.vehicle.wheelsets)
    if not setup.vehicle.members:
        LOGGER.info("steady motion at the start: %s", setup.vehicle.name)
        return on_the_rails(law, steady_alone(law, enough))
    q, q_t = np.zeros((2, law.size))
    q_t[law.wagons] = law.masses * law.speed
    units = law.coordinates_of_units(alone=True)
    for k, places in ((k, units[k]) for k, unit in enumerate(setup.vehicle.units) if unit.parts):
        alone = replace(setup, vehicle=setup.vehicle.alone(k))
        LOGGER.info("steady motion at the start: %s", alone.vehicle.name)
        of_one = force_law(alone, law.speed, held_by(alone))
        equilibrium = steady_alone(of_one, STEADY_ENOUGH / len(alone.vehicle.wheelsets))
        known = np.setdiff1d(np.arange(of_one.size), of_one.of_deck)  # of a bridge each knows its own part alone
        q[places], q_t[places] = equilibrium.q[known], equilibrium.q_t[known]
    q_t[law.sliders] = 0.0  # friction goes on from the design position, as it did in each vehicle
    return on_the_rails(law, steady.steady_state(law, (q, q_t), tolerance=enough))


def steady_alone(law: VehicleOnTrack, tolerance: float = steady.TOLERANCE) -> steady.Equilibrium:
    """The steady motion of one vehicle: on straight track Newton's method finds it from the design position; in curves,
    and where it does not, from where the vehicle creeps to. A wheelset that hunts creeps nowhere: then it is the design
    position again. Raises SimulationError beyond a tolerance of the weight."""
    law.set_search_start(law.start)
    guess = steady.lower_on_rails(law, *design_state(law))
    if law.track.curvature(law.start) == 0.0:
        with suppress(SimulationError):
            return steady.steady_state(law, guess)
    with suppress(SimulationError):
        return steady.crept_state(law, guess, tolerance)
    return steady.steady_state(law, guess, tolerance=tolerance)


def _come_along(setup: Setup[RunPlan], law: VehicleOnTrack, straight: float) -> steady.Equilibrium:
    """The motion that a vehicle has come to along its track from a straight place [m]. Raises NoSteadyMotion where it
    does not arrive."""
    plan = replace(setup.plan, start=straight, end=setup.plan.start, profile=None)
    approach = replace(setup, vehicle=setup.vehicle.loaded_as_at(setup.plan.start), plan=plan)
    run = force_law(approach, drive=held_by(approach))
    motion = Integration(
        BodySystem(run.bodies, run), duration=plan.duration, step=implicit_step(plan.speed, SAMPLES),
        weight=approach.vehicle.weight, sample_interval=SAMPLES, progress=lambda part, _: LOGGER.info(
            "steady motion at the start: runs in, %.0f of %.0f m", part * (plan.end - plan.start), plan.end - plan.start
        ),
    ).run(*start_state(approach, run))  # fmt: skip
    if motion.status != "completed":
        raise NoSteadyMotion(SimulationError(f"the run into the curve stopped: {motion.reason}"))
    # it ends some millimetres off the start: moved there as a whole, the vehicle would not suit the changing track
    q, q_t = motion.q[-1], motion.q_t[-1]
    return steady.Equilibrium(q, q_t, steady.SteadyMotion(law).largest(q, q_t))


def on_the_rails(law: VehicleOnTrack, equilibrium: steady.Equilibrium) -> steady.Equilibrium:
    """The state itself. Raises NoSteadyMotion when a wheel has left its rail."""
    law(0.0, equilibrium.q, equilibrium.q_t, np.zeros(law.size))
    off = derailed(law)
    if off is not None:
        raise NoSteadyMotion(off)
    return equilibrium


def straight_before(setup: Setup[RunPlan]) -> float | None:
    """Distance at which the whole vehicle is last on straight track before its run starts, if that is in a transition
    [m]; None where the curvature under it does not change or no straight track lies behind."""
    track, start = setup.track, setup.plan.start
    parts = [part.centre[0] for part in setup.vehicle.parts]
    behind, ahead = MARGIN - min(parts), MARGIN + max(parts)
    places = np.arange(start + ahead, 0.0, -APART)
    curvature = track.curvature(places)
    if np.ptp(curvature[places >= start - behind]) < EVEN:
        return None
    bent = places[np.abs(curvature) > EVEN]
    gaps = np.flatnonzero(-np.diff(bent, append=0.0) > behind + ahead + APART)
    return float(bent[gaps[0]] - APART - ahead) if gaps.size else None
