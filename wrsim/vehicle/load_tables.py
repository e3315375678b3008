"""[[loads]] and [[payloads]]: what acts on a vehicle besides its own weight, in the user's units.

A payload belongs to the vehicle: it is trimmed with it, so that its springs carry it in the design position. Under a
load the vehicle moves.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, Field

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import RisingRows, Three, number, positive, refuse, text
from wrsim.vehicle.elements import ZERO
from wrsim.vehicle.elements.keys import Axes, Name, Place
from wrsim.vehicle.loads import Load, LoadAxes, Over, Payload
from wrsim.vehicle.preload import Ballast

LARGEST = 1e4
"""Largest component of a force [kN]."""

Rows = tuple[tuple[float, float, float, float], ...]


def _allowed(rows: Rows) -> Rows:
    """Rows (x, force) whose forces are possible."""
    for position, row in enumerate(rows):
        if max(map(abs, row[1:])) > LARGEST:
            raise refuse(f"row [{position}] has a force of more than {LARGEST:g} kN")
    return rows


_Four = Annotated[tuple[float, float, float, float], Field(strict=False)]
OverTime = Annotated[
    RisingRows[Annotated[_Four, Field(description="four numbers [time s, x kN, y kN, z kN]")]], AfterValidator(_allowed)
]
OverDistance = Annotated[
    RisingRows[Annotated[_Four, Field(description="four numbers [distance m, x kN, y kN, z kN]")]],
    AfterValidator(_allowed),
]
Force = Three[Annotated[float, number(-LARGEST, LARGEST, "kN")]]

NO_BALLAST = "is a wheelset, which spins: no mass is put on it; a force_kN may be"
NEEDS_AXES = (
    'must be "track" or "body", the axes that the force keeps to. A load acts beside the preload: the vehicle tilts '
    "under it on its springs. A force that the vehicle is trimmed with, as [[loads]] once meant, stands in [[payloads]]"
)


class LoadTable(Section, header="[[loads]]"):
    """[[loads]]: a force at a point of a body, constant or over the time or the distance, at rest and in runs."""

    one_of: ClassVar[tuple[str, ...]] = ("force_kN time_s_force_kN distance_m_force_kN",)
    aliases: ClassVar[dict[str, str]] = {"on": "body", "axes": "frame", "force_kN": "f_kN"}

    name: Name
    """Name of the load."""
    on: Annotated[str, text("the name of a body")]
    """Body on which it acts."""
    at_mm: Place
    """Point of the body at which it acts."""
    axes: LoadAxes | None = None
    """Axes that the force keeps to: those of the track, or of the body."""
    force_kN: Force | None = None
    """The force, where it is constant."""
    time_s_force_kN: OverTime | None = None
    """The force over the time of the run, row by row; linear between rows."""
    distance_m_force_kN: OverDistance | None = None
    """The force over the distance of its point along the track, row by row."""

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """The axes have to be said."""
        if "axes" not in raw:
            yield Fault("axes", NEEDS_AXES, missing=True)

    def load(self, name: str, body: str, axes: Axes) -> Load:
        """The load in SI units, of this name on this body; axes: of the part that it stands in."""
        over: Over = "time" if self.distance_m_force_kN is None else "distance"
        rows = self.time_s_force_kN or self.distance_m_force_kN or ((0.0, *(self.force_kN or ZERO)),)
        table = tuple((x, *axes.vector((fx, fy, fz))) for x, fx, fy, fz in rows)
        return Load(name, body, axes.point(self.at_mm), table, over, self.axes or "track")


class PayloadTable(Section, header="[[payloads]]"):
    """[[payloads]]: a mass that is part of a body, or a constant force, with which the vehicle is trimmed."""

    aliases: ClassVar[dict[str, str]] = {"on": "body", "force_kN": "f_kN"}
    one_of: ClassVar[tuple[str, ...]] = ("mass_kg force_kN",)
    goes_with: ClassVar[dict[str, str]] = {"inertia_kg_m2": "mass_kg"}

    name: Name
    """Name of the payload."""
    on: Annotated[str, text("the name of a body")]
    """Body that it is part of."""
    at_mm: Place
    """Its centre."""
    mass_kg: Annotated[float, positive(1e6, "kg")] | None = None
    """Its mass."""
    inertia_kg_m2: Three[Annotated[float, number(0, 1e9, "kg m2")]] | None = None
    """Moments of inertia about its own centre; none unless given."""
    force_kN: Force | None = None
    """A force in place of a mass, along the axes of the track at rest."""

    def payload(self, name: str, body: str, axes: Axes) -> Payload | Ballast:
        """The payload in SI units, of this name on this body; axes: of the part that it stands in."""
        at = axes.point(self.at_mm)
        if self.mass_kg is None:
            return Payload(name, body, axes.vector(self.force_kN or ZERO), at)
        return Ballast(body, self.mass_kg, at, self.inertia_kg_m2 or ZERO)
