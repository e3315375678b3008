"""[contact]: models and numbers of the wheel-rail contact; friction by contact angle, slip speed and place."""

from collections.abc import Iterator
from itertools import pairwise
from math import radians
from typing import Annotated, Any, Literal

from wrsim.contact.creep.laws import CREEP_LAWS, Tangential
from wrsim.contact.settings import (
    DRY,
    RANGES,
    SOLVED_STRIPS,
    USUAL,
    Approach,
    ContactSettings,
    Flexibility,
    Friction,
    HalfSpaceSettings,
    Heating,
    Influence,
    Layer,
    Material,
    Normal,
    Pairing,
    TractionBound,
    unsuited,
)
from wrsim.inputs.section import SIDES, Fault, Section, both_or_sides, on_side
from wrsim.inputs.values import List, OrTable, number, plain_number, positive, text

CreepCoefficient = Annotated[float, positive(1e6, "kN per creepage of one wheel, such as 10000")]


class ConicalSection(Section, header="[contact.conical]"):
    """Conical wheels with a prescribed creep law; profiles and the other keys of [contact] then count for nothing."""

    together = ("flange_clearance_mm flange_stiffness_kN_per_m",)

    conicity: Annotated[float, number(0, 1, "such as 0.05")]
    """Slope of the tread."""
    half_spacing_mm: Annotated[float, number(200, 1500, "mm from the middle of the axle to the contact")]
    """Half the distance between the contacts of both wheels."""
    creep_longitudinal_kN: CreepCoefficient
    """Kalker's longitudinal coefficient: force of one wheel for a creepage of 1."""
    creep_lateral_kN: CreepCoefficient
    """Kalker's lateral coefficient: force of one wheel for a creepage of 1."""
    friction: Annotated[float, positive(2, "creep forces saturate; without it they do not")] | None = None
    """Coefficient at which creep forces saturate."""
    flange_clearance_mm: Annotated[float, number(0, 100, "mm of lateral shift")] | None = None
    """Lateral shift at which the flange touches."""
    flange_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """Lateral stiffness of the flange against the rail."""


Modulus = Annotated[float, number(1, 1000, "GPa, steel 210")]
Poisson = Annotated[float, number(0, 0.49, "steel 0.28")]

Element = Annotated[float, number(0.001, 5, "mm; 0.1 to 0.3 for patches of rails")]

STEEL = Material()
EXACT = HalfSpaceSettings()
DEFAULTS = ContactSettings()


class OneMaterial(Section, header="[contact.material.wheel] or [contact.material.rail]"):
    """The material of one side of the contact."""

    youngs_modulus_GPa: Modulus | None = None
    """Young's modulus of this side; that of [contact.material] unless given."""
    poisson: Poisson | None = None
    """Poisson ratio of this side; that of [contact.material] unless given."""


class MaterialSection(Section, header="[contact.material]"):
    """The material of wheel and rail; the tables ``wheel`` and ``rail`` override it for one of them."""

    youngs_modulus_GPa: Modulus = STEEL.youngs_modulus / 1e9
    """Young's modulus of wheel and rail."""
    poisson: Poisson = STEEL.poisson_ratio
    """Poisson ratio of wheel and rail."""
    wheel: OneMaterial = OneMaterial()
    """Numbers of the wheel, where they differ."""
    rail: OneMaterial = OneMaterial()
    """Numbers of the rail, where they differ."""

    def of(self, part: OneMaterial) -> Material:
        """Return the material of the wheel or the rail in SI units."""
        modulus = self.youngs_modulus_GPa if part.youngs_modulus_GPa is None else part.youngs_modulus_GPa
        return Material(modulus * 1e9, self.poisson if part.poisson is None else part.poisson)


class HalfSpaceSection(Section, header="[contact.half_space]"):
    """Elements and kernel of the exact solver, wherever it is used."""

    together = ("element_x_mm element_s_mm",)
    at_most_one = ("element_x_mm resolution",)

    element_x_mm: Element | None = None
    """Length of an element along the track; chosen by resolution unless given."""
    element_s_mm: Element | None = None
    """Width of an element along the curved axis; chosen by resolution unless given."""
    resolution: Annotated[int, number(8, 400)] = EXACT.resolution
    """Number of elements over length and width of the smallest patch that matters."""
    influence: Influence = EXACT.influence
    """Elasticity of a plane half-space, or one turned by the angle between the normals; of strips, too."""
    pairing: Pairing = EXACT.pairing
    """Which points of the profiles lie opposite each other; "level" is how CONTACT pairs them."""

    def settings(self) -> HalfSpaceSettings:
        sized = self.element_x_mm is not None and self.element_s_mm is not None
        element = (self.element_x_mm / 1e3, self.element_s_mm / 1e3) if sized else None  # type: ignore[operator]
        return self.to_si(HalfSpaceSettings, element=element)


class ThirdBodySection(Section, header="[contact.layer]"):
    """A thin third body between wheel and rail: elastic shear, and shear that stays from a yield stress on."""

    together = ("thickness_mm shear_modulus_GPa",)
    goes_with = {"hardening_MPa_per_mm": "yield_stress_MPa"}

    thickness_mm: Annotated[float, positive(1, "mm; 0.01 to 0.05 of oxides and sand")] | None = None
    """Thickness of what shears elastically."""
    shear_modulus_GPa: Annotated[float, positive(100, "GPa; steel 82")] | None = None
    """Shear modulus of the layer."""
    yield_stress_MPa: Annotated[float, positive(10000, "MPa of shear")] | None = None
    """Shear stress from which on the layer yields; it does not unless given."""
    hardening_MPa_per_mm: Annotated[float, number(-5000, 1e6, "MPa per mm of plastic slip; below 0 it softens")] = 0.0
    """How much the yield stress rises with the plastic slip since the leading edge."""

    def consistency(self) -> Iterator[Fault]:
        if self.thickness_mm is None and self.yield_stress_MPa is None:
            yield Fault("thickness_mm", "give thickness_mm with shear_modulus_GPa, yield_stress_MPa, or both")


HEAT = Heating()
Celsius = Annotated[float, number(-60, 1500, "degrees Celsius")]


class TemperatureSection(Section, header="[contact.temperature]"):
    """Temperature of the surfaces by the heat of friction, and friction that changes with it."""

    together = ("friction_change friction_over_K",)
    goes_with = {"friction_from_C": "friction_change"}

    friction_change: Annotated[float, number(-2, 2, "below 0 friction falls")] = HEAT.friction_change
    """What the temperature adds to the coefficient of friction in the end."""
    friction_over_K: Annotated[float, positive(5000, "K")] = HEAT.friction_over
    """Degrees over which it adds that, in proportion."""
    friction_from_C: Celsius = HEAT.friction_from
    """Temperature from which on it does."""
    bulk_C: Celsius = HEAT.bulk
    """Temperature of wheel and rail before the contact."""
    conductivity_W_per_mK: Annotated[float, positive(1000, "W/(m K); steel 50")] = HEAT.conductivity
    """Thermal conductivity of wheel and rail."""
    heat_capacity_J_per_kgK: Annotated[float, positive(10000, "J/(kg K); steel 450")] = HEAT.heat_capacity
    """Specific heat of wheel and rail."""
    density_kg_per_m3: Annotated[float, positive(30000, "kg/m3; steel 7850")] = HEAT.density
    """Density of wheel and rail."""


Coefficient = Annotated[float, number(0, 2, "dry steel 0.3 to 0.5")]
Angle = Annotated[float, number(-30, 80, "contact angle in degrees, flange side positive")]

PLAIN = Friction(0.0)
FROM_DEG, FULL_DEG = 15.0, 35.0


class FrictionSection(Section, header="[contact.friction]"):
    """Friction of both rails or of one, that depends on the place on the rail and on the slip speed."""

    goes_with = {
        "gauge_corner_from_deg": "gauge_corner", "gauge_corner_full_deg": "gauge_corner",
        "falling_decay_s_per_m": "falling_ratio",
    }  # fmt: skip
    above = {"gauge_corner_full_deg": "gauge_corner_from_deg"}
    elsewhere = {
        "left": "[contact] as friction_left", "right": "[contact] as friction_right", "friction_left": "[contact]",
        "friction_right": "[contact]",
    }  # fmt: skip

    static: Coefficient
    """Coefficient of friction on the top of the rail, at no slip."""
    gauge_corner: Coefficient | None = None
    """The same on the gauge corner; as on the top unless given."""
    gauge_corner_from_deg: Angle = FROM_DEG
    """Contact angle up to which the rail counts as top."""
    gauge_corner_full_deg: Angle = FULL_DEG
    """Contact angle from which on the rail counts as gauge corner."""
    falling_ratio: Annotated[float, number(0, 1, "limit at fast slip over static, 1 does not fall")] = 1.0
    """Friction at fast slip over that at no slip: A of static ((1 - A) exp(-B w) + A)."""
    falling_decay_s_per_m: Annotated[float, number(0, 100, "dry 0.6, wet 0.2")] = PLAIN.falling_decay
    """How soon friction falls with the slip speed w: B of the same law."""

    def law(self) -> Friction:
        return self.to_si(Friction, ramp=(radians(self.gauge_corner_from_deg), radians(self.gauge_corner_full_deg)))


FrictionValue = OrTable[Coefficient, FrictionSection]


def law_of(value: float | FrictionSection) -> Friction:
    """The law of a plain coefficient or of a table."""
    return value.law() if isinstance(value, FrictionSection) else Friction(value)


class FrictionPlaceSection(Section, header="[[contact.friction_sections]]"):
    """From a place on another friction holds, which is reached smoothly over transition_m behind that place."""

    from_m: Annotated[float, number(0, 1e6, "m along the track")]
    """Where it begins; it holds up to the next section of the same rail."""
    friction: FrictionValue
    """Coefficient of friction, or a table of how it depends on place on the rail and slip."""
    side: Literal["left", "right", "both"] = "both"
    """Which rail has it."""
    transition_m: Annotated[float, number(0.01, 1000, "m; 0.01, the length of a patch, is a step")] = 1.0
    """Length behind from_m over which the friction changes from that before."""


class ContactSection(Section, header="[contact]"):
    """Contact model, friction and material; everything has a default."""

    at_most_one = ("friction_sections friction_table",)
    goes_with = {"friction_at_m": "friction_sections friction_table"}
    not_above = {"polach_kS": "polach_kA"}

    normal: Normal = DEFAULTS.normal
    """Model of the normal pressure: strips, the paper's, or the exact half-space solver."""
    approach: Approach = DEFAULTS.approach
    """How an approach closes the gap: by its share along each normal, or everywhere alike, as in the paper."""
    tangential: Tangential | None = None
    """Model of the creep forces; the usual one of the normal model unless given."""
    traction_bound: TractionBound = DEFAULTS.traction_bound
    """Shape of the bound on tractions along a strip, for FASTSIM."""
    flexibility: Flexibility = DEFAULTS.flexibility
    """Flexibility in FASTSIM: one number a creepage everywhere, or a single one where surfaces slide."""
    polach_kA: Annotated[float, positive(1)] = DEFAULTS.polach_adhesion
    """Polach's reduction of the adhesion area's stiffness."""
    polach_kS: Annotated[float, positive(1)] = DEFAULTS.polach_slip
    """Polach's reduction of the slip area's stiffness."""
    slope_k0: Annotated[float, positive(1)] = DEFAULTS.slope_k0
    """Slope reduction of FASTSIM and FaStrip: part of Kalker's stiffness at no creepage."""
    slope_alpha_inf: Annotated[float, number(*RANGES["slope_alpha_inf"])] = DEFAULTS.slope_alpha_inf
    """Slope reduction: part of that stiffness at infinite creepage."""
    slope_beta: Annotated[float, number(*RANGES["slope_beta"])] = DEFAULTS.slope_beta
    """Slope reduction: how fast the stiffness falls with the creepage."""
    friction: FrictionValue = DRY
    """Coefficient of friction, or a table of how it depends on place and slip."""
    friction_left: FrictionValue | None = None
    """Friction on the left rail, where the rails differ."""
    friction_right: FrictionValue | None = None
    """Friction on the right rail, where the rails differ."""
    friction_sections: List[FrictionPlaceSection] = ()
    """Friction that changes along the track, section by section."""
    friction_table: Annotated[str, text('a CSV file of friction along the track such as "friction.csv"')] | None = None
    """Friction along the track from a table, in place of sections."""
    friction_at_m: Annotated[float, number(0, 1e6, "m; whose friction holds where nothing runs along the track")] = 0.0
    """Place on the track whose friction holds in analyses that do not run along it."""
    strips: Annotated[int, number(5, 1000)] | None = None
    """Number of strips over the width of a patch; the usual one of the normal model unless given."""
    strip_width_mm: Annotated[float, number(0.005, 2, "mm along the curved axis")] | None = None
    """Width of a strip, in place of their number; for Kik-Piotrowski."""
    cells: Annotated[int, number(*RANGES["cells"])] = DEFAULTS.cells
    """Number of cells of a strip along the rolling direction, for FASTSIM and FaStrip."""
    damping_s_per_m: Annotated[
        float, number(*RANGES["damping"], "normal force times this times the rate of approach")
    ] = DEFAULTS.damping
    """Normal damping: the force grows by this times the speed of approach, and never pulls."""
    max_patches: Annotated[int, number(*RANGES["max_patches"])] | None = None
    """Largest number of patches of one wheel, largest first; the usual number of the normal model unless given."""
    material: MaterialSection = MaterialSection.model_construct()
    """Elastic numbers of wheel and rail."""
    half_space: HalfSpaceSection = HalfSpaceSection.model_construct()
    """Elements of the exact solver."""
    layer: ThirdBodySection | None = None
    """A third body between wheel and rail; none unless given."""
    temperature: TemperatureSection | None = None
    """Temperature of the surface and friction by it; not computed unless given."""
    conical: ConicalSection | None = None
    """Conical wheels with a prescribed creep law in place of profiles; for stability only."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        if raw.get("tangential") == "half-space" and raw.get("normal", DEFAULTS.normal) != "half-space":
            message = '"half-space" solves for tractions on exact pressures: it needs normal = "half-space"'
            yield Fault("tangential", message)
        slope = [key for key in ("slope_k0", "slope_alpha_inf", "slope_beta") if key in raw]
        able = [name for name, law in CREEP_LAWS.items() if law.slope]
        if slope and raw.get("tangential", able[0]) not in able:
            yield Fault(slope[0], 'goes with tangential = "{}" only'.format('" or "'.join(able)))
        yield from both_or_sides(raw, "friction", complete=True)
        name = raw.get("normal", DEFAULTS.normal)
        bounds = SOLVED_STRIPS.get(name) if isinstance(name, str) else None
        if bounds is None:
            if "strips" in raw and "strip_width_mm" in raw:
                yield Fault("strip_width_mm", "cannot be given with strips: give one of them")
            return
        strips = raw.get("strips")
        fewest, most = bounds
        if isinstance(strips, int) and not fewest <= strips <= most:
            yield Fault("strips", f'must be {fewest} to {most} with normal = "{name}"')
        if raw.get("approach") == "constant":
            yield Fault("approach", f'"constant" is Kik-Piotrowski\'s: normal = "{name}" projects the approach')
        if "strip_width_mm" in raw:
            hint = f'normal = "{name}" takes a number of strips, strips = {fewest} to {most}'
            yield Fault("strip_width_mm", f'goes with normal = "kik-piotrowski" only: {hint}')

    def consistency(self) -> Iterator[Fault]:
        law = self.tangential or USUAL[self.normal].tangential
        layer = self.layer.to_si(Layer) if self.layer else None
        heating = self.temperature.to_si(Heating) if self.temperature else None
        if message := unsuited(law, self.flexibility, layer, heating):
            yield Fault("layer" if unsuited(law, self.flexibility, layer, None) else "temperature", message)
        for side in SIDES:
            for (_, before), (i, section) in pairwise(on_side(self.friction_sections, side)):
                end = before.from_m + before.transition_m
                if section.from_m < end * (1.0 - 1e-12):
                    message = f"must be {plain_number(end)} or more, where its rail has reached the section before"
                    yield Fault(("friction_sections", i, "from_m"), message)

    def settings(self) -> ContactSettings:
        """The same in SI units, without friction_sections and friction_table."""
        values = (self.of_side("friction", side)[1] for side in SIDES)
        left, right = (v.law() if isinstance(v, FrictionSection) else v for v in values)
        return self.to_si(
            ContactSettings,
            polach_adhesion=self.polach_kA,
            polach_slip=self.polach_kS,
            friction=(left, right),
            wheel=self.material.of(self.material.wheel),
            rail=self.material.of(self.material.rail),
            half_space=self.half_space.settings(),
            layer=self.layer and self.layer.to_si(Layer),
            temperature=self.temperature and self.temperature.to_si(Heating),
        )
