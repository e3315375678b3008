"""Steps of wear: cases on one profile, the depth that they leave, and the mileage that this profile lasts.

A step goes as far as the wear at its start leaves the largest depth that is allowed. On the way its cases run again on
the profiles that are left by then, and the loss is weighed from all of these stages (`wrsim.study.evolution.stages`):
the contact moves by its own width while a tenth of a millimetre wears off, and a single stage would dig too deep.

A step lies in its folder ``steps/000``, ``001``, ...: its wheel (``wheel.toml``, ``depths.csv``; the first step runs on
the unworn profile itself), its cases as those of a study, the same for the profiles on its way in ``look1``, ``look2``,
..., and ``step.json``, which is written last. One that was killed begins with the first step without one, whose
cases go on by their markers.
All that a step hands to the next is in ``step.json``, and is read from there also when it was not
interrupted, so that both are the same to the bit.

All wheels wear alike: by the mean over all wheels of the vehicle and over the cases by their shares, as if the vehicle
were turned round now and then.
"""

import contextlib
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import AliasChoices, ConfigDict, Field, FiniteFloat, TypeAdapter, ValidationError

from wrsim.contact.profiles.models import write_depths
from wrsim.contact.profiles.wear import on_unworn, smoothed_table
from wrsim.errors import InputError, SimulationError
from wrsim.inputs.toml_files import read_bytes, write_toml
from wrsim.results import Result, write_atomically
from wrsim.results.files import as_json
from wrsim.results.table import formatted, quantity
from wrsim.study.evolution.reading import Evolution
from wrsim.study.evolution.stages import Array, tableau
from wrsim.study.plan import Plan
from wrsim.study.task import COMPLETED, RESULT, Work, missing, read_marker
from wrsim.timing import timed

STEPS, STEP, LOOK, WHEEL, DEPTHS = "steps", "step.json", "look", "wheel.toml", "depths.csv"
SHORTEST_REST = 1e-9
"""Share of the mileage below which nothing is left to run."""


@dataclass(frozen=True)
class Step:
    """One step. start: mileage at which it begins, way: how far it goes [m]; deepest: depth for each metre run where it
    is largest [1]; tread, flange: mass lost by a wheel for each metre run [kg/m]; areas: lost from the unworn profile
    by the end of the step, over the bins' widths [m]; evolution: digest of the profile evolution."""

    __pydantic_config__ = ConfigDict(extra="forbid")

    number: int
    start: FiniteFloat
    way: Annotated[FiniteFloat, Field(gt=0.0)]
    deepest: FiniteFloat
    tread: FiniteFloat
    flange: FiniteFloat
    areas: tuple[FiniteFloat, ...]
    evolution: Annotated[str, Field(validation_alias=AliasChoices("evolution", "service"))]

    @property
    def end(self) -> float:
        """Mileage at which it ends [m]."""
        return self.start + self.way

    def label(self, mileage: float) -> str:
        """One line on a step that is done, of so much mileage [m]."""
        depth = quantity(1e3 * self.deepest * self.way, "mm", ".3g")
        tread, flange = quantity(1e6 * self.tread, "g/km", ".3g"), formatted(1e6 * self.flange, ".3g")
        return (
            f"step {self.number}: {formatted(1e-3 * self.start, '.6g')} to {quantity(1e-3 * self.end, 'km', '.6g')} "
            f"({quantity(100.0 * self.end / mileage, '%', '.0f')}), "
            f"{depth} at the deepest, {tread} on the tread, {flange} on the flange"
        )


def folder_of(directory: Path, number: int) -> Path:
    """The folder of a step."""
    return directory / STEPS / f"{number:03d}"


def read_step(evolution: Evolution, folder: Path) -> Step | None:
    """The step that was done in a folder, None where there is none. Raises InputError where the input has changed."""
    try:
        step = TypeAdapter(Step).validate_json(read_bytes(folder / STEP, "step"), strict=True)
    except (InputError, ValidationError):
        return None
    if len(step.areas) != evolution.places.size - 1:
        return None
    if step.evolution != evolution.digest:
        raise InputError(
            f"{folder / STEP}: was computed from another profile evolution: its file, scenario, cases or models have "
            "changed since; choose another directory with -o"
        )
    return step


def wear_steps(evolution: Evolution, directory: Path, work: Work) -> Iterator[Step]:
    """All steps up to the mileage, those that are done already from their files.

    Raises SimulationError when a case did not come to its end, InputError when the profile would overlap itself.
    """
    start, number = 0.0, 0
    areas = np.zeros(evolution.places.size - 1)
    while evolution.mileage - start > SHORTEST_REST * evolution.mileage:
        folder = folder_of(directory, number)
        if read_step(evolution, folder) is None:
            computed = _computed(evolution, folder, number, start, areas, work)
            write_atomically(folder / STEP, as_json(asdict(computed)))
        step = read_step(evolution, folder)
        if step is None:
            raise InputError(f"{folder / STEP}: cannot be read again")
        yield step
        start, number, areas = step.end, number + 1, np.array(step.areas)


@dataclass(frozen=True)
class _Wear:
    """For each metre run: area lost by bins of the unworn profile, over their widths, and mass on tread and flange."""

    areas: Array
    tread: float
    flange: float

    def deepest(self, evolution: Evolution) -> float:
        """Depth where it is largest, as smoothed."""
        width, cutoff = float(evolution.places[1]), 1e-3 * evolution.spec.smoothing_mm
        return float(smoothed_table(self.areas, width, cutoff).max())


def _computed(evolution: Evolution, folder: Path, number: int, start: float, areas: Array, work: Work) -> Step:
    """How far a step goes and what is lost by its end."""
    looks = [_wear(evolution, folder, areas, start, work)]
    deepest, way = looks[0].deepest(evolution), min(1e3 * evolution.spec.largest_step_km, evolution.mileage - start)
    if deepest > 0.0:
        way = min(way, 1e-3 * evolution.spec.largest_depth_mm / deepest)
    before, whole = tableau()
    try:
        for k, weights in enumerate(before[1:], 1):
            on_the_way = areas + way * _weighed(looks, weights).areas
            mileage = start + way * float(weights.sum())
            looks.append(_wear(evolution, folder / f"{LOOK}{k}", on_the_way, mileage, work))
        mean = _weighed(looks, whole)
        after = areas + way * mean.areas
        evolution.profile(after)
    except InputError as error:
        place = f"step {number}, from {1e-3 * start:.6g} to {1e-3 * (start + way):.6g} km"
        raise InputError(f"{evolution.source.file}: {place}: {error}") from None
    lost = tuple(after.tolist())
    return Step(number, start, way, mean.deepest(evolution), mean.tread, mean.flange, lost, evolution.digest)


def _weighed(looks: Sequence[_Wear], weights: Array) -> _Wear:
    """The sum of some looks at the wear, each with its weight; those without a weight have not been taken yet."""
    pairs = list(zip(weights.tolist(), looks, strict=False))
    areas = np.sum([weight * look.areas for weight, look in pairs], axis=0)
    return _Wear(
        areas, sum(weight * look.tread for weight, look in pairs), sum(weight * look.flange for weight, look in pairs)
    )


def _wear(evolution: Evolution, folder: Path, areas: Array, mileage: float, work: Work) -> _Wear:
    """Run the cases on the profile that is left when so much is lost, in a folder."""
    label = f"{1e-3 * mileage:.6g} km"
    length = evolution.profile(areas).length
    plan = evolution.plan(folder, write_wheel(evolution, folder, areas, label), label)
    todo = missing(plan)
    if todo:
        with timed(f"{len(todo)} cases of {label}"):
            work(plan, todo)
    lost, tread, flange = _lost(evolution, plan)
    return _Wear(on_unworn(evolution.unworn, evolution.table(areas), length, lost, areas.size), tread, flange)


def write_wheel(evolution: Evolution, folder: Path, areas: Array, label: str, stem: str = "") -> Path:
    """Write a wheel's profile as model files whose names begin with stem; gives the file to load, unworn as given."""
    table = evolution.table(areas)
    if table is None:
        return evolution.wheel
    depths = folder / f"{stem}{DEPTHS}"
    content = {
        "name": f"{evolution.unworn.name} after {label}",
        "body": "wheel",
        "kind": "worn",
        "source": f"computed: {evolution.source.title}",
        "base": str(evolution.wheel),
        "depths": depths.name,
    }
    write_atomically(depths, write_depths(table).encode())
    file = folder / f"{stem}{WHEEL}"
    return write_atomically(file, write_toml(content | {"date": _day_of(file, content)}).encode())


def _day_of(file: Path, content: dict[str, str]) -> date:
    """Today, or the day on which the same was written: with another one, cases that are done would have other names."""
    with contextlib.suppress(OSError, ValueError, KeyError):
        known = tomllib.loads(file.read_text(encoding="utf-8"))
        day = date.fromisoformat(str(known.pop("date")))
        if known == content:
            return day
    return date.today()


def _lost(evolution: Evolution, plan: Plan) -> tuple[Array, float, float]:
    """Mean over wheels and cases: area by bins of the present profile and mass on tread and flange, for each metre."""
    areas, zones, faults = np.zeros(0), np.zeros(2), []
    for case, share in zip(plan.cases, evolution.shares, strict=True):
        folder = plan.folder_of(case)
        marker = read_marker(folder)
        if marker is None or marker.status != COMPLETED:
            reason = "no result" if marker is None else f"{marker.status}: {marker.message}"
            faults.append(f"{plan.folder}: case {case.label}: {reason}")
            continue
        dataset = Result.load(folder / RESULT).dataset.sel(wear_law=evolution.spec.law)
        depth = dataset["wear_wheel_depth"].values.reshape(-1, dataset.sizes["wheel_place"]).mean(axis=0)
        areas = share * depth + (areas if areas.size else 0.0)
        zones += share * dataset["wear_wheel_mass"].values.reshape(-1, 2).mean(axis=0)
    if faults:
        raise SimulationError("\n".join(faults))
    return areas, float(zones[0]), float(zones[1])
