"""Profiles as workshops measure them, one row each: dimensions of wheels, head wear of rails, conicity and pressure of
each on a common partner; distances of the active faces of wheelsets."""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wrsim.analysis.conicity.pairs import Pairing, conicity_map
from wrsim.analysis.poses.static import contact_map
from wrsim.contact.profiles.files import Reading, notes_of
from wrsim.contact.profiles.flange import flange_dimensions, tread_hollow
from wrsim.contact.profiles.head_wear import head_wear
from wrsim.contact.profiles.profile import KINDS, Kind, Profile
from wrsim.errors import InputError
from wrsim.results.table import Cell, Column, Table, quantity

HEADS_APART = 0.2  # difference from a measure in the head of a file from which it is told [mm]
MEASURES = {"wheel": ("Sh", "Sd", "qR", "hollow"), "rail": ("W1", "W2", "W3")}
LAID = 0.5e-3
"""How far the field sides of a rail and an unworn one may be apart [m]: tolerance of the width of heads, EN 13674-1."""
SIDE = re.compile(r"(?<![a-z0-9])(left|right|l|r)(?![a-z0-9])", re.IGNORECASE)  # in the name of a file


@dataclass(frozen=True)
class Partner:
    """What profiles are paired with: wheels or rails like this one, on or under both sides.

    gauge: of the track, radius: of the wheels at the tape circle [m]; load: of a wheel, for p0 [N].
    """

    profile: Profile
    pairing: Pairing
    gauge: float
    radius: float
    load: float

    def label(self) -> str:
        """The pair, for notes."""
        where = "on" if self.profile.kind == "rail" else "under"
        sizes = (
            f"gauge {quantity(1e3 * self.gauge, 'mm', '.6g')}, wheel radius {quantity(1e3 * self.radius, 'mm', 'g')}"
        )
        load = f"p0 of a centred wheelset, wheel load {quantity(1e-3 * self.load, 'kN', 'g')}"
        return f"{where} {self.profile.name}{self.pairing.inclined}, both sides alike: {sizes}; {load}"

    def values(self, profiles: Mapping[str, Profile]) -> tuple[list[tuple[float, float]], tuple[str, ...]]:
        """Equivalent conicity at 3 mm and p0 [MPa] of every profile, not-a-number where there is none; reasons."""
        slope, partner = self.pairing.slope, {self.profile.name: self.profile}
        wheels, rails = (profiles, partner) if self.profile.kind == "rail" else (partner, profiles)
        rails = {name: rail.inclined(slope) for name, rail in rails.items()}
        chart = conicity_map(wheels, rails, [self.gauge], self.pairing.spacing, self.radius, self.pairing.roll)
        pressures = [self._pressure(wheels[wheel], rails[rail]) for wheel, rail in chart.pairs]
        return list(zip(chart.conicity[:, 0].tolist(), pressures, strict=True)), chart.reasons

    def _pressure(self, wheel: Profile, rail: Profile) -> float:
        placed = {"gauge": self.gauge, "profile_spacing": self.pairing.spacing(wheel, wheel), "rolling": False}
        try:
            contacts = contact_map(wheel, rail, self.radius, 0.0, loads=self.load, **placed)  # type: ignore[arg-type]
        except InputError:
            return np.nan  # as is the conicity, with the reason
        return 1e-6 * float(contacts["p0"].max())


def measured_tables(
    readings: Mapping[str, Reading], faults: Sequence[str], unworn: Profile | None, partner: Partner | None
) -> dict[Kind, Table]:
    """What is measured on the points, a table a kind: Sh, Sd, qR, hollow of wheels, W1, W2, W3 of rails against the
    unworn one [mm]; conicity and pressure with a partner. What cannot be measured is a gap, its reason in the notes.

    Raises InputError for an unworn profile or a partner that has no use.
    """
    kinds = {reading.profile.kind for reading in readings.values()}
    if unworn is not None and unworn.kind not in kinds:
        raise InputError(f"--reference: {unworn.name} is a {unworn.kind}, and none of the profiles is")
    if partner is not None and kinds == {partner.profile.kind}:
        raise InputError(f"--on: {partner.profile.name} is a {partner.profile.kind} like the profiles")
    tables = dict[Kind, Table]()
    for kind in KINDS:
        if group := {name: reading for name, reading in readings.items() if reading.profile.kind == kind}:
            tables[kind] = _table(kind, group, unworn, partner)
    first = next(iter(tables))
    told = notes_of([reading.profile for reading in readings.values()])
    return tables | {first: replace(tables[first], notes=(*tables[first].notes, *told, *faults))}


def _table(kind: Kind, readings: Mapping[str, Reading], unworn: Profile | None, partner: Partner | None) -> Table:
    against = unworn if unworn is not None and unworn.kind == kind else None
    names, notes = MEASURES[kind], list[str]()
    if kind == "rail" and against is None:
        names, notes = (), ["W1, W2, W3 are measured against the unworn rail: --reference rails/60E1.toml"]
    elif kind == "rail" and against is not None:
        notes = [f"against {against.name}; W2 {quantity(1e3 * against.gauge_depth, 'mm', 'g')} below its top"]
    rows: list[list[Cell]] = []
    profiles = {name: reading.profile for name, reading in readings.items()}
    for name, reading in readings.items():
        try:
            measures = _measures(reading.close, against) if names else ()
            notes += _doubts(name, reading.close, against) + _apart(name, names, measures, reading.instrument)
        except InputError as error:
            notes.append(f"{name}: {error}")
            measures = (np.nan,) * len(names)
        rows.append([name, *(1e3 * value for value in measures)])
    columns = [Column(kind, key=kind), *(Column(name, "mm", ".2f", f"{name}_mm") for name in names)]
    if partner is not None and partner.profile.kind != kind:
        values, reasons = partner.values(profiles)
        rows = [[*row, *pair] for row, pair in zip(rows, values, strict=True)]
        columns.append(Column("tan γe, 3 mm", "", ".3f", "equivalent_conicity_3_mm"))
        columns.append(Column("p0", "MPa", ".0f", "p0_MPa"))
        notes += [partner.label(), *reasons]
    return Table("", tuple(columns), rows, tuple(notes))


def _apart(name: str, names: Sequence[str], measures: Sequence[float], head: Mapping[str, float]) -> list[str]:
    """A note where measures [m] differ from those in the head of the file [mm]."""
    pairs = [(key, 1e3 * value, head[key]) for key, value in zip(names, measures, strict=False) if key in head]
    differences = [
        f"{key} {value:.2f}, in its head {noted:.2f}" for key, value, noted in pairs if abs(value - noted) > HEADS_APART
    ]
    return [f"{name}: {'; '.join(differences)} mm"] if differences else []


def _doubts(name: str, rail: Profile, unworn: Profile | None) -> list[str]:
    """A note where a scan does not lie on the unworn rail: at its field side, or above it."""
    if unworn is None or rail.kind != "rail":
        return []
    wear, faults = head_wear(rail, unworn), []
    if abs(wear.field) > LAID:
        side = "inside" if wear.field > 0.0 else "outside"
        distance = quantity(1e3 * abs(wear.field), "mm", ".2f")
        faults.append(f"its field side lies {distance} {side} that of {unworn.name}")
    if wear.vertical < -LAID:
        faults.append(f"its top lies {quantity(-1e3 * wear.vertical, 'mm', '.2f')} above that of {unworn.name}")
    question = "is it of that rail? field_side, shift_mm, turn_mrad of the scan"
    return [f"{name}: {' and '.join(faults)}: {question}"] if faults else []


def _measures(profile: Profile, unworn: Profile | None) -> tuple[float, ...]:
    if profile.kind == "wheel" or unworn is None:
        flange = flange_dimensions(profile)
        return flange.height, flange.thickness, flange.steepness, tread_hollow(profile)
    wear = head_wear(profile, unworn)
    return wear.vertical, wear.lateral, wear.corner


def wheelsets_table(profiles: Mapping[str, Profile], flange_back: float) -> Table:
    """Distance of the active faces SR = back to back + Sd left + Sd right [mm] of wheels whose names differ by their
    side alone (axle1_left, axle1_right), or of the only two. Raises InputError where there are none."""
    groups = defaultdict[str, list[str]](list)
    for name in profiles:
        groups[SIDE.sub("", name).strip("_-. ") if SIDE.search(name) else name].append(name)
    pairs = {name: sides for name, sides in groups.items() if len(sides) == 2}
    if not pairs and len(profiles) == 2:
        pairs = {" / ".join(profiles): list(profiles)}
    if not pairs:
        raise InputError("--flange-back-mm: needs two wheels, or names of files such as axle1_left, axle1_right")
    rows = []
    for name, sides in pairs.items():
        faces = sum(flange_dimensions(profiles[side]).thickness for side in sides)
        rows.append((name, 1e3 * flange_back, 1e3 * (flange_back + faces)))
    heads = (Column("wheelset", key="wheelset"), Column("back to back", "mm", ".2f", "flange_back_mm"))
    return Table("", (*heads, Column("active faces SR", "mm", ".2f", "SR_mm")), rows)
