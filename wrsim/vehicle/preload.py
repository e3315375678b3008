"""Preload: the forces in the springs that hold a vehicle in its design position.

They are those of an elastic structure on fixed wheelsets under its weight and payloads, K u = f: each spring carries
-k d(u). With these forces the design position is the position of rest. Loads are no part of f: under them the vehicle
moves. A preload in the file is part of f, and its spring not of K. Masses that the vehicle carries are parts of its
bodies. The preload also gives the normal forces of friction elements.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from wrsim.errors import InputError, suggest
from wrsim.vehicle.elements import Array, BilinearSpring, Element, Triple
from wrsim.vehicle.vehicle import Body, Vehicle

DIRECTIONS = ("along x", "along y", "vertically", "in roll", "in pitch", "in yaw")
PITCH = DIRECTIONS.index("in pitch")

TOLERANCE = 1e-9
"""Largest residual over the vehicle's weight; moments are divided by 1 m."""
ROUND_OFF = 1e-12
"""Forces below this part of the weight are zero: a symmetric vehicle is symmetric to the last digit."""


class Preload(NamedTuple):
    """Action of an element on its second body in the design position: force along its directions (m,) [N], moment of
    its rotational springs about x, y, z (3,) [N m]."""

    force: Array
    moment: Array


def preloads(vehicle: Vehicle) -> list[Preload]:
    """The preload of every element. Raises InputError for a body that its springs do not hold in some direction."""
    n, boxes = len(vehicle.bodies), list(vehicle.boxes)
    size = 6 * n + len(boxes)
    base = len(vehicle.wheelsets)
    load = np.zeros((n, 6))
    load[:, 2] = [-body.mass * vehicle.gravity for body in vehicle.bodies]
    for extra in vehicle.payloads:
        i = vehicle.index(extra.body) - base
        if i >= 0:
            load[i] += _at(np.array(extra.at) - vehicle.place(extra.body)).T @ np.array(extra.force)

    moved = motions(vehicle)
    of_bodies = [(travel[:, 6 * base :], turning[:, 6 * base :]) for travel, turning in moved]
    stiffness = np.zeros((size, size))
    held = np.zeros(size)
    right = np.append(load.ravel(), np.zeros(len(boxes)))
    for element, (travel, turning) in zip(vehicle.elements, of_bodies, strict=True):
        if element.preload is not None:
            right += travel.T @ np.array(element.preload)
        else:
            stiffness += travel.T @ np.diag(element.stiffness_at_rest) @ travel
        stiffness += turning.T @ np.diag(element.turning_stiffness) @ turning
        held += element.stiffness_at_rest @ travel**2 + np.array(element.turning_stiffness) @ turning**2
    for name, about in zip(boxes, held[6 * n :], strict=True):
        if not about > 0.0:
            raise InputError(f"no spring keeps axle box '{name}' from turning about the axle: it needs one beside it")
    u = np.linalg.lstsq(stiffness, right, rcond=1e-12)[0] if n else np.zeros(size)
    left = right - stiffness @ u
    if n and np.max(np.abs(left)) > TOLERANCE * vehicle.mass * vehicle.gravity:
        worst = int(np.argmax(np.abs(left)))
        direction = worst % 6 if worst < 6 * n else PITCH
        together = np.abs(left[direction : 6 * n : 6]) > 0.1 * abs(left[worst])
        names = [f"'{vehicle.bodies[i].name}'" for i in np.flatnonzero(together)]
        label = f"{'bodies' if names[1:] else 'body'} {', '.join(names)}"
        label = label if worst < 6 * n else f"axle box '{boxes[worst - 6 * n]}'"
        rest = f"{left[worst]:.4g} {'N' if direction < 3 else 'N m'} residual"
        hint = [f"; preload_kN of '{e.name}' is given" for e in vehicle.elements if e.preload is not None][:1]
        message = f"the preload cannot be found: nothing holds {label} {DIRECTIONS[direction]} ({rest})"
        raise InputError(message + "".join(hint))
    loads = []
    for element, (travel, turning) in zip(vehicle.elements, of_bodies, strict=True):
        force = -element.stiffness_at_rest * (travel @ u) if element.preload is None else np.array(element.preload)
        moment = -np.array(element.turning_stiffness) * (turning @ u)
        least = ROUND_OFF * vehicle.mass * vehicle.gravity
        loads.append(Preload(*(np.where(np.abs(a) > least, a, 0.0) for a in (force, moment))))
    return loads


def motions(vehicle: Vehicle) -> list[tuple[Array, Array]]:
    """Travel of every element along its directions, (m, n), and turning, (3, n), per motion of parts and axle boxes.

    n: six coordinates of each part in the order of ``DIRECTIONS``, then the pitch of each axle box about its axle.
    """
    boxes, count = list(vehicle.boxes), 6 * len(vehicle.parts)

    def motion(element: Element) -> tuple[Array, Array]:
        rows, turns = np.zeros((2, 3, count + len(boxes)))
        for name, end, sign in zip((element.first, element.second), element.points, (-1.0, 1.0), strict=True):
            if name in boxes:  # it pitches about the axle, on which its pitch is its own
                column = count + boxes.index(name)
                rows[:, column] += (sign * _at(np.array(end) - vehicle.place(name)))[:, PITCH]
                turns[1, column] += sign
            part = vehicle.carrier(name)
            i = vehicle.index(part)
            if i < len(vehicle.parts):
                free = [k for k in range(6) if name not in boxes or k != PITCH]
                rows[:, [6 * i + k for k in free]] += (sign * _at(np.array(end) - vehicle.place(part)))[:, free]
                turns[:, [6 * i + k for k in free if k > 2]] += sign * np.eye(3)[:, [k - 3 for k in free if k > 2]]
        return element.directions @ rows, turns

    return [motion(element) for element in vehicle.elements]


def _at(arm: Array) -> Array:
    """Motion of a point (3,) of a body per translation and rotation of the body, (3, 6)."""
    x, y, z = arm
    turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack([np.eye(3), turn])


# --- loads that press friction surfaces together --------------------------------------------------------------------

LEAST = 1e-6
"""Least force at rest of an element that gives a normal force, over the vehicle's weight."""


def normal_loads(vehicle: Vehicle, preloads: Sequence[Preload]) -> list[tuple[int, Triple] | None]:
    """For every element whose friction depends on a normal force: the number of the element that gives it, and factors
    of its reading, component by component. Positive is the force at rest, or the sense of the slider.

    Raises InputError for an element that does not exist, whose own friction depends on another, or that carries nothing
    at rest; and for a bilinear spring that carries nothing.
    """
    for element, preload in zip(vehicle.elements, preloads, strict=True):
        if isinstance(element, BilinearSpring) and abs(preload.force[0]) < LEAST * vehicle.mass * vehicle.gravity:
            raise InputError(f"bilinear spring '{element.name}' carries nothing at rest: it must be under load there")
    numbers = {element.name: i for i, element in enumerate(vehicle.elements)}
    normals: list[tuple[int, Triple] | None] = []
    for element in vehicle.elements:
        normal = None if element.slider is None else element.slider.normal
        if element.slider is None or normal is None:
            normals.append(None)
            continue
        name = normal.element or element.name
        if name not in numbers:
            raise InputError(f"friction '{element.name}': there is no spring '{name}'{suggest(name, list(numbers))}")
        i = numbers[name]
        spring = vehicle.elements[i]
        pressing = None if spring.slider is None else spring.slider.normal
        if normal.element and pressing is not None and pressing.element:
            raise InputError(f"friction '{element.name}': the friction of '{name}' depends on a load itself")
        axis, sense = int(normal.axis), normal.sense
        if sense is None:
            at_rest = spring.reading_at_rest(preloads[i].force)
            axis = axis if len(spring.directions) > 1 else int(np.argmax(np.abs(at_rest)))
            sense = float(np.sign(at_rest[axis]))
            if abs(at_rest[axis]) < LEAST * vehicle.mass * vehicle.gravity:
                along = "xyz"[axis] if len(spring.directions) > 1 else "its direction"
                message = f"'{name}' carries nothing along {along} at rest"
                raise InputError(f"friction '{element.name}' has no normal force: {message}")
        x, y, z = element.slider.friction * normal.factor * sense * np.eye(3)[axis]
        normals.append((i, (float(x), float(y), float(z))))
    return normals


# --- masses that are carried ----------------------------------------------------------------------------------------

SKEWEST = 0.1
"""Largest product of inertia of a body with its ballast over the root of the product of both moments of inertia. The
motion neglects it; the error is of the order of its square."""


@dataclass(frozen=True)
class Ballast:
    """A mass [kg] that moves with a body, its centre [m], its inertia about x, y, z through that [kg m2]."""

    body: str
    mass: float
    centre: Triple
    inertia: Triple


def with_ballast(vehicle: Vehicle, masses: Sequence[Ballast]) -> Vehicle:
    """The vehicle with these masses as parts of its bodies. Raises InputError where the principal axes turn too far."""
    masses_of = ([mass for mass in masses if mass.body == body.name] for body in vehicle.bodies)
    bodies = (_together(body, held) if held else body for body, held in zip(vehicle.bodies, masses_of, strict=True))
    return replace(vehicle, bodies=tuple(bodies))


def _together(body: Body, masses: Sequence[Ballast]) -> Body:
    """The body and the masses as one, its axes as they were."""
    parts = [Ballast(body.name, body.mass, body.centre, body.inertia), *masses]
    weights = [part.mass for part in parts]
    centre = np.average([part.centre for part in parts], axis=0, weights=weights)
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = np.array(part.centre) - centre
        inertia += np.diag(part.inertia) + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    about = np.diag(inertia)
    skew = np.abs(inertia - np.diag(about)) / np.sqrt(np.outer(about, about))
    if skew.max() > SKEWEST:
        i, j = np.unravel_index(int(np.argmax(skew)), skew.shape)
        raise InputError(
            f"the payload turns the principal axes of body '{body.name}' about {'xyz'[3 - int(i) - int(j)]} "
            f"(product of inertia {-inertia[i, j]:.4g} kg m2): it must lie nearer to the body's centre, or be a body "
            "of its own on stiff springs"
        )
    x, y, z = (float(c) for c in centre)
    a, b, c = (float(value) for value in about)
    return replace(body, mass=float(sum(weights)), inertia=(a, b, c), centre=(x, y, z), payload=float(sum(weights[1:])))
