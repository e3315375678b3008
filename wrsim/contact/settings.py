"""Choices and numbers of the contact model: plain data, SI units."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import atan, inf, pi, radians, sqrt, tan
from numbers import Real
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.contact.creep.laws import CREEP_LAWS, Tangential
from wrsim.errors import InputError, suggest

Array = NDArray[np.float64]

Normal = Literal["kik-piotrowski", "strips", "half-space"]
Approach = Literal["projected", "constant"]
Influence = Literal["half-space", "angle-corrected"]
Pairing = Literal["opposite", "level"]
Flexibility = Literal["three", "blended"]
TractionBound = Literal["elliptic", "parabolic"]


@dataclass(frozen=True)
class Defaults:
    """What goes with a normal model where the user chose nothing else: model of the creep forces, numbers of strips
    and of patches; text: its name in documents."""

    tangential: Tangential
    strips: int
    patches: int
    text: str


USUAL: dict[Normal, Defaults] = {
    "kik-piotrowski": Defaults("fastsim", 40, 3, "model of Kik and Piotrowski"),
    "strips": Defaults("fastrip", 16, 4, "strip model"),
    "half-space": Defaults("half-space", 40, 4, "exact solver"),
}
"""Defaults that depend on another choice. Such a key is None in ContactSettings unless given."""

SOLVED_STRIPS: dict[str, tuple[int, int]] = {"strips": (12, 200)}
"""Models that solve for every strip, and how many strips a patch may have then."""

CHOICES: dict[str, tuple[str | None, ...]] = {
    "normal": get_args(Normal), "approach": get_args(Approach), "tangential": (None, *CREEP_LAWS),
    "traction_bound": get_args(TractionBound), "flexibility": get_args(Flexibility),
}  # fmt: skip
"""What the settings of these names may be."""
RANGES = {
    "polach_adhesion": (1e-6, 1.0), "polach_slip": (1e-6, 1.0), "slope_k0": (1e-6, 1.0), "slope_alpha_inf": (0.0, 1.0),
    "slope_beta": (0.0, 100.0), "strips": (5, 10000), "strip_width": (5e-6, 2e-3), "cells": (2, 500),
    "damping": (0.0, 1000.0), "max_patches": (1, 6),
}  # fmt: skip
"""Smallest and largest numbers of these names, those of the keys of a scenario, in SI units."""
MOST_FRICTION = 2.0  # largest coefficient

TURNED = radians(10.0)
"""Turn of the normals over a patch up to which turned influence changes p0 at a load by 0.01 at most: beyond it is told
that it is left out."""
DRY = 0.35  # coefficient of friction unless given


@dataclass(frozen=True)
class Material:
    """Linear elastic, isotropic material: Young's modulus [Pa] and Poisson ratio [1]. Default: rail steel."""

    youngs_modulus: float = 210e9
    poisson_ratio: float = 0.28

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))


@dataclass(frozen=True)
class HalfSpaceSettings:
    """Numbers of the exact half-space solver (`wrsim.contact.half_space`).

    element: size of the elements (along x, along s) [m]; None: so that the smallest patch that matters gets about
    ``resolution`` elements over its length and its width, across not larger than about 0.2 mm, and halved across until
    no peak of pressure is sharper than the rows can resolve. influence: of a plane half-space, or turned by the angle
    between the normals (the strip model takes it too).
    tolerance: of the gap over the approach; tractions are solved to ten times that over the largest bound.
    together, apart: distances of two zones of overlap up to which they press each other down fully, and from which on
    not at all [m] (see contact.half_space.zones; the strip model takes them too). pairing: which points of the
    profiles belong together, ``"opposite"`` ones or, as in CONTACT, those of equal arclength from two points of the
    same lateral place (``"level"``; see contact.half_space.surface_kernel).
    """

    element: tuple[float, float] | None = None
    resolution: int = 36
    influence: Influence = "half-space"
    tolerance: float = 1e-5
    together: float = 4e-3
    apart: float = 8e-3
    pairing: Pairing = "opposite"


@dataclass(frozen=True)
class Layer:
    """A thin third body between wheel and rail, which shears under tractions and does not act on pressures.

    Parameters
    ----------
    thickness, shear_modulus : float
        Of its elastic shear, ``thickness / shear_modulus`` times the traction [m, Pa].
    yield_stress, hardening : float
        Shear stress from which on it yields [Pa], and how much that rises with the plastic slip since the leading edge
        [Pa/m].
    """

    thickness: float = 0.0
    shear_modulus: float = 1e9
    yield_stress: float = inf
    hardening: float = 0.0

    @property
    def flexibility(self) -> float:
        """Elastic shear over the traction [m/Pa]."""
        return self.thickness / self.shear_modulus


@dataclass(frozen=True)
class Heating:
    """Friction by the temperature of the surface, which creep heats: both bodies are half-spaces of one material under
    a heat source that moves fast (docs/theory/friction.md).

    Parameters
    ----------
    friction_change, friction_over, friction_from : float
        What is added to the coefficient of friction in the end [1], over how many degrees above which temperature
        [K, degC]; in proportion in between.
    bulk : float
        Temperature of both bodies before the contact [degC].
    conductivity, heat_capacity, density : float
        Of both bodies [W/(m K), J/(kg K), kg/m3].
    """

    friction_change: float = 0.0
    friction_over: float = 100.0
    friction_from: float = 20.0
    bulk: float = 20.0
    conductivity: float = 50.0
    heat_capacity: float = 450.0
    density: float = 7850.0

    def change(self, temperature: Array) -> Array:
        """What temperatures [degC] add to the coefficient of friction."""
        part = np.clip((temperature - self.friction_from) / self.friction_over, 0.0, 1.0)
        return np.asarray(self.friction_change * part)

    @property
    def warming(self) -> float:
        """Rise of both surfaces by heat per area over the root of its duration [K m2 s^0.5/J]."""
        return 0.5 / sqrt(pi * self.conductivity * self.heat_capacity * self.density)


def unsuited(tangential: Tangential, flexibility: Flexibility, layer: Layer | None, heating: Heating | None) -> str:
    """Why a law of creep forces cannot take a layer or friction by temperature; "" where it can."""
    needs = {
        "layer": layer is not None, "yields": layer is not None and layer.yield_stress < inf,
        "heats": heating is not None,
    }  # fmt: skip
    texts = {
        "layer": "no layer between the bodies", "yields": "no layer that yields", "heats": "no friction by temperature",
    }  # fmt: skip
    for need in (name for name, is_needed in needs.items() if is_needed):
        if not getattr(CREEP_LAWS[tangential], need):
            able = [f'"{name}"' for name, law in CREEP_LAWS.items() if getattr(law, need)]
            return f'tangential = "{tangential}" takes {texts[need]}: take {" or ".join(able)}'
        if need != "layer" and tangential == "fastsim" and flexibility == "three":
            return f'flexibility = "three" takes {texts[need]}: take "blended"'
    return ""


@dataclass(frozen=True)
class Friction:
    """Coefficient of friction of one rail that depends on the place and the slip.

    Parameters
    ----------
    static : float
        At no slip, on the top of the rail [1].
    gauge_corner : float, optional
        The same at contact angles from ``ramp[1]`` on, or None where it is as on the top; between ``ramp[0]`` and
        ``ramp[1]`` it changes smoothly.
    ramp : tuple of float
        The two contact angles [rad].
    falling_ratio, falling_decay : float
        A [1] and B [s/m] of ``mu = static ((1 - A) exp(-B w) + A)``, w the slip speed; A = 1 is friction that does not
        fall.
    """

    static: float
    gauge_corner: float | None = None
    ramp: tuple[float, float] = (radians(15.0), radians(35.0))
    falling_ratio: float = 1.0
    falling_decay: float = 0.6

    @classmethod
    def of(cls, friction: "float | Friction") -> "Friction":
        """The law itself, or that of a mere coefficient. Raises InputError for what is neither."""
        law = friction if isinstance(friction, Friction) else cls(friction)
        for coefficient in (law.static, law.at_corner):
            if not (isinstance(coefficient, Real) and 0.0 <= float(coefficient) <= MOST_FRICTION):
                raise InputError(
                    f"friction = {coefficient!r:.40}: must be a number from 0 to {MOST_FRICTION:g}, or a law"
                )
        return law

    @property
    def at_corner(self) -> float:
        """Coefficient on the gauge corner at no slip [1]."""
        return self.static if self.gauge_corner is None else self.gauge_corner

    @property
    def numbers(self) -> tuple[float, float, float, float, float, float]:
        """As the kernels take them: coefficients on the top and on the corner, the tangents of half the angles of the
        ramp, what is left of friction at fast slip and its decay [s/m]."""
        start, end = (tan(0.5 * angle) for angle in self.ramp)
        return self.static, self.at_corner, start, end, self.falling_ratio, self.falling_decay

    def coefficient(self, normal: Array, slip: Array) -> Array:
        """Coefficients at places with these unit normals (..., 2), outward and up, at these slip speeds [m/s].

        The same as `contact.creep.friction` gives the strips.
        """
        start, end = (tan(0.5 * angle) for angle in self.ramp)
        part = np.clip((-normal[..., 0] / (1.0 + normal[..., 1]) - start) / max(end - start, 1e-9), 0.0, 1.0)
        mu = self.static + (self.at_corner - self.static) * part * part * (3.0 - 2.0 * part)
        return mu * (self.falling_ratio + (1.0 - self.falling_ratio) * np.exp(-self.falling_decay * slip))


@dataclass(frozen=True)
class FrictionAlong:
    """Friction of one rail that changes along the track.

    places: rising distances [m], along the rail where a wheel runs on it; laws: what holds there. Between two places
    every number of the law changes by 3 x^2 - 2 x^3; before the first and behind the last one it stays.
    """

    places: tuple[float, ...]
    laws: tuple[Friction, ...]

    @cached_property
    def table(self) -> Array:
        """Rows (n, 7) as `contact.creep.friction` reads them."""
        return np.array([(place, *law.numbers) for place, law in zip(self.places, self.laws, strict=True)])

    def numbers(self, place: ArrayLike) -> Array:
        """`Friction.numbers` at places (...), (..., 6)."""
        places, rows = self.table[:, 0], self.table[:, 1:]
        s = np.clip(np.asarray(place, dtype=float), places[0], places[-1])
        high = np.clip(np.searchsorted(places, s, side="right"), 1, max(len(places) - 1, 1))
        low, high = high - 1, np.minimum(high, len(places) - 1)
        x = (s - places[low]) / np.where(high > low, places[high] - places[low], 1.0)
        part = (x * x * (3.0 - 2.0 * x))[..., None]
        return np.asarray(rows[low] + part * (rows[high] - rows[low]))

    def at(self, place: float) -> Friction:
        """The law at a place [m]."""
        static, corner, start, end, ratio, decay = self.numbers(place).tolist()
        return Friction(static, corner, (2.0 * atan(start), 2.0 * atan(end)), ratio, decay)


AnyFriction = float | Friction | FrictionAlong


@dataclass(frozen=True)
class ContactSettings:
    """What the user chose for the contact of both wheels.

    Parameters
    ----------
    normal : {"strips", "kik-piotrowski", "half-space"}
        Model of the normal pressure: two conditions per strip (docs/theory/strip_model.md); the paper's; the exact
        solver.
    approach : {"projected", "constant"}
        How a rigid approach closes the gap along the curved axis: by its share along the normal of each strip, or
        everywhere alike, as in the paper.
    tangential : str, optional
        Model of the creep forces, ``"fastsim"``, ``"fastrip"``, ``"polach"``, ``"linear"``, ``"shen-hedrick-elkins"``,
        ``"half-space"`` or ``"none"``; None for the usual one of the normal model (``creep_forces``).
        ``"half-space"`` is the exact one and needs that normal model; ``"none"`` is frictionless.
    traction_bound : {"elliptic", "parabolic"}
        Shape of the bound ``mu p`` along a strip that FASTSIM holds the tractions under.
    flexibility : {"blended", "three"}
        FASTSIM's, one for each kind of creepage: where the surfaces stick, with a single one where they slide, or
        everywhere (Kalker's original).
    polach_adhesion, polach_slip : float
        Polach's factors kA and kS, ``0 < kS <= kA <= 1``.
    slope_k0, slope_alpha_inf, slope_beta : float
        Slope reduction of FASTSIM and FaStrip: part of Kalker's stiffness at no creepage, part of that at infinite
        creepage, and how fast it falls.
    friction : tuple of float, Friction or FrictionAlong
        On the left and right rail: a coefficient [1], a law, or laws along the track.
    strips : int, optional
        Number of strips over the width of a patch, 12 to 200 for ``"strips"``; None where ``strip_width`` rules or,
        without that, for the usual one of the normal model (``strip_count``).
    strip_width : float, optional
        Width of a strip along the curved axis [m], or None when a number rules.
    cells : int
        Cells of a strip along the rolling direction (FASTSIM, FaStrip).
    damping : float
        c [s/m]; the elastic normal force N becomes ``N (1 + c d(approach)/dt)``, never negative.
    max_patches : int, optional
        Patches of one wheel at most, largest first, 1 to 6; None for the usual number of the normal model
        (``patch_count``). A new wheel beside a new rail can touch at four.
    wheel, rail : Material
        The two materials.
    half_space : HalfSpaceSettings
        Numbers of the exact solver.
    layer : Layer, optional
        A third body between wheel and rail, for FASTSIM, FaStrip and the exact solver; one that yields not for FaStrip.
    temperature : Heating, optional
        Friction by temperature, for the same three.
    """

    normal: Normal = "strips"
    approach: Approach = "projected"
    tangential: Tangential | None = None
    traction_bound: TractionBound = "elliptic"
    flexibility: Flexibility = "blended"
    polach_adhesion: float = 1.0
    polach_slip: float = 1.0
    slope_k0: float = 1.0
    slope_alpha_inf: float = 1.0
    slope_beta: float = 0.0
    friction: tuple[AnyFriction, AnyFriction] = (DRY, DRY)
    strips: int | None = None
    strip_width: float | None = None
    cells: int = 20
    damping: float = 2.0
    max_patches: int | None = None
    wheel: Material = field(default_factory=Material)
    rail: Material = field(default_factory=Material)
    half_space: HalfSpaceSettings = field(default_factory=HalfSpaceSettings)
    layer: Layer | None = None
    temperature: Heating | None = None

    def fast(self) -> "ContactSettings":
        """The same with a fast model in place of the exact one, for a first idea of its result."""
        if self.normal != "half-space":
            return self
        tangential = None if self.tangential == "half-space" else self.tangential
        if unsuited(tangential or USUAL["strips"].tangential, self.flexibility, self.layer, self.temperature):
            tangential = "fastsim"
        return replace(
            self, normal="strips", approach="projected", tangential=tangential, strips=None, strip_width=None
        )

    @property
    def creep_forces(self) -> Tangential:
        """Model of the creep forces: the one chosen, or the usual one of the normal model."""
        return self.tangential or USUAL[self.normal].tangential

    @property
    def strip_count(self) -> int | None:
        """Number of strips over the width of a patch: the one chosen, or the usual one; None for a strip width."""
        return self.strips or (None if self.strip_width else USUAL[self.normal].strips)

    @property
    def patch_count(self) -> int:
        """Largest number of patches of one wheel: the one chosen, or the usual one of the normal model."""
        return self.max_patches or USUAL[self.normal].patches

    def check(self) -> None:
        """Raise InputError for a model that there is not, and for a number out of its range."""
        for name, allowed in CHOICES.items():
            if (value := getattr(self, name)) not in allowed:
                known = [word for word in allowed if word]
                raise InputError(
                    f"{name} = {value!r:.40}: must be one of {', '.join(known)}{suggest(str(value), known)}"
                )
        for name, (low, high) in RANGES.items():
            if (value := getattr(self, name)) is not None and not (
                isinstance(value, Real) and low <= float(value) <= high
            ):
                raise InputError(f"{name} = {value!r:.40}: must be a number from {low:g} to {high:g}")
        if message := unsuited(self.creep_forces, self.flexibility, self.layer, self.temperature):
            raise InputError(message)

    def __post_init__(self) -> None:
        if self.tangential == "half-space" and self.normal != "half-space":
            raise ValueError('tangential = "half-space" needs normal = "half-space"')
        if self.strip_width is not None and self.normal == "strips":
            raise ValueError('strip_width is not for normal = "strips", which takes a number of strips')


@dataclass(frozen=True)
class ConicalWheels:
    """The textbook contact of ``dynamics.conical``, alike for all wheels of a vehicle.

    conicity [1]; half_spacing: of the contacts from the middle of the axle [m]; creep_longitudinal, creep_lateral: of
    Kalker, of one wheel [N]; friction: coefficient at which creep forces saturate, None for linear ones.
    flange_clearance [m]: shift at which a flange touches, None without flanges; flange_stiffness [N/m].
    """

    conicity: float
    half_spacing: float
    creep_longitudinal: float
    creep_lateral: float
    friction: float | None = None
    flange_clearance: float | None = None
    flange_stiffness: float = 0.0
