"""From the tables of a vehicle file to the parts of a Vehicle: placed, mirrored and repeated; units end here.

Inside of a part, names refer to its own bodies or to those of the parts around it; from outside, a body in a part is
``place.name`` (``front.frame``). Repeated elements get names of their own: ``primary leading left``.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any

from wrsim.errors import InputError, suggest
from wrsim.inputs.checking import Locate, fault_line
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import given
from wrsim.vehicle import vehicle_sections as sections
from wrsim.vehicle.element_tables import VEHICLE_AXES, Axes, ElementTable, Joint
from wrsim.vehicle.elements import TRACK, ZERO, Element, Triple
from wrsim.vehicle.flexible import Modes
from wrsim.vehicle.loads import GearedMotor, Load, Payload
from wrsim.vehicle.preload import Ballast
from wrsim.vehicle.vehicle import AxleBox, Body, MeasuringPoint, MountedWheelset
from wrsim.vehicle.wheelset import Wheelset

DEEPEST = 8
"""Levels of parts inside of parts."""
MOST = 1000
"""Parts in their places, and bodies and wheelsets, of one vehicle: its matrices grow with their square."""


@dataclass(frozen=True)
class Place:
    """A part: its name (with a dot behind, empty for a vehicle on its own), its axes, its depth."""

    prefix: str = ""
    axes: Axes = VEHICLE_AXES
    depth: int = 0


PlacedPart = tuple[sections.PartTable, KeyPath, Place]


@dataclass
class Assembly:
    """Collects the contents of the parts of a file.

    types: wheelsets by type, "" the one of [wheelset]. boxes: wheelset of each pair of axle boxes. pressed: of elements
    with friction, the possible full names of their normal spring, its key, and its name in the file. written: of every
    element, the prefix of its place and its name in the file. placed: number of parts so far.
    """

    parts: dict[str, sections.PartTable]
    types: dict[str, Wheelset]
    locate: Locate
    find: Callable[[str], FilePath] = FilePath
    bodies: dict[str, Body] = field(default_factory=dict)
    wheelsets: dict[str, MountedWheelset] = field(default_factory=dict)
    boxes: dict[str, str] = field(default_factory=dict)
    elements: list[Element] = field(default_factory=list)
    loads: list[Load] = field(default_factory=list)
    payloads: list[Payload] = field(default_factory=list)
    drives: list[GearedMotor] = field(default_factory=list)
    ballast: list[Ballast] = field(default_factory=list)
    points: list[MeasuringPoint] = field(default_factory=list)
    pressed: dict[str, tuple[tuple[str, ...], KeyPath, str]] = field(default_factory=dict)
    written: dict[str, tuple[str, str]] = field(default_factory=dict)
    placed: int = 0

    def add(self, part: sections.PartTable, path: KeyPath, place: Place) -> None:
        """Assemble the vehicle from its outermost part, at ``path`` of the file."""
        placed = list(self._parts(part, path, place))
        for each in placed:
            self._bodies(*each)
        for each in placed:
            self._elements(*each)
        self.elements = [self._pressed(element) for element in self.elements]

    def _parts(self, part: sections.PartTable, path: KeyPath, place: Place) -> Iterator[PlacedPart]:
        """A part and all parts inside of it, each with its path in the file and its place."""
        self.placed += 1
        yield part, path, place
        names = [table.name for table in part.places]
        for i, table in enumerate(part.places):
            key = (*path, "places", i)
            if names.count(table.name) > 1:
                raise self._fault((*key, "name"), "duplicate name; must be different for each", table.name)
            if table.part not in self.parts:
                raise self._unknown((*key, "part"), "is no part", table.part, list(self.parts))
            if place.depth >= DEEPEST:
                raise self._fault((*key, "part"), f"parts lie in parts more than {DEEPEST} deep", table.part)
            if self.placed > MOST:
                raise self._fault((*key, "part"), f"is one too many: a vehicle has at most {MOST} parts", table.part)
            x, y, z = ((-s if axis in table.mirror else s) for s, axis in zip(place.axes.signs, "xyz", strict=True))
            axes = Axes(place.axes.point(table.at_mm), (x, y, z))
            inner = Place(f"{place.prefix}{table.name}.", axes, place.depth + 1)
            yield from self._parts(self.parts[table.part], ("parts", table.part), inner)

    def _bodies(self, part: sections.PartTable, path: KeyPath, place: Place) -> None:
        for name, body in part.bodies.items():
            full = self._new(name, (*path, "bodies", name), place)
            centre = place.axes.point(body.centre_mm)
            modes = None if body.flexible is None else self._modes(body, centre, (*path, "bodies", name), place)
            self.bodies[full] = Body(full, body.mass_kg, body.inertia_kg_m2, centre, modes)
        for name, mount in part.wheelsets.items():
            full = self._new(name, (*path, "wheelsets", name), place)
            key = (*path, "wheelsets", name, "type")
            wheelset = self.types.get(mount.type or "")
            if wheelset is None:
                if mount.type is None:
                    raise self._fault(key, "is missing: there is no [wheelset] that all wheelsets share")
                raise self._unknown(key, "is no type of wheelset", mount.type, [t for t in self.types if t])
            x = place.axes.point((mount.x_mm, 0.0, 0.0))[0]
            self.wheelsets[full] = MountedWheelset(full, wheelset, x, wheelset.mean_radius)
        for name, box in part.axle_boxes.items():
            self._axle_boxes(name, box, (*path, "axle_boxes", name), place)

    def _elements(self, part: sections.PartTable, path: KeyPath, place: Place) -> None:
        for i, table in enumerate(part.elements):
            self.elements += self._repeated(table, (*path, "elements", i), place)
        for i, drive in enumerate(part.drives):
            self.drives.append(self._drive(drive, (*path, "drives", i), place))
        self.add_loads(part, path, place)
        for i, point in enumerate(part.points):
            body = self._body(point.on, (*path, "points", i, "on"), place)
            self.points.append(MeasuringPoint(place.prefix + point.name, body, place.axes.point(point.at_mm)))

    def add_loads(self, tables: Any, path: KeyPath, place: Place) -> None:
        """Add ``loads`` and ``payloads`` of the table at ``path``, on bodies that are known already."""
        for i, load in enumerate(tables.loads):
            body = self._body(load.on, (*path, "loads", i, "on"), place)
            self.loads.append(load.load(place.prefix + load.name, body, place.axes))
        for i, payload in enumerate(tables.payloads):
            key = (*path, "payloads", i, "on")
            body = self._body(payload.on, key, place)
            mass = payload.payload(place.prefix + payload.name, body, place.axes)
            if isinstance(mass, Payload):
                self.payloads.append(mass)
            elif body in self.wheelsets:
                raise self._fault(key, sections.NO_BALLAST, payload.on)
            else:
                self.ballast.append(mass)

    def _modes(self, body: sections.BodyTable, centre: Triple, path: KeyPath, place: Place) -> Modes:
        table = given(body.flexible)
        try:
            return table.of_body(body.mass_kg, centre, place.axes.origin, place.axes.signs, self.find)
        except InputError as error:
            raise self._fault((*path, "flexible", "modes"), str(error), table.modes) from None

    def _axle_boxes(self, name: str, table: sections.AxleBoxTable, path: KeyPath, place: Place) -> None:
        full = self._new(name, path, place)
        carrier = place.prefix + table.wheelset
        mounted = self.wheelsets.get(carrier)
        if mounted is None:
            known = [k.removeprefix(place.prefix) for k in self.wheelsets if k.startswith(place.prefix)]
            raise self._unknown((*path, "wheelset"), "is no wheelset of this part", table.wheelset, known)
        self.boxes[full] = carrier
        y, rest = table.y_mm / 1e3, (table.mass_kg, table.inertia_kg_m2)
        pair = AxleBox(f"{full} left", y, *rest), AxleBox(f"{full} right", -y, *rest)
        self.wheelsets[carrier] = replace(mounted, boxes=(*mounted.boxes, *pair))

    def _drive(self, table: sections.DriveTable, path: KeyPath, place: Place) -> GearedMotor:
        """A motor with its gear on a rigid wheelset that no other one drives."""
        wheelset = self._body(table.on, (*path, "on"), place)
        if wheelset not in self.wheelsets:
            raise self._fault((*path, "on"), "is no wheelset", table.on)
        if self.wheelsets[wheelset].wheelset.torsion is not None:
            message = "has wheels that turn against each other: a gear drives a rigid one"
            raise self._fault((*path, "on"), message, table.on)
        if wheelset in (drive.wheelset for drive in self.drives):
            raise self._fault((*path, "on"), "is driven by another one of [[drives]] already", table.on)

        def body(key: str, name: str) -> str:
            carrier = self._body(name, (*path, key), place)
            if carrier not in self.bodies:
                raise self._fault((*path, key), "is a wheelset: a motor and its gear are part of other bodies", name)
            return carrier

        return table.to_si(
            GearedMotor,
            wheelset=wheelset,
            motor=body("motor", table.motor),
            case=body("motor" if table.case is None else "case", table.case or table.motor),
            ratio=table.ratio * (1.0 if table.rotor_turns == "forward" else -1.0),
            hollow_inertia=table.hollow_axle_inertia_kg_m2,
        )

    def _new(self, name: str, path: KeyPath, place: Place) -> str:
        if name == TRACK or "." in name:
            message = f"'{name}' cannot be the name of a body: '{TRACK}' is taken and points are for parts"
            raise self._fault(path, message)
        if len(self.bodies) + len(self.wheelsets) + len(self.boxes) >= MOST:
            raise self._fault(path, f"is one too many: a vehicle has at most {MOST} bodies and wheelsets")
        return place.prefix + name

    def _body(self, name: str, path: KeyPath, place: Place, boxes: bool = False) -> str:
        """Full name of a body named in a part; boxes: it may be a pair of axle boxes or the frame of the track."""
        if boxes and name == TRACK:
            return name
        known = [*self.bodies, *self.wheelsets, *((*self.boxes, *self._single_boxes) if boxes else ())]
        around = place.prefix.split(".")[:-1]
        for depth in range(len(around), -1, -1):
            if (full := ".".join((*around[:depth], name))) in known:
                return full
        seen = [k.removeprefix(place.prefix) if k.startswith(place.prefix) else k for k in known]
        raise self._unknown(path, "is no body", name, list(dict.fromkeys((*seen, *((TRACK,) if boxes else ())))))

    @property
    def _single_boxes(self) -> dict[str, str]:
        return {f"{pair} {side}": carrier for pair, carrier in self.boxes.items() for side in ("left", "right")}

    def _centre(self, name: str) -> Triple:
        if name == TRACK:
            return ZERO
        name = self.boxes.get(name) or self._single_boxes.get(name, name)
        return self.bodies[name].centre if name in self.bodies else self.wheelsets[name].centre

    def _repeated(self, table: ElementTable, path: KeyPath, place: Place) -> Iterator[Element]:
        """The elements of one table: one for every ``to``, perhaps on both sides."""
        first = self._body(table.body, (*path, "body"), place, boxes=True)
        for to in table.to:
            second = self._body(to, (*path, "to"), place, boxes=True)
            if second == first:
                raise self._fault((*path, "to"), "is the body that the element comes from", to)
            base = place.axes
            if table.origin != "part":
                base = Axes(self._centre(first if table.origin == "body" else second), base.signs)
            name = table.name + (f" {to}" if len(table.to) > 1 else "")
            point = next(table.points(), ZERO)
            for side in (1.0, -1.0) if table.both_sides else (1.0,):
                x, y, z = base.signs
                axes = Axes(base.origin, (x, side * y, z))
                y = axes.point(point)[1]
                word = " left" if y > 0.0 else " right"
                ends = [end + word if end in self.boxes else end for end in (first, second)]
                if y == 0.0 and ends != [first, second]:
                    raise self._fault(path, "leads to an axle box and lies in the middle: give its points a y")
                full = place.prefix + name + (word if table.both_sides else "")
                element = table.element(Joint(full, table.kind, ends[0], ends[1]), axes)
                self._fits(element, path)
                normal = None if element.slider is None else element.slider.normal
                if normal is not None and normal.element:
                    repeated = (f" {to}{word}", f" {to}", word, "")
                    names = tuple(place.prefix + normal.element + end for end in repeated)
                    self.pressed[full] = names, (*path, "normal_spring"), normal.element
                self.written.setdefault(full, (place.prefix, table.name))
                yield element

    def _pressed(self, element: Element) -> Element:
        """The element with the full name of its normal spring: that on its side, to the same body."""
        if element.name not in self.pressed:
            return element
        names, path, spring = self.pressed[element.name]
        known = {candidate.name: candidate for candidate in self.elements}
        full_name = next((name for name in names if name in known), None)
        if full_name is None:
            prefix, _ = self.written[element.name]
            siblings = list(dict.fromkeys(name for place, name in self.written.values() if place == prefix))
            raise self._unknown(path, "is no element", spring, siblings)
        candidate = known[full_name].slider
        if candidate is not None and candidate.normal is not None and candidate.normal.element:
            raise self._fault(path, "depends on the load of a spring itself: must be that spring", spring)
        slider = element.slider
        if slider is None or slider.normal is None:
            return element
        return replace(element, slider=replace(slider, normal=replace(slider.normal, element=full_name)))

    def _fits(self, element: Element, path: KeyPath) -> None:
        """Springs join wheelsets on their axles, as the second body."""
        if element.first in self.wheelsets and element.turns_with_first:
            message = "is a wheelset: the axes of an element cannot turn with it; exchange body and to"
            raise self._fault((*path, "body"), message, element.first)
        if element.resists_turning and element.second in self.wheelsets:
            message = "is a wheelset, which spins: no rotational spring holds it"
            raise self._fault((*path, "to"), message, element.second)
        for name, end in zip((element.first, element.second), element.points, strict=True):
            if name not in self.wheelsets:
                continue
            x, _, z = self._centre(name)
            if abs(end[0] - x) > 1e-6 or abs(end[2] - z) > 1e-6:
                raise self._fault(
                    path,
                    f"'{element.name}' holds wheelset '{name}' beside its axle, which lies at x = {1e3 * x:g}, "
                    f"z = {1e3 * z:g} mm; its point is at x = {1e3 * end[0]:g}, z = {1e3 * end[2]:g} mm",
                )

    def _unknown(self, path: KeyPath, message: str, name: str, known: list[str]) -> InputError:
        return self._fault(path, f"{message}; there is {', '.join(known) or 'none'}{suggest(name, known)}", name)

    def _fault(self, path: KeyPath, message: str, value: str | None = None) -> InputError:
        return InputError(fault_line(path, message, self.locate, value))
