"""Small motions about a state: mass, damping and stiffness matrices, state matrix; natural modes of a vehicle on its
springs with its wheelsets fixed, and names of modes."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from wrsim.simulation.bodies import Solid, mass_matrix, velocity_forces
from wrsim.simulation.force_law import Array, ForceLaw, force_derivative
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.track.segments import Straight
from wrsim.track.track import Track
from wrsim.vehicle.equivalent import SMALL_STROKE, Stroke
from wrsim.vehicle.vehicle import Vehicle

DIRECTIONS = ("vertical", "longitudinal", "lateral", "yaw", "roll", "pitch")
"""In the order of the coordinates."""

SHARE = 0.3
"""Part of the largest share of the kinetic energy above which another direction is named."""

SLOWEST = 1e-3
"""Frequency below which nothing oscillates [Hz]."""


@dataclass(frozen=True)
class Linearised:
    """mass q_tt + damping q_t + stiffness q = 0 for small motions about a state, all (n, n); bodies: their number.

    Order of q: coordinates of the bodies; dampers in series with springs, whose rates are their extensions, and sliders
    (places ``sliders``), which do not slip; ``positions``: pitch of axle boxes, twist of axles, displacements of rails.
    """

    mass: Array
    damping: Array
    stiffness: Array
    bodies: int
    positions: int = 0
    sliders: tuple[int, ...] = ()

    @property
    def state_matrix(self) -> Array:
        """A of y_t = A y with y = (q of the bodies, positions of axle boxes and rails, q_t of the bodies, extensions
        of the dampers, velocities of axle boxes and rails), without sliders."""
        n, m = len(self.mass), 6 * self.bodies
        full = np.zeros((2 * n, 2 * n))
        full[:n, n:] = np.eye(n)
        full[n:, :n] = -np.linalg.solve(self.mass, self.stiffness)
        full[n:, n:] = -np.linalg.solve(self.mass, self.damping)
        rates = np.delete(np.arange(n, 2 * n), self.sliders)
        retained = np.r_[0:m, n - self.positions : n, rates]
        return full[np.ix_(retained, retained)]


def linearise(
    forces: ForceLaw, bodies: Sequence[Solid], q: Array, q_t: Array, stroke: Stroke = SMALL_STROKE, t: float = 0.0
) -> Linearised:
    """Matrices of the small motions about a state without acceleration, gyroscopic terms included.

    Dampers and sliders are linear ones that are equivalent at the stroke, see ``vehicle.equivalent``.

    On straight track a steady run is such a state; in a curve it is not, for the coordinates are global.
    """

    def inertia(t: float, q: Array, q_t: Array, out: Array) -> None:
        out[:] = velocity_forces(bodies, q, q_t)

    with forces.equivalent(stroke, t, q, q_t):
        stiffness, damping = (
            force_derivative(ForceLaw(inertia), q, q_t, len(bodies), t, *by)
            - force_derivative(forces, q, q_t, len(bodies), t, *by)
            for by in ((1.0, 0.0), (0.0, 1.0))
        )
    sliders = tuple(forces.sliders.tolist())
    return Linearised(mass_matrix(bodies, q), damping, stiffness, len(bodies), forces.positions, sliders)


@dataclass(frozen=True)
class Mode:
    """frequency: undamped natural one [Hz]; damping: ratio to critical [1]; shape: complex amplitudes of the bodies'
    coordinates (bodies, 6) in the order of ``DIRECTIONS``; name: its parts and directions."""

    frequency: float
    damping: float
    shape: NDArray[np.complex128]
    name: str


def natural_modes(vehicle: Vehicle, stroke: Stroke = SMALL_STROKE) -> tuple[Mode, ...]:
    """Oscillating modes in the design position at a stroke of its elements, slowest first; the wheelsets are fixed."""
    if not vehicle.bodies:
        return ()
    law = VehicleOnTrack(vehicle, Track.build([Straight(200.0)], 1.5), (), speed=0.0, start=100.0, drive="free")
    q, q_t = design_state(law)
    linear = linearise(law, law.bodies, q, law.relaxed_rates(q, q_t), stroke)
    n, w = 6 * len(law.bodies), 6 * len(vehicle.wheelsets)
    matrix = linear.state_matrix
    rates = n + law.positions
    retained = np.r_[w:rates, rates + w : len(matrix)]
    values, vectors = np.linalg.eig(matrix[np.ix_(retained, retained)])
    free = n - w
    turning = [rates + c + 1 - int(np.sum(law.sliders <= c)) for c in law.gears.values()]  # rates of hollow axles
    geared = np.searchsorted(retained, turning)
    of_boxes = np.array([box.inertia[1] for _, box in vehicle.boxes.values()])
    of_gears = np.array([drive.inertia for drive in vehicle.drives])
    modes = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag <= 2.0 * np.pi * SLOWEST:
            continue
        shape = vector[:free].reshape(-1, 6)
        ends = np.cumsum([free, len(of_boxes), len(law.twists), len(law.modes)])
        boxes, twists, elastic = (vector[a:b] for a, b in pairwise(ends))
        twisting = (0.25 * law.bodies[w].inertia[1] * abs(a) ** 2 for w, a in zip(law.twists, twists, strict=True))
        energies = {
            "axle boxes pitch": float(of_boxes @ np.abs(boxes) ** 2),
            "axles twist": sum(twisting),
            "hollow axles twist": float(of_gears @ np.abs(vector[geared]) ** 2) / abs(value) ** 2,
        }
        for part, shapes in law.attachments.modes.items():
            amplitudes = elastic[law.modes_of(part) - law.modes.start]
            energies[f"{vehicle.names[part]} bends"] = float(shapes.masses @ np.abs(amplitudes) ** 2)
        name = max(energies, key=lambda word: energies[word])
        if energies[name] <= _energy(vehicle, shape).sum():
            name = mode_name(vehicle, shape)
        modes.append(Mode(abs(value) / (2.0 * np.pi), -value.real / abs(value), shape, name))
    return tuple(sorted(modes, key=lambda mode: mode.frequency))


def mode_name(vehicle: Vehicle, shape: NDArray[np.complex128]) -> str:
    """Name of a mode: the parts with the most kinetic energy, their directions, and their phase.

    shape: of all parts (parts, 6) or of the bodies alone (bodies, 6). All wheelsets are one group, and so are bodies
    of one name in different parts (``front.frame``, ``rear.frame``).
    """
    names = [*(f"{m.name}.wheelsets" for m in vehicle.wheelsets), *(b.name for b in vehicle.bodies)][-len(shape) :]
    energy = _energy(vehicle, shape)
    groups: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        groups.setdefault(name.rpartition(".")[2], []).append(i)
    name, members = max(groups.items(), key=lambda group: float(energy[group[1]].sum()))
    shares = energy[members].sum(axis=0)
    order = np.argsort(-shares)
    named = [int(k) for k in order if shares[k] >= SHARE * shares[order[0]]]
    a, phase = shape[members, named[0]], ""
    if len(a) == 2 and min(abs(a)) >= 0.2 * max(abs(a)):
        phase = ", together" if (a[0] * np.conj(a[1])).real > 0.0 else ", against each other"
    return f"{name} {' and '.join(DIRECTIONS[k] for k in named)}{phase}"


def _energy(vehicle: Vehicle, shape: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Kinetic energies of all parts, or of the bodies alone, along their coordinates, but for a common factor."""
    parts = vehicle.parts[-len(shape) :]
    inertia = np.array([(p.mass, p.mass, p.mass, p.inertia[2], p.inertia[0], p.inertia[1]) for p in parts])
    return np.asarray(inertia * np.abs(shape) ** 2)
