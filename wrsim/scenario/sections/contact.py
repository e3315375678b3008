"""[contact]: models and numbers of the wheel-rail contact."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, get_args

from wrsim.contact.models import NORMAL_MODELS
from wrsim.contact.settings import (
    DRY,
    Approach,
    ContactSettings,
    Flexibility,
    HalfSpaceSettings,
    Influence,
    Material,
    Normal,
    Pairing,
    Tangential,
    TractionBound,
)
from wrsim.inputs.section import Fault, Section, both_or_sides
from wrsim.inputs.values import List, number, plain, positive, text, words
from wrsim.scenario.sections.conical import ConicalSection
from wrsim.scenario.sections.friction import FrictionPlaceSection, FrictionSection, FrictionValue

Modulus = Annotated[float, number(1, 1000, "GPa, steel 210")]
Poisson = Annotated[float, number(0, 0.49, "steel 0.28")]

Element = Annotated[float, number(0.001, 5, "mm; 0.1 to 0.3 for patches of rails")]

STEEL = Material()
EXACT = HalfSpaceSettings()
DEFAULTS = ContactSettings()

MATERIAL_ALIASES = {
    "youngs_modulus_GPa": "E E_GPa modulus_GPa young_GPa",
    "poisson": "nu poisson_ratio poissons_ratio sigma",
}


class OneMaterial(Section):
    """The material of one side of the contact."""

    header: ClassVar[str] = "[contact.material.wheel] or [contact.material.rail]"
    aliases: ClassVar[dict[str, str]] = MATERIAL_ALIASES

    youngs_modulus_GPa: Modulus | None = None
    poisson: Poisson | None = None


class MaterialSection(Section):
    """The material of wheel and rail; the tables ``wheel`` and ``rail`` override it for one of them."""

    header: ClassVar[str] = "[contact.material]"
    aliases: ClassVar[dict[str, str]] = MATERIAL_ALIASES

    youngs_modulus_GPa: Modulus = STEEL.youngs_modulus / 1e9
    poisson: Poisson = STEEL.poisson_ratio
    wheel: OneMaterial = OneMaterial()
    rail: OneMaterial = OneMaterial()

    def of(self, part: OneMaterial) -> Material:
        """Return the material of the wheel or the rail in SI units."""
        modulus = self.youngs_modulus_GPa if part.youngs_modulus_GPa is None else part.youngs_modulus_GPa
        return Material(modulus * 1e9, self.poisson if part.poisson is None else part.poisson)


class HalfSpaceSection(Section):
    """Elements and kernel of the exact solver, wherever it is used; see HalfSpaceSettings."""

    header: ClassVar[str] = "[contact.half_space]"
    aliases: ClassVar[dict[str, str]] = {
        "element_x_mm": "dx_mm",
        "element_s_mm": "ds_mm",
        "resolution": "elements",
        "influence": "kernel",
    }

    element_x_mm: Element | None = None
    element_s_mm: Element | None = None
    resolution: Annotated[int, number(8, 400)] = EXACT.resolution
    influence: Influence = EXACT.influence
    pairing: Pairing = EXACT.pairing

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Elements by their size or by their number."""
        sizes = [key for key in ("element_x_mm", "element_s_mm") if key in raw]
        if len(sizes) == 1:
            other = "element_s_mm" if "element_x_mm" in raw else "element_x_mm"
            yield Fault(other, f"goes with {sizes[0]}: must be {words(Element)}", missing=True)
        if sizes and "resolution" in raw:
            yield Fault("resolution", f"cannot stand next to {' and '.join(sizes)}: give sizes or a number")

    def settings(self) -> HalfSpaceSettings:
        """Return the same in SI units."""
        sized = self.element_x_mm is not None and self.element_s_mm is not None
        return HalfSpaceSettings(
            element=(self.element_x_mm / 1e3, self.element_s_mm / 1e3) if sized else None,  # type: ignore[operator]
            resolution=self.resolution,
            influence=self.influence,
            pairing=self.pairing,
        )


class ContactSection(Section):
    """Everything has a default; see ContactSettings for the meaning of each choice."""

    header: ClassVar[str] = "[contact]"
    aliases: ClassVar[dict[str, str]] = {
        "friction": "mu friction_coefficient",
        "friction_left": "mu_left",
        "friction_right": "mu_right",
        "friction_sections": "friction_along friction_section",
        "friction_table": "friction_file friction_csv",
        "normal": "normal_model",
        "tangential": "tangential_model creep",
        "traction_bound": "bound",
        "strips": "n_strips",
        "cells": "n_cells",
        "max_patches": "patches",
        "polach_kA": "kA k_A",
        "polach_kS": "kS k_S",
    }

    normal: Normal = DEFAULTS.normal
    approach: Approach = DEFAULTS.approach
    tangential: Tangential | None = None
    traction_bound: TractionBound = DEFAULTS.traction_bound
    flexibility: Flexibility = DEFAULTS.flexibility
    polach_kA: Annotated[float, positive(1)] = DEFAULTS.polach_adhesion
    polach_kS: Annotated[float, positive(1)] = DEFAULTS.polach_slip
    friction: FrictionValue = DRY
    friction_left: FrictionValue | None = None
    friction_right: FrictionValue | None = None
    friction_sections: List[FrictionPlaceSection] = ()
    friction_table: Annotated[str, text('a CSV file of friction along the track such as "friction.csv"')] | None = None
    friction_at_m: Annotated[float, number(0, 1e6, "m; whose friction holds where nothing runs along the track")] = 0.0
    strips: Annotated[int, number(5, 1000)] | None = None
    strip_width_mm: Annotated[float, number(0.005, 2, "mm along the curved axis")] | None = None
    cells: Annotated[int, number(2, 500)] = DEFAULTS.cells
    damping_s_per_m: Annotated[float, number(0, 1000, "normal force times this times the rate of approach")] = (
        DEFAULTS.damping
    )
    max_patches: Annotated[int, number(1, 6)] | None = None
    material: MaterialSection = MaterialSection()
    half_space: HalfSpaceSection = HalfSpaceSection()
    conical: ConicalSection | None = None

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Friction for both sides or for each; a number of strips or their width; exact creep on exact pressure."""
        if raw.get("tangential") == "half-space" and raw.get("normal", DEFAULTS.normal) != "half-space":
            yield Fault(
                "tangential", '"half-space" solves for tractions on exact pressures: it needs normal = "half-space"'
            )
        yield from both_or_sides(raw, "friction", complete=True)
        if "friction_table" in raw and "friction_sections" in raw:
            yield Fault("friction_table", "cannot stand next to friction_sections: places come from one of them")
        if "friction_at_m" in raw and "friction_table" not in raw and "friction_sections" not in raw:
            yield Fault("friction_at_m", "goes with friction_sections or friction_table: without, friction is the same")
        name = raw.get("normal", DEFAULTS.normal)
        model = NORMAL_MODELS[name] if name in get_args(Normal) else None
        if model is None or not model.solves_for_strips:
            if "strips" in raw and "strip_width_mm" in raw:
                yield Fault("strip_width_mm", "cannot stand next to strips: give one of them")
            return
        strips = raw.get("strips")
        if isinstance(strips, int) and not model.fewest <= strips <= model.most:
            yield Fault("strips", f'must be {model.fewest} to {model.most} with normal = "{name}"')
        if raw.get("approach") == "constant":
            yield Fault("approach", f'"constant" is Kik-Piotrowski\'s: normal = "{name}" projects the approach')
        if "strip_width_mm" in raw:
            yield Fault(
                "strip_width_mm",
                f'goes with normal = "kik-piotrowski" only: normal = "{name}" takes a number of strips, '
                f"strips = {model.fewest} to {model.most}",
            )

    def consistency(self) -> Iterator[Fault]:
        """Polach's factors in order: with kS above kA his law would pull more than mu N."""
        if self.polach_kS > self.polach_kA:
            yield Fault("polach_kS", f"must not be above polach_kA ({self.polach_kA:g})")
        said: set[int] = set()
        for side in ("left", "right"):
            own = [(i, s) for i, s in enumerate(self.friction_sections) if s.side in (side, "both")]
            for (_, before), (i, now) in pairwise(own):
                end = before.from_m + before.transition_m
                if now.from_m < end * (1.0 - 1e-12) and i not in said:
                    said.add(i)
                    message = f"must be {plain(end)} or more, where its rail has reached the section before"
                    yield Fault(("friction_sections", i, "from_m"), message)

    def settings(self) -> ContactSettings:
        """Return the same in SI units; friction_sections and friction_table not counted."""
        left, right = (
            value.law() if isinstance(value, FrictionSection) else value
            for _, value in (self.of_side("friction", side) for side in ("left", "right"))
        )
        return ContactSettings(
            normal=self.normal,
            approach=self.approach,
            tangential=self.tangential,
            traction_bound=self.traction_bound,
            flexibility=self.flexibility,
            polach_adhesion=self.polach_kA,
            polach_slip=self.polach_kS,
            friction=(left, right),
            strips=self.strips,
            strip_width=None if self.strip_width_mm is None else self.strip_width_mm / 1000.0,
            cells=self.cells,
            damping=self.damping_s_per_m,
            max_patches=self.max_patches,
            wheel=self.material.of(self.material.wheel),
            rail=self.material.of(self.material.rail),
            half_space=self.half_space.settings(),
        )
