"""Couplings between the vehicles of a train: screw couplings with side buffers, and centre couplers.

Each gear (draw gear, buffer) is a spring along the line between two hinges, one on either vehicle, that pulls or pushes
only. Both neighbours have the same gear, and these lie in series: a coupling gives way twice as far as one of them.
"""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from wrsim.inputs.section import Choice, Fault, Section
from wrsim.inputs.values import fields, number, positive, requirement
from wrsim.vehicle.element_tables import ForceOfTravel, Glyph
from wrsim.vehicle.elements import Element, Normal, PlaneFriction, Slider, Strut, Table, Triple

RISE = 1e-3
"""Stroke of one gear over which its preload builds up [m]."""
FAR = 1.0
"""Extent of a table beyond the stroke and beyond the slack [m]; beyond, it is extrapolated."""
DRAW, BUFF, BUFFER, PLATES = "draw gear", "buff gear", "buffer", "buffer plates"
"""Kinds of elements."""

ROD = Glyph("_", "#222222")
GLYPHS = {DRAW: ROD, BUFF: ROD, BUFFER: Glyph("|", "#D55E00"), PLATES: Glyph("D", "#CC79A7", hollow=True)}
"""Their marks in drawings."""


class Gap(NamedTuple):
    """A gap of a train: its name, the bodies ahead and behind, the middle of the gap in the train's axes [m]."""

    name: str
    ahead: str
    behind: str
    x: float


class GearTable(Section, header="[couplings.draw] or [couplings.buff]"):
    """[couplings.draw] and [couplings.buff]: the gear of one vehicle; that of its neighbour is alike, in series."""

    one_of: ClassVar[tuple[str, ...]] = ("stiffness_kN_per_m stroke_mm_force_kN",)
    at_most_one: ClassVar[tuple[str, ...]] = ("preload_kN stroke_mm_force_kN", "stroke_mm stroke_mm_force_kN")

    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """Stiffness over its stroke; goes with stroke_mm. Or give a table."""
    preload_kN: Annotated[float, number(0, 1e4, "kN")] = 0.0
    """Force with which the stroke begins; it builds up over 1 mm."""
    stroke_mm: Annotated[float, positive(1000, "mm")] | None = None
    """Length of its stroke."""
    stroke_mm_force_kN: ForceOfTravel | None = None
    """Force over its stroke, row by row from stroke 0, in place of stiffness, preload and stroke."""
    solid_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] = 50_000.0
    """Stiffness beyond the end of the stroke, of what lies behind the gear."""
    friction_share: Annotated[float, number(0, 0.9)] = 0.0
    """Friction as a part of its force: so much more on the way in, and so much less on the way out."""
    friction_travel_mm: Annotated[float, positive(100, "mm")] = 2.0
    """Travel over which the friction at the end of the stroke builds up."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        if "stiffness_kN_per_m" in raw and "stroke_mm" not in raw and "stroke_mm_force_kN" not in raw:
            stroke = requirement(fields(cls)["stroke_mm"])
            yield Fault("stroke_mm", f"goes with stiffness_kN_per_m: must be {stroke}", True)

    def consistency(self) -> Iterator[Fault]:
        rows = self.stroke_mm_force_kN
        if rows is not None and (rows[0][0] != 0.0 or rows[0][1] < 0.0):
            yield Fault("stroke_mm_force_kN", "must begin with stroke 0 and a force not below 0")
        if self.stroke < 2.0 * RISE:
            key = "stroke_mm" if rows is None else "stroke_mm_force_kN"
            yield Fault(key, f"must be a stroke of at least {2e3 * RISE:g} mm")

    @property
    def stroke(self) -> float:
        """Length of the stroke of one gear [m]."""
        if self.stroke_mm_force_kN is not None:
            return self.stroke_mm_force_kN[-1][0] / 1e3
        return (self.stroke_mm or 0.0) / 1e3

    @property
    def law(self) -> Table:
        """Rows (stroke [m], force [N]) of both neighbours' gears together, from (0, 0) to the end of the stroke."""
        if self.stroke_mm_force_kN is not None:
            rows = [(t / 1e3, 1e3 * f) for t, f in self.stroke_mm_force_kN]
        else:
            first = 1e3 * self.preload_kN
            rows = [(0.0, first), (self.stroke, first + 1e3 * (self.stiffness_kN_per_m or 0.0) * self.stroke)]
        if rows[0][1] > 0.0:
            risen = float(np.interp(RISE, *np.transpose(rows)))
            rows = [(0.0, 0.0), (RISE, risen), *(row for row in rows if row[0] > RISE)]
        return tuple((2.0 * t, f) for t, f in rows)

    def element(
        self,
        name: str,
        kind: str,
        gap: Gap,
        ends: tuple[Triple, Triple],
        free: float = 0.0,
        held: float = 0.0,
        count: int = 1,
    ) -> Strut:
        """The gear between two hinges, ahead and behind [m]: it pulls, or as a buffer pushes, beyond ``free`` [m] of
        travel; held: its force at rest [N]; count: of those side by side that it stands for."""
        sign = 1.0 if kind == DRAW else -1.0
        law = tuple((t, count * f) for t, f in self.law)
        strokes, forces = np.transpose(law)
        begin, (end, most) = free - float(np.interp(held, forces, strokes)), law[-1]
        rows = [(begin - FAR, 0.0), *((begin + t, f) for t, f in law)]
        rows.append((begin + end + FAR, most + count * 1e3 * self.solid_stiffness_kN_per_m * FAR))
        table = tuple(sorted((sign * t, sign * f) for t, f in rows))
        slider = None
        if self.friction_share:
            stiffness = self.friction_share * most / (2e-3 * self.friction_travel_mm)
            slider = Slider("coulomb", stiffness, friction=self.friction_share, normal=Normal("", 1.0, 0, sign))
        limits = (begin - FAR, begin + end) if sign > 0.0 else (-begin - end, FAR - begin)
        return Strut(
            name, kind, gap.ahead, gap.behind, ends, None, spring_table=table, limits=limits, slider=slider,
            preload=(-sign * held,),
        )  # fmt: skip


class BuffersTable(GearTable, header="[couplings.buffers]"):
    """[couplings.buffers]: the two side buffers of a vehicle; those of its neighbour are alike."""

    height_mm: Annotated[float, positive(5000, "mm above the rails")]
    """Height of their middle above the rails."""
    half_spacing_mm: Annotated[float, positive(2000, "mm from the middle of the vehicle")]
    """Distance of each from the middle of the vehicle."""
    head_radius_mm: Annotated[float, positive(1e5, "mm")]
    """Radius of the spheres that their heads are parts of."""
    plate_friction: Annotated[float, number(0, 1)] = 0.0
    """Coefficient of friction between their heads, against sliding sideways and up."""
    plate_stick_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] = 5000.0
    """Stiffness of a pair of buffers across, where their heads stick."""

    def elements(self, gap: Gap, free: float, held: float) -> Iterator[Element]:
        """Springs and plates of both sides: two spheres push along the line between their centres. free: distance of
        the heads at rest [m]; held: force of each at rest [N]."""
        for side, y in (("left", self.half_spacing_mm / 1e3), ("right", -self.half_spacing_mm / 1e3)):
            name = f"{gap.name} buffer {side}"
            yield self.element(name, BUFFER, gap, self._centres(gap, free, y), free, held)
            if self.plate_friction:
                normal = Normal(name, 1.0, 0, -1.0)
                stick = 1e3 * self.plate_stick_stiffness_kN_per_m
                slider = Slider("coulomb", stick, friction=self.plate_friction, normal=normal)
                point = (gap.x, y, self.height_mm / 1e3)
                yield PlaneFriction(f"{gap.name} plates {side}", PLATES, gap.ahead, gap.behind, point, 0, slider=slider)

    def pair(self, gap: Gap, free: float, held: float) -> Strut:
        """Both sides as one in the middle; held: force of each at rest [N]."""
        centres = self._centres(gap, free, 0.0)
        return self.element(f"{gap.name} buffers", BUFFER, gap, centres, free, 2.0 * held, count=2)

    def _centres(self, gap: Gap, free: float, y: float) -> tuple[Triple, Triple]:
        """Centres of the spheres of one side, ahead and behind [m]."""
        far, z = 0.5 * free + self.head_radius_mm / 1e3, self.height_mm / 1e3
        return (gap.x + far, y, z), (gap.x - far, y, z)


class CouplingTable(Choice, header="[[couplings]]"):
    """Keys of all couplings."""

    kind: str
    """Kind of coupling."""
    height_mm: Annotated[float, positive(5000, "mm above the rails")]
    """Height of hook or coupler above the rails."""
    hinge_mm: Annotated[float, number(10, 5000, "mm behind the coupling plane, into the vehicle")]
    """Distance of the hinge, about which hook or coupler swings, from the end of its vehicle."""
    slack_mm: Annotated[float, number(0, 500, "mm")] = 0.0
    """Play of the coupling: of a screw coupling before it pulls, of a centre coupler from one side to the other."""
    draw: GearTable
    """Gear for tensile forces."""

    @property
    def gap(self) -> float:
        """Distance of the ends of both vehicles at rest [m]."""
        return 0.0

    def elements(self, gap: Gap) -> Iterator[Element]:
        raise NotImplementedError

    def along(self, gap: Gap) -> Iterator[Element]:
        """The elements between two vehicles that move along the track alone."""
        return self.elements(gap)

    def _hinges(self, gap: Gap) -> tuple[Triple, Triple]:
        """Hinges of the vehicles ahead and behind [m]."""
        far, z = 0.5 * self.gap + self.hinge_mm / 1e3, self.height_mm / 1e3
        return (gap.x + far, 0.0, z), (gap.x - far, 0.0, z)


class ScrewCouplingTable(CouplingTable, kind="screw"):
    """A screw coupling that pulls, and two side buffers at each end that push."""

    pretension_kN: Annotated[float, number(0, 1000, "kN")] = 0.0
    """Force with which the screw pulls the buffers together at rest, half of it on each side."""
    gap_mm: Annotated[float, number(0, 500, "mm")] = 0.0
    """Distance of the buffers' heads at rest."""
    buffers: BuffersTable
    """Side buffers."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        for key in ("slack_mm", "gap_mm"):
            if raw.get("pretension_kN") and raw.get(key):
                yield Fault(key, "must be 0 next to pretension_kN: the screw holds the buffers together")

    @property
    def gap(self) -> float:
        return self.gap_mm / 1e3

    def elements(self, gap: Gap) -> Iterator[Element]:
        held = 1e3 * self.pretension_kN
        hinges = self._hinges(gap)
        yield self.draw.element(f"{gap.name} draw gear", DRAW, gap, hinges, self.slack_mm / 1e3, held)
        yield from self.buffers.elements(gap, self.gap, 0.5 * held)

    def along(self, gap: Gap) -> Iterator[Element]:
        yield next(iter(self.elements(gap)))
        yield self.buffers.pair(gap, self.gap, 0.5e3 * self.pretension_kN)


class CentreCouplerTable(CouplingTable, kind="centre"):
    """A centre coupler: a bar between two hinges that pulls and pushes."""

    buff: GearTable
    """Gear for compressive forces."""

    def elements(self, gap: Gap) -> Iterator[Element]:
        free = 0.5 * self.slack_mm / 1e3
        yield self.draw.element(f"{gap.name} draw gear", DRAW, gap, self._hinges(gap), free)
        yield self.buff.element(f"{gap.name} buff gear", BUFF, gap, self._hinges(gap), free)


AnyCouplingTable = Annotated[ScrewCouplingTable | CentreCouplerTable, Field(discriminator="kind")]
