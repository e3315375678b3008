"""Vehicle files (``models/vehicles/*.toml``) to plain data in SI units.

A file with bodies, parts, elements or [wheelsets] is put together from its parts; one with nothing but [wheelset],
[suspension] and [sprung] is a single wheelset that its bogie guides, one with [[vehicles]] a train. See
docs/vehicles.md and docs/trains.md for the formats.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.inputs.checking import Locate, check_section, fault_line, opened
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.lookup import Finder, model_file, usual_finder
from wrsim.inputs.values import number
from wrsim.vehicle.assembly import Assembly, Place
from wrsim.vehicle.elements import GUIDE, TRACK
from wrsim.vehicle.elements.keys import scaled
from wrsim.vehicle.preload import Ballast, normal_loads, preloads, with_ballast
from wrsim.vehicle.train_files import TrainFile, train_of
from wrsim.vehicle.vehicle import Vehicle, single_wheelset
from wrsim.vehicle.vehicle_sections import ModelFile, PartTable, SprungTable, SuspensionTable, WheelsetTable
from wrsim.vehicle.wheelset import STANDARD_GRAVITY, Wheel, Wheelset

OF_PARTS = ("bodies", "wheelsets", "elements", "drives", "parts", "places", "wheelset_types")
"""Tables of a file that puts a vehicle together from parts."""


class WheelsetFile(ModelFile):
    """The file of a single wheelset."""

    aliases: ClassVar[dict[str, str]] = {**ModelFile.aliases, "wheelset": "vehicle", "sprung": "sprung_mass"}

    wheelset: WheelsetTable
    """The rigid body and its wheels."""
    suspension: SuspensionTable = SuspensionTable()
    """Springs and dampers to the frame that follows the track."""
    sprung: SprungTable = SprungTable()
    """The share of the vehicle that the wheelset carries."""


class VehicleFile(ModelFile, PartTable):
    """The file of a vehicle of parts: the outermost one, and what the parts share."""

    gravity_m_per_s2: Annotated[float, number(9, 10)] = STANDARD_GRAVITY
    """Gravity with which the source has its loads from."""
    wheelset: WheelsetTable | None = None
    """The wheelset of all mounts that name no type."""
    wheelset_types: dict[str, WheelsetTable] = Field(default_factory=dict)
    """Other wheelsets, by the names of their types."""
    parts: dict[str, PartTable] = Field(default_factory=dict)
    """Parts that are described once and placed as often as needed."""


def load_vehicle(path: str | Path, find: Finder | None = None) -> Vehicle:
    """Read a vehicle file and the wheel profiles it names; check that its springs can hold it.

    Parameters
    ----------
    path : str or Path
        A vehicle file (docs/vehicles.md); a name that is not found as it stands is looked up among the models:
        ``"vehicles/manchester_1.toml"``.
    find : Finder, optional
        Where profiles are looked up after the folder of the vehicle file itself.

    Returns
    -------
    Vehicle

    Raises
    ------
    InputError
        With all faults of the file at once: file, line, key, value, what is allowed.
    """
    path = model_file(path)
    data, locate = opened(path, "vehicle file")
    finder = (find or usual_finder()).beside(path)
    if "vehicles" in data:
        return _checked(train_of(check_section(TrainFile, data, locate), finder, locate, _member), path)
    if any(key in data for key in OF_PARTS):
        return _of_parts(check_section(VehicleFile, data, locate), path, finder, locate, Place())
    if "wheelset" not in data and "body" in data:
        raise InputError(f"{path}: is a profile file; a vehicle file with a table [wheelset] is needed here")
    return _of_one_wheelset(check_section(WheelsetFile, data, locate), finder, locate)


def _of_one_wheelset(file: WheelsetFile, finder: Finder, locate: Locate) -> Vehicle:
    suspension = file.suspension
    return single_wheelset(
        _wheelset(file.wheelset, ("wheelset",), file, finder, locate),
        stiffness=scaled(suspension.stiffness_kN_per_m),
        damping=scaled(suspension.damping_kNs_per_m),
        half_spacing=suspension.half_spacing_mm / 1000.0,
        ahead=suspension.ahead_of_bogie_centre_mm / 1000.0,
        carried_mass=file.sprung.mass_kg,
        carried_height=file.sprung.height_above_axle_mm / 1000.0,
    )


def _member(path: Path, find: Finder, place: Place) -> Vehicle:
    """A vehicle of a train. Raises InputError."""
    data, locate = opened(path, "vehicle file")
    if not any(key in data for key in OF_PARTS):
        raise InputError(f"{path}: is no vehicle of parts; a train takes vehicles with bodies")
    return _of_parts(check_section(VehicleFile, data, locate), path, find.beside(path), locate, place)


def _of_parts(file: VehicleFile, path: Path, finder: Finder, locate: Locate, place: Place) -> Vehicle:
    types: dict[str, Wheelset] = {}
    if file.wheelset is not None:
        types[""] = _wheelset(file.wheelset, ("wheelset",), file, finder, locate)
    for name, table in file.wheelset_types.items():
        types[name] = _wheelset(table, ("wheelset_types", name), file, finder, locate)
    assembly = Assembly(file.parts, types, locate)
    assembly.add(file, (), place)
    lists = ("elements", "loads", "payloads", "points", "drives")
    parts: dict[str, Any] = {key: tuple(getattr(assembly, key)) for key in lists}
    wheelsets = tuple(sorted(assembly.wheelsets.values(), key=lambda mounted: -mounted.x))
    bodies = tuple(assembly.bodies.values())
    vehicle = Vehicle(file.name, wheelsets, bodies, source=file.source, gravity=file.gravity_m_per_s2, **parts)
    return _checked(vehicle, path, assembly.ballast)


def _checked(vehicle: Vehicle, path: Path, ballast: Sequence[Ballast] = ()) -> Vehicle:
    """The vehicle of a file, with what it carries. Raises InputError where its springs cannot hold it."""
    try:
        check_connected(vehicle)
        vehicle = with_ballast(vehicle, ballast)
        normal_loads(vehicle, preloads(vehicle))
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
    for what, named in (("elements", vehicle.elements), ("loads", vehicle.loads)):
        names = [each.name for each in named]
        twice = sorted(name for name, times in Counter(names).items() if times > 1)
        if twice:
            raise InputError(f"{what} need names of their own; these stand for more than one: {', '.join(twice)}")
    held = {TRACK, GUIDE, *(mounted.name for mounted in vehicle.wheelsets), *vehicle.boxes}
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
        which = f"{'body' if len(loose) == 1 else 'bodies'} {', '.join(loose)} hang on nothing"
        raise InputError(f"{which}: no element joins them to a wheelset, not even by way of other bodies")


def _wheelset(
    table: WheelsetTable, path: KeyPath, file: WheelsetFile | VehicleFile, finder: Finder, locate: Locate
) -> Wheelset:
    def wheel(side: str) -> Wheel:
        key, name = table.of_side("wheel", side)
        try:
            profile = finder.find(name)
        except InputError as error:
            raise InputError(fault_line((*path, key), str(error), locate, name)) from None
        return Wheel(load_profile(profile, "wheel"), table.of_side("radius_mm", side)[1] / 1000.0)

    return Wheelset(
        name=file.name,
        mass=table.mass_kg,
        inertia=(table.roll_inertia_kg_m2, table.spin_inertia_kg_m2, table.yaw_inertia_kg_m2),
        profile_spacing=table.spacing,
        left=wheel("left"),
        right=wheel("right"),
        source=file.source,
        torsion=table.torsion,
    )
