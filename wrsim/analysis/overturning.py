"""The speed at which a vehicle overturns in a curve, in the wind: quasi-static, and in runs into the curve.

Quasi-static: the vehicle at rest on hard supports that push and do not pull, under the weight and the centrifugal force
of all of its masses (``analysis.stationary.statics``), with springs, bump stops and sway, and under the wind. The speed
rises until there is no rest any more; each rest is looked for from the one before.
In runs the speed is halved into between one at which the vehicle comes through and one at which it does not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any

import numpy as np

from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import MARGIN
from wrsim.analysis.progress import Progress, Report
from wrsim.analysis.stationary.statics import SupportedVehicle, accelerated, rest_from_design, static_state
from wrsim.errors import SimulationError
from wrsim.results import Result, assemble
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.overturning import OverturningPlan
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.system import Array
from wrsim.track.cant import cant_angle
from wrsim.track.segments import Arc, Straight, Transition
from wrsim.vehicle.vehicle import Vehicle

STEPS = 40  # speeds from the lowest to the highest at which a rest is looked for, at least
RUN_ON = 2.0  # time in the full curve after which the vehicle has come through [s]: the period of a car body's sway
RISING = 3.0 * RUN_ON
"""Time on straight track in which the wind rises, in runs [s]: long for the sway, which overshoots in a short one."""
ENDED = 0.05  # part of the last speed within which an overturning vehicle's inner wheels lose the rest of their load
SPAN = 1.5  # fastest run over the quasi-static limit


@dataclass(frozen=True)
class Rest:
    """At a speed and in a wind [m/s].

    unloading: of the wheels, (wheelsets, 2); roll: of the bodies (bodies,) [rad]; left_over: share of its load at rest
    that the lighter side carries; message: why no rest follows, where that is not because the vehicle overturns.
    """

    speed: float
    wind: float
    unloading: Array
    roll: Array
    left_over: float
    message: str = ""


def run_overturning(setup: Setup[OverturningPlan], progress: Progress | None = None) -> Result:
    """Unloading of the wheels over the speed, for every wind; Ctrl-C keeps the winds done.

    Raises SimulationError when the vehicle overturns at the lowest speed already.
    """
    plan, report = setup.plan, Report(progress)
    winds = plan.winds
    rests: list[list[Rest]] = []
    outcome: dict[str, Any] = {}
    try:
        for wind in winds:
            rests.append(rising_speeds(setup, wind))
            report(len(rests) / len(winds) * (0.2 if plan.run else 1.0))
        if plan.run:
            outcome = runs_into_curve(setup, rests[0][-1].speed, report)
    except KeyboardInterrupt:
        if not rests:
            raise
    poses = [rest for series in rests for rest in series]
    ends = [series[-1] for series in rests if series[-1].speed < plan.highest and not series[-1].message]
    coords: dict[str, Any] = {
        "pose": [f"{3.6 * rest.speed:.6g}kmh_{rest.wind:.6g}m_s" for rest in poses],
        "wheelset": [m.name for m in setup.vehicle.wheelsets],
        "body": [body.name for body in setup.vehicle.bodies],
    }
    channels: dict[str, Any] = {
        "pose_speed": [rest.speed for rest in poses],
        "pose_radius": np.full(len(poses), plan.radius),
        "pose_cant": np.full(len(poses), plan.cant),
        "wind_speed": [rest.wind for rest in poses],
        "pose_message": np.array([rest.message for rest in poses]),
        "overturns": np.array([int(any(rest is end for end in ends)) for rest in poses]),
        "wheel_unloading": np.array([rest.unloading for rest in poses]),
        "quasi_static_roll": np.array([rest.roll for rest in poses]),
    }
    reason = f"interrupted by the user after {len(rests)} of {len(winds)} winds" if len(rests) < len(winds) else ""
    if plan.run and not outcome:
        reason = reason or "interrupted by the user during the runs"
    return Result(assemble(coords, channels, setup.attributes(reason) | outcome))


def rising_speeds(setup: Setup[OverturningPlan], wind: float) -> list[Rest]:
    """Rests at rising speeds, the last within the tolerance of where there is none any more, or the highest speed."""
    plan, vehicle = setup.plan, replace(setup.vehicle, loads=())
    level = np.zeros(len(vehicle.wheelsets))
    before = static_state(vehicle).wheel_loads
    step = (plan.highest - plan.lowest) / STEPS
    speed, rests = plan.lowest, list[Rest]()
    last: SupportedVehicle | None = None
    while True:
        loaded = at_speed(setup, vehicle, speed, wind)
        try:
            if last is None:
                state, support = rest_from_design(loaded, level)
            else:
                support = SupportedVehicle(loaded)
                support.go_on_from(last)
                state = support.rest(level)
        except SimulationError:
            if not rests:
                why = f"with a wind of {wind:g} m/s " if wind else ""
                raise SimulationError(f"the vehicle overturns {why}at {3.6 * speed:.4g} km/h already") from None
            step *= 0.5
            if step < plan.tolerance:
                return [*rests[:-1], _last(rests)]
            speed = rests[-1].speed + step
            continue
        left_over = float((state.wheel_loads.sum(axis=0) / before.sum(axis=0)).min())
        rests.append(Rest(speed, wind, 1.0 - state.wheel_loads / before, state.moved[:, 2], left_over))
        last = support
        if speed >= plan.highest:
            return rests
        speed = min(speed + step, plan.highest)


def _last(rests: Sequence[Rest]) -> Rest:
    """The last rest; with a message where the lighter side, as it loses load with the speed, would still carry some
    beyond ``ENDED``: then the search has failed, and not the vehicle."""
    *_, before, last = (rests[0], *rests)
    rate = (before.left_over - last.left_over) / max(last.speed - before.speed, 1e-9)
    if last.left_over <= ENDED * rate * last.speed:
        return last
    message = f"no rest is found above, though the lighter side still carries {last.left_over:.2f} of its load"
    return replace(last, message=message)


def at_speed(setup: Setup[OverturningPlan], vehicle: Vehicle, speed: float, wind: float) -> Vehicle:
    """The vehicle under all that acts on it in the curve, in the axes of the track, also the wind, which is outward."""
    plan, (outward, tilt) = setup.plan, _outward_and_tilt(setup)
    inertia, g = speed**2 / abs(plan.radius), vehicle.gravity
    left = outward * (inertia * cos(tilt) - g * sin(tilt))
    down = g * cos(tilt) + inertia * sin(tilt) - g
    pressed = accelerated(vehicle, left, down)
    if plan.air is None:
        return pressed
    return replace(pressed, loads=(*pressed.loads, *plan.air.loads(vehicle, 0.0, wind, speed, outward, tilt)))


def _outward_and_tilt(setup: Setup[OverturningPlan]) -> tuple[float, float]:
    """1 where outward is to the left, -1 to the right; tilt of the full curve [rad]."""
    plan = setup.plan
    return float(-np.sign(plan.radius)), float(cant_angle(plan.cant, setup.track.cant_base))


def runs_into_curve(setup: Setup[OverturningPlan], limit: float, report: Report) -> dict[str, Any]:
    """The highest speed at which the vehicle comes through and the lowest at which it does not, as attributes."""
    plan = setup.plan
    low, high = plan.lowest, min(SPAN * limit, plan.highest)
    ends: dict[float, str] = {}
    count = int(np.ceil(np.log2(max((high - low) / plan.tolerance, 2.0)))) + 1
    ends[high] = stopped_at(setup, high)
    report(0.2 + 0.8 / count)
    while ends[high] and high - low > plan.tolerance:
        speed = 0.5 * (low + high)
        ends[speed] = stopped_at(setup, speed)
        low, high = (low, speed) if ends[speed] else (speed, high)
        report(0.2 + 0.8 * min(len(ends) / count, 1.0))
    if not ends[high]:
        return {"run_stands_m_s": high, "run_falls_m_s": np.nan, "run_end": ""}
    return {"run_stands_m_s": low, "run_falls_m_s": high, "run_end": ends[high]}


def stopped_at(setup: Setup[OverturningPlan], speed: float) -> str:
    """Why a run into the curve at a speed [m/s] has ended before its end; empty where the vehicle comes through.

    The wind begins at the start and has its peak in the middle of the full curve that is run through.
    """
    plan = setup.plan
    places = [part.centre[0] for part in setup.vehicle.parts]
    start, ahead, on = MARGIN - min(places), MARGIN + max(places), RUN_ON * speed
    if plan.air is not None:
        ahead += RISING * speed
    straight, arc = Straight(start + ahead), Arc(on + ahead, plan.radius, plan.cant)
    track = setup.track.relaid([straight, Transition(plan.transition), arc])
    run: Any = RunPlan(start, straight.length + plan.transition + on, speed)
    vehicle = setup.vehicle
    if plan.air is not None:
        outward, tilt = _outward_and_tilt(setup)
        way = plan.winds[0], start, straight.length + plan.transition + 0.5 * on, plan.gust
        vehicle = plan.air.along_track(vehicle, *way, speed, left=outward, tilt=tilt)
    held: Any = replace(setup, vehicle=vehicle, track=track, plan=run)
    try:
        return str(run_in_time(held).dataset.attrs.get("stop_reason", ""))
    except SimulationError as error:
        return str(error)
