"""Vehicle files (``models/vehicles/*.toml``) and train files (``models/trains/*.toml``) to plain data in SI units.

A file with bodies, parts, elements or [wheelsets] is assembled from its parts; one with nothing but [wheelset],
[suspension] and [sprung] is a single wheelset that its bogie guides, one with [[vehicles]] a train. See
docs/user/vehicles.md and docs/user/trains.md for the formats.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from wrsim.contact.profiles.models import load_profile
from wrsim.errors import InputError, suggest
from wrsim.inputs.changes import changed, full_path, key_path
from wrsim.inputs.checking import Locate, check_section, fault_line, opened, refuse_other_kind
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.lookup import Finder, model_file, usual_finder
from wrsim.inputs.values import repeated
from wrsim.vehicle.assembly import Assembly, Place
from wrsim.vehicle.couplings import Gap
from wrsim.vehicle.element_tables import Axes
from wrsim.vehicle.elements import GUIDE, TRACK, ZERO, Element
from wrsim.vehicle.out_of_round import parts_of
from wrsim.vehicle.preload import Ballast, normal_loads, preloads, with_ballast
from wrsim.vehicle.vehicle import BrakePipe, Coupling, Member, Vehicle, Wagon, single_wheelset
from wrsim.vehicle.vehicle_sections import MemberTable, TrainFile, VehicleFile, WheelsetFile, WheelsetTable
from wrsim.vehicle.wheelset import Wheel, Wheelset

PART_TABLES = ("bodies", "wheelsets", "elements", "drives", "parts", "places", "wheelset_types")
"""Tables of a file that assembles a vehicle from parts."""


class Change(NamedTuple):
    """A value of a vehicle file to be changed: its dotted key by names (`wrsim.inputs.changes`), the value, and where
    it comes from, for messages."""

    key: str
    value: Any
    owner: str


def load_vehicle(path: str | Path, find: Finder | None = None, changes: Sequence[Change] = ()) -> Vehicle:
    """Read a vehicle file and the wheel profiles it names; check that its springs can hold it.

    Parameters
    ----------
    path : str or Path
        A vehicle file (docs/user/vehicles.md); a name that is not found as a path is looked up among the models:
        ``"vehicles/manchester_1.toml"``.
    find : Finder, optional
        Where profiles are looked up after the folder of the vehicle file itself.
    changes : sequence of Change
        Values to be changed; in a train those of its vehicles follow behind their names.

    Returns
    -------
    Vehicle

    Raises
    ------
    InputError
        With all faults of the file at once: file, line, key, value, what is allowed.
    """
    path = model_file(path)
    data, locate, inner = changed_tables(path, changes)
    finder = (find or usual_finder()).beside(path)
    if "vehicles" in data:
        return _checked(_train(check_section(TrainFile, data, locate), finder, locate, inner), path)
    if any(key in data for key in PART_TABLES):
        return _of_parts(check_section(VehicleFile, data, locate), path, finder, locate, Place())
    if "wheelset" not in data:
        refuse_other_kind(VehicleFile, data, locate)
    file = check_section(WheelsetFile, data, locate)
    return file.suspension.to_si(
        single_wheelset,
        wheelset=_wheelset(file.wheelset, ("wheelset",), file, finder, locate),
        ahead=file.suspension.ahead_of_bogie_centre_mm / 1000.0,
        carried_mass=file.sprung.mass_kg,
        carried_height=file.sprung.height_above_axle_mm / 1000.0,
    )


def changed_tables(path: Path, changes: Sequence[Change]) -> tuple[dict[str, Any], Locate, dict[str, list[Change]]]:
    """Tables of a vehicle file with changes, what locates their keys, and changes inside of the vehicles of a train."""
    data, written = opened(path, "vehicle file")
    owners: dict[KeyPath, str] = {}
    inner: dict[str, list[Change]] = {}
    members = [each.get("name") for each in data.get("vehicles", ()) if isinstance(each, dict)]
    for change in changes:
        try:
            keys = key_path(change.key)
            if keys[0] in members and len(keys) > 2:
                inner.setdefault(str(keys[0]), []).append(change._replace(key=change.key.partition(".")[2]))
                continue
            full = full_path(data, keys, by_name=True)
            data = changed(data, full, change.value)
        except InputError as error:
            raise InputError(f"{change.owner}: {error}") from None
        owners[full] = change.owner

    def locate(key: KeyPath) -> str:
        for full, owner in owners.items():
            table = full[:-1] if full[-1] == "kind" else full  # which has other keys then
            if key and (key == full[: len(key)] or table == key[: len(table)]) and len(key) >= len(full) - 1:
                return owner
        return written(key)

    return data, locate, inner


def _of_parts(file: VehicleFile, path: Path, finder: Finder, locate: Locate, place: Place) -> Vehicle:
    types: dict[str, Wheelset] = {}
    if file.wheelset is not None:
        types[""] = _wheelset(file.wheelset, ("wheelset",), file, finder, locate)
    for name, table in file.wheelset_types.items():
        types[name] = _wheelset(table, ("wheelset_types", name), file, finder, locate)
    assembly = Assembly(file.parts, types, locate, finder.find)
    assembly.add(file, (), place)
    lists = ("elements", "loads", "payloads", "points", "drives")
    parts: dict[str, Any] = {key: tuple(getattr(assembly, key)) for key in lists}
    wheelsets = tuple(sorted(assembly.wheelsets.values(), key=lambda mounted: -mounted.x))
    bodies = tuple(assembly.bodies.values())
    vehicle = Vehicle(file.name, wheelsets, bodies, source=file.source, gravity=file.gravity_m_per_s2, **parts)
    return _checked(vehicle, path, assembly.ballast)


def _wheelset(
    table: WheelsetTable, path: KeyPath, file: WheelsetFile | VehicleFile, finder: Finder, locate: Locate
) -> Wheelset:
    def wheel(side: str) -> Wheel:
        key, name = table.of_side("wheel", side)
        try:
            profile = finder.find(name)
        except InputError as error:
            raise InputError(fault_line((*path, key), str(error), locate, name)) from None
        tables = list(enumerate(table.out_of_round))
        wheel = Wheel(load_profile(profile, "wheel", table.back), table.of_side("radius_mm", side)[1] / 1000.0)
        return replace(wheel, out_of_round=parts_of(tables, side, wheel, finder.find, fault))

    def fault(place: KeyPath, message: str) -> InputError:
        return InputError(fault_line((*path, "out_of_round", *place), message, locate))

    axle = None if table.axle is None else table.axle.axle()
    if axle is not None:
        try:
            axle.wheels(table.mass_kg, table.spin_inertia_kg_m2, table.yaw_inertia_kg_m2, 0.5 * table.spacing)
        except InputError as error:
            raise InputError(fault_line((*path, "axle"), str(error), locate)) from None
    left, right = wheel("left"), wheel("right")
    try:
        return Wheelset(
            name=file.name,
            mass=table.mass_kg,
            inertia=(table.roll_inertia_kg_m2, table.spin_inertia_kg_m2, table.yaw_inertia_kg_m2),
            profile_spacing=table.spacing,
            left=left,
            right=right,
            source=file.source,
            torsion=table.torsion,
            axle=axle,
            back=table.back,
        )
    except InputError as error:
        raise InputError(fault_line((*path, "back_to_tape_circle_mm"), str(error), locate)) from None


def _checked(vehicle: Vehicle, path: Path, ballast: Sequence[Ballast] = ()) -> Vehicle:
    """The vehicle of a file, with what it carries. Raises InputError where its springs cannot hold it."""
    try:
        _check_connected(vehicle)
        vehicle = with_ballast(vehicle, ballast)
        normal_loads(vehicle, preloads(vehicle))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return vehicle


def _check_connected(vehicle: Vehicle) -> None:
    """A vehicle has wheelsets, names of its own, and elements that join every body to a wheelset, perhaps by way of
    other bodies. Raises InputError."""
    if not vehicle.wheelsets:
        raise InputError("the vehicle has no wheelset: a table [wheelsets.NAME] is needed")
    for kind, named in (("elements", vehicle.elements), ("loads", vehicle.loads)):
        if twice := sorted(repeated(each.name for each in named)):
            raise InputError(f"duplicate names of {kind}; must be different for each: {', '.join(twice)}")
    held = {TRACK, GUIDE, *(mounted.name for mounted in vehicle.wheelsets), *vehicle.boxes}
    joints = [{element.first, element.second} for element in vehicle.elements]
    while more := set().union(*(ends for ends in joints if ends & held)) - held:
        held |= more
    loose = [body.name for body in vehicle.bodies if body.name not in held]
    if loose:
        subject = f"{'body' if len(loose) == 1 else 'bodies'} {', '.join(loose)} hang on nothing"
        raise InputError(f"{subject}: no element joins them to a wheelset, not even by way of other bodies")


def _train(file: TrainFile, finder: Finder, locate: Locate, changes: Mapping[str, Sequence[Change]]) -> Vehicle:
    """The vehicles of a train, one behind the other, as one vehicle whose origin is that of the first one."""

    def fault(path: KeyPath, message: str, value: object = None) -> InputError:
        return InputError(fault_line(path, message, locate, value))

    named = [(i, table, name) for i, table in enumerate(file.vehicles) for name in table.names]
    for k, (i, _, name) in enumerate(named):
        if "." in name or name in (TRACK, GUIDE):
            reason = f"'{name}' cannot be the name of a vehicle: a point precedes the names of its bodies"
            raise fault(("vehicles", i, "name"), reason)
        if name in [earlier for _, _, earlier in named[:k]]:
            raise fault(("vehicles", i, "name"), f"'{name}' is the name of another vehicle; names need be different")
    gaps = len(named) - 1
    if gaps < 1:
        raise fault(("vehicles",), "is one vehicle: a train has at least two (or count = 2)")
    if len(file.couplings) not in (1, gaps):
        reason = f"there are {len(file.couplings)} for {gaps} gaps between vehicles: give one for all, or one for each"
        raise fault(("couplings",), reason)
    tables = file.couplings if len(file.couplings) == gaps else file.couplings * gaps
    vehicles: list[Vehicle] = []
    members: list[Member] = []
    couplings: list[Coupling] = []
    between: list[Element] = []
    chain: list[Element] = []
    rear, middle, ahead = 0.0, 0.0, ("", "")
    for k, (i, table, name) in enumerate(named):
        half, sign = 0.5 * table.length_mm / 1e3, -1.0 if table.reversed else 1.0
        nose = half + sign * table.middle_mm / 1e3  # of its front end before its origin
        front = rear - tables[k - 1].gap if k else nose
        if table.brake_force_kN is not None and file.brakes is None:
            raise fault(("vehicles", i, "brake_force_kN"), "goes with [brakes], the brake pipe of the train")
        member = _member_of(table, name, front - half)
        if table.model is None:
            behind = (name, name)
        else:
            place = Place(f"{name}.", Axes((front - nose, 0.0, 0.0), (sign, sign, 1.0)))
            try:
                vehicle = _member(finder.find(table.model), finder, place, changes.get(table.name, ()))
            except InputError as error:
                raise fault(("vehicles", i, "model"), str(error)) from None
            vehicles.append(vehicle)
            if wrong := _member_fault(vehicle, name, table, vehicles[0].gravity, front, front - 2.0 * half):
                raise fault(("vehicles", i, wrong[0]), wrong[1], getattr(table, wrong[0]))
            behind = (name, f"{name}.{table.body}" if table.body else vehicle.names[vehicle.reference])
            member = replace(member, wheelsets=len(vehicle.wheelsets), bodies=len(vehicle.bodies))
        middle = middle if k else front - half
        if file.brakes is not None:
            member = replace(member, delay=(middle - front + half) / file.brakes.propagation_m_per_s)
        members.append(member)
        if k:
            coupling = tables[k - 1]
            gap = Gap(f"{ahead[0]}-{name}", ahead[1], behind[1], 0.5 * (rear + front))
            alone = members[-2].wagon is not None and member.wagon is not None
            new = tuple(coupling.along(gap) if alone else coupling.elements(gap))
            point = (gap.x, 0.0, coupling.height_mm / 1e3)
            couplings.append(Coupling(gap.name, gap.ahead, gap.behind, point, tuple(element.name for element in new)))
            (chain if alone else between).extend(new)
        rear, ahead = front - 2.0 * half, behind
    if not vehicles:
        raise fault(("vehicles",), "has no vehicle in full, with a model: a run looks at one at least")
    lists = ("wheelsets", "bodies", "elements", "loads", "payloads", "points", "drives")
    parts: dict[str, Any] = {key: tuple(part for v in vehicles for part in getattr(v, key)) for key in lists}
    parts["elements"] += tuple(between)
    pipe = file.brakes
    return Vehicle(
        file.name, source=file.source, gravity=vehicles[0].gravity, members=tuple(members), chain=tuple(chain),
        brakes=None if pipe is None else BrakePipe(pipe.propagation_m_per_s, pipe.filling_s),
        couplings=tuple(couplings), **parts,
    )  # fmt: skip


def _member_of(table: MemberTable, name: str, x: float) -> Member:
    """A vehicle of a train with its middle at x [m]; of one in full the parts are not counted yet."""
    wagon = None
    if table.mass_t is not None:
        a, b, c = table.resistance_N or ZERO
        resistance = (a, 3.6 * b, 3.6**2 * c)
        pivots = (table.pivot_spacing_mm or 0.0) / 1e3
        wagon = Wagon(name, 1e3 * table.mass_t, x, pivots, resistance, table.curve_resistance_m or 0.0)
    driven = wagon is None if table.driven is None else table.driven
    return Member(name, 0, 0, driven, 1e3 * (table.brake_force_kN or 0.0), wagon=wagon)


def _member(path: Path, find: Finder, place: Place, changes: Sequence[Change]) -> Vehicle:
    data, locate, _ = changed_tables(path, changes)
    if not any(key in data for key in PART_TABLES):
        raise InputError(f"{path}: is no vehicle of parts; a train takes vehicles with bodies")
    return _of_parts(check_section(VehicleFile, data, locate), path, find.beside(path), locate, place)


def _member_fault(
    vehicle: Vehicle, name: str, table: MemberTable, gravity: float, front: float, rear: float
) -> tuple[str, str] | None:
    """Key and message where a vehicle does not fit into its train, between its ends [m]."""
    if vehicle.gravity != gravity:
        reason = f"has a gravity of {vehicle.gravity:g} m/s2 in its file, the first vehicle has {gravity:g}"
        return "model", reason
    framed = [e.name for e in vehicle.elements if {e.first, e.second} & {TRACK, GUIDE}]
    if framed:
        return "model", f"has elements to the frame of the track ('{framed[0]}'), which a train has not"
    for mounted in vehicle.wheelsets:
        if not rear < mounted.x < front:
            far = abs(mounted.x - 0.5 * (front + rear))
            return "length_mm", f"is too short: '{mounted.name}' lies {far:.4g} m from the middle"
    bodies = [body.name.removeprefix(f"{name}.") for body in vehicle.bodies]
    if not bodies:
        return "model", "has no body that couplings can hold on to"
    if table.body is not None and table.body not in bodies:
        reason = f"is no body of that vehicle; there is {', '.join(bodies)}{suggest(table.body, bodies)}"
        return "body", reason
    return None
