"""Flange climbing: how far a wheel rolls until it has climbed its flange, at an angle of attack and a lateral force.

A wheelset alone on straight track is held at its angle of attack and rolls; of its suspension the dampers stay. A force
at the height of the rails pushes it to the left; the right rail has no friction. Y/Q of the left wheel grows from half
of Nadal's limit to the wanted value within ``RAMP`` of the way. The way counts from where it passes Nadal's limit to
where the contact has left the flank and passes the place of the flange's tip at which its angle is arctan(mu): from
there on friction alone holds the wheel up (TCRP Report 71, volume 5).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan
from typing import Any

import numpy as np

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.derailment import overlap, wheels_of
from wrsim.analysis.motion.messages import NoSteadyMotion, steady_words, stop_words
from wrsim.analysis.motion.monitor import WITHIN
from wrsim.analysis.motion.start import STEADY_ENOUGH
from wrsim.analysis.progress import Progress, Report
from wrsim.assessment.nadal import distance_to_climb, nadal_limit
from wrsim.contact.profiles.flange import Flank, flank_of
from wrsim.contact.records import STATUS_TOO_DEEP
from wrsim.contact.settings import ContactSettings, Friction
from wrsim.errors import InputError, SimulationError
from wrsim.results import Result, assemble
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.climb import ClimbPlan, ClimbPoint
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import crept_state, lower_on_rails
from wrsim.simulation.step_size import implicit_step
from wrsim.simulation.system import Array, BodySystem
from wrsim.track.segments import Straight
from wrsim.vehicle.dynamics import kinematics
from wrsim.vehicle.elements import ZERO, Spring
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import Vehicle, single_wheelset

START = 5.0  # straight track before the wheelset [m]
BEFORE, RAMP = 0.02, 0.02
"""Ways with the first force and to the whole one [m]: two contacts long, so that creep forces are built up."""
FIRST = 0.5  # the first force over that of Nadal's limit
HELD = 1e9  # stiffness that holds the wheelset in yaw [N m/rad]: the moment of full slip turns it by 0.1 mrad
LOOKS = 4  # steps within the ramp, at least


@dataclass(frozen=True)
class Climb:
    """One climb, or none.

    climbed: whether the wheel did; way: of the climb, or as far as the run went; shift, lift: of the wheelset's centre
    to the left and up [m]; message: what else ended it.
    """

    climbed: bool
    way: float
    shift: float
    lift: float
    message: str = ""


def run_climb(setup: Setup[ClimbPlan], progress: Progress | None = None) -> Result:
    """Every point of the scenario. Ctrl-C keeps those done.

    Raises InputError for a wheel without a flank and without friction, SimulationError when no point can be started.
    """
    plan, report, climbs = setup.plan, Report(progress), list[Climb]()
    flank, friction = flank_of(setup.wheelset.left.profile), friction_of(setup.contact)
    limit = nadal_limit(flank.angle, friction)
    try:
        for point in plan.points:
            climbs.append(climb_at(setup, point, flank, friction))
            report(len(climbs) / len(plan.points))
    except KeyboardInterrupt:
        if not climbs:
            raise
    points = plan.points[: len(climbs)]
    if all(np.isnan(climb.way) for climb in climbs):
        raise SimulationError(f"no point can be started; the first: {climbs[0].message}")
    length = flank.length(atan(friction))
    channels: dict[str, Any] = {
        "attack": [p.attack for p in points],
        "climb_quotient": [p.quotient for p in points],
        "nadal_limit": np.full(len(points), limit),
        "flange_angle": np.full(len(points), flank.angle),
        "flange_length": np.full(len(points), length),
        "climbed": np.array([int(climb.climbed) for climb in climbs]),
        "climb_distance": [climb.way for climb in climbs],
        "climb_distance_tcrp": distance_to_climb(np.array([p.attack for p in points]), flank.angle, length),
        "climb_shift": [climb.shift for climb in climbs],
        "climb_lift": [climb.lift for climb in climbs],
        "pose_message": np.array([climb.message for climb in climbs]),
    }
    n = len(climbs)
    reason = f"interrupted by the user after {n} of {len(plan.points)} points" if n < len(plan.points) else ""
    return Result(assemble({"pose": [p.name for p in points]}, channels, setup.attributes(reason)))


def friction_of(contact: ContactSettings) -> float:
    """Coefficient of friction on the gauge corner of the left rail. Raises InputError without any."""
    law = contact.friction[0]
    if contact.tangential == "none" or not isinstance(law, Friction | float):
        raise InputError("[contact] has no friction: without it no wheel climbs below the angle of its flange")
    law = Friction.of(law)
    return law.static if law.gauge_corner is None else law.gauge_corner


def climb_at(setup: Setup[ClimbPlan], point: ClimbPoint, flank: Flank, friction: float) -> Climb:
    """One climb, from rest on the flange; a message where the wheelset cannot be started or leaves the rail."""
    plan, limit = setup.plan, nadal_limit(flank.angle, friction)
    first = min(FIRST * limit, point.quotient)
    rise = point.quotient - first
    # way at which the limit is passed, or the force is whole where that is below it
    passed = BEFORE + (RAMP if rise <= 0.0 else RAMP * min((limit - first) / rise, 1.0))
    end = START + passed + plan.longest
    wheelset = held_wheelset(setup.vehicle, point.attack)
    whole: Any = setup  # of which the run takes all but the plan
    held: Setup[RunPlan] = replace(
        whole,
        vehicle=wheelset,
        drive="free",
        track=setup.track.relaid([Straight(end + 2.0 * START)]),
        contact=replace(setup.contact, friction=(setup.contact.friction[0], Friction(0.0))),
        plan=RunPlan(START, end + START, plan.speed),
    )
    force = 0.5 * first * wheelset.weight
    at_first = replace(held, vehicle=pushed_aside(wheelset, ((0.0, force),)))
    law = force_law(at_first)
    try:
        q, q_t = rolling_state(law, flank)
    except SimulationError as fault:
        why = steady_words(NoSteadyMotion.of(fault), wheelset)
        return Climb(False, np.nan, np.nan, np.nan, f"Y/Q = {first:.3f}: {why}")
    left = law.wheels[0][0].model.arrays.total
    times = BEFORE / plan.speed, (BEFORE + RAMP) / plan.speed
    # the other wheel adds to the push by its contact angle, and roll to the vertical force
    rows = ((times[0], force), (times[1], force + point.quotient * float(left.Fb) + float(left.Fo)))
    law = force_law(replace(held, vehicle=pushed_aside(wheelset, rows)))
    step = implicit_step(plan.speed, RAMP / LOOKS / plan.speed)
    watch = _Watch(law, flank.place(atan(friction)), end)
    motion = Integration(
        BodySystem(law.bodies, law), duration=(end + START) / plan.speed, step=step, weight=wheelset.weight,
        sample_interval=step, monitor=watch, monitor_interval=step,
    ).run(q, q_t)  # fmt: skip
    shift, lift = (float(motion.q[-1, i] - motion.q[0, i]) for i in (kinematics.Y, kinematics.Z))
    message = "" if watch.climbed or watch.held else motion.reason
    return Climb(watch.climbed, watch.at - START - passed, shift, lift, message)


def rolling_state(law: VehicleOnTrack, flank: Flank) -> tuple[Array, Array]:
    """The motion (q, q_t) that the wheelset creeps to from the middle of the track, evaluated.

    Newton's method alone may end in a balance on the flange's tip that does not last. Raises SimulationError without
    one on the flank or beside it.
    """
    law.set_search_start(law.start)
    creeping = crept_state(law, lower_on_rails(law, *design_state(law)), STEADY_ENOUGH)
    law(0.0, creeping.q, creeping.q_t, np.zeros(law.size))
    if _main_contact(law) < flank.end:
        raise SimulationError("the wheel climbs already")
    return creeping.q, creeping.q_t


def _main_contact(law: VehicleOnTrack) -> float:
    """Arclength of the contact with the largest force on the left wheel's profile [m]; infinite without any."""
    arrays = law.wheels[0][0].model.arrays
    patches = arrays.patches[: int(arrays.total["lobes"])]
    return float(patches["arc_wheel"][np.argmax(patches["N"])]) if patches.size else np.inf


def held_wheelset(vehicle: Vehicle, attack: float) -> Vehicle:
    """The wheelset with its weight, held along the track and at an angle of attack [rad]."""
    wheelset, name = vehicle.wheelsets[0].wheelset, vehicle.wheelsets[0].name
    springs = [e for e in vehicle.elements if isinstance(e, Spring)]
    held = single_wheelset(
        wheelset,
        stiffness=(0.5 * HELD, 0.0, 0.0),
        damping=springs[0].damping if springs else ZERO,
        half_spacing=1.0,
        carried_mass=vehicle.weight / vehicle.gravity - vehicle.mass,
    )
    couple = (
        Load.constant(f"turn {side}", name, (-0.5 * y * HELD * attack, 0.0, 0.0), (0.0, y, wheelset.mean_radius))
        for side, y in (("left", 1.0), ("right", -1.0))
    )
    return replace(held, loads=tuple(couple), gravity=vehicle.gravity)


def pushed_aside(wheelset: Vehicle, rows: Sequence[tuple[float, float]]) -> Vehicle:
    """The wheelset pushed to the left at the height of the rails; rows: time [s] and force [N]."""
    table = tuple((time, 0.0, force, 0.0) for time, force in rows)
    push = Load("push", wheelset.names[0], (0.0, 0.0, 0.0), table)
    return replace(wheelset, loads=(*wheelset.loads, push))


class _Watch:
    """Ends a run where the left wheel has climbed, or has rolled far enough; ``at``: the place [m]."""

    def __init__(self, law: VehicleOnTrack, tip: float, last: float) -> None:
        """tip: arclength on the wheel's profile at which it has climbed [m]; last: where it counts as held [m]."""
        self.law, self.tip, self.last, self.climbed, self.held, self.at = law, tip, last, False, False, law.start
        self._wheels = wheels_of(law)
        self._before = np.inf

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        self.law.at(t, q, q_t, WITHIN)
        before, self.at = self.at, self.law.distance
        if any(wheel.status & STATUS_TOO_DEEP for wheel in self._wheels):
            return stop_words(overlap(self._wheels), t, self.at)
        beyond = _main_contact(self.law) - self.tip
        if beyond <= 0.0:
            if np.isfinite(self._before):
                self.at -= beyond / (beyond - self._before) * (self.at - before)  # the place between two looks
            self.climbed = True
            return "the wheel has climbed its flange"
        self._before = beyond
        self.held = self.at >= self.last
        return "the rail has held the wheel" if self.held else None
