"""Outcomes of runs and searches as data, and their messages for people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from wrsim.contact.status import WORDS
from wrsim.errors import SimulationError
from wrsim.results.summary import CUT_STEPS
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.steady_state import Unbalanced
from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Derailment:
    """What ends a run or a search: a wheel off its rail; the same out of an oscillation that is not resolved; a wheel
    so deep in its rail that no contact law covers it, a lost solution; a vehicle that overturns."""

    kind: Literal["derailed", "unresolved", "overlap", "overturned"]
    message: str


EventKind = Literal["lift", "stop", "contact", "steps", "between", "strike", "spins", "slides", "loose", "swings"]


@dataclass(frozen=True)
class Event:
    """A wheel without contact, a bump stop beyond the end of its table, a message of a contact (bit of
    `wrsim.contact.status`), steps of the integration that had to be cut, a vertical force that the samples miss, a
    strike of a wheel on its rail that the time step does not resolve, an axle that is driven or braked beyond adhesion,
    a friction element without a normal force, or a wheelset that excites itself on its contacts.

    part: name of the wheelset or of the element; start, end: time [s] and distance of the vehicle [m]; missed: the
    force between samples, and by how much it is beyond those beside it [N]; of a strike the force and the error of its
    peaks [N]; step: that resolves the strike or the oscillation [s]; profile: whose end a contact reaches, which
    one ("inner", "outer") and where it is, outward [m]; lasted: way [m] and time [s] in all without contact; swing:
    frequency at which an oscillation grows and that of its cycle, 0 where that is not reached [Hz]; unsolved:
    evaluations of that contact without a solution of the strip model, and steps, both of the whole run so far.
    """

    kind: EventKind
    part: str
    start: tuple[float, float]
    end: tuple[float, float]
    side: str = ""
    bit: int = 0
    missed: tuple[float, float] = (0.0, 0.0)
    step: float = 0.0
    profile: tuple[str, str, float] | None = None
    lasted: tuple[float, float] | None = None
    swing: tuple[float, float] = (0.0, 0.0)
    unsolved: tuple[int, int] = (0, 0)


class NoSteadyMotion(SimulationError):
    """No steady motion was found; ``reason``: what became of the search."""

    def __init__(self, reason: Derailment | SimulationError) -> None:
        super().__init__(str(reason))
        self.reason = reason

    @classmethod
    def of(cls, fault: SimulationError) -> NoSteadyMotion:
        """What has stopped a search, as such an error; it may be one already."""
        return fault if isinstance(fault, cls) else cls(fault)


def stop_words(outcome: Derailment, time: float, distance: float) -> str:
    """Why a run has to stop, when [s] and where [m]."""
    reason = f"derailed: {outcome.message}"
    if outcome.kind == "overlap":
        reason = f"the contact solution is lost: {outcome.message}; a shorter step may help"
    if outcome.kind == "unresolved":
        reason = f"no verdict: {outcome.message}"
    return f"{reason}, at t = {time:.4g} s, {distance:.2f} m along the track"


def event_words(event: Event, vehicle: Vehicle) -> str:
    """What happened, how far and how long."""
    whole = event.end[1] - event.start[1], event.end[0] - event.start[0]
    way, time = event.lasted or whole
    lasted = f"for {way:.2f} m, {1e3 * time:.0f} ms"
    if way < whole[0]:
        lasted += f" in all within {whole[0]:.2f} m"
    wheel = wheel_words(event.side, event.part, vehicle)
    if event.kind == "contact":
        detail = "" if event.profile is None else f": {end_words(*event.profile)}"
        detail += " (in all {} evaluations in {} steps)".format(*event.unsolved) if event.unsolved[1] else ""
        return f"{wheel}: {WORDS[event.bit]}" + ("" if event.end == event.start else f", {lasted}") + detail
    if event.kind == "between":
        force, beyond = (1e-3 * value for value in event.missed)
        return (
            f"Q of {wheel} peaks at {force:.4g} kN between output samples, {beyond:.3g} kN beyond both: "
            'run.fast_channels = ["Q"] or a smaller run.output_interval_ms resolves it'
        )
    if event.kind == "strike":
        force, error = (1e-3 * value for value in event.missed)
        return (
            f"impact of {wheel} (Q {force:.4g} kN): raw Y and Q peaks uncertain by {error:.2g} kN; "
            f"run.step_us = {1e6 * event.step:.0f} resolves them"
        )
    if event.kind == "swings":
        grows, cycle = event.swing
        frequencies = f"at {cycle:.0f} Hz (it grows at {grows:.0f} Hz)" if cycle else f"at {grows:.0f} Hz"
        subject = f"wheelset {event.part}" if len(vehicle.wheelsets) > 1 else "the wheelset"
        return (
            f"{subject} excites itself on its contacts {frequencies}: Y and Q from there on are those of this "
            f'oscillation, in steps of {1e3 * event.step:.2g} ms; damped rails, [track.structure] kind = "moving mass",'
            " or a larger contact.damping_s_per_m end it"
        )
    if event.kind == "stop" and any(event.part in coupling.elements for coupling in vehicle.couplings):
        return f"the stroke of {event.part} is used up {lasted}"
    return {
        "lift": f"{wheel} loses contact {lasted}",
        "stop": f"bump stop {event.part} is beyond the end of its table {lasted}",
        "steps": f"{CUT_STEPS} were subdivided {lasted}",
        "spins": f"wheelset {event.part} is driven beyond adhesion and spins {lasted}",
        "slides": f"wheelset {event.part} is braked beyond adhesion and slides {lasted}",
        "loose": f"nothing presses friction {event.part} together {lasted}: it has no normal force",
    }[event.kind]


def end_words(name: str, side: str, place: float) -> str:
    """The inner or outer end of a profile, where it is [m], and what to do about it."""
    return f"the {side} end of profile '{name}' (u = {1e3 * place:.0f} mm); give it points beyond"


def steady_words(problem: NoSteadyMotion, vehicle: Vehicle) -> str:
    """Why there is no steady motion."""
    reason = problem.reason
    if not isinstance(reason, Derailment):
        steady = isinstance(reason, Unbalanced)
        return f"no steady motion found; {reason}{_unequal(vehicle)}" if steady else str(reason)
    if reason.kind == "derailed":
        return f"the steady motion found is a derailed one: {reason.message}{_unequal(vehicle)}"
    return f"the state found is no contact: {reason.message}" if reason.kind == "overlap" else reason.message


def start_words(problem: NoSteadyMotion, setup: Setup[RunPlan]) -> str:
    """Why a run has nothing to start from, with its place and advice."""
    run, curvature = setup.plan, float(setup.track.curvature(setup.plan.start))
    curve = f" in a curve of {1.0 / abs(curvature):.4g} m radius" if curvature != 0.0 else ""
    advice = ". Start the run before the curve to see what becomes of it" if curve else ""
    return (
        f"the run has no steady motion to start from at {run.start:g} m and {3.6 * run.speed:g} km/h{curve}: "
        f"{steady_words(problem, setup.vehicle)}{advice}"
    )


def _unequal(vehicle: Vehicle) -> str:
    """What wheels of unequal radii ask of a wheelset; empty where all are alike."""
    worst = max((m for m in vehicle.wheelsets), key=lambda m: abs(m.wheelset.left.radius - m.wheelset.right.radius))
    apart = worst.wheelset.left.radius - worst.wheelset.right.radius
    if apart == 0.0:
        return ""
    side = "right" if apart > 0.0 else "left"
    name = f" of wheelset {worst.name}" if len(vehicle.wheelsets) > 1 else ""
    return (
        f". The {side} wheel{name} is the smaller one by {1e3 * abs(apart):.3g} mm of radius: to roll straight the "
        "wheelset has to shift to that side until its profile there rolls on as large a radius, or springs have to "
        "hold it against the creep forces; neither was found"
    )


def wheel_words(side: str, wheelset: str, vehicle: Vehicle) -> str:
    """ "the left wheel", with the name of its wheelset where there are several."""
    return f"the {side} wheel" + (f" of wheelset {wheelset}" if len(vehicle.wheelsets) > 1 else "")
