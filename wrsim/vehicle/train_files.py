"""Train files (``models/trains/*.toml``): vehicles in a row and the couplings between them, as one `Vehicle`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field

from wrsim.errors import InputError, suggest
from wrsim.inputs.checking import Locate, fault_line
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.lookup import Finder
from wrsim.inputs.section import Section
from wrsim.inputs.values import List, Switch, number, positive, text
from wrsim.vehicle.assembly import Place
from wrsim.vehicle.couplings import Couplings, Gap
from wrsim.vehicle.elements import GUIDE, TRACK, Element
from wrsim.vehicle.elements.keys import Axes, Name
from wrsim.vehicle.vehicle import Coupling, Member, Vehicle
from wrsim.vehicle.vehicle_sections import ModelFile

ReadMember = Callable[[Path, Finder, Place], Vehicle]
"""Reads the vehicle file at a path and puts the vehicle at a place. Raises InputError."""


class MemberTable(Section, header="[[vehicles]]"):
    """[[vehicles]]: a vehicle of a train, or several alike, one behind the other."""

    aliases: ClassVar[dict[str, str]] = {"model": "file vehicle", "count": "number times", "length_mm": "length_m"}

    model: Annotated[str, text('a vehicle file such as "vehicles/manchester_1.toml"')]
    """File of the vehicle."""
    name: Name
    """Its name; names of its bodies follow behind a dot, and several alike are numbered: coach1, coach2."""
    count: Annotated[int, number(1, 100)] = 1
    """How many of them run one behind the other."""
    length_mm: Annotated[float, positive(200_000, "mm over buffers or couplers, as coupled")]
    """Its length between the planes in which it meets its neighbours."""
    middle_mm: Annotated[float, number(-100_000, 100_000, "mm, positive forward")] = 0.0
    """Where the middle of that length lies, from the origin of its file."""
    body: Name | None = None
    """Body that its couplings hold on to; the heaviest unless given."""
    reversed: Switch = False
    """Whether it runs the other way round."""
    driven: Switch = True
    """Whether a drive of its own holds its speed; if not, its couplings alone take it along."""


class TrainFile(ModelFile, header="a train file"):
    """The file of a train: vehicles from front to rear, and what couples them."""

    aliases: ClassVar[dict[str, str]] = {**ModelFile.aliases, "vehicles": "vehicle", "couplings": "coupling"}

    name: Annotated[str, text("the train's name")]
    """Name of the train."""
    vehicles: Annotated[List[MemberTable], Field(min_length=1)]
    """Its vehicles, from front to rear."""
    couplings: Annotated[Couplings, Field(min_length=1)]
    """One for all gaps between them, or one for each gap from front to rear."""


@dataclass(frozen=True)
class _Placed:
    """A vehicle in its place: the number of its table, its name, itself, the ends of its length [m]."""

    table: int
    name: str
    vehicle: Vehicle
    x: float
    front: float
    rear: float
    body: str


def train_of(file: TrainFile, finder: Finder, locate: Locate, read: ReadMember) -> Vehicle:
    """The train as one vehicle, its origin that of its first vehicle. Raises InputError."""

    def fault(path: KeyPath, message: str, value: object = None) -> InputError:
        return InputError(fault_line(path, message, locate, value))

    names = [(i, name) for i, table in enumerate(file.vehicles) for name in _names(table)]
    for k, (i, name) in enumerate(names):
        if "." in name or name in (TRACK, GUIDE):
            words = f"'{name}' cannot be the name of a vehicle: points stand before the names of its bodies"
            raise fault(("vehicles", i, "name"), words)
        if name in [other for _, other in names[:k]]:
            raise fault(("vehicles", i, "name"), f"'{name}' is the name of another vehicle; names need be different")
    gaps = len(names) - 1
    if gaps < 1:
        raise fault(("vehicles",), "is one vehicle: a train has at least two (or count = 2)")
    if len(file.couplings) not in (1, gaps):
        words = f"there are {len(file.couplings)} for {gaps} gaps between vehicles: give one for all, or one for each"
        raise fault(("couplings",), words)
    couplings = file.couplings if len(file.couplings) == gaps else file.couplings * gaps
    placed = list(_placed(file, names, [coupling.gap for coupling in couplings], finder, read, fault))
    joints: list[Coupling] = []
    elements: list[Element] = []
    for (ahead, behind), table in zip(pairwise(placed), couplings, strict=True):
        gap = Gap(f"{ahead.name}-{behind.name}", ahead.body, behind.body, 0.5 * (ahead.rear + behind.front))
        new = tuple(table.elements(gap))
        elements += new
        at = (gap.x, 0.0, table.height_mm / 1e3)
        joints.append(Coupling(gap.name, gap.ahead, gap.behind, at, tuple(element.name for element in new)))
    members = (
        Member(s.name, len(s.vehicle.wheelsets), len(s.vehicle.bodies), s.x, file.vehicles[s.table].driven)
        for s in placed
    )
    own = ("wheelsets", "bodies", "elements", "loads", "payloads", "points", "drives")
    parts: dict[str, Any] = {key: tuple(part for s in placed for part in getattr(s.vehicle, key)) for key in own}
    parts["elements"] += tuple(elements)
    return Vehicle(
        file.name, source=file.source, gravity=placed[0].vehicle.gravity, members=tuple(members),
        couplings=tuple(joints), **parts,
    )  # fmt: skip


def _names(table: MemberTable) -> list[str]:
    return [table.name] if table.count == 1 else [f"{table.name}{k + 1}" for k in range(table.count)]


def _placed(
    file: TrainFile, names: list[tuple[int, str]], gaps: list[float], finder: Finder, read: ReadMember,
    fault: Callable[..., InputError],
) -> Iterator[_Placed]:  # fmt: skip
    """The vehicles one behind the other. Raises InputError."""
    end, gravity = 0.0, 0.0
    for k, (i, name) in enumerate(names):
        table = file.vehicles[i]
        half, sign = 0.5 * table.length_mm / 1e3, -1.0 if table.reversed else 1.0
        ahead = half + sign * table.middle_mm / 1e3  # of its front end before its origin
        front = ahead if k == 0 else end - gaps[k - 1]
        x, end = front - ahead, front - 2.0 * half
        try:
            place = Place(f"{name}.", Axes((x, 0.0, 0.0), (sign, sign, 1.0)))
            vehicle = read(finder.find(table.model), finder, place)
        except InputError as error:
            raise fault(("vehicles", i, "model"), str(error)) from None
        gravity = gravity or vehicle.gravity
        if vehicle.gravity != gravity:
            words = f"has a gravity of {vehicle.gravity:g} m/s2 in its file, the first vehicle has {gravity:g}"
            raise fault(("vehicles", i, "model"), words, table.model)
        framed = [e.name for e in vehicle.elements if {e.first, e.second} & {TRACK, GUIDE}]
        if framed:
            words = f"has elements to the frame of the track ('{framed[0]}'), which a train has not"
            raise fault(("vehicles", i, "model"), words, table.model)
        for mounted in vehicle.wheelsets:
            if not end < mounted.x < front:
                far = abs(mounted.x - 0.5 * (front + end))
                words = f"is too short: '{mounted.name}' lies {far:.4g} m from the middle"
                raise fault(("vehicles", i, "length_mm"), words, table.length_mm)
        yield _Placed(i, name, vehicle, x, front, end, _coupled(vehicle, name, table, i, fault))


def _coupled(vehicle: Vehicle, name: str, table: MemberTable, i: int, fault: Callable[..., InputError]) -> str:
    """The body that the couplings of a vehicle hold on to."""
    bodies = [body.name for body in vehicle.bodies]
    if not bodies:
        raise fault(("vehicles", i, "model"), "has no body that couplings can hold on to", table.model)
    if table.body is None:
        return vehicle.names[vehicle.reference]
    if f"{name}.{table.body}" not in bodies:
        known = [body.removeprefix(f"{name}.") for body in bodies]
        words = f"is no body of that vehicle; there is {', '.join(known)}{suggest(table.body, known)}"
        raise fault(("vehicles", i, "body"), words, table.body)
    return f"{name}.{table.body}"
