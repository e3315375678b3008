"""A vehicle at rest on level, canted or twisted rails: its pose under its loads, and the force of every wheel.

The wheelsets rest each on two hard supports half the profile spacing to either side of its middle that
push and do not pull, so a wheel may lift; the rails hold them sideways at their own height. All else finds its place in
its springs, bump stops and all. Where on the profiles the contacts lie is left out: with rails under
the wheels ``analysis = "equilibrium"`` gives more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import cos, sin

import numpy as np

from wrsim.errors import SimulationError
from wrsim.jit.linalg import Vec
from wrsim.simulation.force_law import all_on_all
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.newton import damped_newton, relax
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import TOLERANCE, SteadyMotion
from wrsim.simulation.system import COORDINATES, Array
from wrsim.track.segments import Straight
from wrsim.track.track import Track
from wrsim.vehicle.bogies import Bogie
from wrsim.vehicle.elements import Triple
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import Vehicle

SUPPORT = 1e10  # stiffness of a support [N/m]
PARTS = 0.25, 0.5, 0.75, 1.0
"""Parts of the loads, one after the other, where the rest under all of them is not found at once."""
RELAXING = 200  # most steps of a motion with the forces
LENGTH, PLACE = 200.0, 100.0  # level track, and where on it the vehicle is [m]

X, Y, Z, HEADING, ROLL, SPIN = (COORDINATES.index(name) for name in ("x", "y", "z", "heading", "roll", "spin"))


@dataclass(frozen=True)
class StaticState:
    """wheel_loads: (wheelsets, 2), left and right [N]; moved: of the bodies from the design position, (bodies, 3), to
    the left, up [m] and roll [rad]; readings: forces and travels of the elements, (elements, 6); moment: with which a
    bogie that is turned is held turned, to the left [N m].
    """

    wheel_loads: Array
    moved: Array
    readings: Array
    moment: float = 0.0


def canted(vehicle: Vehicle, angle: float) -> Vehicle:
    """The vehicle on rails that are canted by this angle [rad], the right one higher, in the axes of the track: the
    same as a curve to the right with so much cant deficiency, but for the weight, which is m g cos(angle)."""
    return accelerated(vehicle, vehicle.gravity * sin(angle), vehicle.gravity * (cos(angle) - 1.0))


def accelerated(vehicle: Vehicle, left: float, down: float) -> Vehicle:
    """The vehicle with loads at all masses, carried ones and payloads: their mass times an acceleration to the left and
    one down, beside that of gravity [m/s2]."""
    masses = [(part.name, part.mass, part.centre) for part in vehicle.parts]
    masses += [(p.body, -p.force[2] / vehicle.gravity, p.at) for p in vehicle.payloads]
    for c in vehicle.carried:
        x, y, z = vehicle.place(c.body)
        masses.append((c.body, c.mass, (x, y, z + c.height)))
    forces = (
        Load.constant(f"inertia {i}", body, (0.0, mass * left, -mass * down), point)
        for i, (body, mass, point) in enumerate(masses)
    )
    return replace(vehicle, loads=(*vehicle.loads, *forces))


def static_state(vehicle: Vehicle, twist: float = 0.0) -> StaticState:
    """The vehicle at rest under its payloads and loads, those over time or distance at their largest.

    twist: by how much the rails turn about the track along it [rad/m]; they are level under the middle of the
    wheelsets and their left side rises ahead. Raises SimulationError when the vehicle finds no rest: it overturns.
    """
    ahead = np.array([mounted.x for mounted in vehicle.wheelsets])
    return rest_from_design(vehicle, twist * (ahead - ahead.mean()))[0]


def rest_from_design(vehicle: Vehicle, tilt: Array) -> tuple[StaticState, SupportedVehicle]:
    """A rest looked for from the design position, and what the next one can be looked for from.

    tilt (wheelsets,) [rad]: see `SupportedVehicle.rest`. Raises SimulationError as `static_state`.
    """
    supported = SupportedVehicle(vehicle)
    try:
        return supported.rest(tilt), supported
    except SimulationError:
        if not vehicle.loads:
            raise
    before: SupportedVehicle | None = None
    for part in PARTS:
        supported = SupportedVehicle(vehicle.loaded_as(partial(_part_of, part)))
        if before is not None:
            supported.go_on_from(before)
        state, before = supported.rest(tilt), supported
    return state, supported


def _part_of(part: float, load: Load) -> Triple:
    x, y, z = load.largest
    return part * x, part * y, part * z


class SupportedVehicle(SteadyMotion):
    """A vehicle on its supports, from one rest to the next.

    Friction goes on from where it has slipped to; a motion between two rests may take its time, for dampers. There is
    no inertia in it, and no time for what lies behind dampers: a stiffness there is taken as rigid while it moves.
    ahead: places of the wheelsets along the vehicle (wheelsets,) [m].
    """

    def __init__(self, vehicle: Vehicle) -> None:
        """vehicle: under its payloads and loads, those over time or distance at their largest."""
        loaded = vehicle.loaded_as(lambda load: load.largest)
        track = Track.build([Straight(LENGTH)], 1.5)
        super().__init__(VehicleOnTrack(loaded, track, (), speed=0.0, start=PLACE, drive="train"))
        wheelsets = vehicle.wheelsets
        w = len(wheelsets)
        self.ahead = np.array([mounted.x for mounted in wheelsets])
        self._vehicle = vehicle
        self._half = np.array([0.5 * mounted.wheelset.profile_spacing for mounted in wheelsets])
        self._radius = np.array([mounted.wheelset.mean_radius for mounted in wheelsets])
        self._before: tuple[Array, float] | None = None
        self._x = self.unknowns(*design_state(self.law))
        supports = self._supported
        self._design = supports[w:, [Y, Z, ROLL]].copy()
        supports[:w, Z] = self._radius - 0.5 * vehicle.weight / w / SUPPORT

    def go_on_from(self, previous: SupportedVehicle) -> None:
        """Look for the next rest from that of the same vehicle under other loads."""
        self._x[:], self.slips = previous._x, previous.slips.copy()

    @property
    def _supported(self) -> Array:
        """Coordinates of the bodies (bodies, 6), wheelsets first; a view."""
        n = len(self.law.bodies)
        return self._x[: 6 * n].reshape(n, 6)

    def _state(self, x: Array) -> tuple[Array, Array, Vec]:
        q, q_t, turning = super()._state(x)
        if self._before is not None:
            before, interval = self._before
            n = 6 * len(self.law.bodies)
            q_t[:n] += (q[:n] - before[:n]) / interval
            q_t[self.positions] = (q[self.positions] - before[self.positions]) / interval
        return q, q_t, turning

    def rest(
        self, tilt: Array, turned: tuple[Bogie, float] | None = None, interval: float | None = None
    ) -> StaticState:
        """The rest on supports that are turned about the track, tilt (wheelsets,) [rad], positive lifts the left side.

        turned: a bogie and by how much its wheelsets are turned to the left about its centre [rad]; then all
        wheelsets are held along the track and in yaw, too. interval: time that the motion there took [s]; without it
        dampers do nothing. Raises SimulationError when the vehicle finds no rest: it overturns.
        """
        x, w = self._x, len(self._vehicle.wheelsets)
        supported, held = self._supported, [Y, SPIN]
        self._before = None if interval is None else (self.state(x)[0], interval)
        supported[:w, ROLL] = tilt
        if turned is not None:
            held += [X, HEADING]
            bogie, angle = turned
            numbers = list(bogie.wheelsets)
            arm = self.ahead[numbers] - bogie.centre
            supported[numbers, HEADING] = angle
            supported[numbers, X] = PLACE + bogie.centre + arm * cos(angle)
            supported[numbers, Y] = arm * sin(angle)
        free = np.delete(np.arange(x.size), [6 * i + k for i in range(w) for k in held])
        supports = np.zeros((w, 2))
        pushed = np.zeros((w, 6))

        def residual(part: Array) -> Array:
            x[free] = part
            left = self.residual(x)
            axles = left[: 6 * w].reshape(w, 6)
            pushed[:] = axles
            for side, sign in enumerate((1.0, -1.0)):
                sunk = self._radius - supported[:w, Z] + sign * self._half * (tilt - supported[:w, ROLL])
                supports[:, side] = SUPPORT * np.maximum(sunk, 0.0)
            up, about = supports.sum(axis=1), self._half * (supports[:, 0] - supports[:, 1])
            axles[:, Z] += up / self._vehicle.weight
            across = axles[:, Y] * np.cos(supported[:w, HEADING]) - axles[:, X] * np.sin(supported[:w, HEADING])
            # the rails push back at their height
            axles[:, ROLL] += about / self._vehicle.weight - self._radius * across
            return left[free]

        with self.law.relaxed_dampers(self.slips):
            x[free], left, _ = damped_newton(residual, x[free].copy(), self.small[free], TOLERANCE, 100)
            if np.max(np.abs(left)) > TOLERANCE:  # stopped at a spring that lets go: move with the forces for a while
                terms = [(residual, all_on_all(free.size))]
                crept, _ = relax(residual, x[free].copy(), self.small[free], terms, TOLERANCE, RELAXING, np.copy)
                x[free], left, _ = damped_newton(residual, crept, self.small[free], TOLERANCE, 100)
        largest, lifted = float(np.max(np.abs(left))), np.all(supports == 0.0, axis=0)
        if not largest <= TOLERANCE or lifted.any():
            why = f"{largest:.2g} of its weight is left over"
            if largest <= TOLERANCE:
                why = f"no {'left' if lifted[0] else 'right'} wheel carries"
            raise SimulationError(f"{self._vehicle.name} does not come to rest under its loads: it overturns ({why})")
        readings = self.law.records.copy()
        self._before = None
        self.slips = self.law.relaxed_rates(*self.state(x))[self.law.sliders]
        moment = 0.0
        if turned is not None:
            force = -self._vehicle.weight * pushed[numbers]
            levers = supported[numbers][:, [X, Y]] - (PLACE + bogie.centre, 0.0)
            moment = float(np.sum(force[:, HEADING] + levers[:, 0] * force[:, Y] - levers[:, 1] * force[:, X]))
        return StaticState(supports.copy(), supported[w:, [Y, Z, ROLL]] - self._design, readings, moment)
