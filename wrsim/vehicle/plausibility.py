"""Plausibility of a vehicle: values that no railway vehicle has, and what is wrong with them in mechanics.

Every rule follows from a principle that is given with its threshold. Nothing is refused: the vehicle of a thought
experiment may run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import hypot, inf, pi

import numpy as np
from numpy.typing import NDArray

from wrsim.vehicle.elements import Array, Element
from wrsim.vehicle.plausible_values import overdamped
from wrsim.vehicle.preload import DIRECTIONS, Preload, motions, preloads
from wrsim.vehicle.vehicle import Body, MountedWheelset, Vehicle

RIGID_UP_TO = 100.0
"""Frequency [Hz] above which no body of a railway vehicle is rigid: frames and car bodies bend at 8 to 50 Hz, wheelsets
from 50 Hz on. A rigid body that oscillates faster on its springs has no counterpart."""
LONG, LONG_UP_TO = 5.0, 25.0
"""Car bodies, held at points more than 5 m apart as no bogie is, bend first at 8 to 20 Hz: the same [Hz] for them."""
ARMS_UP_TO = 250.0
"""Frequency [Hz] of axle boxes on their bushings: a bar of mass m that turns about the axle on a bushing of stiffness k
at its end has omega^2 = 3 k / m whatever its length, 247 Hz with the stiffest bushings, 40 kN/mm, and 50 kg."""
LIGHT_ARM = 50.0
"""That mass [kg]. Lighter boxes are placeholders, links without mass: their stiffness is judged with it."""
SLOWEST = 1e-3
"""Frequency [Hz] below which a direction is free: within the minutes of a run nothing returns."""
HIGHEST, ROOF = 4.0, 4.28
"""Height [m] of a centre of mass, below the roof of the reference profile G1 (EN 15273-2). The former is also the most
that a spring deflects at rest: with more it is longer than the vehicle is high."""
HALF_GAUGE = hypot(1.645, ROOF)
"""Distance [m] from the axis of the track in the plane of the rails to the corner of the reference profile G1."""
OVERHANG = 4.5
"""Length [m] of a body beyond the outermost point that holds it: with LONGEST_SPAN n (a + n) / 2 R, 0.45 m in a curve
of 150 m. No mass of a body is farther from its centre, nor is its radius of gyration."""
DENSEST = 22_590.0
"""Density of osmium [kg/m3]. Of all solids of a mass and a density the sphere has the least moments of inertia."""
LONGEST_SPAN = 25.0
"""Distance a [m] of neighbouring wheelsets: halfway between them a vehicle is a^2 / 8 R off the track, 0.52 m in a
curve of 150 m; reference profiles leave less."""
UNEVEN = 0.4
"""Largest deviation of a static wheel load from the mean of its vehicle: EN 14363 allows a wheel to lose 0.6 of its
load on twisted track in all, of which twist takes 0.2 and more."""
MOST_UNSPRUNG = 0.45
"""Share of the wheelsets in the mass of a vehicle with bodies: 0.1 to 0.3 from coaches to empty wagons. Of a bogie on a
test stand, which springs hold to its frame, it may be more."""


@dataclass(frozen=True)
class _Springs:
    """Stiffness of each element in all coordinates: six of each part (``DIRECTIONS``), then pitch of the axle boxes.

    by_element: to trace a frequency to the one that causes it; stuck: of all, with friction that sticks.
    """

    vehicle: Vehicle
    by_element: list[Array]
    stuck: Array

    @classmethod
    def build(cls, vehicle: Vehicle, moved: list[tuple[Array, Array]]) -> _Springs:
        by_element, stuck = [], np.zeros((6 * len(vehicle.parts) + len(vehicle.boxes),) * 2)
        for element, (travel, turning) in zip(vehicle.elements, moved, strict=True):
            along = travel.T * element.stiffness_at_rest @ travel
            by_element.append(along + turning.T * np.array(element.turning_stiffness) @ turning)
            stuck += by_element[-1]
            if element.slider is not None:
                stuck += (element.slider.stiffness or 1e6) * travel.T @ travel
        return cls(vehicle, by_element, stuck)

    def loose(self, places: NDArray[np.intp]) -> Array:
        """Motions of these coordinates that no spring resists, all others held: (coordinates, motions), orthonormal."""
        scale = self.inertia[places] ** -0.5
        values, vectors = np.linalg.eigh(scale[:, None] * self.stuck[np.ix_(places, places)] * scale)
        return np.asarray(vectors[:, values < (2.0 * pi * SLOWEST) ** 2])

    @property
    def whole(self) -> Array:
        return np.sum(self.by_element, axis=0) if self.by_element else np.zeros_like(self.stuck)

    @property
    def inertia(self) -> Array:
        of_parts = [c for part in self.vehicle.parts for c in (*(part.mass,) * 3, *part.inertia)]
        return np.array([*of_parts, *(box.inertia[1] for _, box in self.vehicle.boxes.values())])


def doubts(vehicle: Vehicle, known: Collection[str] = ()) -> list[str]:
    """What of a vehicle is implausible: one sentence each, with the element, its value, what is plausible and why.

    Of a train, vehicle by vehicle; of several alike the first one. known: parts of which something is known to be
    wrong; what follows from that has no sentence of its own.
    """
    sentences, seen = [], set()
    for member in [vehicle.alone(k) for k, member in enumerate(vehicle.members) if member.wagon is None] or [vehicle]:
        moved = motions(member)
        springs = _Springs.build(member, moved)
        kind = tuple(
            (np.round(each / np.max(each, initial=1.0), 9) + 0.0).tobytes() for each in (springs.whole, springs.inertia)
        )
        if kind not in seen:
            seen.add(kind)
            sentences += _of_vehicle(springs, moved, known)
    return sentences


def _of_vehicle(springs: _Springs, moved: list[tuple[Array, Array]], known: Collection[str]) -> list[str]:
    vehicle, named = springs.vehicle, set(known)
    apart = [*_distances(vehicle)]
    radii = dict(_gyration(vehicle, named, bool(apart)))
    named |= radii.keys()
    heights = dict(_heights(vehicle, named))
    named |= heights.keys()
    dense = dict(_density(vehicle, named))
    light = [] if named else [*_masses(vehicle)]
    named |= dense.keys()
    free = [] if apart else [*_free_directions(springs)]
    fast = [] if apart or light else [*_frequencies(springs, named)]
    loads = preloads(vehicle)
    uneven = [] if free or apart else [*_wheel_loads(vehicle, moved, loads)]
    one_a_part = (*radii.values(), *heights.values(), *dense.values())
    sentences = [*one_a_part, *apart, *light, *free, *fast, *_compression(vehicle, loads), *uneven]
    # masses and springs that are wrong make wrong damping ratios
    return sentences if sentences or known else [*overdamped(vehicle, moved, springs.whole, springs.inertia)]


def _heights(vehicle: Vehicle, known: Collection[str]) -> Iterator[tuple[str, str]]:
    """Bodies whose centres are too high or too low, with a sentence each; of known ones the moments of inertia say
    nothing. Heights from 0 to ROOF with the mean c have a variance of at most c (ROOF - c) (Bhatia and Davis, 2000)."""
    for body in {(body.mass, body.centre[2]): body for body in vehicle.bodies[::-1]}.values():
        roll, pitch, yaw = body.inertia
        least = 0.0 if body.name in known else max(0.5 * (roll + pitch - yaw) / body.mass / ROOF, 0.0)
        if not least <= body.centre[2] <= HIGHEST:
            message = f"centre of mass of body '{body.name}' is at a height of {body.centre[2]:.4g} m above the rails"
            message += f"; plausible is {least:.3g} to {HIGHEST:g} m, or it reaches below the rails"
            yield body.name, f"{message} or above the loading gauge"


def _distances(vehicle: Vehicle) -> Iterator[str]:
    """Wheelsets that overlap or are too far apart, bogies among each other."""
    close, far = list[str](), list[str]()
    for ahead, behind in pairwise(sorted(vehicle.wheelsets, key=lambda m: -m.x)):
        apart, least = ahead.x - behind.x, ahead.wheelset.mean_radius + behind.wheelset.mean_radius
        pair = f"wheelsets '{ahead.name}' and '{behind.name}' are {apart:.4g} m apart{{}}"
        if apart < least:
            close.append(
                f"{pair}; plausible is more than {least:.4g} m, or their wheels overlap: check wheelbase and pivots"
            )
        if apart > LONGEST_SPAN:
            far.append(f"{pair}; plausible is up to {LONGEST_SPAN:g} m, or the vehicle leaves the gauge in curves")
    for messages in (close, far):
        yield from (messages[0].format(_more(messages, "pair")) for _ in messages[:1])
    if close:
        return
    spans = dict[tuple[float, float], str]()  # side frames of one truck have one span
    for name in (body.name for body in vehicle.bodies if body is not vehicle.parts[vehicle.reference]):
        joined = [{*_carriers(vehicle, e)} for e in vehicle.elements]
        held = [m.x for m in vehicle.wheelsets if {name, m.name} in joined]
        spans |= {(min(held), max(held)): name} if len(held) > 1 else {}
    for (span, first), (neighbour, second) in pairwise(sorted(spans.items(), key=lambda item: -sum(item[0]))):
        if neighbour[1] > span[0]:
            mixed = (
                f"wheelsets of '{first}' and '{second}' are among each other: {span[1] - span[0]:.4g} m is a wheelbase"
            )
            yield f"{mixed} too long for their distance of {0.5 * (sum(span) - sum(neighbour)):.4g} m"


def _carriers(vehicle: Vehicle, element: Element) -> tuple[str, str]:
    return vehicle.carrier(element.first), vehicle.carrier(element.second)


def _more(items: Sequence[object], noun: str) -> str:
    """How many more there are than the first."""
    more = len(items) - 1
    return f" (and {more} more {noun}{'s' * (more != 1)})" if more > 0 else ""


def _masses(vehicle: Vehicle) -> Iterator[str]:
    share = sum(mounted.mass for mounted in vehicle.wheelsets) / vehicle.mass
    if vehicle.bodies and not vehicle.runs_with_frame and share > MOST_UNSPRUNG:
        message = f"the wheelsets are {share:.0%} of the mass of '{vehicle.name}', {vehicle.mass:.4g} kg"
        yield f"{message}; plausible is 10 to 30 %: its bodies are too light"


def _gyration(vehicle: Vehicle, known: Collection[str], misplaced: bool) -> Iterator[tuple[str, str]]:
    """Parts whose radii of gyration are beyond their size, with a sentence each; of misplaced ones the length is not
    known."""
    for part in _alike(vehicle):
        if isinstance(part, Body):
            reach = max(abs(x - part.centre[0]) for x in _held(vehicle, part.name)) + OVERHANG
            most = (HALF_GAUGE, hypot(reach, HIGHEST), hypot(reach, 0.5 * HIGHEST))
            most = (most[0], inf, inf) if misplaced else most
            part_name, mass, inertia = f"body '{part.name}'", part.mass, part.inertia
        else:
            wheelset = part.wheelset
            across = hypot(0.5 * wheelset.profile_spacing + 0.5, wheelset.mean_radius)
            most = (across, inf, across)  # inertia of gears and motors is often counted about the axle
            part_name, mass, inertia = f"wheelset '{part.name}'", wheelset.mass, wheelset.inertia
        radii = [(value / mass) ** 0.5 for value in inertia]
        wrong = [k for k in range(3) if radii[k] > most[k]]
        if wrong and part.name not in known:
            each = _joined([f"{radii[k]:.4g} m {DIRECTIONS[3 + k]} ({inertia[k]:.4g} kg m2)" for k in wrong])
            limits = _joined([f"{most[k]:.3g}" for k in wrong])
            message = f"radius of gyration of {part_name} of {mass:.4g} kg is {each}"
            yield part.name, f"{message}; plausible is up to {limits} m, as far as any mass"


def _held(vehicle: Vehicle, part: str) -> list[float]:
    """Where along the vehicle elements hold a part [m]."""
    return [end[0] for e in vehicle.elements for n, end in zip((e.first, e.second), e.points, strict=True) if n == part]


def _density(vehicle: Vehicle, known: Collection[str]) -> Iterator[tuple[str, str]]:
    """Parts whose moments of inertia are those of something too dense, with a sentence each."""
    for part in _alike(vehicle):
        mass = part.mass if isinstance(part, Body) else part.wheelset.mass
        inertia = part.inertia if isinstance(part, Body) else part.wheelset.inertia
        sphere = 0.6 * (0.75 * mass / pi / DENSEST) ** (2 / 3)
        if (gyration := 0.5 * sum(inertia) / mass) < sphere and part.name not in known:
            name = f"{'body' if isinstance(part, Body) else 'wheelset'} '{part.name}'"
            message = f"moments of inertia of {name} are those of a sphere of {(gyration / 0.6) ** 0.5:.3g} m of radius"
            yield part.name, f"{message}; {mass:.4g} kg of the densest metal have {(sphere / 0.6) ** 0.5:.3g} m"


def _alike(vehicle: Vehicle) -> Iterator[Body | MountedWheelset]:
    """All parts, but of those with the same mass and inertia the first only."""
    seen = set()
    for part in vehicle.parts:
        inertia = part.mass, part.inertia
        if inertia not in seen:
            seen.add(inertia)
            yield part


def _what(vehicle: Vehicle, i: int) -> str:
    name = vehicle.names[i]
    return f"{'wheelset' if i < len(vehicle.wheelsets) else 'body'} '{name}'"


def _joined(items: list[str]) -> str:
    return " and ".join(filter(None, (", ".join(items[:-1]), items[-1])))


def _free_directions(springs: _Springs) -> Iterator[str]:
    """Directions in which nothing holds a part, or several parts together: zero eigenvalues of the stiffness.

    Contact is left out, but the rails hold wheelsets vertically and in roll; axles spin; the heaviest part is held
    along x, y and in yaw, for the track, or what drives it, holds the vehicle as a whole.
    """
    vehicle, base = springs.vehicle, len(springs.vehicle.wheelsets)
    if len(vehicle.parts) == 1:
        return
    directions_of = [[0, 1, 5] if i < base else [0, 1, 2, 3, 4, 5] for i in range(len(vehicle.parts))]
    alike: dict[str, list[str]] = {}
    for i, directions in enumerate(directions_of):
        loose = springs.loose(6 * i + np.array(directions))
        if loose.size:
            free = [DIRECTIONS[directions[k]] for k, row in enumerate(loose) if row @ row > 0.5]
            alike.setdefault(_joined(free), []).append(_what(vehicle, i))
    for along, parts in alike.items():
        label = parts[0] + _more(parts, "part")
        yield f"nothing holds {label} {along}: no spring of it works in that direction"
    directions_of[vehicle.reference] = [k for k in directions_of[vehicle.reference] if k not in (0, 1, 5)]
    places = np.array([6 * i + k for i, directions in enumerate(directions_of) for k in directions])
    together = springs.loose(places)
    if together.size and not alike:
        moves = np.zeros((len(vehicle.parts), 6))
        moves[places // 6, places % 6] = np.linalg.norm(together, axis=1)
        parts = [name for name, row in zip(vehicle.names, moves, strict=True) if max(row) > 0.1 * moves.max()]
        ways = [word for word, column in zip(DIRECTIONS, moves.T, strict=True) if max(column) > 0.1 * moves.max()]
        message = f"{', '.join(parts)} move together {_joined(ways)}"
        yield f"{message}, and nothing holds them against {_what(vehicle, vehicle.reference)}"


def _frequencies(springs: _Springs, known: Collection[str]) -> Iterator[str]:
    """Frequencies of single parts and axle boxes, all others held: bounds from below of the highest one of the whole
    vehicle.

    Motors and cases that ride on the axle that they drive are held by bearings and left out.
    """
    vehicle, whole, inertia = springs.vehicle, springs.whole, springs.inertia
    joined = {frozenset((e.first, e.second)) for e in vehicle.elements}
    on_axle = {n for d in vehicle.drives for n in (d.motor, d.case) if frozenset((n, d.wheelset)) in joined}
    wrong = {part.mass for part in vehicle.parts if part.name in known}
    fastest: dict[bytes, tuple[float, str]] = {}
    for i, part in enumerate(vehicle.parts):
        places = slice(6 * i, 6 * i + 6)
        scale = inertia[places] ** -0.5
        values, vectors = np.linalg.eigh(scale[:, None] * whole[places, places] * scale)
        frequency, shape = max(values[-1], 0.0) ** 0.5 / (2.0 * pi), scale * vectors[:, -1]
        limit = LONG_UP_TO if np.ptp(_held(vehicle, part.name) or [0.0]) > LONG else RIGID_UP_TO
        if frequency > limit and part.name not in on_axle and part.mass not in wrong:
            element = vehicle.elements[int(np.argmax([shape @ k[places, places] @ shape for k in springs.by_element]))]
            along = DIRECTIONS[int(np.argmax(np.abs(vectors[:, -1])))]
            message = f"{_what(vehicle, i)} oscillates {along} at {frequency:.4g} Hz on '{element.name}'"
            message += f"; plausible is up to {limit:g} Hz, above which it bends: stiffness or mass is wrong"
            alike = element.stiffness_at_rest.tobytes()
            fastest[alike] = max(fastest.get(alike, (0.0, "")), (frequency, message))
    for place, name in enumerate(vehicle.boxes, 6 * len(vehicle.parts)):
        k = int(np.argmax([matrix[place, place] for matrix in springs.by_element]))
        element = vehicle.elements[k]
        squared_arm = springs.by_element[k][place, place] / max(element.stiffness_at_rest.max(), 1.0)
        least = max(inertia[place], LIGHT_ARM * squared_arm / 3.0)
        frequency = (max(whole[place, place], 0.0) / least) ** 0.5 / (2.0 * pi)
        if frequency > ARMS_UP_TO:
            message = f"axle box '{name}' oscillates in pitch at {frequency:.4g} Hz on '{element.name}'"
            message += f"; plausible is up to {ARMS_UP_TO:g} Hz: stiffness, mass or inertia is wrong"
            alike = element.stiffness_at_rest.tobytes()
            fastest[alike] = max(fastest.get(alike, (0.0, "")), (frequency, message))
    yield from (message for _, message in fastest.values())


def _compression(vehicle: Vehicle, loads: list[Preload]) -> Iterator[str]:
    """Springs that their static load compresses by more than there is room for."""
    softest: dict[bytes, tuple[float, str]] = {}
    for element, preload in zip(vehicle.elements, loads, strict=True):
        stiffness = element.stiffness_at_rest
        by = np.divide(np.abs(preload.force), stiffness, out=np.zeros(len(stiffness)), where=stiffness > 0.0)
        if (k := int(np.argmax(by))) >= 0 and by[k] > HIGHEST:
            message = f"'{element.name}' carries {abs(preload.force[k]) / 1e3:.4g} kN, deflects by {by[k]:.4g} m with"
            message += f" {stiffness[k] / 1e3:.4g} kN/m; plausible is up to {HIGHEST:g} m, a vehicle's height"
            softest[stiffness.tobytes()] = max(softest.get(stiffness.tobytes(), (0.0, "")), (float(by[k]), message))
    yield from (message for _, message in softest.values())


def _wheel_loads(vehicle: Vehicle, moved: list[tuple[Array, Array]], loads: list[Preload]) -> Iterator[str]:
    """Static wheel loads far from the mean of their vehicle, from the forces of the springs on the wheelsets."""
    base = len(vehicle.wheelsets)
    forces = np.zeros(6 * len(vehicle.parts) + len(vehicle.boxes))
    for (travel, turning), preload in zip(moved, loads, strict=True):
        forces += travel.T @ preload.force + turning.T @ preload.moment
    on_wheelsets = forces[: 6 * base].reshape(-1, 6)
    on_wheelsets[:, 2] -= [mounted.mass * vehicle.gravity for mounted in vehicle.wheelsets]
    for carried in vehicle.carried:
        if (i := vehicle.index(carried.body)) < base:
            on_wheelsets[i, 2] -= carried.mass * vehicle.gravity
    for payload in vehicle.payloads:
        if (i := vehicle.index(payload.body)) < base:
            on_wheelsets[i, :3] += payload.force
            on_wheelsets[i, 3:] += np.cross(np.array(payload.at) - vehicle.place(payload.body), payload.force)
    spacing = np.array([mounted.wheelset.profile_spacing for mounted in vehicle.wheelsets])
    wheels = -0.5 * on_wheelsets[:, 2:3] + np.outer(on_wheelsets[:, 3] / spacing, (-1.0, 1.0))
    mean = float(np.mean(wheels))
    off = np.max(np.abs(wheels - mean), axis=1)
    if (worst := int(np.argmax(off))) >= 0 and off[worst] > UNEVEN * abs(mean):
        left, right = (1e-3 * wheels[worst]).tolist()
        name = vehicle.wheelsets[worst].name
        message = f"static wheel loads of '{name}' are {left:.4g} kN left and {right:.4g} kN right"
        more = int(np.sum(off > UNEVEN * abs(mean))) - 1
        message += f" (and of {more} more wheelsets as far off)" if more else ""
        message += f"; plausible is within {UNEVEN:.0%} of the vehicle's mean, {1e-3 * mean:.4g} kN"
        yield f"{message}: check centres of mass, pivots and springs"
