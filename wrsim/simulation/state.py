"""States of a vehicle on its track: rest, and steady motion at speed.

From a design position (`simulation.placement`) ``lower_on_rails`` lets the rails carry the wheelsets, ``steady_state``
finds the poses at which nothing accelerates but what the curve asks for; at speed 0 that is the position of rest. All
of them are meant at the time 0, when the vehicle's origin is at the start of its law.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.body import steady as kernels
from wrsim.core.linalg import Vec
from wrsim.errors import SimulationError
from wrsim.simulation.bodies import inertia_table
from wrsim.simulation.force_law import Forces, groups_in_a_row
from wrsim.simulation.newton import DIFFERENCE, Apart, bracket, damped_newton, relax, roots
from wrsim.simulation.placement import design_state, turn_gears
from wrsim.simulation.system import COORDINATES, Array

if TYPE_CHECKING:
    from wrsim.simulation.law import VehicleOnTrack

SMALL_WHEELSET = {"z": 1e-5, "x": 1e-3, "y": 1e-4, "heading": 1e-4, "roll": 1e-5, "spin": 1e-2}
"""Changes of a wheelset's coordinates (its spin: rate) that change the forces by a few per cent ..."""

SMALL_BODY = {"z": 1e-4, "x": 1e-3, "y": 1e-3, "heading": 1e-3, "roll": 1e-3, "spin": 1e-4}
"""... and of another body's."""

GOAL, TOLERANCE = 1e-10, 1e-9
"""Largest force left over, as a part of the weight, that ends the search, and that is accepted; moments are divided by
1 m."""

BODIES_PLACED = 1e-6
"""Forces left over on the bodies, as a part of the weight, with which the search goes on to the wheelsets."""

COUPLED = 1e-4
"""Steps of the derivatives of bodies that couplings hold on to, as parts of these changes: heads of buffers that stick
give way by some 0.1 mm, ten metres from the middle."""

SMALL_RAIL = (1e-5, 1e-5)
"""Changes of a rail's displacement, lateral and vertical, that change the forces by a few per cent [m]."""

SMALL_BOX = 1e-4
"""The same of an axle box's pitch [rad]."""

SMALL_TURN, SMALL_TWIST = 1e-2, 1e-4
"""The same of the rate with which independent wheels turn against each other [rad/s], and of the twist of an axle
[rad]."""

FREE = 1e-9
"""Moment about its axle with which an independent wheel rolls freely, as a part of the weight times 1 m."""

MOST_STEPS, AT_FLANGES = 120, 1e-6
"""Of the way of a vehicle with independent wheels to its flanges: steps, and forces left over at its end, as a part of
the weight."""

SEARCH_HEIGHT = 0.05
"""How far a wheelset is lowered or raised in search of the rails [m]."""

SEARCH_ROLL = 0.05
"""How far it is rolled in search of the other rail [rad]."""


@dataclass(frozen=True)
class Equilibrium:
    """A state without acceleration: q, q_t; largest residual over the weight; Newton's iterations."""

    q: Array
    q_t: Array
    residual: float
    iterations: int


class Unbalanced(SimulationError):
    """No state without acceleration was found; ``forces``: the largest that remain, over the weight, by their names."""

    def __init__(self, forces: tuple[tuple[str, float], ...]) -> None:
        super().__init__("remaining forces over the weight: " + ", ".join(f"{name} {f:.3g}" for name, f in forces))
        self.forces = forces


class NotCarried(SimulationError):
    """The rails do not carry a wheelset at any height within ``SEARCH_HEIGHT``."""

    def __init__(self, wheelset: str) -> None:
        super().__init__(
            f"the rails do not carry wheelset '{wheelset}' anywhere within {1e3 * SEARCH_HEIGHT:g} mm of its height; "
            "do wheels, gauge and radius fit?"
        )


class SteadyMotion:
    """Forces less inertia forces of a vehicle in steady motion about the axis of the curve that it is in.

    Unknowns, six a body: its coordinates, of a wheelset the spin rate (over and above the turning of all) in the place
    of the spin angle; then the pitch of the axle boxes, then the twist of axles (of independent wheels its rate), then,
    if elastic, the displacements of the rails under the wheels. ``residual(x)`` is what is left over, ``state(x)`` the
    state; ``unknowns(q, q_t)`` goes back.
    """

    def __init__(self, law: VehicleOnTrack) -> None:
        self.law = law
        self.slips = np.zeros(len(law.sliders))
        """Unknowns of sliders from which these settle; 0: from the design position."""
        n, w = len(law.bodies), len(law.vehicle.wheelsets)
        self.distance = law.start + law.vehicle.parts[law.vehicle.reference].centre[0]
        self.spins = 5 + 6 * np.arange(w)
        self.inertia = inertia_table(law.bodies)
        self.small = np.array(
            [(SMALL_WHEELSET if i < w else SMALL_BODY)[name] for i in range(n) for name in COORDINATES]
        )
        self.difference = np.full(6 * n + law.positions, DIFFERENCE)
        for coupling in law.vehicle.couplings:
            for name in (coupling.ahead, coupling.behind):
                own = 6 * law.vehicle.index(name)
                self.difference[own : own + 6] = COUPLED
        self.scale = np.full(6 * n, 1.0 / law.vehicle.weight)
        self._out, self._inertia = np.zeros(law.size), np.zeros(6 * n)
        self.positions = slice(law.size - law.positions, law.size)
        free = [law.vehicle.wheelsets[i].wheelset.independent for i in law.twists]
        small = [SMALL_TURN if alone else SMALL_TWIST for alone in free]
        boxes = np.full(law.positions - law.rails - len(free), SMALL_BOX)
        self.small = np.concatenate([self.small, boxes, small, np.tile(SMALL_RAIL, law.rails // 2)])
        self.turns = np.array([at for at, alone in zip(law.twists.values(), free, strict=True) if alone], dtype=int)
        """Places of the twists of independent wheels in the state, ..."""
        self.alone = np.array([i for i, by_itself in zip(law.twists, free, strict=True) if by_itself], dtype=int)
        """Numbers of their wheelsets."""
        self.turning = self.turns - (law.size - law.positions) + 6 * n
        """... and among the unknowns."""
        self.scale = np.append(self.scale, np.full(law.positions, self.scale[0]))
        rails = () if law.elastic is None else np.tile(law.elastic.mass, law.rails // 2)
        twisting = (0.25 * law.bodies[i].inertia[1] for i in law.twists)
        self.masses = np.array([*(box.inertia[1] for _, box in law.vehicle.boxes.values()), *twisting, *rails])

    @property
    def apart(self) -> Apart | None:
        """Unknowns that may be changed at once, each of another vehicle of a train; None for one vehicle."""
        law, n = self.law, 6 * len(self.inertia)
        if law.units < 2:
            return None
        own = []
        for places in law.coordinates_of_units(alone=True):
            behind = places[places >= law.size - law.positions] - (law.size - law.positions) + n
            own.append(np.concatenate([places[places < n], behind]))
        return groups_in_a_row(own)

    def state(self, x: Array) -> tuple[Array, Array]:
        """State (q, q_t) with these unknowns; those of dampers in series with springs 0, of sliders ``slips``."""
        return self._state(x)[:2]

    def unknowns(self, q: Array, q_t: Array) -> Array:
        """Unknowns of a steady state near (q, q_t)."""
        n = len(self.inertia)
        x = np.concatenate([q[: 6 * n], q[self.positions]])
        x[self.spins] = 0.0
        _, rates, _ = self._state(x)
        x[self.spins] = q_t[self.spins] - rates[self.spins]
        x[self.turning] = q_t[self.turns]
        return x

    def _state(self, x: Array) -> tuple[Array, Array, Vec]:
        law, n = self.law, len(self.inertia)
        q, q_t = np.zeros(law.size), np.zeros(law.size)
        q[: 6 * n] = x[: 6 * n]
        q[self.spins] = 0.0
        q[self.positions] = x[6 * n :]
        q[self.turns], q_t[self.turns] = 0.0, x[self.turning]
        q_t[law.sliders] = self.slips
        turning, _, status = kernels.follow_together(
            q, x[self.spins], law.track.centre.curve, law.vehicle.reference, self.distance, law.speed, q_t[: 6 * n]
        )
        if status:
            raise SimulationError(f"the vehicle has no place on the track near {self.distance:g} m")
        turn_gears(law, q_t)
        return q, q_t, turning

    def residual(self, x: Array, contacts: bool = True) -> Array:
        """Forces less inertia forces over the weight (6 n,), then the moments on the axle boxes and the forces on the
        rails under the wheels. Without contacts it is complete for bodies that are no wheelsets."""
        n = len(self.inertia)
        q, q_t, turning = self._state(x)
        forces: Forces = self.law if contacts else self.law.on_bodies
        forces(0.0, q, q_t, self._out)
        kernels.together_inertia(q, q_t, turning, self.inertia, len(self.spins), self._inertia)
        left = np.append(self._out[: 6 * n] - self._inertia, self.masses * self._out[self.positions])
        left *= self.scale
        if self.law.speed == 0.0:
            left[self.spins] = x[self.spins]  # at rest no axle turns
            left[self.turning] = x[self.turning]
        return left

    def rolled(self, x: Array) -> Array:
        """The same with independent wheels turning so that the moment about the axle of each vanishes: creep forces
        saturate, and far from free rolling their derivatives are of little use."""
        x = x.copy()
        spins, turning = self.spins[self.alone], self.turning

        def moments(omega: Array) -> Array:
            left, right = omega.reshape(2, -1)
            x[spins], x[turning] = 0.5 * (left + right), left - right
            rest = self.residual(x)
            return np.concatenate([0.5 * rest[spins] + rest[turning], 0.5 * rest[spins] - rest[turning]])

        begin = np.concatenate([x[spins] + 0.5 * x[turning], x[spins] - 0.5 * x[turning]])
        moments(roots(moments, begin, SMALL_TURN, FREE))
        return x

    def largest(self, q: Array, q_t: Array) -> float:
        """Largest force left over at the steady state near (q, q_t), as a part of the weight."""
        self.slips = q_t[self.law.sliders]
        with self.law.settled(self.slips):
            return float(np.max(np.abs(self.residual(self.unknowns(q, q_t)))))


def steady_state(
    law: VehicleOnTrack,
    guess: tuple[Array, Array] | None = None,
    *,
    tolerance: float = TOLERANCE,
    max_iterations: int = 60,
    near: VehicleOnTrack | None = None,
) -> Equilibrium:
    """The steady motion of a vehicle at the start and at the speed of its law; rest at speed 0.

    guess: a state near it, from whose slips friction goes on; default the design position, wheelsets lowered until the
    rails carry them. tolerance:
    largest force left over, as a part of the weight, that is accepted when the search finds no better. near: a law with
    nearly the same forces, of which the derivatives are taken. Something must hold the speed: the law's drive, or
    springs to a frame. Raises Unbalanced when there is no such motion near the guess, NotCarried when the rails are not
    there.
    """
    law.look_near(law.start)
    steady = SteadyMotion(law)
    q, q_t = lower_on_rails(law, *design_state(law)) if guess is None else guess
    steady.slips = q_t[law.sliders]
    x = steady.unknowns(q, q_t)
    slope = None
    if near is not None:
        nearly = SteadyMotion(near)
        nearly.slips, slope = steady.slips, nearly.residual
    goal = GOAL if tolerance <= TOLERANCE or near is None else tolerance
    with law.settled(steady.slips), (near or law).settled(steady.slips):
        if not np.all(np.isfinite(steady.residual(x))):
            raise SimulationError("steady motion: the forces at its start are not finite")
        first = _place_bodies(steady, x, max_iterations)
        # derivatives from one contact to the next, residuals from a cold start: the answer does not depend on the way
        x, left, iterations = damped_newton(
            steady.residual, x, steady.small, goal, max_iterations, slope, (near or law).following,
            steady.apart, steady.difference,
        )  # fmt: skip
    largest = float(np.max(np.abs(left)))
    if not largest <= tolerance:
        raise Unbalanced(_largest(law, left))
    q, q_t = steady.state(x)
    return Equilibrium(q, law.settled_rates(q, q_t), largest, first + iterations)


def relaxed_state(law: VehicleOnTrack, guess: tuple[Array, Array]) -> Equilibrium:
    """Where a vehicle with independent wheels creeps to from a state, which is near its steady motion: no creep forces
    lead its axles there, flanges do, and Newton's method does not find the way to them.
    """
    law.look_near(law.start)
    steady = SteadyMotion(law)
    q, q_t = guess
    steady.slips = q_t[law.sliders]
    x = steady.unknowns(q, q_t)
    with law.settled(steady.slips):
        _place_bodies(steady, x, MOST_STEPS)
        x, largest = relax(steady.residual, x, steady.small, AT_FLANGES, MOST_STEPS, steady.rolled, law.following)
    q, q_t = steady.state(x)
    return Equilibrium(q, q_t, largest, MOST_STEPS)


def _place_bodies(steady: SteadyMotion, x: Array, max_iterations: int) -> int:
    """Let bodies and axle boxes find their places in their springs while the wheelsets stay where they are; changes x.

    In a curve a long body lies along the chord, far inside of the centre line. Returns the iterations.
    """
    boxes = len(steady.law.vehicle.boxes)
    bodies = slice(6 * len(steady.spins), 6 * len(steady.inertia) + boxes)
    if bodies.start == bodies.stop:
        return 0
    whole = x.copy()

    def residual(places: Array) -> Array:
        whole[bodies] = places
        return steady.residual(whole, contacts=False)[bodies]

    x[bodies], _, iterations = damped_newton(
        residual, x[bodies].copy(), steady.small[bodies], BODIES_PLACED, max_iterations,
        difference=steady.difference[bodies],
    )  # fmt: skip
    return iterations


def _largest(law: VehicleOnTrack, left: Array) -> tuple[tuple[str, float], ...]:
    """The four largest forces that remain, with the names of their coordinates."""
    names = law.vehicle.names
    places = [f"{name} {coordinate}" for name in names for coordinate in COORDINATES]
    places += [f"{name} pitch" for name in law.vehicle.boxes]
    places += [f"{names[i]} twist" for i in law.twists] + ["rail"] * law.rails
    return tuple((places[i], float(left[i])) for i in np.argsort(-np.abs(left))[:4])


def lower_on_rails(law: VehicleOnTrack, q: Array, q_t: Array) -> tuple[Array, Array]:
    """The state with each wheelset lowered until the rails carry about what rests on it, and rolled so that both do.

    Newton's method does not find its way from a wheelset in the air or on one wheel. Raises NotCarried.
    """
    steady = SteadyMotion(law)
    x = steady.unknowns(q, q_t)
    share = 1.0 / len(law.vehicle.wheelsets)
    for i, mounted in enumerate(law.vehicle.wheelsets):
        z, roll = 6 * i + COORDINATES.index("z"), 6 * i + COORDINATES.index("roll")

        def carried(angle: float, z: int = z, roll: int = roll, name: str = mounted.name) -> float:
            """Moment left over at this roll, with the height found."""
            x[roll] = angle

            def lift(height: float) -> float:
                x[z] = height
                return float(steady.residual(x)[z])

            if not bracket(lift, float(x[z]), SMALL_WHEELSET["z"], 0.1 * share, SEARCH_HEIGHT):
                raise NotCarried(name)
            return float(steady.residual(x)[roll])

        bracket(carried, float(x[roll]), SMALL_WHEELSET["roll"], 0.1 * share, SEARCH_ROLL)
    if law.elastic is not None:  # everything sinks with the rails
        sunk = 0.5 * share * law.vehicle.weight / law.elastic.stiffness[1]
        x[: 6 * len(law.bodies) : 6] -= sunk
        x[len(x) - law.rails + 1 :: 2] -= sunk
    return steady.state(x)
