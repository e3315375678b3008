"""Wheels on rails for the tests of the contact model: shipped and synthetic profiles, one model for each choice."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wrsim import ContactModel, ContactSettings, Pose, Profile, load_profile
from wrsim.contact import models
from wrsim.contact import records as k
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.model import Contact
from wrsim.contact.profiles.sections import circle, cone
from wrsim.contact.records import PlacedWheel, Shape
from wrsim.contact.records import ProfileTable as Table
from wrsim.contact.records import WheelPose as WheelPose
from wrsim.contact.search.locus import placed
from wrsim.contact.settings import Material
from wrsim.contact.strips.records import System
from wrsim.contact.wheel_rail import place_bodies
from wrsim.jit.linalg import Vec
from wrsim.simulation.pose_solver import PoseSolver, Solved

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
    "S1002/54E1 1:20": ("S1002", "54E1", 20),
    "worn/60E1 1:40": ("worn", "60E1", 40),
    "worn/worn 1:40": ("worn", "worn", 40),
}


@cache
def wheel_profile(name: str) -> Profile:
    """S1002, or ``worn``: the shipped one with a hollow tread, worn flange and root."""
    return load_profile(MODELS / f"wheels/{'S1002_worn' if name == 'worn' else name}.toml")


@cache
def rail_profile(name: str, inclination: int) -> Profile:
    """60E1, 54E1 or ``worn`` (the shipped 60E1 that lost 2 mm at its gauge corner), inclined by 1 : inclination."""
    return load_profile(MODELS / f"rails/{'60E1_worn' if name == 'worn' else name}.toml").inclined(1.0 / inclination)


def round_wheel(radius: float, half_width: float = 0.02) -> Profile:
    """Wheel profile of one arc, convex towards the rail, lowest at u = 0."""
    return circle(f"arc R{1e3 * radius:g}", "wheel", -radius, half_width)


def flat_rail(half_width: float = 0.05) -> Profile:
    """A plane."""
    return cone("flat", "rail", 0.0, -half_width, half_width)


def contact_model(
    wheel: Profile, rail: Profile, *, radius: float = RADIUS, friction: float = 0.3, **choices
) -> ContactModel:
    """Contact model without damping, in the tables' steel; choices as in ContactSettings, but Kik-Piotrowski unless
    they name another normal model."""
    settings = ContactSettings(**{"normal": "kik-piotrowski", "wheel": STEEL, "rail": STEEL, "damping": 0.0} | choices)
    return models.contact_model(wheel, rail, radius, settings, friction)


def pair_model(pair: str, **choices) -> ContactModel:
    """Contact model of one of the ``PAIRS``."""
    wheel, rail, inclination = PAIRS[pair]
    return contact_model(wheel_profile(wheel), rail_profile(rail, inclination), **choices)


def rail_origin(rail: Profile, gauge: float = GAUGE) -> tuple[float, float]:
    """(o, b) of a rail's profile origin in the track cross-section."""
    return 0.5 * gauge - rail.gauge_point()[0], -rail.top[1]


def bench(model: ContactModel, *, rolling: bool = True, sides: tuple[int, ...] = (1,)) -> PoseSolver:
    """One wheel (or two alike) of a wheelset on straight track."""
    origin = rail_origin(model.rail)
    # each with arrays of its own
    models = [model, *(replace(model) for _ in sides[1:])]
    wheels = [WheelOnRail(m, side, HALF_SPACING, origin) for m, side in zip(models, sides, strict=True)]
    return PoseSolver(wheels, rolling, model.radius)


def settle(stand: PoseSolver, lateral: float, yaw: float, load: float, roll: float = 0.0) -> tuple[Solved, Contact]:
    """Lower the first wheel of a bench until it carries the load."""
    solved = stand.solve(Pose("test", lateral, yaw, load, roll))
    return solved, contact_of(stand)


def contact_of(stand: PoseSolver, wheel: int = 0) -> Contact:
    """What the wheel's model computed last."""
    return Contact.copy_from(stand.wheels[wheel].model.arrays, 0)


def finite(values: Array) -> bool:
    """Whether all numbers are finite, of records too."""
    values = np.asarray(values)
    parts = [values] if values.dtype.names is None else [values[name] for name in values.dtype.names]
    return all(bool(np.isfinite(part).all()) for part in parts)


def numbers(contact: Contact) -> list[float]:
    """All numbers of a contact but its strips'."""
    lobes = [value for lobe in contact.patches.tolist() for value in lobe]
    return [*contact.force, *contact.moment, contact.wear_number, contact.closest, *lobes]


def wheel_at(
    table: Array, step: float, radius: float, origin: Array, axle: Array, roller: float = 0.0
) -> PlacedWheel:  # fmt: skip
    """A wheel as the kernels take it, from its profile's table; origin, axle: (3,) in rail axes;
    roller: inverse of its radius [1/m]."""
    pose = WheelPose(Vec(*map(float, origin)), Vec(*map(float, axle)), Vec(0.0, 0.0, 0.0), Vec(0.0, 0.0, 0.0))
    none = np.zeros((0, 0))
    return placed(Table(table, float(step)), radius, pose, Shape(none, none, 0, 0.0, 0.0, 0.0, 0.0, 0.0), roller)


def columns(rows: Array, names: str) -> Array:
    """Some fields of records (n,), side by side (n, names)."""
    return np.stack([rows[name] for name in names.split()], axis=-1)


def strips_of(contact: Contact, group: float | None = None) -> Array:
    """Strips of all lobes, or of the lobes of one patch, in one array."""
    rows = [
        strips
        for lobe, strips in zip(contact.patches, contact.strips, strict=True)
        if group is None or lobe["group"] == group
    ]
    return np.concatenate(rows) if rows else np.zeros(0, k.STRIP)


def strip_system(model: ContactModel) -> tuple[System, int]:
    """What the kernels of the strip model work on, in the state of the last call, and how many strips a grid has."""
    a = model.arrays.rows
    wheel, rail, _pose = place_bodies(a)
    system = System(wheel, rail, a.influence, a.rows, a.places, a.grids, a.vectors, a.matrix, a.memo)
    return system, int(model.arrays.model.strips)
