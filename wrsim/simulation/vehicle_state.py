"""States of a whole vehicle on its track: the design position, rest, and steady motion at speed.

``design_state`` puts every body where the file has it, ``steady_state`` finds the poses at which nothing accelerates
but what the curve asks for. Both serve as starts of runs; the second at speed 0 is the position of rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.body import steady as kernels
from wrsim.errors import SimulationError
from wrsim.simulation.equilibrium import Equilibrium, bracket, newton
from wrsim.simulation.placement import place_on_track
from wrsim.simulation.system import COORDINATES, Array
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

if TYPE_CHECKING:
    from wrsim.simulation.vehicle_law import VehicleOnTrack

SMALL_WHEELSET = {"z": 1e-5, "x": 1e-3, "y": 1e-4, "heading": 1e-4, "roll": 1e-5, "spin": 1e-2}
"""Changes of a wheelset's coordinates (its spin: rate) that change the forces by a few per cent ..."""

SMALL_BODY = {"z": 1e-4, "x": 1e-3, "y": 1e-3, "heading": 1e-3, "roll": 1e-3, "spin": 1e-4}
"""... and of another body's."""

TOLERANCE = 1e-10
"""Largest force left over, as a part of the weight; moments are divided by 1 m."""

HUNG = 1e-6
"""Forces left over on the bodies, as a part of the weight, with which the search goes on to the wheelsets."""

SMALL_RAIL = (1e-5, 1e-5)
"""Changes of a rail's displacement, lateral and vertical, that change the forces by a few per cent [m]."""

LARGEST_APPROACH = 2e-3
"""How far a wheelset is lowered or raised to be carried by the rails [m]."""


def design_state(law: VehicleOnTrack, distance: float, *, lateral: float = 0.0) -> tuple[Array, Array]:
    """State (q, q_t) of a vehicle that follows the track in its design position, its origin at ``distance`` [m].

    Every body lies at its own place along the track, wheelsets ``lateral`` [m] to the left, bodies half as much. The
    wheels do not touch the rails yet, or overlap them by nothing.
    """
    q, q_t = np.zeros(law.size), np.zeros(law.size)
    vehicle = law.vehicle
    lower = np.mean([mounted.height - mounted.wheelset.mean_radius for mounted in vehicle.wheelsets])
    for i, part in enumerate(vehicle.parts):
        wheelset = i < len(vehicle.wheelsets)
        radius = vehicle.wheelsets[i].wheelset.mean_radius if wheelset else np.inf
        own = slice(6 * i, 6 * i + 6)
        q[own], q_t[own] = place_on_track(
            law.track.centre,
            distance + part.centre[0],
            speed=law.speed,
            height=part.centre[2] - float(lower),
            spin_rate=law.speed / radius,
            lateral=part.centre[1] + (lateral if wheelset else 0.5 * lateral),
        )
    return q, q_t


class SteadyVehicle:
    """Forces less inertia forces of a vehicle in steady motion about the axis of the curve that it is in.

    Unknowns, six a body: its coordinates, of a wheelset the spin rate (over and above the turning of all) in the place
    of the spin angle; then the displacements of the rails under the wheels, if elastic. ``residual(x)`` is what is
    left over, ``state(x)`` the state; ``unknowns(q, q_t)`` goes back.
    """

    def __init__(self, law: VehicleOnTrack, distance: float) -> None:
        """distance: of the vehicle's origin, within some metres [m]."""
        self.law = law
        n, w = len(law.bodies), len(law.vehicle.wheelsets)
        self.distance = distance + law.vehicle.parts[law.vehicle.reference].centre[0]
        self.spins = 5 + 6 * np.arange(w)
        self.inertia = np.array([(body.mass, *body.inertia) for body in law.bodies])
        self.small = np.array(
            [(SMALL_WHEELSET if i < w else SMALL_BODY)[name] for i in range(n) for name in COORDINATES]
        )
        self.scale = np.full(6 * n, 1.0 / (law.vehicle.mass * STANDARD_GRAVITY))
        self._out, self._inertia = np.zeros(law.size), np.zeros(6 * n)
        self._states = np.zeros((n, 18))
        self.rails = slice(law.size - law.rails, law.size)
        if law.elastic is not None:
            self.small = np.append(self.small, np.tile(SMALL_RAIL, law.rails // 2))
            self.scale = np.append(self.scale, np.full(law.rails, self.scale[0]))
            self.rail_masses = np.tile(law.elastic.mass, law.rails // 2)

    def state(self, x: Array) -> tuple[Array, Array]:
        """State (q, q_t) with these unknowns; dampers in series with springs extended by nothing."""
        return self._state(x)[:2]

    def unknowns(self, q: Array, q_t: Array) -> Array:
        """Unknowns of a steady state near (q, q_t)."""
        n = len(self.inertia)
        x = np.concatenate([q[: 6 * n], q[self.rails]])
        x[self.spins] = 0.0
        _, rates, _ = self._state(x)
        x[self.spins] = q_t[self.spins] - rates[self.spins]
        return x

    def _state(self, x: Array) -> tuple[Array, Array, tuple[float, float, float]]:
        law, n = self.law, len(self.inertia)
        q, q_t = np.zeros(law.size), np.zeros(law.size)
        q[: 6 * n] = x[: 6 * n]
        q[self.spins] = 0.0
        q[self.rails] = x[6 * n :]
        path = law.track.centre
        wx, wy, wz, _, status = kernels.follow_together(
            q,
            x[self.spins],
            len(self.spins),
            path.table,
            path.step,
            law.vehicle.reference,
            self.distance,
            law.speed,
            q_t[: 6 * n],
        )
        if status:
            raise SimulationError(f"the vehicle has no place on the track near {self.distance:g} m")
        return q, q_t, (wx, wy, wz)

    def residual(self, x: Array) -> Array:
        """Forces less inertia forces over the weight (6 n,), then those on the rails under the wheels."""
        n = len(self.inertia)
        q, q_t, turning = self._state(x)
        self.law(0.0, q, q_t, self._out)
        kernels.together_inertia(q, q_t, *turning, self.inertia, len(self.spins), self._states, self._inertia)
        left = self._out[: 6 * n] - self._inertia
        if self.law.elastic is not None:
            left = np.append(left, self.rail_masses * self._out[self.rails])
        left *= self.scale
        if self.law.speed == 0.0:
            left[self.spins] = 0.0  # at rest an axle turns as it likes
        return left


def steady_state(
    law: VehicleOnTrack,
    distance: float,
    guess: tuple[Array, Array] | None = None,
    *,
    tolerance: float = TOLERANCE,
    enough: float | None = None,
    max_iterations: int = 60,
) -> Equilibrium:
    """The steady motion of a vehicle with its origin at ``distance`` [m], at the speed of its law; rest at speed 0.

    guess: a state near it; default the design position, wheelsets lowered until the rails carry them.
    tolerance: largest force left over, as a part of the weight, that ends the search; enough: one that is accepted when
    the search finds no better, default the same. The law's drive must hold the vehicle ("train" or "wheels"). Raises
    SimulationError when there is no such motion near the guess, naming the bodies whose forces remain.
    """
    law.look_near(distance)
    steady = SteadyVehicle(law, distance)
    if guess is None:
        q, q_t = design_state(law, distance)
        lower_on_rails(law, q, q_t)
    else:
        q, q_t = guess
    x = steady.unknowns(q, q_t)
    with law.dampers_at_rest():
        left = steady.residual(x)
        if not np.all(np.isfinite(left)):
            raise SimulationError("steady motion: the forces at its start are not finite")
        first = _hang(steady, x, max_iterations)
        x, left, iterations = newton(steady.residual, x, steady.small, tolerance, max_iterations)
    largest = float(np.max(np.abs(left)))
    if not largest <= (tolerance if enough is None else enough):
        raise SimulationError(f"no steady motion found; {_words(law, left)}")
    q, q_t = steady.state(x)
    return Equilibrium(q, law.yielded(q, q_t), largest, first + iterations)


def _hang(steady: SteadyVehicle, x: Array, max_iterations: int) -> int:
    """Let the bodies find their places in their springs while the wheelsets stay where they are; changes x.

    In a curve a long body lies along the chord, far inside of the centre line. Returns the iterations.
    """
    hung = slice(6 * len(steady.spins), 6 * len(steady.inertia))
    if hung.start == hung.stop:
        return 0
    whole = x.copy()

    def residual(bodies: Array) -> Array:
        whole[hung] = bodies
        return steady.residual(whole)[hung]

    x[hung], _, iterations = newton(residual, x[hung].copy(), steady.small[hung], HUNG, max_iterations)
    return iterations


def _words(law: VehicleOnTrack, left: Array) -> str:
    """The largest forces that remain."""
    order = np.argsort(-np.abs(left))[:4]
    names = law.vehicle.names
    places = [f"{name} {coordinate}" for name in names for coordinate in COORDINATES] + ["rail"] * law.rails
    words = [f"{places[i]} {left[i]:.3g}" for i in order]
    return "remaining forces over the weight: " + ", ".join(words)


def lower_on_rails(law: VehicleOnTrack, q: Array, q_t: Array) -> None:
    """Lower or raise each wheelset along the track's normal until the rails carry what the vehicle rests on it."""
    out = np.zeros(law.size)
    share = law.vehicle.mass * STANDARD_GRAVITY / len(law.vehicle.wheelsets)
    for i in range(len(law.vehicle.wheelsets)):

        def excess(height: float, i: int = i) -> float:
            q[6 * i] = height
            law(0.0, q, q_t, out)
            return float(out[6 * i]) / share

        if not bracket(excess, float(q[6 * i]), SMALL_WHEELSET["z"], 0.1, LARGEST_APPROACH):
            raise SimulationError(
                f"the rails do not carry wheelset '{law.vehicle.names[i]}' anywhere within "
                f"{1e3 * LARGEST_APPROACH:g} mm of its design height; do wheels, gauge and radius fit?"
            )
    if law.elastic is not None:  # everything sinks with the rails
        sunk = share / 2.0 / law.elastic.stiffness[1]
        q[: 6 * len(law.bodies) : 6] -= sunk
        q[law.size - law.rails + 1 :: 2] -= sunk
