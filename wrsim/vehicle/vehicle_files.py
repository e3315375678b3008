"""Files of whole vehicles (``models/vehicles/*.toml``) to plain data in SI units.

A file with a table [suspension] or nothing but [wheelset] describes a lone wheelset (``vehicle.files``); one with
bodies, parts, elements or [wheelsets] a whole vehicle. See docs/vehicles.md for the format.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field

from wrsim.errors import InputError
from wrsim.inputs.checking import check
from wrsim.inputs.lines import KeyPath, key_lines, line_of
from wrsim.inputs.lookup import Finder
from wrsim.inputs.toml_files import parse_toml, read_text
from wrsim.inputs.values import Day, Source, text
from wrsim.vehicle.assembly import Assembly
from wrsim.vehicle.elements import TRACK
from wrsim.vehicle.files import WheelsetTable, load_vehicle, load_wheel
from wrsim.vehicle.preload import preloads
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.vehicle_sections import PartTable
from wrsim.vehicle.wheelset import Wheel, Wheelset

WHOLE = ("bodies", "wheelsets", "elements", "parts", "places", "wheelset_types")
"""Tables that only the file of a whole vehicle has."""


class WholeVehicleFile(PartTable):
    """The file of a whole vehicle: its outermost part, and what the parts share."""

    header: ClassVar[str] = "the file of a whole vehicle"
    aliases: ClassVar[dict[str, str]] = {"title": "name"}

    name: Annotated[str, text("the vehicle's name")]
    source: Source
    date: Day
    wheelset: WheelsetTable | None = None
    wheelset_types: dict[str, WheelsetTable] = Field(default_factory=dict)
    parts: dict[str, PartTable] = Field(default_factory=dict)


def is_whole_vehicle(data: dict[str, Any]) -> bool:
    """True for the tables of a whole vehicle, False for those of a lone wheelset."""
    return any(key in data for key in WHOLE)


def load_any(path: str | Path, find: Finder | None = None) -> Vehicle | Wheelset:
    """Read a vehicle file of either kind.

    Raises InputError with the faults of the file: file, line, key, value, what is allowed.
    """
    path = Path(path)
    data = parse_toml(read_text(path, "vehicle file"), str(path))
    return load_whole_vehicle(path, find) if is_whole_vehicle(data) else load_vehicle(path, find)


def load_whole_vehicle(path: str | Path, find: Finder | None = None) -> Vehicle:
    """Read the file of a whole vehicle and the wheel profiles it names; check that its springs can hold it.

    Raises InputError as ``load_any``.
    """
    path = Path(path)
    text = read_text(path, "vehicle file")
    lines = key_lines(text)

    def locate(key: KeyPath) -> str:
        line = line_of(lines, key)
        return f"{path}:{line}" if line else str(path)

    file = check(WholeVehicleFile, parse_toml(text, str(path)), locate)
    finder = (find or Finder(())).beside(path)
    types: dict[str, Wheelset] = {}
    if file.wheelset is not None:
        types[""] = _wheelset(file.wheelset, ("wheelset",), file, finder, locate)
    for name, table in file.wheelset_types.items():
        types[name] = _wheelset(table, ("wheelset_types", name), file, finder, locate)
    assembly = Assembly(file.parts, types, locate)
    assembly.add(file, ())
    vehicle = Vehicle(
        file.name,
        tuple(sorted(assembly.wheelsets.values(), key=lambda mounted: -mounted.x)),
        tuple(assembly.bodies.values()),
        tuple(assembly.elements),
        tuple(assembly.loads),
        tuple(assembly.points),
        file.source,
    )
    try:
        check_connected(vehicle)
        preloads(vehicle)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return vehicle


def check_connected(vehicle: Vehicle) -> None:
    """Refuse a vehicle without wheelsets, elements of one name, and bodies that no chain of elements joins to a
    wheelset.

    Raises InputError.
    """
    if not vehicle.wheelsets:
        raise InputError("the vehicle has no wheelset: a table [wheelsets.NAME] is needed")
    names = [element.name for element in vehicle.elements]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"elements need names of their own; these stand for more than one: {', '.join(twice)}")
    held = {TRACK, *(mounted.name for mounted in vehicle.wheelsets)}
    while True:
        more = {
            end
            for element in vehicle.elements
            for end in (element.first, element.second)
            if (element.first in held) != (element.second in held)
        } - held
        if not more:
            break
        held |= more
    loose = [body.name for body in vehicle.bodies if body.name not in held]
    if loose:
        raise InputError(
            f"{'body' if len(loose) == 1 else 'bodies'} {', '.join(loose)} hang on nothing: no element joins them to a "
            "wheelset, not even by way of other bodies"
        )


def _wheelset(table: WheelsetTable, path: KeyPath, file: WholeVehicleFile, finder: Finder, locate: Any) -> Wheelset:
    left, right = (
        Wheel(load_wheel(table, side, finder, locate, path), radius)
        for side, radius in zip(("left", "right"), table.radii, strict=True)
    )
    return Wheelset(
        name=file.name,
        mass=table.mass_kg,
        inertia=(table.roll_inertia_kg_m2, table.spin_inertia_kg_m2, table.yaw_inertia_kg_m2),
        profile_spacing=table.spacing,
        left=left,
        right=right,
        source=file.source,
    )
