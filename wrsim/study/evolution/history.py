"""How wheels have worn: profiles, flange and conicity against the mileage, written and read again."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wrsim.analysis.conicity.conicity import wheelset_conicity
from wrsim.contact.profiles.flange import flange_dimensions
from wrsim.contact.profiles.profile import Profile
from wrsim.errors import InputError
from wrsim.plots.drawing import save_all
from wrsim.plots.wear import evolution_figures
from wrsim.results import write_atomically
from wrsim.results.dataset import faults_of_attributes, faults_of_variable, versions
from wrsim.results.files import EVOLUTION, as_csv, as_json
from wrsim.results.netcdf import write_netcdf
from wrsim.results.table import Column, Table, as_records, as_rows
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.study.collect import read_numbers
from wrsim.study.evolution.reading import Evolution
from wrsim.study.evolution.steps import DEPTHS, WHEEL, Step, write_wheel

FORMAT = "wrsim wear"
COLUMNS = {
    "mileage": ("mileage_km", 1e-3, "m", "mileage"),
    "flange_thickness": ("Sd_mm", 1e3, "m", "flange thickness Sd"),
    "flange_height": ("Sh_mm", 1e3, "m", "flange height Sh"),
    "flange_steepness": ("qR_mm", 1e3, "m", "flange steepness qR"),
    "conicity": ("conicity", 1.0, "1", "equivalent conicity"),
    "deepest": ("depth_mm", 1e3, "m", "largest depth worn off"),
    "deepest_u": ("depth_u_mm", 1e3, "m", "where that is"),
    "tread": ("tread_g_per_km", 1e6, "kg/m", "mass lost on the tread in the step that begins here"),
    "flange": ("flange_g_per_km", 1e6, "kg/m", "mass lost on the flange in the step that begins here"),
}
"""Numbers against the mileage: name in tables, factor, SI unit, meaning."""
PROFILES = {
    "u": (("point", "place"), "outward coordinate of the profile"),
    "w": (("point", "place"), "height of the profile"),
    "depth": (("point", "place"), "depth along the normal"),
    "unworn_u": (("place",), "outward coordinate of the unworn profile"),
}
"""Profiles [m]: dimensions, meaning."""
TABLE, REPORT, WORN = "wear.csv", "wear.json", "worn_"
OUTPUTS = (EVOLUTION, TABLE, REPORT, WORN + WHEEL, WORN + DEPTHS)


def wear_history(evolution: Evolution, steps: Sequence[Step]) -> xr.Dataset:
    """Profiles and numbers at the start of every step and at the end of the last one; dimensions point, place."""
    points: list[tuple[float, np.ndarray, Step | None]] = []
    lost = np.zeros(evolution.places.size - 1)
    for step in steps:  # what is lost before each of them
        points.append((step.start, lost, step))
        lost = np.array(step.areas)
    points.append((steps[-1].end if steps else 0.0, lost, None))
    middles = 0.5 * (evolution.places[1:] + evolution.places[:-1])
    origin = float(evolution.unworn.arclength_of(0.0))
    unworn = np.stack(evolution.unworn.at(middles))
    normal = np.stack(evolution.unworn.normal(middles))
    rows, depths = [], []
    for mileage, areas, following in points:
        table = evolution.table(areas)
        depth = np.zeros(middles.size) if table is None else table.at(middles - origin)[0]
        depths.append(depth)
        rows.append(_numbers(evolution, evolution.profile(areas), mileage, depth, unworn[0], following))
    places = np.stack([unworn[:, None, :] - normal[:, None, :] * np.stack(depths)])[0]
    variables: dict[str, Any] = {
        name: ("point", np.array([row[i] for row in rows]), {"units": unit, "long_name": meaning})
        for i, (name, (_, _, unit, meaning)) in enumerate(COLUMNS.items())
    }
    for (name, (dims, meaning)), values in zip(PROFILES.items(), (*places, np.stack(depths), unworn[0]), strict=True):
        variables[name] = (dims, values, {"units": "m", "long_name": meaning})
    attributes = {
        "format": FORMAT, "title": evolution.source.title, "law": evolution.spec.law, "wheel": evolution.unworn.name,
        "evolution_text": evolution.source.text, "cases_text": evolution.cases_text,
        "vehicle": evolution.setup.vehicle.name,
        "scenario_text": evolution.base.text.replace(str(evolution.wheel), evolution.spec.wheel),
        "conicity_amplitude_m": 1e-3 * evolution.spec.conicity_amplitude_mm,
    }  # fmt: skip
    return xr.Dataset(variables, attrs=attributes | versions())


def _numbers(
    evolution: Evolution, profile: Profile, mileage: float, depth: np.ndarray, u: np.ndarray, step: Step | None
) -> tuple[float, ...]:
    """The values of COLUMNS; step: the one that begins there."""
    nothing = float("nan")
    place = int(np.argmax(depth))
    try:
        flange = flange_dimensions(profile, 1e-3 * evolution.spec.flange_back_mm)
        sizes = flange.thickness, flange.height, flange.steepness
    except InputError:  # a cone has none
        sizes = nothing, nothing, nothing
    deepest = float(depth[place]), float(u[place]) if depth[place] > 0.0 else nothing
    lost = (nothing, nothing) if step is None else (step.tread, step.flange)
    return (mileage, *sizes, _conicity(evolution, profile), *deepest, *lost)


def _conicity(evolution: Evolution, profile: Profile) -> float:
    """Equivalent conicity of the wheelset on the rails of the base scenario; not-a-number where it does not swing."""
    setup = evolution.setup
    new = setup.wheelset
    wheelset = replace(new, left=replace(new.left, profile=profile), right=replace(new.right, profile=profile))
    plan = ConicityPlan(amplitudes=(1e-3 * evolution.spec.conicity_amplitude_mm,))
    try:
        result = wheelset_conicity(wheelset, setup.rails, setup.track.nominal_gauge, plan, evolution.source.title)
    except InputError:
        return float("nan")
    return float(result.dataset["equivalent_conicity"].values.ravel()[0])


def write_history(
    evolution: Evolution, steps: Sequence[Step], directory: Path, pictures: bool
) -> tuple[xr.Dataset, list[Path]]:
    """Write the history, the worn wheel as a model file, and pictures into the folder of a profile evolution."""
    dataset = wear_history(evolution, steps)
    files = [
        write_netcdf(directory / EVOLUTION, dataset),
        write_atomically(directory / TABLE, as_csv(as_rows(mileage_table(dataset)))),
        write_atomically(directory / REPORT, as_json(evolution_report(dataset))),
    ]
    if steps:
        areas, label = np.array(steps[-1].areas), f"{1e-3 * steps[-1].end:.6g} km"
        wheel = write_wheel(evolution, directory, areas, label, WORN)
        files += [wheel] if wheel != evolution.wheel else []
    if pictures:
        files += save_all(evolution_figures(dataset), directory)
    return dataset, files


def read_history(path: Path) -> xr.Dataset:
    """The dataset of a profile evolution, from its folder or its ``wear.nc``. Raises InputError for anything else."""
    return read_numbers(path, EVOLUTION, FORMAT, "profile evolution", _faults)


def _faults(dataset: xr.Dataset) -> Iterator[str]:
    """What is wrong with the dataset of a profile evolution; see `history`."""
    yield from faults_of_attributes(dataset.attrs, ("title", "law"))
    layout = dict.fromkeys(COLUMNS, ("point",)) | {name: dims for name, (dims, _) in PROFILES.items()}
    for name, dims in layout.items():
        yield from faults_of_variable(dataset, name, dims, "number")
    if 0 in dataset.sizes.values():
        yield "holds no numbers"
    for name in ("mileage", *PROFILES):
        if not np.isfinite(dataset[name].values).all():
            yield f"its {name} is not finite everywhere"


def mileage_table(dataset: xr.Dataset) -> Table:
    """Numbers against the mileage, in units for readers."""
    columns = []
    for column, _, _, _ in COLUMNS.values():
        heading, _, unit = column.replace("depth_u", "at u").partition("_")
        columns.append(Column(heading, unit.replace("_per_", "/"), ".5g", column))
    rows = [
        [factor * float(dataset[name].values[i]) for name, (_, factor, _, _) in COLUMNS.items()]
        for i in range(dataset.sizes["point"])
    ]
    return Table(str(dataset.attrs["title"]), tuple(columns), rows)


def evolution_report(dataset: xr.Dataset) -> dict[str, Any]:
    """Content of ``wear.json``: title, law, the numbers at the start and at the end."""
    records = as_records(mileage_table(dataset))
    ends = {"new": records[0], "worn": records[-1]}
    return {"title": dataset.attrs["title"], "law": dataset.attrs["law"], "steps": dataset.sizes["point"] - 1} | ends
