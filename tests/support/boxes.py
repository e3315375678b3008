"""A box on elements of its own over a wheelset that is held, and any vehicle on its springs alone."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from support.vehicles import manchester
from wrsim import Straight, Track, Vehicle
from wrsim.simulation import Integrator
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.dynamics import vehicle_forces
from wrsim.vehicle.element_tables import KINDS, VEHICLE_AXES, Axes, Joint
from wrsim.vehicle.elements import TRACK, Element, PlaneFriction, Slider, Spring, Strut, Triple
from wrsim.vehicle.vehicle import Body

MASS, INERTIA, HEIGHT = 4000.0, (1000.0, 3000.0, 3500.0), 1.5


def box(*elements: Element) -> Vehicle:
    """A body over a wheelset, held by the elements; the wheelset is held anyway."""
    return replace(
        manchester(),
        wheelsets=manchester().wheelsets[:1],
        bodies=(Body("box", MASS, INERTIA, (0.0, 0.0, HEIGHT)),),
        elements=elements,
        points=(),
    )


def on_springs(vehicle: Vehicle, gravity: float = 0.0) -> VehicleOnTrack:
    """The law of a vehicle on its springs alone."""
    track = Track.build([Straight(200.0)], 1.5)
    return VehicleOnTrack(vehicle, track, (), speed=0.0, start=100.0, drive="free", gravity=gravity)


def spring(position: Sequence[float] = (0.0, 0.0, HEIGHT), name: str = "spring", **values: object) -> Spring:
    x, y, z = position
    return replace(Spring(name, "spring", TRACK, "box", (x, y, z)), **values)  # type: ignore[arg-type]


def rows(vectors: np.ndarray) -> np.ndarray:
    """Records of vectors as (n, 3)."""
    return np.array(vectors.tolist())


def displaced(law: VehicleOnTrack, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """A state at a large heading with all bodies shifted and turned against each other, and moving."""
    rng = np.random.default_rng(seed)
    q, q_t = design_state(law)
    n = len(law.bodies)
    turn, c, s = 2.0, np.cos(2.0), np.sin(2.0)
    for i in range(n):
        coordinates = q[6 * i : 6 * i + 6]
        coordinates[1], coordinates[2] = (
            c * (coordinates[1] - 100.0) - s * coordinates[2],
            s * (coordinates[1] - 100.0) + c * coordinates[2],
        )
        coordinates[3] += turn
        coordinates[:3] += 0.03 * rng.standard_normal(3)
        coordinates[3:] += 0.08 * rng.standard_normal(3)
    q_t[: 6 * n] = rng.standard_normal(6 * n)
    q_t[6 * n :] = 0.01 * rng.standard_normal(law.dampers)
    return q, q_t


def moment_kept(law: VehicleOnTrack, more: float = 0.0) -> None:
    """At the state asked for last, all forces on bodies add up to nothing; so do their moments about the origin but
    for what turns axle boxes, ``more`` about the first body's axle."""
    bodies, wrenches = (law.workspace.views[k] for k in (vehicle_forces.BODIES, vehicle_forces.WRENCHES))
    n = len(law.bodies)
    places, forces, moments = (rows(a[:n]) for a in (bodies["position"], wrenches["force"], wrenches["moment"]))
    largest = np.abs(forces).max()
    assert largest > 1e5
    assert np.abs(forces.sum(axis=0)).max() < 1e-10 * largest
    turning = (np.cross(places, forces) + moments).sum(axis=0) + more * rows(bodies["left"])[0]
    assert np.abs(turning).max() < 1e-10 * largest * np.abs(places).max()


def derivatives(law: VehicleOnTrack, q: np.ndarray, q_t: np.ndarray, size: int, change: Any = None) -> np.ndarray:
    """Of the first generalised forces with respect to as many coordinates, by differences; change: made to the forces,
    given them and the coordinates."""
    out, columns, step = np.zeros(law.size), np.zeros((size, size)), 1e-5
    for i in range(size):
        for sign in (1.0, -1.0):
            moved = q.copy()
            moved[i] += sign * step
            law(0.0, moved, q_t, out)
            if change is not None:
                change(out, moved)
            columns[:, i] += 0.5 * sign / step * out[:size]
    return columns


def symmetric(matrix: np.ndarray, *without: int) -> bool:
    """Whether a matrix of differences is, without these rows and columns."""
    kept = np.delete(np.delete(matrix, without, axis=0), without, axis=1)
    return bool(np.abs(kept - kept.T).max() < 1e-7 * np.abs(kept).max())


AT: Triple = (0.0, 0.0, HEIGHT)

FIXED = spring(stiffness=(0.0, 0.0, 4e6), turning_stiffness=(4e6, 4e6, 4e6))
"""Holds the box vertically and against turning."""


def slides(force: float, stiffness: float, axis: int = 0, **more: Any) -> Strut:
    """Friction of a constant bound along an axis."""
    slider = Slider("coulomb", stiffness, force, **more)
    return Strut("friction", "friction", TRACK, "box", (AT, AT), axis, slider=slider)  # type: ignore[arg-type]


def in_plane(force: float, stiffness: float) -> PlaneFriction:
    """The same in the horizontal plane."""
    return PlaneFriction("friction", "friction", TRACK, "box", AT, 2, slider=Slider("coulomb", stiffness, force))


def motion(law: VehicleOnTrack, q: Any, q_t: Any, duration: float, step: float, integrator: Integrator) -> Any:
    """The box from a state on; what it weighs is the measure of Newton's method."""
    system = BodySystem(law.bodies, law)
    return Integration(system, duration=duration, step=step, integrator=integrator, weight=MASS * 0.01).run(q, q_t)


Z, X = 6, 7
"""Places of the box in the state."""


def element(kind: str, axes: Axes = VEHICLE_AXES, **keys: Any) -> Any:
    """An element of the box as a file has it."""
    common = {"kind": kind, "name": kind, "body": "track", "to": ["box"], "at_mm": [0, 0, 1e3 * HEIGHT]}
    table = KINDS[kind].model_validate(common | {"direction": "x"} | keys)
    return table.element(Joint(kind, kind, TRACK, "box"), axes)


def driven(law: VehicleOnTrack, travel: Any, times: Any) -> Any:
    """Force of the element along x over a prescribed travel(t), its unknowns integrated by RK4."""
    q, q_t = design_state(law)
    place, inner, forces = q[X], np.zeros(law.dampers), []

    h = 1e-7

    def rates(t: float, unknowns: Any) -> tuple[Any, float]:
        out = np.zeros(law.size)
        q[X], q_t[X] = place + travel(t), (travel(t + h) - travel(t - h)) / (2.0 * h)
        q_t[12:] = unknowns
        law(0.0, q, q_t, out)
        return out[12:].copy(), -float(out[X])

    for t, step in zip(times, np.diff(times, append=times[-1]), strict=True):
        a, force = rates(t + 2.0 * h, inner)  # behind a return, not on it
        forces.append(force)
        b = rates(t + 0.5 * step, inner + 0.5 * step * a)[0]
        c = rates(t + 0.5 * step, inner + 0.5 * step * b)[0]
        d = rates(t + step - 2.0 * h, inner + step * c)[0]
        inner = inner + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return np.array(forces)


def zigzag(amplitude: float) -> Any:
    """Travel that goes evenly up and down with period 1 s, from 0."""
    return lambda t: amplitude * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * t))


def last_loop(law: VehicleOnTrack, amplitude: float, loops: int = 3, steps: int = 400) -> tuple[Any, Any]:
    """Travel and force of the last of some loops."""
    times = np.linspace(0.0, loops, loops * steps + 1)
    path = zigzag(amplitude)
    forces = driven(law, path, times)
    return path(times[-steps - 1 :]), forces[-steps - 1 :]
