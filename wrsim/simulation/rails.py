"""Rails on sleepers under a vehicle: a window of them that travels along with it, and their part in every step."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.jit import Array, Ints
from wrsim.simulation.implicit_step import METHOD, GeneralizedAlpha
from wrsim.track.sleepers import SleeperTrack
from wrsim.track.track import RailElasticity, Track
from wrsim.vehicle.dynamics import sleeper_rails as systems
from wrsim.vehicle.dynamics import sleepers as kernel

MOVE = 6
"""Bays by which the window moves at once where they differ."""

BEFORE, BEYOND, APART = 200.0, 400.0, 1.0
"""How far from the track's ends distances along the rails are tabled, and between two rows [m]; beyond it is
straight."""

STARTING_MASS = 100.0
"""Mass in place of the rail in the search for the start: it scales an equation of statics [kg]."""

RADIUS = 0.5
"""Factor by which the method damps the fastest oscillation of the rails in a step. The elements vibrate at up to some
10 kHz, which no step resolves: wheels that pass kinks of the rail over sleepers excite it, and it must decay. At 0.5
the numerical damping of 100 Hz at 1 ms is 0.4 % of critical."""


class RailsOnSleepers:
    """Rails under the wheels of a vehicle, from their start on; see ``dynamics.sleepers``.

    Until the first step the rails are at rest under each wheel's force. ``static``: a spring and a mass in their
    place for the search of that state.
    """

    def __init__(
        self, sleepers: SleeperTrack, track: Track, workspace: tuple[Array, Ints], wheels: Sequence[np.record],
        places: Array, weight: float, size: int, deck: NDArray[Any],
    ) -> None:  # fmt: skip
        """sleepers: what the rails of the track lie on; workspace: buffer and index of the wheels
        (``dynamics.wheel_forces``); wheels: their records WHEEL; places (wheels,) along the centre line [m]; weight
        [N] and size of the state of the vehicle; deck: records MODE of the bridge below. Raises InputError for wheels
        on it."""
        self.sleepers, self._wheels, self._records = sleepers, workspace, wheels
        self._moves = 1 if sleepers.uniform else MOVE
        # what is beside the window does not act on the deck: a bridge comes in and leaves as a whole
        self._margin = sleepers.margin + (sleepers.bridge.length if sleepers.bridge else 0.0)
        self.count = int(np.ceil((float(np.ptp(places)) + 2.0 * self._margin) / sleepers.spacing)) + self._moves + 2
        self._state = np.zeros(2)
        """Number of the window's first sleeper; whether steps have been taken."""
        self._filled: float = np.nan
        self._prepared: tuple[float, float] = (np.nan, np.nan)
        """First sleeper (of those that differ) and step that the factors belong to; step 0: statics."""
        on_rails = np.zeros(len(places), systems.WHEEL_ON_RAIL)
        on_rails["side"] = [wheel.side for wheel in wheels]
        on_rails["place"], on_rails["push_b"] = places, -weight / len(places)
        on_rails["step_distance"] = kernel.SHORTEST
        lines = np.append(np.arange(-BEFORE, track.length + BEYOND, APART), track.length + BEYOND)
        along = np.array([track.rail_distance("left", lines), track.rail_distance("right", lines), lines])
        beam, n = sleepers.rail, len(places)
        head = np.array([beam.height - beam.shear_centre, beam.shear_modulus * beam.torsion])
        loads, previous = (systems.Loads(np.zeros((n, 3, 6)), np.zeros((n, 2, 6), dtype=np.intp)) for _ in range(2))
        nodes = np.zeros(self.count * sleepers.elements + 1)
        self.rails = systems.Rails(self._pair(0), self._pair(2), nodes, on_rails, loads, previous, head, along)
        self.method = np.zeros(10)
        self.guess = np.zeros((3, 2 * n))
        """Displacements, velocities and accelerations of the rails under the wheels from which a step starts."""
        self.deck = np.zeros((2, len(deck)))
        """Where the bridge's modes are foretold for the end of the step, and their rates."""
        self._pressed = deck["rest"]
        if sleepers.bridge is not None and sleepers.bridge.at(places)[0].any():
            raise InputError("a run on sleepers begins with no wheel on the bridge: change run.start_distance_m")
        self._deflections = sleepers.layout(self.count, 0).nodes[:, 0]
        self.peak = np.zeros(3 + size + 3 * len(self.rails.nodes))
        """The largest force of a wheel on its rail so far [N], its number and place [m]; the state of the vehicle then;
        places of the rails' nodes, and how far the left and the right rail are up there [m]."""
        self.static = self._rest_at_start()

    @property
    def wheels(self) -> NDArray[np.record]:
        """records WHEEL_ON_RAIL of the wheels."""
        return self.rails.wheels  # type: ignore[return-value]

    @property
    def first(self) -> int:
        """Number of the window's first sleeper."""
        return int(self._state[0])

    def strike(self, q: Array) -> None:
        """After a step, with the state of the vehicle at its end: note it in ``peak`` where a wheel presses on its rail
        with the largest force so far."""
        i = int(np.argmin(self.wheels["last_b"]))
        if -self.wheels["last_b"][i] > self.peak[0]:
            hardest, rows = self.wheels[i], self.rails.vertical.rows[:, systems.U, self._deflections]
            self.peak[:] = np.concatenate([[-hardest.last_b, i, hardest.place], q, self.rails.nodes, *rows])

    def memory(self) -> list[Array]:
        """Views of all that lasts from step to step."""
        rows = self.rails.vertical.rows, self.rails.lateral.rows
        return [self._state, self.wheels.view(np.float64), *rows, self.peak, self._pressed]

    def resume(self) -> None:
        """After the memory has been restored: between two steps the rails under the wheels stay where they are."""
        if self._state[1]:
            if self.first != self._filled:
                self._fill()
            for wheel in self._records:
                wheel.rate_n = wheel.rate_b = 0.0

    def begin(self, step: float, q: Array, q_t: Array, q_tt: Array) -> None:
        """Begin a step [s]; q, q_t, q_tt: of the rails under the wheels, overwritten by guesses of its end."""
        if not self._state[1]:
            kernel.look_ahead(0.0, *self._wheels, self.rails)
            kernel.push_on(*self._wheels, self.rails)
            self._lie(True)
            self._state[1] = 1.0
        for _ in range(2):
            self._prepare(step)
            self._carry()
            if kernel.begin(self.method, self.guess, *self._wheels, self.rails):
                break
            self._move()
        self._press()
        self.guess[2] = 0.0
        q[:], q_t[:], q_tt[:] = self.guess

    def _carry(self) -> None:
        """Forces of the bridge on ballast and end zones at the end of the step."""
        for r in range(2 if len(self._pressed) else 0):
            self.rails.vertical.forces[r] = self._held[r] @ self.deck[0] + self._dragged[r] @ self.deck[1]

    def _press(self) -> None:
        """What these do to the modes of the bridge, as foretold."""
        c, d = self.method[5:7]
        self._pressed[:] = 0.0
        for r in range(2 if len(self._pressed) else 0):
            system, forces = self.rails.vertical.rows[r], self.rails.vertical.forces[r]
            u, u_t = system[systems.P] + c * system[systems.U_TT], system[systems.P_T] + d * system[systems.U_TT]
            self._pressed[:] += self._follow.T @ forces - self._held[r].T @ u - self._dragged[r].T @ u_t

    def look_at_wheels(self, q: Array, q_t: Array, q_tt: Array) -> None:
        """Better guesses, with the wheels at their places."""
        kernel.look_at_wheels(self.method, self.guess, *self._wheels, self.rails)
        q[:], q_t[:], q_tt[:] = self.guess

    def hold(self, first: bool, tolerance: float, last: Array, q: Array, q_t: Array, q_tt: Array) -> bool:
        """Hold an iteration between two that led to each other; returns whether one was held."""
        return bool(kernel.hold(first, tolerance, self.method, last, (q, q_t, q_tt), self.wheels))

    def end(self, q: Array) -> None:
        """End the step with the displacements q that it has found."""
        self.guess[0] = q
        kernel.end(self.method, self.guess, *self._wheels, self.rails)

    def _prepare(self, step: float) -> None:
        """Factors for a step [s]."""
        if self._prepared != (self._matrices, step):
            method, (c, d) = GeneralizedAlpha.from_spectral_radius(RADIUS), METHOD.increments(step)
            self.method[:9] = step, *method, *method.increments(step), 1.0 / c, d / c
            systems.prepare(1.0, self.method[6], self.method[5], self.rails)
            self._prepared = self._matrices, step

    def _lie(self, rolling: bool) -> None:
        """Lay the rails, at rest or as wheels that roll along keep them deflected, under the wheels' forces."""
        self._move(True)
        systems.place(self.rails)
        systems.prepare(0.0, 0.0, 1.0, self.rails)
        self._prepared = self._matrices, 0.0
        systems.rest(rolling, self.rails)

    def _rest_at_start(self) -> RailElasticity:
        """Place the wheels at rest; how a rail yields to its own wheel there."""
        self._lie(False)
        systems.compliances(1.0, self.rails)
        on_rails = self.wheels
        stiffness = float(1.0 / on_rails["nn"].mean()), float(1.0 / on_rails["bb"].mean())
        for i, (on_rail, wheel) in enumerate(zip(on_rails, self._records, strict=True)):
            n, b = systems.read(systems.U, i, self.rails.loads, self.rails)
            wheel.yield_nn, wheel.yield_nb, wheel.yield_bb = on_rail.nn, on_rail.nb, on_rail.bb
            # the other wheels with their mean forces
            wheel.free_n = n - (on_rail.nb - on_rail.element_nb) * on_rail.push_b
            wheel.free_b = b - (on_rail.bb - on_rail.element_bb) * on_rail.push_b
            wheel.held_n = wheel.held_b = 1.0
            wheel.rate_n = wheel.rate_b = stiffness[1] / STARTING_MASS
        mass = STARTING_MASS * stiffness[0] / stiffness[1]
        return RailElasticity(stiffness, (0.0, 0.0), (mass, STARTING_MASS))

    def _pair(self, system: int) -> systems.Pair:
        sleepers = self.sleepers
        layout = sleepers.layout(self.count, system)
        band, n = (2, layout.size, layout.width + 1), layout.size
        mass, damping, stiffness, factors, inverse = np.zeros((5, *band))
        rows, bending = np.zeros((2, systems.ROWS, n)), np.zeros((2, self.count * sleepers.elements))
        shear = np.array([sleepers.rail.shear("vertical" if system < 2 else "lateral")])
        return systems.Pair(
            np.array([layout.per_node, sleepers.elements]), mass, damping, stiffness, factors, inverse,
            np.zeros((2, n)), np.zeros((2, n)), rows, bending, shear,
        )  # fmt: skip

    def _move(self, fresh: bool = False) -> None:
        """Move the window to where the wheels are; fresh: lay it anew, at rest."""
        sleepers = self.sleepers
        first = sleepers.number_at(float(self.wheels["place"].min()) - self._margin)
        gone = first - self.first
        self._state[0] = first
        for pair in (self.rails.vertical, self.rails.lateral):
            shift, rows = gone * (pair.numbers[0] * sleepers.elements + 1), pair.rows
            if fresh or not 0 <= shift < rows.shape[2]:
                rows[:] = 0.0
                continue
            rows[:, :, : rows.shape[2] - shift] = rows[:, :, shift:].copy()
            rows[:, :, rows.shape[2] - shift :] = 0.0
        self._fill()

    def _fill(self) -> None:
        """Matrices of the window, and its nodes."""
        sleepers, rails, nodes = self.sleepers, self.rails, self.rails.nodes
        self._matrices = 0 if sleepers.uniform else self.first  # what tells them from those of another place
        if not sleepers.uniform or np.isnan(self._filled):
            for pair, system in ((rails.vertical, 0), (rails.lateral, 2)):
                for r in range(2):
                    bays = sleepers.bays(self._matrices, self.count, system + r)
                    bands = sleepers.bands(self._matrices, self.count, system + r)
                    pair.mass[r], pair.damping[r], pair.stiffness[r] = bands.mass, bands.damping, sum(bands.stiffness)
                    pair.drag[r], pair.bending[r] = sleepers.end_zones(bays, bands.mass, system + r), bays.bending
            self._along = bays.along
            self._prepared = np.nan, np.nan
        nodes[:] = sleepers.places(self.first, 1)[0] + self._along
        self._filled = self.first
        if sleepers.bridge is not None:
            layout = sleepers.layout(self.count, 0)
            self._follow = sleepers.following(self.first, self.count, sleepers.bridge)
            held = np.zeros((2, 2, layout.size))
            held[1] = rails.vertical.drag
            for r in range(2):
                ballast, part = sleepers.ballast, sleepers.bays(self._matrices, self.count, r).ballast
                held[:, r, layout.sleepers] += np.outer((ballast.stiffness[1], ballast.damping[1]), part)
            self._held, self._dragged = held[..., None] * self._follow
        self.method[9] = sleepers.offset + sleepers.spacing * (self.first + self._moves) + self._margin
