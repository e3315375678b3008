"""The reference tables of wheel-rail contact computed with CONTACT 25.2, and any of our models on their cases.

The tables are not part of this repository (subsets are, in tests/data). Columns: millimetres, newtons, megapascals,
radians; CONTACT's track frame, y to the right and z down. A right wheel there is the mirror image of our left wheel,
with the same numbers for lateral shift and yaw and the opposite one for roll.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.channels import WheelOnRail
from wrsim.contact.creep.laws import CREEP_LAWS
from wrsim.contact.half_space import HalfSpace, HalfSpaceContact
from wrsim.contact.model import Contact, ContactModel
from wrsim.contact.models import contact_model
from wrsim.contact.pose import Pose
from wrsim.contact.profiles.files import read_points
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.profiles.sections import circle
from wrsim.contact.settings import ContactSettings, Flexibility, Material, Normal, TractionBound
from wrsim.simulation.pose_solver import HalfSpacePoseSolver, PoseSolver

Array = NDArray[np.float64]
Row = dict[str, str]

MODELS = Path(__file__).parents[1] / "models"
STEEL = Material(2.0 * 82e9 * 1.28, 0.28)  # G 82 GPa, nu 0.28
HALF_SPACING, HALF_GAUGE, FRICTION = 0.75, 0.7175, 0.3
TOUCHING = 0.2  # strips whose edges are nearer than this part of their width belong to one region


# --- models -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Chosen:
    """A model by name: the value of ``normal`` (or "half-space"), then options after slashes.

    Options: ``constant`` or ``projected`` (approach), ``strips=30``, ``parabolic``, a ``tangential`` model; for the
    half-space ``table`` (element size of the row, area counted by elements), ``level`` (pairing as CONTACT's),
    ``angle-corrected``, ``resolution=48``.
    """

    name: str
    settings: ContactSettings
    solver: HalfSpace | None = None
    table_elements: bool = False

    @classmethod
    def parse(cls, name: str) -> Chosen:
        """Raises SystemExit for an option that is not known."""
        normal, *options = name.split("/")
        exact = normal == "half-space"
        values: dict[str, object] = {"normal": normal}
        if exact:
            values["tangential"] = "half-space"
        if normal not in get_args(Normal):
            raise SystemExit(f"model '{name}': allowed: {', '.join(get_args(Normal))}")
        solver, table = HalfSpace(), False
        for option in options:
            key, _, value = option.partition("=")
            if option in ("constant", "projected"):
                values["approach"] = option
            elif option in ("elliptic", "parabolic"):
                values["traction_bound"] = option
            elif key == "strips" and value.isdigit():
                values["strips"] = int(value)
            elif exact and option == "table":
                table = True
            elif exact and option == "level":
                solver = replace(solver, pairing="level")
            elif exact and option == "angle-corrected":
                solver = replace(solver, influence="angle-corrected")
            elif exact and key == "resolution" and value.isdigit():
                solver = replace(solver, resolution=int(value))
            else:
                raise SystemExit(f"model '{name}': unknown option '{option}'; {' '.join((cls.__doc__ or '').split())}")
        settings = ContactSettings(wheel=STEEL, rail=STEEL, damping=0.0, **values)  # type: ignore[arg-type]
        return cls(name, settings, solver if exact else None, table)

    def with_tangential(self, tangential: str) -> ContactSettings:
        """Settings with a model of the creep forces by its name, perhaps with "/three" or "/parabolic" or both."""
        name, *options = tangential.split("/")
        allowed: dict[str, str] = dict.fromkeys(get_args(TractionBound), "traction_bound")
        allowed |= dict.fromkeys(get_args(Flexibility), "flexibility")
        if name not in CREEP_LAWS or not set(options) <= set(allowed):
            raise SystemExit(
                f"creep forces '{tangential}': allowed: {', '.join(CREEP_LAWS)}, or with /three, /parabolic"
            )
        chosen = {allowed[option]: option for option in options}
        return replace(self.settings, tangential=name, **chosen)  # type: ignore[arg-type]


# --- what a model says --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Region:
    """One connected region of contact: N [N], p0 [Pa], area [m2], lateral place in the track frame [m]; extents along
    the curved axis and along the rail [m]; contact angles at its edges [rad]."""

    normal_force: float
    p0: float
    area: float
    place: float
    width: float
    length: float
    angle_from: float
    angle_to: float


@dataclass(frozen=True)
class Answer:
    """A model's contact at one pose: the patch with the largest force, all regions, forces on the wheel [N], seconds of
    one evaluation at the pose that was found; of strips the mean place of the normal force along the track [m]."""

    normal_force: float
    p0: float
    area: float
    approach: float
    n_patches: int
    force: Array
    moment: Array
    regions: tuple[Region, ...]
    seconds: float
    along: float = np.nan

    @property
    def angles(self) -> tuple[float, float]:
        """Contact angles at the edges of the region with the largest force [rad]."""
        return self.regions[0].angle_from, self.regions[0].angle_to

    @property
    def total(self) -> float:
        """Normal force of all regions [N]."""
        return sum(r.normal_force for r in self.regions)


def strip_regions(strips: Array, place: float) -> tuple[Region, ...]:
    """Connected regions of strips in contact, by falling force; strips (n, STRIP_COLUMNS) of all lobes."""
    strips = strips[(strips["N"] > 0.0) & (strips["a"] > 0.0)]
    tangent = np.column_stack([strips["nb"], -strips["no"]])
    centre, half = np.column_stack([strips["o"], strips["b"]]), 0.5 * strips["ds"][:, None]
    near, far = centre - half * tangent, centre + half * tangent
    apart = np.hypot(*(far[:, None] - near[None, :]).transpose(2, 0, 1))
    joined = apart < TOUCHING * np.minimum(strips["ds"][:, None], strips["ds"][None, :])
    label = np.arange(len(strips))
    for i, j in np.argwhere(joined):
        label[label == label[j]] = label[i]
    regions = []
    for region in np.unique(label):
        strips_of_region = strips[label == region]
        strips_of_region = strips_of_region[
            np.argsort(
                strips_of_region["o"] * strips_of_region["nb"].mean()
                - strips_of_region["b"] * strips_of_region["no"].mean()
            )
        ]
        angle = np.arctan2(-strips_of_region["no"], strips_of_region["nb"])
        ends = (angle[0], angle[-1])
        if len(strips_of_region) > 1:  # at the outer edges of the outer strips
            ds = strips_of_region["ds"]
            beyond = ds[[0, -1]] / (ds[[0, -1]] + ds[[1, -2]])
            ends = tuple(angle[[0, -1]] + beyond * (angle[[0, -1]] - angle[[1, -2]]))
        force = strips_of_region["N"]
        regions.append(
            Region(
                float(force.sum()),
                float(strips_of_region["p"].max()),
                float((2.0 * strips_of_region["a"] * strips_of_region["ds"]).sum()),
                float(force @ strips_of_region["o"] / force.sum()) + place,
                float(strips_of_region["ds"].sum()),
                float(
                    (strips_of_region["x"] + strips_of_region["a"]).max()
                    - (strips_of_region["x"] - strips_of_region["a"]).min()
                ),
                float(ends[0]),
                float(ends[1]),
            )
        )
    return tuple(sorted(regions, key=lambda r: -r.normal_force))


def answer_of_strips(model: ContactModel, contact: Contact, place: float, repeats: int = 10) -> Answer | None:
    """The answer of a strip model, timed so many times; None without contact."""
    lobes = contact.patches[contact.patches["N"] > 0.0]
    if not len(lobes):
        return None
    groups = {g: float(lobes["N"][lobes["group"] == g].sum()) for g in set(lobes["group"])}
    main = lobes[lobes["group"] == max(groups, key=groups.__getitem__)]
    strips = np.concatenate(contact.strips)
    return Answer(
        float(main["N"].sum()),
        float(main["p0"].max()),
        float(main["area"].sum()),
        float(main["approach"][np.argmax(main["N"])]),
        len(groups),
        contact.force,
        contact.moment,
        strip_regions(strips, place),
        _seconds(model.arrays.evaluate, repeats),
        float(strips["N"] @ strips["x"] / strips["N"].sum()),
    )


def answer_of_elements(contact: HalfSpaceContact | None, place: float, counted: bool, seconds: float) -> Answer | None:
    """The answer of the exact solver; None without contact."""
    if contact is None or not contact.patches:
        return None
    patch = contact.patches[0]
    regions = []
    for p in contact.patches:
        for r in p.regions:
            outward = float(r.p.sum(axis=1) @ p.grid.axis["o"][r.rows] / r.p.sum()) + place
            figures = r.normal_force, r.p0, r.area, outward, r.s[1] - r.s[0], r.length
            regions.append(Region(*figures, *r.angle))
    return Answer(
        patch.normal_force,
        patch.p0,
        np.count_nonzero(patch.p) * patch.grid.cell if counted else patch.area,
        patch.approach,
        len(contact.patches),
        contact.force,
        contact.moment,
        tuple(sorted(regions, key=lambda r: -r.normal_force)),
        seconds,
    )


def _seconds(call: object, repeats: int) -> float:
    """Shortest of some calls."""
    best = np.inf
    for _ in range(repeats):
        began = time.perf_counter()
        call()  # type: ignore[operator]
        best = min(best, time.perf_counter() - began)
    return float(best)


@dataclass(frozen=True)
class Place:
    """Which wheel stands on which rail, and where."""

    wheel: Profile
    rail: Profile
    origin: tuple[float, float]
    radius: float
    rolling: bool


def solve(
    chosen: Chosen, place: Place, pose: Pose, spin: float = 0.0, element: float = 0.0, repeats: int = 10
) -> Answer | None:
    """Contact of a model at a prescribed vertical load; None where it finds none, with a line that says so.

    spin: rate about the axle at 2 m/s [rad/s], 0: no slip at the tape circle; element: of the reference [m]; repeats:
    of strips for their time.
    """
    settings = chosen.settings if place.rolling else replace(chosen.settings, tangential="none")
    model = _model(place.wheel, place.rail, place.radius, settings)
    wheel = WheelOnRail(model, 1, HALF_SPACING, place.origin)
    radius = 2.0 / spin if spin else place.radius
    if chosen.solver is None:
        bench = PoseSolver([wheel], place.rolling, radius)
        solved = bench.solve(pose)
        answer = answer_of_strips(model, Contact.copy_from(model.arrays, 0), place.origin[0], repeats)
    else:
        solver = replace(chosen.solver, element=(element, element)) if chosen.table_elements else chosen.solver
        exact = HalfSpacePoseSolver([wheel], place.rolling, radius, solver)
        solved = exact.solve(pose)
        still = _model(place.wheel, place.rail, place.radius, replace(settings, tangential="none"))
        still.arrays.pose[:] = model.arrays.pose
        seconds = _seconds(lambda: solver.solve_pose(still), 1) if exact.contacts[0] is not None else np.nan
        answer = answer_of_elements(exact.contacts[0], place.origin[0], chosen.table_elements, seconds)
    if solved.message:
        print(f"  {chosen.name}: {pose.name}: {solved.message}")
    return answer


@cache
def _model(wheel: Profile, rail: Profile, radius: float, settings: ContactSettings) -> ContactModel:
    return contact_model(wheel, rail, radius, settings, FRICTION)


# --- cases --------------------------------------------------------------------------------------------


def read(path: Path) -> list[Row]:
    """Rows of a reference table."""
    if not path.is_file():
        raise SystemExit(f"{path}: there is no such reference table")
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def by_case(rows: Iterable[Row]) -> dict[str, dict[str, list[Row]]]:
    """Case -> method -> rows (one for each patch)."""
    cases: dict[str, dict[str, list[Row]]] = {}
    for row in rows:
        cases.setdefault(row["case_id"], {}).setdefault(row["method"], []).append(row)
    return cases


@cache
def shipped(kind: str, name: str) -> Profile:
    """A shipped profile by the name that the tables use."""
    worn = {"wheels": "S1002_worn", "rails": "60E1_worn"}
    return load_profile(MODELS / kind / f"{worn[kind] if 'worn' in name else name}.toml")


@cache
def own_place(wheel: str, rail: str, cant: str, rolling: bool) -> Place:
    """Place of a right wheel of ``own_static.csv``: R 460 mm, gauge 1435 mm, origins 1500 mm apart."""
    inclined = shipped("rails", rail).inclined(1.0 / float(cant.split(":")[1]))
    origin = (HALF_GAUGE - inclined.gauge_point()[0], -inclined.top[1])
    return Place(shipped("wheels", wheel), inclined, origin, 0.46, rolling)


@cache
def bench_place(folder: Path) -> Place:
    """Place of the Manchester contact benchmark: its own profiles, from the reference folder."""
    wheel = read_points(folder / "profiles/MBench_S1002_v3.prw", "wheel", measured=False).profile
    rail = read_points(folder / "profiles/MBench_UIC60_v3.prr", "rail", measured=False).profile
    return Place(wheel, rail, (HALF_GAUGE - rail.gauge_point()[0], -rail.top[1]), 0.46, True)


@cache
def arc_place(radius_wheel: float, radius_rail: float, radius: float) -> Place:
    """A hollow wheel arc on a rail corner, origins above one another at zero shift; frictionless."""
    wheel = circle("hollow", "wheel", radius_wheel, 0.95 * radius_wheel)
    rail = circle("corner", "rail", radius_rail, 0.98 * radius_rail)
    return Place(wheel, rail, (HALF_SPACING, 0.0), radius, False)


def pose_of(row: Row) -> Pose:
    """The pose of a row of either side as that of our left wheel."""
    mirrored = 1.0 if row.get("side", "R") == "R" else -1.0
    return Pose(
        row["case_id"],
        mirrored * 1e-3 * float(row["y_ws_mm"]),
        mirrored * float(row["yaw_rad"]),
        float(row["Fz_req_N"]),
        -mirrored * float(row.get("roll_rad", 0.0)),
    )


def static_answers(
    chosen: Chosen, cases: dict[str, dict[str, list[Row]]], folder: Path, with_shipped: bool
) -> Iterator[tuple[str, Row, Answer | None]]:
    """Answers to the cases of a static table; with_shipped: with our profiles, else the Manchester ones."""
    for name, methods in cases.items():
        row = next(iter(methods.values()))[0]
        rolling = row.get("tang", "3") == "3"
        place = (
            own_place(row["wheel"], row["rail"], row["cant_label"], rolling) if with_shipped else bench_place(folder)
        )
        spin = abs(float(row["vpitch_radps"]))
        yield name, row, solve(chosen, place, pose_of(row), spin, 1e-3 * float(row["dx_eff_mm"]))


def groove_answer(chosen: Chosen, groove: float, spin: float) -> Answer | None:
    """A ball of R 10 mm across and R 420 mm along in a groove of a radius [m]; G 80 GPa, nu 0.28, 10 kN vertical.

    spin: turning rate of the ball at 0.42 m/s [rad/s]; friction takes part in the load.
    """
    steel = Material(2.0 * 80e9 * 1.28, 0.28)
    ball = replace(chosen, settings=replace(chosen.settings, wheel=steel, rail=steel))
    wheel = circle("ball", "wheel", -0.010, 0.0098)
    rail = circle("groove", "rail", -groove, 0.98 * groove)
    place = Place(wheel, rail, (HALF_SPACING, 0.0), 0.42, True)
    return solve(ball, place, Pose("ball", 0.0, 0.0, 10e3), spin * 2.0 / 0.42)
