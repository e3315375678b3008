"""Plausibility of single values of a vehicle: damping, radii of one axle, payloads, stops. See ``plausibility``."""

from collections.abc import Iterator
from math import inf, pi

import numpy as np

from wrsim.vehicle.elements import Array, BilinearSpring, Element, Spring, Strut
from wrsim.vehicle.preload import DIRECTIONS
from wrsim.vehicle.vehicle import Vehicle

MOST_DAMPED = 5.0
"""Damping ratio of a part on its springs, all others held. Suspensions have 0.05 to 0.5, bodies on yaw dampers to 1.5;
N s/m typed as kN s/m makes at least 50 of it. Beyond 5 a part takes 10 periods or more to return."""
RATED = 0.1
"""Velocity at which dampers are rated [m/s] (EN 13802)."""
SLOWEST = 0.1
"""Frequency [Hz] below which no suspension holds a part: that of a spring that its load deflects by 25 m."""
UNLIKE_RADII = 3e-3
"""Difference dr of the radii of one axle [m]. With an equivalent conicity of 0.2 it rolls straight at dr / 0.4 = 7.5 mm
from the middle, where its flange touches (EN 15302: clearance 7 mm)."""


def value_doubts(vehicle: Vehicle) -> Iterator[str]:
    """One sentence for every implausible value."""
    unlike = [m for m in vehicle.wheelsets if abs(m.wheelset.left.radius - m.wheelset.right.radius) > UNLIKE_RADII]
    for mounted in unlike[:1]:
        left, right = (1e3 * wheel.radius for wheel in (mounted.wheelset.left, mounted.wheelset.right))
        message = f"radii of wheelset '{mounted.name}' are {left:.6g} mm left and {right:.6g} mm right"
        more = f" (and of {len(unlike) - 1} more)" * (len(unlike) > 1)
        yield f"{message}{more}; plausible is a difference of up to {1e3 * UNLIKE_RADII:g} mm"
    adapts = any(isinstance(e, BilinearSpring) or (e.slider and e.slider.normal) for e in vehicle.elements)
    for body in vehicle.bodies:
        if body.payload > (empty := body.mass - body.payload) and not adapts:
            message = (
                f"body '{body.name}' of {empty:.4g} kg carries a payload of {body.payload:.4g} kg, more than its mass"
            )
            yield f"{message}; plausible is that of springs or friction that follow the load, of freight wagons"
    yield from _one_sided_stops(vehicle)


def _one_sided_stops(vehicle: Vehicle) -> Iterator[str]:
    """Lateral and longitudinal stops in one direction that no other stop between these bodies has an opposite of."""
    sides: dict[tuple[str, str, int], dict[float, str]] = {}  # by bodies and axis: names by direction
    for e in vehicle.elements:
        if isinstance(e, Strut) and e.kind == "bump-stop" and e.axis in (0, 1) and e.limits is not None:
            turned = -1.0 if e.first > e.second else 1.0
            named = sides.setdefault((min(e.first, e.second), max(e.first, e.second), e.axis), {})
            named |= {turned * side: e.name for side, end in zip((-1.0, 1.0), e.limits, strict=True) if abs(end) < inf}
    single = [(key[2], next(iter(named.values()))) for key, named in sides.items() if len(named) == 1]
    for axis, name in single[:1]:
        more = f" (and {len(single) - 1} more)" * (len(single) > 1)
        yield f"bump stop '{name}'{more} stops one direction along {'xy'[axis]} only, and none the other: both_ways?"


def overdamped(vehicle: Vehicle, moved: list[tuple[Array, Array]], stiffness: Array, inertia: Array) -> Iterator[str]:
    """Parts that creep back on their springs and dampers, all others held; by the element that damps them most.

    moved: motions of the elements; stiffness, inertia: in the coordinates of these.
    """
    damping = [_damping(element, *each) for element, each in zip(vehicle.elements, moved, strict=True)]
    worst: dict[bytes, tuple[float, str]] = {}
    for i, name in enumerate(vehicle.names[: len(vehicle.parts)]):
        places = slice(6 * i, 6 * i + 6)
        scale = inertia[places] ** -0.5
        values, vectors = np.linalg.eigh(scale[:, None] * stiffness[places, places] * scale)
        for rate, vector in zip(np.sqrt(np.maximum(values, 0.0)), vectors.T, strict=True):
            each = [float(scale * vector @ matrix[places, places] @ (scale * vector)) for matrix in damping]
            if rate > 2.0 * pi * SLOWEST and (ratio := sum(each) / (2.0 * rate)) > MOST_DAMPED:
                k = int(np.argmax(each))
                message = f"'{name}' has {DIRECTIONS[int(np.argmax(np.abs(vector)))]} a damping ratio of {ratio:.3g} on"
                message += (
                    f" '{vehicle.elements[k].name}'; plausible is up to {MOST_DAMPED:g}: is it N s/m given as kN s/m?"
                )
                kind = np.round(np.linalg.eigvalsh(damping[k])[-1], 6).tobytes()
                worst[kind] = max(worst.get(kind, (0.0, "")), (ratio, message))
    yield from (message for _, message in worst.values())


def _damping(element: Element, travel: Array, turning: Array) -> Array:
    """Damping in all coordinates [N s/m], dampers at the rated velocity and on rigid mountings."""
    if isinstance(element, Spring):
        about = turning.T * np.array(element.turning_damping) @ turning
        return np.asarray(travel.T * np.array(element.damping) @ travel + about)
    table = element.damper_table if isinstance(element, Strut) else ()
    c = float(np.interp(RATED, *np.transpose(table))) / RATED if table else getattr(element, "damping", 0.0)
    return np.asarray(c * travel.T @ travel)
