"""Plausibility of single values of a vehicle: damping, radii of one axle, payloads, stops. See ``plausibility``."""

from collections.abc import Iterator
from math import inf, pi

import numpy as np

from wrsim.vehicle.elements import Array, BilinearSpring, Element, Spring, Strut
from wrsim.vehicle.preload import WORDS, motions
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


def value_doubts(vehicle: Vehicle, others: bool) -> Iterator[str]:
    """One sentence for every implausible value; of several alike the worst. others: whether something else is wrong, of
    which damping ratios would tell again."""
    unlike = [m for m in vehicle.wheelsets if abs(m.wheelset.left.radius - m.wheelset.right.radius) > UNLIKE_RADII]
    for mounted in unlike[:1]:
        left, right = (1e3 * wheel.radius for wheel in (mounted.wheelset.left, mounted.wheelset.right))
        words = f"radii of wheelset '{mounted.name}' are {left:.6g} mm left and {right:.6g} mm right"
        more = f" (and of {len(unlike) - 1} more)" * (len(unlike) > 1)
        yield f"{words}{more}; plausible is a difference of up to {1e3 * UNLIKE_RADII:g} mm"
    adapts = any(isinstance(e, BilinearSpring) or (e.slider and e.slider.normal) for e in vehicle.elements)
    for body in vehicle.bodies:
        if body.payload > (empty := body.mass - body.payload) and not adapts:
            words = (
                f"body '{body.name}' of {empty:.4g} kg carries a payload of {body.payload:.4g} kg, more than its mass"
            )
            yield f"{words}; plausible is that of springs or friction that follow the load, of freight wagons"
    yield from _one_sided_stops(vehicle)
    if not others:
        yield from _overdamped(vehicle)


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


def _damping(element: Element) -> Array:
    """Damping along its directions (m,) [N s/m] at the rated velocity, on a rigid mounting."""
    if isinstance(element, Spring):
        return np.array(element.damping)
    if not isinstance(element, Strut):
        return np.zeros(len(element.directions))
    table = element.damper_table
    return np.array([float(np.interp(RATED, *np.transpose(table))) / RATED if table else element.damping])


def _overdamped(vehicle: Vehicle) -> Iterator[str]:
    """Parts that creep back on their springs and dampers, all others held; by the element that damps them most."""
    moved = motions(vehicle)
    worst: dict[bytes, tuple[float, str]] = {}
    for i, part in enumerate(vehicle.parts):
        places = slice(6 * i, 6 * i + 6)
        held = [(e, t[:, places], r[:, places]) for e, (t, r) in zip(vehicle.elements, moved, strict=True)]
        held = [each for each in held if each[1].any() or each[2].any()]
        stiffness = np.zeros((6, 6))
        for e, travel, turning in held:
            stiffness += travel.T * e.stiffness_at_rest @ travel
            stiffness += turning.T * np.array(e.turning_stiffness) @ turning
        scale = np.array([*(part.mass,) * 3, *part.inertia]) ** -0.5
        values, vectors = np.linalg.eigh(scale[:, None] * stiffness * scale)
        for rate, vector in zip(np.sqrt(np.maximum(values, 0.0)), (scale[:, None] * vectors).T, strict=True):
            if rate < 2.0 * pi * SLOWEST:
                continue
            each = [float((t @ vector) ** 2 @ _damping(e)) for e, t, _ in held]
            each = [own + float((r @ vector) ** 2 @ _turning(e)) for own, (e, _, r) in zip(each, held, strict=True)]
            if (ratio := sum(each) / (2.0 * rate)) > MOST_DAMPED:
                element = held[int(np.argmax(each))][0]
                along = WORDS[int(np.argmax(np.abs(vector / scale)))]
                words = f"'{vehicle.names[i]}' has {along} a damping ratio of {ratio:.3g} on '{element.name}'"
                words += f"; plausible is up to {MOST_DAMPED:g}: is it N s/m that is given as kN s/m?"
                kind = _damping(element).tobytes()
                worst[kind] = max(worst.get(kind, (0.0, "")), (ratio, words))
    yield from (words for _, words in worst.values())


def _turning(element: Element) -> Array:
    return np.array(element.turning_damping) if isinstance(element, Spring) else np.zeros(3)
