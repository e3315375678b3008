"""States of equilibrium of a vehicle on its track: rest, and steady motion at speed.

From a design position (`simulation.placement`) ``lower_on_rails`` lowers the wheelsets until the rails carry them;
``steady_state`` solves for the poses without acceleration, but for that of the curve; at speed 0 this is the position
of rest. All states are at the time 0, with the vehicle's origin at the start of its law.
"""

from cmath import exp, phase
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import SimulationError
from wrsim.jit.linalg import Vec
from wrsim.simulation.bodies import inertia_table
from wrsim.simulation.force_law import Forces, Groups, all_on_all, groups_in_a_row
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.newton import DIFFERENCE, Terms, damped_newton, relax, roots
from wrsim.simulation.placement import design_state, turn_gears
from wrsim.simulation.system import COORDINATES, Array
from wrsim.track.path_kernel import frame_at
from wrsim.vehicle.dynamics import rigid_body as kernels
from wrsim.vehicle.dynamics.kinematics import HEADING, X, Y
from wrsim.vehicle.dynamics.vehicle_forces import FRAMES

SMALL_WHEELSET = {"z": 1e-5, "x": 1e-3, "y": 1e-4, "heading": 1e-4, "roll": 1e-5, "spin": 1e-2}
SMALL_BODY = {"z": 1e-4, "x": 1e-3, "y": 1e-3, "heading": 1e-3, "roll": 1e-3, "spin": 1e-4}
SMALL_RAIL, SMALL_BOX, SMALL_TWIST, SMALL_TURN = 1e-5, 1e-4, 1e-4, 1e-2
"""Changes that change the forces by a few per cent: coordinates of wheelsets (their spin: rate) and other bodies,
displacement of a rail [m], pitch of an axle box, twist of an axle [rad], difference of the spin rates of independent
wheels [rad/s]."""

ALONG = 1e-2
"""The same along the track of a body in a train: gaps of couplings add up to centimetres, steps are limited."""

GOAL, TOLERANCE = 1e-10, 1e-9
"""Largest residual force over the weight that ends the search, and that is accepted; moments are divided by 1 m."""

BODIES_PLACED = 1e-6
"""Residual forces on the bodies over the weight at which the search continues with the wheelsets."""

COUPLED = 1e-4
"""Steps of the derivatives of coupled bodies as parts of these changes: sticking heads of buffers yield by some 0.1 mm,
ten metres from the middle."""

HELD = GOAL / DIFFERENCE
"""Spring along the track on each vehicle of a train in the derivatives, per small change: a residual is known to GOAL,
its derivative to this; on even track nothing else holds a train, or each vehicle that nothing couples."""

FREE = 1e-9
"""Moment about its axle of a freely rolling independent wheel, over the weight times 1 m."""

MOST_STEPS, RELAXED = 120, 1e-6
"""Steps of a vehicle that creeps to its steady motion, and residual at its end over the weight."""

SEARCH_HEIGHT, SEARCH_ROLL = 0.05, 0.05
"""Range of height [m] and roll [rad] in which the rails are searched."""


@dataclass(frozen=True)
class Equilibrium:
    """A state without acceleration: q, q_t; largest residual over the weight."""

    q: Array
    q_t: Array
    residual: float


class Unbalanced(SimulationError):
    """No state without acceleration was found; ``forces``: the largest residuals over the weight, by their names."""

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

    Unknowns, six a body: its coordinates, of a wheelset the spin rate (less that of free rolling) in the place of the
    spin angle; the pitch of the axle boxes; the way of vehicles along the track alone; the twist of axles (of
    independent wheels its rate); elastic modes; of elastic rails their displacements under the wheels.
    ``residual(x)``, ``state(x)``, and back ``unknowns(q, q_t)``.

    In place of x, y and heading stand those against the arc at the start, as residual forces do: the drive alone holds
    the vehicle along the track, and a way along it does not lead into a flange.
    """

    def __init__(self, law: VehicleOnTrack) -> None:
        self.law = law
        vehicle, n, w = law.vehicle, len(law.bodies), len(law.vehicle.wheelsets)
        self.slips = np.zeros(len(law.sliders))
        """Unknowns of sliders from which friction continues; 0: from the design position."""
        self.distance = law.start + vehicle.parts[vehicle.reference].centre[0]
        self.curvature = float(law.track.curvature(self.distance))
        frame = frame_at(law.track.centre.curve, self.distance)
        self.place, self.tangent = complex(*frame.origin[:2]), exp(1j * phase(complex(*frame.t[:2])))
        self.forward = np.full(n, self.tangent)
        self.inertia = inertia_table(law.bodies)
        self.spins = 5 + 6 * np.arange(w)
        self.positions = slice(law.size - law.positions, law.size)
        independent = np.array([vehicle.wheelsets[i].wheelset.independent for i in law.twists], dtype=bool)
        self.alone = np.array(list(law.twists), dtype=int)[independent]
        """Numbers of the wheelsets with independent wheels, ..."""
        self.turns = np.array(list(law.twists.values()), dtype=int)[independent]
        """... places of their twists in the state, ..."""
        self.turning = self.turns - self.positions.start + 6 * n
        """... and among the unknowns."""
        of_wheelset, of_body = ([small[name] for name in COORDINATES] for small in (SMALL_WHEELSET, SMALL_BODY))
        of_twists = np.where(independent, SMALL_TURN, SMALL_TWIST)
        of_modes = [SMALL_BODY["z"]] * len(law.modes)
        behind = [
            [SMALL_BOX] * len(vehicle.boxes),
            [ALONG] * len(law.wagons),
            of_twists,
            of_modes,
            [SMALL_RAIL] * law.rails,
        ]
        self.small = np.concatenate([np.tile(of_wheelset, w), np.tile(of_body, n - w), *behind])
        if law.units > 1:
            self.small[X : 6 * n : 6] = ALONG
        self.difference = np.full(self.small.size, DIFFERENCE)
        for coupling in vehicle.couplings:
            for name in (coupling.ahead, coupling.behind):
                self.difference[self.unknowns_of(vehicle.index(name))] = COUPLED
        rails = () if law.elastic is None else np.tile(law.elastic.mass, law.rails // 2)
        twisting = (0.25 * law.bodies[i].inertia[1] for i in law.twists)
        modal = np.concatenate([np.zeros(0), *(part.masses for part in law.attachments.modes.values())])
        if law.deck is not None:
            modal = np.append(modal, law.deck.masses)
        of_boxes = (box.inertia[1] for _, box in vehicle.boxes.values())
        self.masses = np.array([*of_boxes, *np.ones(len(law.wagons)), *twisting, *modal, *rails])
        self._out, self._inertia, self._weight = np.zeros(law.size), np.zeros(6 * n), vehicle.weight

    def unknowns_of(self, body: int) -> range:
        """The unknowns of a body, or of a vehicle that moves along the track alone, by its number."""
        n = len(self.inertia)
        return range(6 * body, 6 * body + 6) if body < n else range(5 * n + body - FRAMES, 5 * n + body - FRAMES + 1)

    def terms(self) -> Terms:
        """Forces without contacts, by an unknown of every third vehicle at once; contacts, by one of all wheelsets."""
        first, behind = self.positions.start, 6 * len(self.inertia) - self.positions.start

        def unknown(places: NDArray[np.intp]) -> NDArray[np.intp]:
            return np.where(places < first, places, places + behind)

        of_contacts = (group for block in self.law.blocks()[1:] for group in block.groups)
        contacts = [(unknown(columns), unknown(rows)) for columns, rows in of_contacts]
        without = partial(self.residual, contacts=False)
        return [(without, self.apart()), (lambda x: self.residual(x) - without(x), contacts)]

    def apart(self, part: slice = slice(None)) -> Groups:
        """Groups of unknowns, or of a part of them, that may be changed at once: each of another vehicle of a train."""
        law, n = self.law, 6 * len(self.inertia)
        begin, end, _ = part.indices(self.small.size)
        if law.units < 2:
            return all_on_all(end - begin)
        first = self.positions.start
        of_units = law.coordinates_of_units(alone=True)
        of_units[0] = np.append(of_units[0], np.array(law.of_deck, dtype=np.intp))
        places = (np.append(unit[unit < n], unit[unit >= first] - first + n) for unit in of_units)
        units = [unit[(unit >= begin) & (unit < end)] - begin for unit in places]
        return groups_in_a_row(units) if all(map(len, units)) else all_on_all(end - begin)

    @property
    def held(self) -> Array | None:
        """Springs along the track on the reference parts of a train's vehicles; None for one vehicle."""
        if self.law.units < 2:
            return None
        held = np.zeros(self.small.size)
        held[[self.unknowns_of(unit.reference)[:2][-1] for unit in self.law.vehicle.units]] = HELD  # x of a body
        return held

    def state(self, x: Array) -> tuple[Array, Array]:
        """State (q, q_t) with these unknowns; those of dampers in series with springs 0, of sliders ``slips``."""
        return self._state(x)[:2]

    def unknowns(self, q: Array, q_t: Array) -> Array:
        """Unknowns of a steady state near (q, q_t)."""
        n = len(self.inertia)
        x = np.concatenate([q[: 6 * n], q[self.positions]])
        x[6 * n + self.law.wagons - self.positions.start] /= self.law.masses
        self._to_track(x[: 6 * n])
        x[self.spins] = 0.0
        _, rates, _ = self._state(x)
        x[self.spins] = q_t[self.spins] - rates[self.spins]
        x[self.turning] = q_t[self.turns]
        return x

    def _from_track(self, coordinates: Array) -> None:
        """Turn distances along the arc, offsets from it and headings against it into coordinates, in place.

        ``forward``: the direction of the arc at the bodies (n,), in the complex plane of x and y.
        """
        c, rows = self.curvature, coordinates.reshape(-1, 6)
        if c == 0.0 and self.tangent == 1.0:
            return
        angle = c * rows[:, X]
        turned = np.exp(1j * angle)
        gone = -1j / c * np.expm1(1j * angle) if c else rows[:, X]
        place = self.place + self.tangent * (gone + 1j * rows[:, Y] * turned)
        rows[:, X], rows[:, Y] = place.real, place.imag
        rows[:, HEADING] += phase(self.tangent) + angle
        self.forward = self.tangent * turned

    def _to_track(self, coordinates: Array) -> None:
        """The reverse."""
        c, rows = self.curvature, coordinates.reshape(-1, 6)
        if c == 0.0 and self.tangent == 1.0:
            return
        place = (rows[:, X] + 1j * rows[:, Y] - self.place) / self.tangent
        angle = np.angle(1.0 + 1j * c * place)
        rows[:, Y] = (place * np.exp(-1j * angle) - (1j / c * np.expm1(-1j * angle) if c else 0.0)).imag
        rows[:, X] = angle / c if c else place.real
        rows[:, HEADING] -= phase(self.tangent) + angle

    def _state(self, x: Array) -> tuple[Array, Array, Vec]:
        law, n = self.law, len(self.inertia)
        q, q_t = np.zeros(law.size), np.zeros(law.size)
        q[: 6 * n] = x[: 6 * n]
        self._from_track(q[: 6 * n])
        q[self.spins] = 0.0
        q[self.positions] = x[6 * n :]
        q[self.turns], q_t[self.turns] = 0.0, x[self.turning]
        q[law.wagons] *= law.masses
        q_t[law.wagons] = law.masses * law.speed
        q_t[law.sliders] = self.slips
        turning, _, status = kernels.follow_together(
            q, x[self.spins], law.track.centre.curve, law.vehicle.reference, self.distance, law.speed, q_t[: 6 * n]
        )
        if status:
            raise SimulationError(f"the vehicle has no place on the track near {self.distance:g} m")
        turn_gears(law, q_t)
        return q, q_t, turning

    def residual(self, x: Array, contacts: bool = True) -> Array:
        """Forces less inertia forces over the weight (6 n,), moments on axle boxes and twisted axles, forces on rails.
        Without contacts it is complete for all bodies but wheelsets."""
        n = len(self.inertia)
        q, q_t, turning = self._state(x)
        forces: Forces = self.law if contacts else self.law.on_bodies
        forces(0.0, q, q_t, self._out)
        kernels.together_inertia(q, q_t, turning, self.inertia, len(self.spins), self._inertia)
        left = np.append(self._out[: 6 * n] - self._inertia, self.masses * self._out[self.positions])
        along = left[: 6 * n].reshape(n, 6)
        force = (along[:, X] + 1j * along[:, Y]) / self.forward
        along[:, X], along[:, Y] = force.real, force.imag
        left *= 1.0 / self._weight
        if self.law.speed == 0.0:
            left[self.spins] = x[self.spins]  # at rest no axle turns
            left[self.turning] = x[self.turning]
        return left

    def rolled(self, x: Array) -> Array:
        """The unknowns with every independent wheel rolling freely: far from it creep forces saturate, and their
        derivatives are of little use."""
        x = x.copy()
        spins, turning = self.spins[self.alone], self.turning

        def moments(omega: Array) -> Array:
            left, right = omega.reshape(2, -1)
            x[spins], x[turning] = 0.5 * (left + right), left - right
            rest = self.residual(x)
            return np.concatenate([0.5 * rest[spins] + rest[turning], 0.5 * rest[spins] - rest[turning]])

        begin = np.concatenate([x[spins] + 0.5 * x[turning], x[spins] - 0.5 * x[turning]])
        roots(moments, begin, SMALL_TURN, FREE)
        return x

    def largest(self, q: Array, q_t: Array) -> float:
        """Largest residual at the steady state near (q, q_t), over the weight."""
        self.slips = q_t[self.law.sliders]
        with self.law.relaxed_dampers(self.slips):
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

    guess: a state near it, from whose slips friction continues; default the design position, wheelsets lowered on the
    rails. tolerance: largest residual over the weight that is accepted at the end of the search. near: a law with
    nearly the same forces, for the derivatives. The law's drive, or springs to a frame, must hold the speed. Raises
    Unbalanced when there is no such motion near the guess, NotCarried when the rails are not there.
    """
    law.set_search_start(law.start)
    steady = SteadyMotion(law)
    q, q_t = lower_on_rails(law, *design_state(law)) if guess is None else guess
    nearly = steady if near is None else SteadyMotion(near)
    steady.slips = nearly.slips = q_t[law.sliders]
    x = steady.unknowns(q, q_t)
    goal = GOAL if near is None else tolerance
    solve = partial(
        damped_newton, steady.residual, small=steady.small, max_iterations=max_iterations, terms=nearly.terms(),
        difference=steady.difference, held=steady.held,
    )  # fmt: skip
    with law.relaxed_dampers(steady.slips), nearly.law.relaxed_dampers(steady.slips):
        if not np.all(np.isfinite(steady.residual(x))):
            raise SimulationError("steady motion: the forces at its start are not finite")
        _place_bodies(steady, x, max_iterations)
        if law.units > 1:
            with law.following():
                x = solve(x=x, tolerance=RELAXED)[0]
        # derivatives with warm starts, residuals from a cold start: the result does not depend on the iterations
        x, left, _ = solve(x=x, tolerance=goal, while_deriving=nearly.law.following)
    largest = float(np.max(np.abs(left)))
    if not largest <= tolerance:
        raise Unbalanced(_largest(law, left))
    q, q_t = steady.state(x)
    return Equilibrium(q, law.relaxed_rates(q, q_t), largest)


def crept_state(law: VehicleOnTrack, guess: tuple[Array, Array], tolerance: float = TOLERANCE) -> Equilibrium:
    """The steady motion near where a vehicle creeps to from a guess: where flanges guide its axles, Newton's method
    often does not converge from between them. tolerance and errors: as of `steady_state`."""
    law.set_search_start(law.start)
    steady = SteadyMotion(law)
    q, q_t = guess
    steady.slips = q_t[law.sliders]
    x = steady.unknowns(q, q_t)
    with law.relaxed_dampers(steady.slips):
        _place_bodies(steady, x, MOST_STEPS)
        with law.following():
            x, _ = relax(steady.residual, x, steady.small, steady.terms(), RELAXED, MOST_STEPS, steady.rolled)
    return steady_state(law, steady.state(x), tolerance=tolerance)


def _place_bodies(steady: SteadyMotion, x: Array, max_iterations: int) -> None:
    """Solve for bodies and axle boxes on their springs with the wheelsets fixed; changes x.

    In a curve a long body lies along the chord, far inside of the centre line.
    """
    boxes = len(steady.law.vehicle.boxes) + len(steady.law.wagons)
    bodies = slice(6 * len(steady.spins), 6 * len(steady.inertia) + boxes)
    if bodies.start == bodies.stop:
        return
    whole = x.copy()

    def residual(places: Array) -> Array:
        whole[bodies] = places
        return steady.residual(whole, contacts=False)[bodies]

    held = steady.held
    x[bodies] = damped_newton(
        residual, x[bodies].copy(), steady.small[bodies], BODIES_PLACED, max_iterations,
        [(residual, steady.apart(bodies))], difference=steady.difference[bodies],
        held=None if held is None else held[bodies],
    )[0]  # fmt: skip


def _largest(law: VehicleOnTrack, left: Array) -> tuple[tuple[str, float], ...]:
    """The four largest residuals, with the names of their coordinates."""
    names = law.vehicle.names
    places = [f"{name} {coordinate}" for name in names for coordinate in COORDINATES]
    places += [f"{name} pitch" for name in law.vehicle.boxes]
    places += [f"{name} along" for name in law.vehicle.wagons]
    places += [f"{names[i]} twist" for i in law.twists]
    places += [f"{names[i]} mode {k + 1}" for i in law.attachments.modes for k in range(len(law.modes_of(i)))]
    places += ["bridge"] * len(law.of_deck) + ["rail"] * law.rails
    return tuple((places[i], float(left[i])) for i in np.argsort(-np.abs(left))[:4])


def lower_on_rails(law: VehicleOnTrack, q: Array, q_t: Array) -> tuple[Array, Array]:
    """The state with each wheelset lowered until the rails carry about its load, and rolled so that both do.

    Newton's method does not converge from a wheelset in the air or on one wheel. Raises NotCarried.
    """
    steady = SteadyMotion(law)
    x = steady.unknowns(q, q_t)
    share = 1.0 / len(law.vehicle.wheelsets)
    z, roll = (6 * np.arange(len(law.vehicle.wheelsets)) + COORDINATES.index(name) for name in ("z", "roll"))

    def lift(heights: Array) -> Array:
        x[z] = heights
        return steady.residual(x)[z]

    def carried(angles: Array) -> Array:
        """Residual moments at these rolls, with the heights found."""
        x[roll] = angles
        x[z], heights = roots(lift, x[z], SMALL_WHEELSET["z"], 0.1 * share, SEARCH_HEIGHT)
        if not heights.all():
            raise NotCarried(law.vehicle.wheelsets[int(np.argmin(heights))].name)
        return steady.residual(x)[roll]

    with law.following():
        x[roll], _ = roots(carried, x[roll], SMALL_WHEELSET["roll"], 0.1 * share, SEARCH_ROLL)
    if law.elastic is not None:  # everything sinks with the rails
        sunk = 0.5 * share * law.vehicle.weight / law.elastic.stiffness[1]
        x[: 6 * len(law.bodies) : 6] -= sunk
        x[len(x) - law.rails + 1 :: 2] -= sunk
    return steady.state(x)
