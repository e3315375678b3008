"""[contact]: models and numbers of the wheel-rail contact."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from wrsim.contact.settings import ContactSettings, Material
from wrsim.inputs.section import Fault, Section, both_or_sides
from wrsim.inputs.values import Choice, Quantity, Whole

Modulus = Quantity(1, 1000, example="GPa, steel 210")
Poisson = Quantity(0, 0.49, example="steel 0.28")
Friction = Quantity(0, 2, example="dry steel 0.3 to 0.5")

STEEL = Material()
DEFAULTS = ContactSettings()

MATERIAL_ALIASES = {
    "E": "youngs_modulus_GPa",
    "E_GPa": "youngs_modulus_GPa",
    "modulus_GPa": "youngs_modulus_GPa",
    "young_GPa": "youngs_modulus_GPa",
    "nu": "poisson",
    "poisson_ratio": "poisson",
    "poissons_ratio": "poisson",
    "sigma": "poisson",
}


class OneMaterial(Section):
    """The material of one side of the contact."""

    header: ClassVar[str] = "[contact.material.wheel] or [contact.material.rail]"
    aliases: ClassVar[dict[str, str]] = MATERIAL_ALIASES

    youngs_modulus_GPa: Annotated[float, Modulus] | None = None
    poisson: Annotated[float, Poisson] | None = None


class MaterialSection(Section):
    """The material of wheel and rail; the tables ``wheel`` and ``rail`` override it for one of them."""

    header: ClassVar[str] = "[contact.material]"
    aliases: ClassVar[dict[str, str]] = MATERIAL_ALIASES

    youngs_modulus_GPa: Annotated[float, Modulus] = STEEL.youngs_modulus / 1e9
    poisson: Annotated[float, Poisson] = STEEL.poisson_ratio
    wheel: OneMaterial = OneMaterial()
    rail: OneMaterial = OneMaterial()

    def of(self, part: OneMaterial) -> Material:
        """Return the material of the wheel or the rail in SI units."""
        modulus = self.youngs_modulus_GPa if part.youngs_modulus_GPa is None else part.youngs_modulus_GPa
        return Material(modulus * 1e9, self.poisson if part.poisson is None else part.poisson)


class ContactSection(Section):
    """Everything has a default; see ContactSettings for the meaning of each choice."""

    header: ClassVar[str] = "[contact]"
    aliases: ClassVar[dict[str, str]] = {
        "mu": "friction",
        "mu_left": "friction_left",
        "mu_right": "friction_right",
        "friction_coefficient": "friction",
        "normal_model": "normal",
        "tangential_model": "tangential",
        "creep": "tangential",
        "bound": "traction_bound",
        "n_strips": "strips",
        "n_cells": "cells",
        "patches": "max_patches",
    }

    normal: Annotated[Literal["kik-piotrowski"], Choice(("kik-piotrowski",))] = DEFAULTS.normal
    approach: Annotated[Literal["projected", "constant"], Choice(("projected", "constant"))] = DEFAULTS.approach
    tangential: Annotated[Literal["fastsim", "none"], Choice(("fastsim", "none"))] = DEFAULTS.tangential
    traction_bound: Annotated[Literal["elliptic", "parabolic"], Choice(("elliptic", "parabolic"))] = (
        DEFAULTS.traction_bound
    )
    friction: Annotated[float, Friction] = DEFAULTS.friction[0]
    friction_left: Annotated[float, Friction] | None = None
    friction_right: Annotated[float, Friction] | None = None
    strips: Annotated[int, Whole(5, 1000)] | None = None
    strip_width_mm: Annotated[float, Quantity(0.005, 2, example="mm along the curved axis")] | None = None
    cells: Annotated[int, Whole(2, 500)] = DEFAULTS.cells
    damping_s_per_m: Annotated[
        float, Quantity(0, 1000, example="normal force times this times the rate of approach")
    ] = DEFAULTS.damping
    max_patches: Annotated[int, Whole(1, 3)] = DEFAULTS.max_patches
    material: MaterialSection = MaterialSection()

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Friction for both sides or for each; a number of strips or their width."""
        yield from both_or_sides(raw, "friction", "friction_left", "friction_right", complete=True)
        if "strips" in raw and "strip_width_mm" in raw:
            yield Fault("strip_width_mm", "cannot stand next to strips: give one of them")

    def settings(self) -> ContactSettings:
        """Return the same in SI units."""
        left = self.friction if self.friction_left is None else self.friction_left
        right = self.friction if self.friction_right is None else self.friction_right
        by_width = self.strip_width_mm is not None
        return ContactSettings(
            normal=self.normal,
            approach=self.approach,
            tangential=self.tangential,
            traction_bound=self.traction_bound,
            friction=(left, right),
            strips=None if by_width else (self.strips or DEFAULTS.strips),
            strip_width=None if self.strip_width_mm is None else self.strip_width_mm / 1000.0,
            cells=self.cells,
            damping=self.damping_s_per_m,
            max_patches=self.max_patches,
            wheel=self.material.of(self.material.wheel),
            rail=self.material.of(self.material.rail),
        )
