"""The same poses or the same run by several contact models, side by side: differences, tables, times.

What is compared belongs to a wheel, since models may split the contact into patches differently: sums and extremes
over its patches, and the angle of the largest one. Samples are those of the reference; other runs are interpolated to
them in time.
"""

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import pi
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.special import elliprd, elliprf

from wrsim.analysis import run
from wrsim.analysis.contacts import contact_models
from wrsim.analysis.progress import Progress, Report
from wrsim.contact.channels import POSE_CHANNELS
from wrsim.contact.settings import Array
from wrsim.contact.tables import combined_modulus
from wrsim.errors import InputError, SimulationError, suggest
from wrsim.inputs.section import SIDES
from wrsim.register import ANALYSES
from wrsim.results import CHANNELS, Result
from wrsim.results.summary_tables import first_lines, happened, remarks
from wrsim.results.table import MISSING, Cell, Column, Table, csv_numbers, formatted
from wrsim.results.tables import channel_cells, rows_of
from wrsim.results.wheelsets import of_wheelset, wheelsets
from wrsim.scenario.build import Setup, build
from wrsim.scenario.contact_choice import HERTZ, with_contact_model
from wrsim.scenario.loading import Scenario
from wrsim.scenario.sections.run import RunPlan


class Measure(NamedTuple):
    """What a difference is divided by, factor and unit in which it is given."""

    label: str
    factor: float
    unit: str
    symbol: str


RELATIVE = Measure("relative", 100.0, "percent", "%")
NORMAL_FORCE = Measure("of the normal force", 100.0, "percent", "% of N")
PLAIN = Measure("plain", 180.0 / pi, "deg", "°")
DIFFERENCES = {
    "N": RELATIVE,
    "p0": RELATIVE,
    "area": RELATIVE,
    "approach": RELATIVE,
    "contact_angle": PLAIN,
    "contact_angle_variation": PLAIN,
    "X": NORMAL_FORCE,
    "Y": NORMAL_FORCE,
    "Q": NORMAL_FORCE,
    "T_gamma": RELATIVE,
}
"""Quantities that are compared, and what their difference is divided by."""

SHOWN = ("p0", "area", "approach", "N", "contact_angle", "X", "Y", "T_gamma")  # quantities in the table on the screen
FEW = 4  # poses and wheels of a small comparison, whose values are printed one by one

TIMED_MOMENTS = 8
TIMED = 0.02  # least time of one measurement [s]

RATIO = 8.0  # largest logarithm of a ratio of axes: beyond, a contact is a line


@dataclass(frozen=True)
class Compared:
    """One model: its name, its result, the time of the whole analysis and of one contact of one wheel [s]."""

    name: str
    result: Result
    run_time: float
    evaluation_time: float


@dataclass(frozen=True)
class Comparison:
    """Models and what they make of the same scenario; ``reference``: the reference model.

    values: dims (model, sample, wheel), ``sample`` those of the reference: every quantity of ``DIFFERENCES`` in SI
    units, and ``<quantity>_difference`` as a ratio, or in SI units where it is plain.
    """

    models: tuple[Compared, ...]
    reference: str
    values: xr.Dataset

    @property
    def main(self) -> Compared:
        """The reference."""
        return next(m for m in self.models if m.name == self.reference)

    def remarks(self, model: Compared) -> list[str]:
        """Events and remarks of a model; of Hertz' ellipses what they are."""
        if model.name == HERTZ:
            base = _base_of([each.name for each in self.models], self.reference)
            return [f'ellipses at N, contact point and curvatures of "{base}"; no creep forces']
        summary = model.result.summary()
        return happened(summary) + remarks(summary)


def compare_models(
    scenario: Scenario, names: Sequence[str], reference: str | None = None, progress: Progress | None = None
) -> Comparison:
    """Analyse a scenario with several contact models (names as in `scenario.contact_choice`, and ``HERTZ``).

    reference: one of the names, the first unless given. Raises InputError for names that are no models, before
    anything is computed; SimulationError, with the model's name, when one has no result at all.
    """
    if len(names) < 2:
        raise InputError(f"--contact {','.join(names)}: needs two models at least, such as kik-piotrowski,half-space")
    reference = names[0] if reference is None else reference
    if reference not in names:
        raise InputError(f"--reference {reference}: is none of the models{suggest(reference, list(names))}")
    if not ANALYSES[scenario.analysis].compared:
        raise InputError(f'analysis = "{scenario.analysis}": contact models are compared in static poses and runs')
    scenarios = {name: with_contact_model(scenario, name) for name in names if name != HERTZ}
    setups = {name: build(changed) for name, changed in scenarios.items()}
    base = _base_of(names, reference)
    if HERTZ in names and any(surface is not None for surface in setups[base].surfaces):
        raise InputError(f'model "{HERTZ}": is for rails of one profile; those of the scenario change along the track')
    report, models = Report(progress), dict[str, Compared]()
    for i, (name, setup) in enumerate(setups.items()):

        def share(done: float, left: float, before: int = i) -> None:
            """Progress of all models together; the time left as if the others took as long."""
            report((before + done) / len(setups))

        _load(scenarios[name], setup)
        start = time.perf_counter()
        try:
            result = run(scenarios[name], progress=share, setup=setup)
        except SimulationError as error:
            raise SimulationError(f'model "{name}": {error}') from None
        taken = time.perf_counter() - start
        models[name] = Compared(name, result, taken, time_evaluation(setup, result.dataset))
    if HERTZ in names:
        start = time.perf_counter()
        ellipses = hertz_contacts(setups[base], models[base].result.dataset)
        models[HERTZ] = Compared(HERTZ, Result(ellipses), time.perf_counter() - start, np.nan)
    ordered = [models[name] for name in names]
    return Comparison(tuple(ordered), reference, _values(ordered, reference))


def _base_of(names: Sequence[str], reference: str) -> str:
    """The model on whose contacts Hertz' ellipses are: the reference, or the first other one."""
    return next(name for name in (reference, *names) if name != HERTZ)


def _load(scenario: Scenario, setup: Setup) -> None:
    """Load what an analysis needs by a short one, so that its own time counts; exact runs take far longer."""
    plan: Any = setup.plan
    if isinstance(plan, RunPlan):
        if setup.contact.normal == "half-space":
            return
        end = min(plan.end, plan.start + 2.0 * plan.speed * plan.output_interval)
        plan = replace(plan, end=end, patches_at=(), wear=None)
    else:
        plan = replace(plan, poses=plan.poses[:1])
    with suppress(SimulationError):
        run(scenario, setup=replace(setup, plan=plan))


def hertz_contacts(setup: Setup, dataset: xr.Dataset) -> xr.Dataset:
    """Hertz' ellipses of all patches of a result: p0, area, approach, width and length at their normal forces.

    Curvatures: across, of both profiles at the contact point; along, of the wheel there. With Carlson's integrals
    (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.3). Not-a-number without a curvature across, and for forces of
    other directions than the normal one.
    """
    ellipses = dataset.drop_vars([name for name in dataset.variables if str(name).startswith("strip_")]).copy(deep=True)
    for name in ("X", "Y", "Q", "T_gamma"):
        ellipses[name] = np.nan * ellipses[name]
    for i in range(dataset.sizes["wheelset"]):
        wheelset = setup.vehicle.wheelsets[i].wheelset
        for j, side in enumerate(dataset["wheel"].values):
            wheel, rail = getattr(wheelset, side), setup.rails[SIDES.index(side)]
            solved = np.isfinite(dataset["N"].values[:, i, j])
            N, u, v, angle = (dataset[n].values[:, i, j][solved] for n in ("N", "u_wheel", "u_rail", "contact_angle"))
            arc, arc_rail = wheel.profile.arclength_of(u), rail.arclength_of(v)
            along = np.cos(angle) / (wheel.radius - wheel.profile.at(arc)[1])
            along += 0.0 if setup.roller is None else 1.0 / setup.roller
            across = wheel.profile.curvature(arc) - rail.curvature(arc_rail)
            for name, values in _ellipses(N, along, across, combined_modulus(setup.contact)).items():
                ellipses[name].values[:, i, j][solved] = values
            for name in ("contact_angle_min", "contact_angle_max"):
                ellipses[name].values[:, i, j] = dataset["contact_angle"].values[:, i, j]
    return ellipses


def _ellipses(N: Array, along: Array, across: Array, modulus: float) -> dict[str, Array]:
    """Hertz' contacts (n,) of curvatures, sums of both bodies [1/m], at forces [N]; half axes a along, b across."""
    with np.errstate(invalid="ignore", divide="ignore"):
        wanted = np.log(np.where(across > 0.0, across, np.nan) / along)
        low, high = np.full(N.shape, -RATIO), np.full(N.shape, RATIO)  # of ln(b/a)
        for _ in range(50):
            middle = 0.5 * (low + high)
            k2 = np.exp(2.0 * middle)
            wider = np.log(elliprd(0.0, 1.0, k2) / elliprd(0.0, k2, 1.0)) > wanted
            low, high = np.where(wider, middle, low), np.where(wider, high, middle)
        k = np.exp(middle) + 0.0 * wanted  # not-a-number where there is no ellipse
        a = np.cbrt(N * elliprd(0.0, k * k, 1.0) / (pi * modulus * along))
        p0 = 1.5 * N / (pi * a * a * k)
    approach = p0 * a * k * elliprf(0.0, 1.0, k * k) / modulus
    return {"p0": p0, "area": pi * a * a * k, "approach": approach, "length": 2.0 * a, "width": 2.0 * a * k}


def of_wheels(dataset: xr.Dataset) -> xr.Dataset:
    """The quantities of ``DIFFERENCES`` (sample, wheel) in SI units; not-a-number without contact.

    Wheels are "left" and "right", or "front.outer left" where there are several wheelsets.
    """
    d, names = dataset, wheelsets(dataset)
    quantities = {
        "N": d["N"].sum("patch", min_count=1),
        "p0": d["p0"].max("patch"),
        "area": d["area"].sum("patch", min_count=1),
        "approach": d["approach"].max("patch"),
        "contact_angle": d["contact_angle"].isel(patch=0),
        "contact_angle_variation": d["contact_angle_max"].max("patch") - d["contact_angle_min"].min("patch"),
    }
    quantities |= {name: d[name] for name in ("X", "Y", "Q", "T_gamma")}
    sample = "time" if "time" in d.dims else "pose"
    sides = [str(side) for side in d["wheel"].values]
    labels = [f"{name} {side}" for name in names for side in sides] if len(names) > 1 else sides
    arrays = {name: ((sample, "wheel"), a.values.reshape(d.sizes[sample], -1)) for name, a in quantities.items()}
    return xr.Dataset(arrays, {sample: d[sample].values, "wheel": labels})


def time_evaluation(setup: Setup, dataset: xr.Dataset) -> float:
    """Time of one contact of one wheel of the first wheelset [s]: median over some snapshots; nan without any."""
    dataset = of_wheelset(dataset, wheelsets(dataset)[0])
    if not all(name in dataset for name in POSE_CHANNELS):
        return np.nan
    models = dict(zip(("left", "right"), contact_models(setup), strict=True))
    poses = np.concatenate([dataset[name].values for name in POSE_CHANNELS], axis=-1)
    moments = np.flatnonzero(np.isfinite(poses).all(axis=(1, 2)))
    times = []
    for moment in moments[np.unique(np.linspace(0, max(len(moments) - 1, 0), TIMED_MOMENTS).astype(int))]:
        for wheel, pose in zip(dataset["wheel"].values, poses[moment], strict=True):
            model = models[str(wheel)]
            model.arrays.pose[:] = pose
            model.solve()
            count, began = 0, time.perf_counter()
            while (taken := time.perf_counter() - began) < TIMED:
                model.solve()
                count += 1
            times.append(taken / count)
    return float(np.median(times)) if times else np.nan


def _values(models: Sequence[Compared], reference: str) -> xr.Dataset:
    """Quantities and differences of all models at the samples of the reference."""
    base = next(m for m in models if m.name == reference).result.dataset
    reference_values, sample = of_wheels(base), "time" if "time" in base.dims else "pose"
    names = xr.Variable("model", [m.name for m in models])
    values = xr.concat([_at_samples(m.result.dataset, reference_values) for m in models], names, join="exact")
    for quantity, kind in DIFFERENCES.items():
        expected = reference_values[quantity]
        scale = {RELATIVE: expected, NORMAL_FORCE: reference_values["N"], PLAIN: xr.ones_like(expected)}[kind]
        values[f"{quantity}_difference"] = (values[quantity] - expected) / scale.where(np.abs(scale) > 0.0)
    if len(wheelsets(base)) == 1:
        base = of_wheelset(base)
    context = [n for n in ("distance", "lateral_shift", "yaw", "load") if n in base.variables]
    return values.assign_coords({n: (sample, base[n].values) for n in context if base[n].dims == (sample,)})


def _at_samples(dataset: xr.Dataset, reference: xr.Dataset) -> xr.Dataset:
    """A model's quantities at the reference's samples; not-a-number beyond its end and where a pose is unsolved."""
    values = of_wheels(dataset)
    if "pose" in dataset.dims:
        return values.where(dataset["pose_message"] == "").reindex(pose=reference["pose"].values)
    times, wanted = dataset["time"].values, reference["time"].values
    if times.size == wanted.size and np.allclose(times, wanted, rtol=0.0, atol=1e-9):
        return values.assign_coords(time=wanted)
    beyond = wanted > times[-1] + 1e-9

    def at_wanted(column: Array) -> Array:
        return np.where(beyond, np.nan, np.interp(wanted, times, column))

    arrays = {name: (("time", "wheel"), np.apply_along_axis(at_wanted, 0, a.values)) for name, a in values.items()}
    return xr.Dataset(arrays, reference.coords)


def comparison_report(comparison: Comparison, scenario: str) -> dict[str, Any]:
    """Everything in numbers: differences in per cent or degrees, times in microseconds and seconds."""
    models = {}
    for model in comparison.models:
        differences = {}
        for quantity, measure in DIFFERENCES.items():
            off = np.abs(comparison.values[f"{quantity}_difference"].sel(model=model.name).values)
            if (off := off[np.isfinite(off)]).size:
                spread = zip(("median", "p95", "max"), np.quantile(off, (0.5, 0.95, 1.0)).tolist(), strict=True)
                differences[f"{quantity}_{measure.unit}"] = {name: measure.factor * value for name, value in spread}
        dataset = model.result.dataset
        unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
        models[model.name] = {
            "status": model.result.status,
            "unsolved_poses": unsolved,
            "remarks": comparison.remarks(model),
            "evaluation_us": None if model.evaluation_time != model.evaluation_time else 1e6 * model.evaluation_time,
            "run_s": model.run_time,
            "differences": differences,
        }
    kinds = {quantity: kind.label for quantity, kind in DIFFERENCES.items() if kind != PLAIN}
    return {"scenario": scenario, "reference": comparison.reference, "relative_to": kinds, "models": models}


def rows_of_samples(comparison: Comparison) -> list[list[str]]:
    """One row per sample, wheel and model; the first is the header. Differences in per cent or degrees."""
    values = comparison.values
    sample = "time" if "time" in values.dims else "pose"
    i, j, m = (index.ravel() for index in np.indices([values.sizes[d] for d in (sample, "wheel", "model")]))
    context = [n for n in (sample, "distance", "lateral_shift", "yaw", "load") if n in values.coords]
    columns = [(CHANNELS[n].column, channel_cells(n, values[n].values[i])) for n in context]
    columns += [("wheel", list(values["wheel"].values[j])), ("model", list(values["model"].values[m]))]
    columns += [(CHANNELS[q].column, channel_cells(q, values[q].values[m, i, j])) for q in DIFFERENCES]
    for q, kind in DIFFERENCES.items():
        difference = values[f"{q}_difference"].values[m, i, j]
        columns.append((f"{q}_difference_{kind.unit}", csv_numbers((kind.factor * difference).tolist())))
    return rows_of(columns)


def comparison_tables(comparison: Comparison, report: dict[str, Any]) -> list[Table]:
    """The values when they are few, differences and times; a column for every model."""
    values, models = comparison.values, report["models"]
    sample = "time" if "time" in values.dims else "pose"
    rows: list[list[Cell]] = []
    if values.sizes[sample] * values.sizes["wheel"] <= FEW:
        for i, place in enumerate(values[sample].values):
            for j, wheel in enumerate(values["wheel"].values):
                rows.append([f"{place} {wheel}" if sample == "pose" else str(wheel)])
                for q in SHOWN:
                    numbers = values[q].values[:, i, j] * CHANNELS[q].shown.factor
                    rows.append([CHANNELS[q].column, *map(float, numbers)])
    rows.append(["difference, median / 95 %"])
    for q in SHOWN:
        cells = [model["differences"].get(f"{q}_{DIFFERENCES[q].unit}") for model in models.values()]
        spread = [
            MISSING if c is None else f"{formatted(c['median'], '.2g')} / {formatted(c['p95'], '.2g')}" for c in cells
        ]
        marked = [("reference" if n == comparison.reference else cell) for n, cell in zip(models, spread, strict=True)]
        rows.append([f"{q} ({DIFFERENCES[q].symbol})", *marked])
    rows += [["time"], ["one contact (µs)", *(model["evaluation_us"] for model in models.values())]]
    rows.append(["all (s)", *(model["run_s"] for model in models.values())])
    notes = []
    for name, model in models.items():
        if model["unsolved_poses"]:
            notes.append(f"{name}: {model['unsolved_poses']} poses without a solution")
        notes += first_lines([f"{name}: {remark}" for remark in model["remarks"]], "remarks")
    return [Table("", (Column(), *(Column(name, "", ".5g") for name in models)), rows, tuple(notes))]
