"""Wheels on rails for the tests of the contact model: shipped and synthetic profiles, one model for each choice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis.poses import Solved, StaticBench
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.model import Contact, ContactModel
from wrsim.contact.settings import ContactSettings, Material
from wrsim.core import layout as k
from wrsim.geometry.profile import Profile
from wrsim.geometry.profile_models import load_profile
from wrsim.geometry.profile_sections import circle, cone
from wrsim.scenario.cases import StaticPose

Array = NDArray[np.float64]

MODELS = Path(__file__).parents[2] / "models"
RADIUS = 0.46
HALF_SPACING = 0.75
GAUGE = 1.435
STEEL = Material(2.0 * 82e9 * 1.28, 0.28)  # G = 82 GPa, nu = 0.28, as in the tables of CONTACT
PLAIN = {"tangential": "none", "damping": 0.0}  # the normal problem alone
PAIRS = {
    "S1002/60E1 1:40": ("S1002", "60E1", 40),
    "S1002/60E1 1:20": ("S1002", "60E1", 20),
    "worn/60E1 1:40": ("worn", "60E1", 40),
    "worn/worn 1:40": ("worn", "worn", 40),
}


@cache
def wheel_profile(name: str) -> Profile:
    """S1002, or ``worn``: hollow tread, worn flange and root (sums of cosine bells, metres of wear)."""
    profile = load_profile(MODELS / "wheels/S1002.toml")
    if name == "S1002":
        return profile
    return worn_wheel(profile, ((1.1e-3, 2e-3, 26e-3), (1.6e-3, -43e-3, 10e-3)))


@cache
def rail_profile(name: str, inclination: int) -> Profile:
    """60E1, 54E1 or ``worn`` (a 60E1 that lost 2 mm at its gauge corner), inclined by 1 : inclination."""
    if name == "worn":
        return worn_rail(load_profile(MODELS / "rails/60E1.toml"), 2e-3, 18e-3).inclined(1.0 / inclination)
    return load_profile(MODELS / f"rails/{name}.toml").inclined(1.0 / inclination)


def _bell(x: Array) -> tuple[Array, Array, Array]:
    """cos(pi x / 2)^2 for abs(x) < 1, else 0; with its two derivatives."""
    inside = np.abs(x) < 1.0
    return (
        np.where(inside, np.cos(0.5 * np.pi * x) ** 2, 0.0),
        np.where(inside, -0.5 * np.pi * np.sin(np.pi * x), 0.0),
        np.where(inside, -0.5 * np.pi**2 * np.cos(np.pi * x), 0.0),
    )


Curve = Callable[[Array], tuple[Array, Array, Array]]
BESIDE = 1e-10  # distance beside a node at which a curvature's limit is taken [m]


def _worn(new: Profile, ends: Sequence[float], curve: Curve) -> Profile:
    """Profile of a curve r(L), (n, 2), with derivatives, L the arclength of ``new``; curvature jumps at ``ends``."""
    at = np.unique(np.concatenate([new.arclength, ends]))
    at = at[np.concatenate([[True], np.diff(at) > 1e-9])]
    position, first, _ = curve(at)

    def curvature(beside: float) -> Array:
        _, v, a = curve(np.clip(at + beside, 0.0, new.length))
        return (v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0]) / np.hypot(*v.T) ** 3

    middle, half = 0.5 * (at[1:] + at[:-1]), 0.5 * np.diff(at)
    x, weight = np.polynomial.legendre.leggauss(6)
    rate = np.hypot(*curve((middle[:, None] + half[:, None] * x).ravel())[1].T).reshape(-1, 6)
    length = np.concatenate([[0.0], np.cumsum(half * (rate @ weight))])
    angle = np.unwrap(np.arctan2(first[:, 1], first[:, 0]))
    return Profile(f"worn {new.name}", new.kind, length, *position.T, angle, curvature(-BESIDE), curvature(BESIDE))


def worn_wheel(new: Profile, bells: tuple[tuple[float, float, float], ...]) -> Profile:
    """Material removed upward from a wheel: bells (depth, middle, half width) over u [m]."""

    def curve(arc: Array) -> tuple[Array, Array, Array]:
        u, w = new.at(arc)
        tu, tw = new.tangent(arc)
        kappa = new.curvature(arc)
        first, second = np.column_stack([tu, tw]), np.column_stack([-kappa * tw, kappa * tu])
        for depth, middle, half in bells:
            f, f1, f2 = (depth * x for x in _bell((u - middle) / half))
            w = w + f
            first[:, 1] += f1 / half * tu
            second[:, 1] += f2 / half**2 * tu**2 - f1 / half * kappa * tw
        return np.column_stack([u, w]), first, second

    ends = [float(new.arclength_of(m + side * half)) for _, m, half in bells for side in (-1.0, 1.0)]
    return _worn(new, ends, curve)


def worn_rail(new: Profile, depth: float, half: float) -> Profile:
    """A bell of wear at the gauge corner, in the direction of the normal where the profile leans by 65 degrees.

    One direction for all: wear along each point's own normal would make a corner where two arcs meet.
    """
    middle = float(np.interp(-np.radians(65.0), -new.angle, new.arclength))
    inward = -np.array(new.normal(middle))

    def curve(arc: Array) -> tuple[Array, Array, Array]:
        d, d1, d2 = (depth * x for x in _bell((arc - middle) / half))
        kappa = new.curvature(arc)
        first, second = np.column_stack(new.tangent(arc)), kappa[:, None] * np.column_stack(new.normal(arc))
        return (
            np.column_stack(new.at(arc)) + np.outer(d, inward),
            first + np.outer(d1 / half, inward),
            second + np.outer(d2 / half**2, inward),
        )

    return _worn(new, [middle - half, middle + half], curve)


def round_wheel(radius: float, half_width: float = 0.02) -> Profile:
    """Wheel profile of one arc, convex towards the rail, lowest at u = 0."""
    return circle(f"arc R{1e3 * radius:g}", "wheel", -radius, half_width)


def flat_rail(half_width: float = 0.05) -> Profile:
    """A plane."""
    return cone("flat", "rail", 0.0, -half_width, half_width)


def contact_model(
    wheel: Profile, rail: Profile, *, radius: float = RADIUS, friction: float = 0.3, **choices
) -> ContactModel:
    """Contact model without damping, in the tables' steel; choices as in ContactSettings."""
    settings = ContactSettings(**{"wheel": STEEL, "rail": STEEL, "damping": 0.0} | choices)
    return ContactModel.build(wheel, rail, radius, settings, friction)


def pair_model(pair: str, **choices) -> ContactModel:
    """Contact model of one of the ``PAIRS``."""
    wheel, rail, inclination = PAIRS[pair]
    return contact_model(wheel_profile(wheel), rail_profile(rail, inclination), **choices)


def rail_origin(rail: Profile, gauge: float = GAUGE) -> tuple[float, float]:
    """(o, b) of a rail's profile origin in the track cross-section."""
    return 0.5 * gauge - rail.gauge_point()[0], -rail.top[1]


def bench(model: ContactModel, *, rolling: bool = True, sides: tuple[int, ...] = (1,)) -> StaticBench:
    """One wheel (or two alike) of a wheelset on straight track."""
    origin = rail_origin(model.rail)
    wheels = [WheelOnRail(model, side, HALF_SPACING, origin) for side in sides]
    return StaticBench(wheels, rolling, model.radius)


def settle(stand: StaticBench, lateral: float, yaw: float, load: float, roll: float = 0.0) -> tuple[Solved, Contact]:
    """Lower the first wheel of a bench until it carries the load."""
    solved = stand.solve(StaticPose("test", lateral, yaw, load, roll))
    return solved, contact_of(stand)


def contact_of(stand: StaticBench, wheel: int = 0) -> Contact:
    """What the wheel's model computed last."""
    return Contact.copy_from(stand.wheels[wheel].model.arrays, 0)


def strips_of(contact: Contact, group: float | None = None) -> Array:
    """Strips of all lobes, or of the lobes of one patch, in one array."""
    rows = [
        strips
        for lobe, strips in zip(contact.patches, contact.strips, strict=True)
        if group is None or lobe[k.GROUP] == group
    ]
    return np.concatenate(rows) if rows else np.zeros((0, k.STRIP_COLUMNS))
