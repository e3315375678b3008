"""A profile evolution, read and checked, and the plan of the cases of one step."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.profiles.wear import DepthTable, bin_edges, depths_of, worn
from wrsim.errors import InputError
from wrsim.inputs.toml_files import noting_reads
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import Scenario
from wrsim.scenario.sections.run import RunPlan
from wrsim.study.axes import AxisPoints, axis_points
from wrsim.study.evolution.stages import STAGES, Array
from wrsim.study.plan import Plan, StudyInput, with_cases
from wrsim.study.spec import CasesSection, CsvAxis, EvolutionFile, OutputsSection

SHARE = "share"
"""Column of the table of cases."""
WHOLE = 1e-6
"""How far shares may be from adding up to one."""
PLACE_STEP = 0.25e-3
"""Width of the bins on the unworn profile [m]."""
SHARPEST = 1000.0
"""Curvature that one step may leave at most [1/m]: a radius of 1 mm, as narrow as a patch."""


@dataclass(frozen=True)
class Evolution:
    """A profile evolution in SI units.

    source: the file as it was read, spec: its content, base: its scenario with all that holds for every case; mileage
    [m]; points, cases_text: the cases and their table; shares: of the mileage, in their order; wheel: file of the
    unworn profile, which is ``unworn``; places: edges of the bins of its arclength [m]; setup: of ``base``; digest: of
    everything that shapes the numbers.
    """

    source: StudyInput
    spec: EvolutionFile
    base: Scenario
    mileage: float
    points: AxisPoints
    cases_text: str
    shares: tuple[float, ...]
    wheel: Path
    unworn: Profile
    places: Array
    setup: Setup[RunPlan]
    digest: str

    def table(self, areas: Array) -> DepthTable | None:
        """Depths after so much was lost, areas over the bins' widths [m]; None for the unworn profile."""
        return depths_of(self.unworn, areas, 1e-3 * self.spec.smoothing_mm) if areas.any() else None

    def profile(self, areas: Array) -> Profile:
        """The profile after so much was lost. Raises InputError where it would overlap itself."""
        table = self.table(areas)
        return self.unworn if table is None else worn(self.unworn, [table], f"{self.unworn.name}, worn")

    def plan(self, folder: Path, wheel: Path, label: str) -> Plan:
        """The study of one step: all cases with this wheel, in a folder. Raises InputError with all faults."""
        base = self.base.with_values({"vehicle.wheel": str(wheel.resolve())}, str(self.source.file))
        title, cases = f"{self.source.title}, {label}", CasesSection(time_limit_s=self.spec.time_limit_s)
        return with_cases(self.source.plan_of(base, title, folder, (self.points,), OutputsSection(), cases), base)[0]


def read_evolution(file: Path, models: Sequence[str | Path] = ()) -> tuple[Evolution, tuple[Path, ...]]:
    """A profile evolution, and all files that were read. Raises InputError with file, key and what is allowed."""
    with noting_reads() as seen:
        source = StudyInput(file, "profile evolution file", EvolutionFile, models)
        spec: EvolutionFile = source.spec
        base = source.base
        with source.naming("largest_depth_mm", value=spec.largest_depth_mm):
            _check_bend(spec)
        if base.analysis != "curving":
            with source.naming("base", value=spec.base):
                raise InputError(f'its analysis is "{base.analysis}"; must be a scenario with analysis = "curving"')
        wheel = source.file_of("wheel", name=spec.wheel).resolve()
        with source.naming("wheel", value=spec.wheel):
            unworn = load_profile(wheel, "wheel")
        table = source.file_of("cases", name=spec.cases)
        axis = CsvAxis(kind="csv", file=str(table.resolve()))
        points, shares = _weighted(axis_points(axis, source.finder, source.locate(("cases",))))
        changes = {"wear.laws": [spec.law], "vehicle.wheel": str(wheel)}
        base = base.with_values(changes, source.locate(("base",)))
        setup = build(base)
    digest = hashlib.sha256(repr((spec, STAGES, base.text, sorted(setup.inputs.items()))).encode())
    for path, content in sorted((str(path), content) for path, content in seen.items()):
        digest.update(f"{path} {hashlib.sha256(content).hexdigest()}\n".encode())
    evolution = Evolution(
        source, spec, base, 1e3 * spec.mileage_km, points, table.read_text(encoding="utf-8"), shares, wheel, unworn,
        bin_edges(unworn, PLACE_STEP), setup, digest.hexdigest()[:32],
    )  # fmt: skip
    return evolution, tuple(seen)


def _check_bend(spec: EvolutionFile) -> None:
    """Refuse steps that dig waves too sharp for any contact: of smoothing_mm, between 0 and largest_depth_mm deep.

    Such a wave bends by depth / 2 (2 pi / length)^2. Raises InputError.
    """
    most = 1e3 * SHARPEST * 2.0 * (1e-3 * spec.smoothing_mm / (2.0 * np.pi)) ** 2
    if spec.largest_depth_mm > most:
        enough = np.ceil(2e4 * np.pi * np.sqrt(0.5e-3 * spec.largest_depth_mm / SHARPEST)) / 10.0
        raise InputError(
            f"one step could leave waves of smoothing_mm = {spec.smoothing_mm:g} that bend by more than "
            f"{SHARPEST:g} 1/m; must be at most {np.floor(1e4 * most) / 1e4:g} with them, "
            f"or smoothing_mm at least {enough:g}"
        )


def _weighted(points: AxisPoints) -> tuple[AxisPoints, tuple[float, ...]]:
    """Cases without their shares, and the shares. Raises InputError."""
    columns = list(points.columns)
    if SHARE not in columns:
        file = points.places[0].rpartition(":")[0]
        names = ", ".join(str(name) for name in columns)
        raise InputError(
            f'{file}: share is missing: needs a column "{SHARE}", the share of each case in the mileage; '
            f"its columns are {names}"
        )
    position = columns.index(SHARE)
    shares = []
    for place, row in zip(points.places, points.values, strict=True):
        share = row[position]
        if isinstance(share, bool) or not isinstance(share, int | float) or not 0.0 < share <= 1.0:
            raise InputError(f"{place}: {SHARE} = {share}: must be a number above 0, up to 1")
        shares.append(float(share))
    if abs(sum(shares) - 1.0) > WHOLE:
        raise InputError(f"{points.places[-1]}: {SHARE}: all of them add up to {sum(shares):.6g}; must be 1")
    keys = tuple(key for i, key in enumerate(points.keys) if i != position)
    if not keys:
        raise InputError(f"{points.places[0]}: no column varies a key; must be dotted keys such as vehicle.speed_kmh")
    for name in ("vehicle.wheel", "wear.laws"):
        if any(name in group for group in keys):
            raise InputError(f"{points.places[0]}: column {name}: the steps of wear set it; take it away")
    values = tuple(tuple(v for i, v in enumerate(row) if i != position) for row in points.values)
    return replace(points, keys=keys, values=values), tuple(shares)
