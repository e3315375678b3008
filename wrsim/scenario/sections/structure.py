"""[track.structure]: what the rails rest on."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from wrsim.inputs.section import Choice, Section, given
from wrsim.inputs.values import List, number, positive, text
from wrsim.track.bridge import Bridge, read_bridge
from wrsim.track.sleepers import Layer, RailBeam, RailJoint, SleeperTrack, SupportRow
from wrsim.track.track import RailElasticity

Stiffness = Annotated[float, number(0.1, 1e5)]
Damping = Annotated[float, number(0, 1e5)]
Place = Annotated[float, number(-1e3, 1e6, "m along the track")]
Which = Literal["left", "right", "both"]


class StructureTable(Choice, header="[track.structure]"):
    """What the rails rest on. Without this table a run in time has the moving mass with its defaults under each wheel,
    and all other analyses have rigid rails."""

    kind: str
    """Kind of structure."""


class RigidStructure(StructureTable, kind="rigid"):
    """Rails that do not move."""

    also_called = "none stiff fixed"

    def to_geometry(self, find: Callable[[str], Path]) -> None:
        return None


class MovingMassStructure(StructureTable, kind="moving mass"):
    """A mass on spring and damper under each wheel, moving along with it; laterally and vertically.

    Defaults: the track of GM/TT0088 (British Railways Board, Permissible track forces for railway vehicles, 1993), per
    wheel, recalled; its lateral damping is the same part of critical as the vertical one, 22 %.
    """

    source: ClassVar[str] = "GM/TT0088"

    lateral_stiffness_MN_per_m: Annotated[float, number(0.1, 1e5, "20 to 50 for one rail under one wheel")] = 25.0
    """Stiffness that holds the rail sideways under one wheel."""
    vertical_stiffness_MN_per_m: Annotated[float, number(0.1, 1e5, "30 to 100")] = 62.0
    """Stiffness that carries the rail under one wheel."""
    lateral_damping_kNs_per_m: Damping = 29.3
    """Damping of the rail sideways under one wheel."""
    vertical_damping_kNs_per_m: Damping = 55.4
    """Damping of the rail up and down under one wheel."""
    lateral_mass_kg: Annotated[float, number(1, 1e5, "of the rail and what moves with it")] = 170.0
    """Mass of rail that moves sideways with one wheel."""
    vertical_mass_kg: Annotated[float, number(1, 1e5, "of the rail and what moves with it")] = 245.0
    """Mass of rail that moves up and down with one wheel."""

    def to_geometry(self, find: Callable[[str], Path]) -> RailElasticity:
        return RailElasticity(
            stiffness=(1e6 * self.lateral_stiffness_MN_per_m, 1e6 * self.vertical_stiffness_MN_per_m),
            damping=(1e3 * self.lateral_damping_kNs_per_m, 1e3 * self.vertical_damping_kNs_per_m),
            mass=(self.lateral_mass_kg, self.vertical_mass_kg),
        )


class RailBeamSection(Section, header="[track.structure.rail]"):
    """The rail as a beam with bending, shear and torsion; 60E1 unless given."""

    young_GPa: Annotated[float, number(10, 1000)] = 210.0
    """Young's modulus."""
    shear_modulus_GPa: Annotated[float, number(1, 500)] = 80.769
    """Shear modulus."""
    mass_kg_per_m: Annotated[float, number(1, 500)] = 60.2
    """Mass of one rail per metre."""
    area_cm2: Annotated[float, number(1, 1000)] = 76.7
    """Area of the section."""
    vertical_bending_cm4: Annotated[float, number(1, 1e5)] = 3037.0
    """Second moment of area for bending up and down."""
    lateral_bending_cm4: Annotated[float, number(1, 1e5)] = 512.0
    """Second moment of area for bending sideways."""
    torsion_cm4: Annotated[float, number(1, 1e5)] = 220.0
    """Torsion constant of the section."""
    vertical_shear_coefficient: Annotated[float, positive(1.0)] = 0.393
    """Part of the area that counts as shear area up and down."""
    lateral_shear_coefficient: Annotated[float, positive(1.0)] = 0.54
    """Part of the area that counts as shear area sideways."""
    height_mm: Annotated[float, number(50, 300)] = 172.0
    """Height of the rail's head above its foot, where wheels push."""
    shear_centre_mm: Annotated[float, number(0, 200)] = 40.0
    """Height of the shear centre above the foot."""

    def to_geometry(self) -> RailBeam:
        return self.to_si(
            RailBeam, mass=self.mass_kg_per_m, area=1e-4 * self.area_cm2, vertical=1e-8 * self.vertical_bending_cm4,
            lateral=1e-8 * self.lateral_bending_cm4, torsion=1e-8 * self.torsion_cm4,
            shear_vertical=self.vertical_shear_coefficient, shear_lateral=self.lateral_shear_coefficient,
        )  # fmt: skip


class LayerSection(Section, header="[track.structure.pad] or [track.structure.ballast]"):
    """Springs and dampers of a pad under one rail, or of the ballast under half a sleeper."""

    vertical_stiffness_MN_per_m: Annotated[float, number(0.1, 1e5, "50 to 1000 for pads, 20 to 100 for ballast")]
    """Stiffness up and down."""
    lateral_stiffness_MN_per_m: Annotated[float, number(0.1, 1e5, "20 to 100 for pads, 10 to 50 for ballast")]
    """Stiffness sideways."""
    vertical_damping_kNs_per_m: Damping
    """Damping up and down."""
    lateral_damping_kNs_per_m: Damping
    """Damping sideways."""

    def to_geometry(self) -> Layer:
        return Layer(
            (1e6 * self.lateral_stiffness_MN_per_m, 1e6 * self.vertical_stiffness_MN_per_m),
            (1e3 * self.lateral_damping_kNs_per_m, 1e3 * self.vertical_damping_kNs_per_m),
        )


class SupportSection(Section, header="[[track.structure.supports]]"):
    """Stiffness and damping of pads and ballast at a place; linear from one place to the next."""

    at_m: Place
    """Where on the track."""
    pad_percent: Annotated[float, number(0.1, 1e4)] = 100.0
    """Stiffness and damping of the pads in parts of what [track.structure.pad] gives."""
    ballast_percent: Annotated[float, number(0, 1e4)] = 100.0
    """Stiffness and damping of the ballast in parts of what [track.structure.ballast] gives."""
    side: Which = "both"
    """Under which rail."""

    def to_geometry(self) -> SupportRow:
        return SupportRow(self.at_m, 0.01 * self.pad_percent, 0.01 * self.ballast_percent, self.side)


class UnsupportedSection(Section, header="[[track.structure.unsupported]]"):
    """Sleepers without ballast beneath."""

    at_m: Place
    """The nearest sleeper to this place is the first one."""
    sleepers: Annotated[int, number(1, 20)] = 1
    """How many in a row."""
    side: Which = "both"
    """Under which rail."""


class JointSection(Section, header="[[track.structure.joints]]"):
    """A joint of a rail: a stretch with less stiffness in bending."""

    at_m: Place
    """Where its middle lies."""
    bending_percent: Annotated[float, positive(100.0)] = 5.0
    """Bending stiffness there in parts of the rail's."""
    length_mm: Annotated[float, number(1, 2000)] = 50.0
    """Length with this stiffness."""
    side: Which = "both"
    """Which rail has it."""

    def to_geometry(self) -> RailJoint:
        return RailJoint(self.at_m, 0.01 * self.bending_percent, 1e-3 * self.length_mm, self.side)


class BridgeSection(Section, header="[track.structure.bridge]"):
    """A bridge: a continuous beam over its spans, or modes from a file; it moves up and down."""

    one_of = ("spans_m modes",)
    together = ("spans_m bending_GNm2 mass_t_per_m",)
    goes_with = {"damping_percent": "spans_m", "count": "spans_m"}

    at_m: Place
    """Where it begins along the track."""
    spans_m: Annotated[List[Annotated[float, number(1, 500, "m")]], Field(min_length=1)] = ()
    """Lengths of its spans on stiff supports."""
    bending_GNm2: Annotated[float, positive(1e6, "GN m2, E I of the whole deck")] | None = None
    """Bending stiffness of the deck."""
    mass_t_per_m: Annotated[float, positive(1000, "t/m, with what lies on it")] | None = None
    """Mass of the deck; under stiff rails with the whole track."""
    damping_percent: Annotated[float, number(0, 100, "percent of critical")] = 1.0
    """Damping of every mode of the beam."""
    count: Annotated[int, number(1, 50)] = 10
    """Modes of the beam."""
    modes: Annotated[str, text('a CSV file such as "bridge_modes.csv"')] | None = None
    """File of the modes of any deck, in place of a beam."""

    def deck(self, find: Callable[[str], Path]) -> Bridge:
        if self.modes is not None:
            return read_bridge(find(self.modes), self.at_m)
        bending, mass = 1e9 * given(self.bending_GNm2), 1e3 * given(self.mass_t_per_m)
        return Bridge.of_spans(self.at_m, self.spans_m, bending, mass, 0.01 * self.damping_percent, self.count)


class SleepersStructure(StructureTable, kind="sleepers"):
    """Each rail a beam on pads, sleepers and ballast, in a window that travels with the vehicle."""

    spacing_mm: Annotated[float, number(100, 2000)] = 600.0
    """Distance between two sleepers."""
    first_sleeper_m: Annotated[float, number(-10, 10, "m along the track")] = 0.0
    """Where one of the sleepers lies."""
    scatter_mm: Annotated[float, number(0, 500)] = 0.0
    """Largest shift of a sleeper along the track, at random."""
    seed: Annotated[int, number(0, 2**31 - 1)] = 0
    """Number that decides how the sleepers are shifted."""
    sleeper_mass_kg: Annotated[float, number(10, 5000, "of a whole sleeper, 250 to 350 for concrete")]
    """Mass of a whole sleeper."""
    sleeper_width_mm: Annotated[float, number(50, 1000)] = 260.0
    """Width of a sleeper along the track; they must not overlap."""
    pad_width_mm: Annotated[float, number(10, 500)] = 150.0
    """Width of a pad across the rail, which holds the rail against roll."""
    rail: RailBeamSection = Field(default_factory=RailBeamSection)
    """The rail as a beam; 60E1 unless given."""
    pad: LayerSection
    """Springs and dampers between rail and sleeper."""
    ballast: LayerSection
    """Springs and dampers under half a sleeper."""
    supports: List[SupportSection] = ()
    """Stiffness of pads and ballast by place, such as a transition zone."""
    unsupported: List[UnsupportedSection] = ()
    """Sleepers without ballast beneath."""
    joints: List[JointSection] = ()
    """Joints of the rails."""
    bridge: BridgeSection | None = None
    """A bridge that the ballast lies on."""
    elements: Annotated[int, number(1, 50)] = 4
    """Finite elements of the rail from sleeper to sleeper."""
    margin_m: Annotated[float, number(1, 1000)] = 10.0
    """Length of the window beyond the first and the last wheel."""
    end_m: Annotated[float, number(0.1, 1000)] = 4.0
    """Length at either end of the window that is damped, so that no waves come back."""

    def to_geometry(self, find: Callable[[str], Path]) -> SleeperTrack:
        spacing = 1e-3 * self.spacing_mm
        unsupported = tuple((row.at_m + i * spacing, row.side) for row in self.unsupported for i in range(row.sleepers))
        return self.to_si(
            SleeperTrack, rail=self.rail.to_geometry(), pad=self.pad.to_geometry(), ballast=self.ballast.to_geometry(),
            sleeper_mass=self.sleeper_mass_kg, offset=self.first_sleeper_m, unsupported=unsupported,
            supports=tuple(row.to_geometry() for row in self.supports),
            joints=tuple(row.to_geometry() for row in self.joints),
            bridge=None if self.bridge is None else self.bridge.deck(find),
        )  # fmt: skip


class BridgeStructure(StructureTable, BridgeSection, kind="bridge"):
    """A bridge below stiff rails."""

    elastic_length_m: Annotated[float, number(0, 5, "m, (4 E I / k)^(1/4) of both rails on their supports")] = 0.8
    """Length with which rails, sleepers and ballast spread the load of a wheel over the deck; 0: not at all."""

    def to_geometry(self, find: Callable[[str], Path]) -> Bridge:
        return self.deck(find).beneath(self.elastic_length_m)


def _alone(table: Any) -> Any:
    """Rigid rails need no figures: those of a base do not count."""
    return {"kind": "rigid"} if isinstance(table, dict) and table.get("kind") == "rigid" else table


AnyStructure = Annotated[
    RigidStructure | MovingMassStructure | SleepersStructure | BridgeStructure,
    Field(discriminator="kind"),
    BeforeValidator(_alone),
]
