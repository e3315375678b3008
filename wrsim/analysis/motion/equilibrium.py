"""Equilibrium: a vehicle at rest on its track, without friction."""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from wrsim.analysis.contacts import force_law, held_by
from wrsim.analysis.motion.derailment import resultant_at_start
from wrsim.analysis.motion.messages import NoSteadyMotion, steady_words
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.motion.result import result_of
from wrsim.analysis.motion.start import EXACT, on_the_rails
from wrsim.analysis.progress import Progress, Report
from wrsim.errors import SimulationError
from wrsim.results import Result
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.integrate import Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import TOLERANCE, Equilibrium, crept_state, lower_on_rails, steady_state
from wrsim.simulation.system import Array
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import Vehicle, single_wheelset

ENOUGH = 1e-5
"""Force left over, as a part of the weight, that is accepted where patches that appear and vanish stop the search."""


PLAY = 12e-3  # farthest lateral shift of a wheelset at which a search begins, more by half the gauge widening [m]
SHIFT = 1e-3  # between two shifts at which a search begins [m]


def run_equilibrium(setup: Setup[RunPlan], progress: Progress | None = None) -> Result:
    """Find the rest state; the result holds that one sample, at time 0. Raises SimulationError where there is none."""
    law = force_law(setup, drive=held_by(setup))
    near = replace(setup, contact=setup.contact.fast())
    try:
        if near.contact == setup.contact:
            equilibrium = at_rest(setup, law)
        else:
            fast = force_law(near, drive=held_by(setup))
            first = at_rest(near, fast)
            equilibrium = steady_state(law, (first.q, first.q_t), tolerance=EXACT, near=fast)
    except NoSteadyMotion as problem:
        raise SimulationError(steady_words(problem, setup.vehicle)) from None
    Report(progress)(1.0)
    rest = Motion(np.zeros(1), equilibrium.q[None], equilibrium.q_t[None], 0.0, "completed")
    monitor = Monitor(law, 1.0)
    outcome = monitor.look(0.0, equilibrium.q, equilibrium.q_t)
    if outcome is not None:
        raise SimulationError(steady_words(NoSteadyMotion(outcome), setup.vehicle))
    return result_of(setup, law, rest, monitor.events())


def at_rest(setup: Setup[RunPlan], law: VehicleOnTrack) -> Equilibrium:
    """The vehicle at rest at the start of the run: on canted track it has slid down to its flanges.

    At rest there is no rolling, so the creep forces are undefined and friction holds wheels wherever they are put; the
    wanted state is the one that needs no friction. Raises NoSteadyMotion when there is none.
    """
    if not law.vehicle.bodies and len(law.vehicle.wheelsets) == 1:
        return _wheelset_at_rest(setup, law)
    resultant_at_start(setup, 0.0)
    law.set_search_start(law.start)
    q, q_t = design_state(law)
    for i in range(len(law.vehicle.wheelsets)):
        with suppress(SimulationError):  # of a vehicle it may be held where it is not by itself
            q[6 * i : 6 * i + 6] = _seat(setup, i)
    with suppress(SimulationError):
        return on_the_rails(law, steady_state(law, (q, q_t), tolerance=ENOUGH))
    try:
        return on_the_rails(law, crept_state(law, (q, q_t), ENOUGH))
    except SimulationError as fault:
        raise NoSteadyMotion.of(fault) from None


def _wheelset_at_rest(setup: Setup[RunPlan], law: VehicleOnTrack, tolerance: float = TOLERANCE) -> Equilibrium:
    """A wheelset looked for further and further to where cant or loads push it and springs or a flange hold it.
    tolerance: largest residual over the weight that is accepted."""
    problems = []
    for shift in _shifts(setup):
        try:
            law.set_search_start(law.start)
            start = lower_on_rails(law, *design_state(law, lateral=shift))
            return on_the_rails(law, steady_state(law, start, tolerance=tolerance))
        except SimulationError as problem:
            problems.append(problem)
    try:
        law.set_search_start(law.start)
        return on_the_rails(law, crept_state(law, lower_on_rails(law, *design_state(law)), tolerance))
    except SimulationError:
        raise NoSteadyMotion.of(problems[0]) from None


def _shifts(setup: Setup[RunPlan]) -> list[float]:
    """Lateral shifts of the wheelset from which a search begins [m]: from the middle to where it is pushed, without a
    push to either side, and towards its smaller wheel, if it has one."""
    widening = float(setup.track.gauge(setup.plan.start)) - setup.track.nominal_gauge
    push, wheelset = resultant_at_start(setup, 0.0).left, setup.vehicle.wheelsets[0].wheelset
    sides = [np.sign(push)] if push != 0.0 else [1.0, -1.0]
    ways = [*sides, np.sign(wheelset.right.radius - wheelset.left.radius)]
    steps = np.arange(SHIFT, PLAY + 0.5 * max(widening, 0.0), SHIFT)
    return [0.0, *(float(step * way) for step in steps for way in ways if way)]


def _seat(setup: Setup[RunPlan], i: int) -> Array:
    """Coordinates (6,) of wheelset i at rest with its share of the vehicle on it, free of everything else."""
    vehicle, run = setup.vehicle, setup.plan
    mounted = vehicle.wheelsets[i]
    share = (vehicle.mass - sum(m.mass for m in vehicle.wheelsets)) / len(vehicle.wheelsets)
    height, mass = 0.0, sum(body.mass for body in vehicle.bodies)
    if mass > 0.0:  # of what the wheelsets carry, above their axles
        axles = float(np.mean([m.height for m in vehicle.wheelsets]))
        height = sum(body.mass * body.centre[2] for body in vehicle.bodies) / mass - axles
    alone = single_wheelset(mounted.wheelset, carried_mass=share, carried_height=height)
    share_of_loads = _share_of_loads(vehicle, run.start, mounted.x, alone.names[0])
    alone = replace(alone, loads=share_of_loads, gravity=vehicle.gravity)
    single = replace(setup, vehicle=alone, plan=replace(run, start=run.start + mounted.x))
    return _wheelset_at_rest(single, force_law(single, drive="train"), ENOUGH).q[:6]


def _share_of_loads(vehicle: Vehicle, distance: float, x: float, wheelset: str) -> tuple[Load, ...]:
    """What a wheelset at x [m] along the vehicle gets of loads and payloads, for a start: a force at the height of the
    rails, and a couple of vertical forces; of the lateral force as if the vehicle were a beam on its wheelsets.
    """
    acting = (*vehicle.loaded_as_at(distance).loads, *(payload.as_load() for payload in vehicle.payloads))
    places = np.array([mounted.x for mounted in vehicle.wheelsets])
    centre, n = float(places.mean()), len(places)
    spread = float(np.sum((places - centre) ** 2))
    left = up = tipping = turning = 0.0
    for load in acting:
        fx, fy, fz = load.largest
        ahead, y, z = load.at
        left, up, tipping = left + fy / n, up + fz / n, tipping + (z * fy - y * fz) / n
        turning += (ahead - centre) * fy - y * fx
    if spread > 0.0:
        left += turning * (x - centre) / spread
    return (
        Load.constant("push", wheelset, (0.0, left, up), (0.0, 0.0, 0.0)),
        Load.constant("tip left", wheelset, (0.0, 0.0, -0.5 * tipping), (0.0, 1.0, 0.0)),
        Load.constant("tip right", wheelset, (0.0, 0.0, 0.5 * tipping), (0.0, -1.0, 0.0)),
    )
