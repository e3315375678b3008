"""A vehicle that rolls straight at any speed: its force law, the steady state and the small motions about it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.derailment import contact_words, overlap, pushed, wheels_of
from wrsim.analysis.motion.messages import NoSteadyMotion, steady_words
from wrsim.analysis.motion.start import first_steady, shifts
from wrsim.analysis.stability.modes import Modes, modes_of
from wrsim.core.contact.records import STATUS_TOO_DEEP
from wrsim.errors import SimulationError
from wrsim.geometry.track.segments import Straight
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.stability import StabilityPlan
from wrsim.simulation.law import ConicalVehicleOnTrack, VehicleOnTrack
from wrsim.simulation.modes import linearise, mode_name
from wrsim.simulation.steady_state import Equilibrium, steady_state
from wrsim.simulation.system import Array

LENGTH, PLACE = 400.0, 200.0
"""Straight track, and where on it the vehicle starts [m]; behind its end it goes on straight."""


class RollingVehicle:
    """Steady rolling on straight level track. ``law`` is that of the speed asked for last."""

    def __init__(self, setup: Setup, speed: float) -> None:
        straight = setup.track.relaid([Straight(LENGTH)])
        self.setup = replace(setup, track=straight, plan=RunPlan(PLACE, PLACE, speed))
        self.law: VehicleOnTrack
        if setup.conical is not None:
            self.law = ConicalVehicleOnTrack(
                setup.vehicle, straight, setup.conical, speed=speed, start=PLACE, drive=setup.drive
            )
        else:
            self.law = force_law(self.setup)
        self._last: tuple[Array, Array] | None = None
        self.remark = ""
        """Messages of the contacts of the state found last."""

    def state(self, speed: float) -> tuple[Array, Array]:
        """The steady state (q, q_t) at a speed [m/s]. Raises SimulationError when there is none."""
        law = self.law
        law.set_speed(speed)
        law.look_near(PLACE)
        try:
            found = self._from_design() if self._last is None else steady_state(law, self._last)
        except SimulationError:
            if self._last is None:
                raise
            found = self._from_design()
        self._last = found.q, found.q_t
        law.at(0.0, found.q, found.q_t)
        wheels = wheels_of(law)
        if any(wheel.status & STATUS_TOO_DEEP for wheel in wheels):
            raise SimulationError(steady_words(NoSteadyMotion(overlap(wheels)), law.vehicle))
        self.remark = contact_words(wheels)
        return found.q.copy(), found.q_t.copy()

    def _from_design(self) -> Equilibrium:
        """The steady state from the middle of the track or, where loads push the vehicle aside, from there."""
        return first_steady(self.law, shifts(self.setup, pushed(self.setup, self.law.speed).left))

    def modes(self, speed: float, highest: float) -> Modes:
        """Modes of the small motions about the steady state at a speed [m/s], up to a frequency [Hz]."""
        linear = linearise(self.law, self.law.bodies, *self.state(speed))
        return modes_of(linear, speed, len(self.law.vehicle.wheelsets), highest)


def mode_shapes(setup: Setup[StabilityPlan], speeds: Sequence[float]) -> Iterator[tuple[Modes, list[str]]]:
    """Modes of the set-up's vehicle at speeds [m/s], each with the names of its modes."""
    rolling = RollingVehicle(setup, speeds[0])
    for speed in speeds:
        found = rolling.modes(speed, setup.plan.highest)
        yield found, [mode_name(setup.vehicle, shape) for shape in found.shapes]
