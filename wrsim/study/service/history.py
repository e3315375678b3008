"""How wheels have worn: profiles, flange and conicity against the mileage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wrsim.analysis.conicity.conicity import conicity
from wrsim.errors import InputError
from wrsim.geometry.profile.flange import flange_dimensions
from wrsim.geometry.profile.profile import Profile
from wrsim.plots.drawing import save_all
from wrsim.plots.wear import service_figures
from wrsim.results import write_atomically
from wrsim.results.dataset import versions
from wrsim.results.files import as_csv, as_json
from wrsim.results.netcdf import write_netcdf
from wrsim.results.render import as_rows
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.study.service.record import COLUMNS, FORMAT, NUMBERS, report_of, table_of
from wrsim.study.service.service import Service
from wrsim.study.service.steps import DEPTHS, WHEEL, Step, write_wheel

TABLE, REPORT, WORN = "wear.csv", "wear.json", "worn_"
OUTPUTS = (NUMBERS, TABLE, REPORT, WORN + WHEEL, WORN + DEPTHS)


def history(service: Service, steps: Sequence[Step]) -> xr.Dataset:
    """Profiles and numbers at the start of every step and at the end of the last one; dimensions point, place."""
    points: list[tuple[float, np.ndarray, Step | None]] = []
    lost = np.zeros(service.places.size - 1)
    for step in steps:  # what is lost before each of them
        points.append((step.start, lost, step))
        lost = np.array(step.areas)
    points.append((steps[-1].end if steps else 0.0, lost, None))
    middles = 0.5 * (service.places[1:] + service.places[:-1])
    origin = float(service.unworn.arclength_of(0.0))
    unworn = np.stack(service.unworn.at(middles))
    normal = np.stack(service.unworn.normal(middles))
    rows, depths = [], []
    for mileage, areas, own in points:
        table = service.table(areas)
        depth = np.zeros(middles.size) if table is None else table.at(middles - origin)[0]
        depths.append(depth)
        rows.append(_numbers(service, service.profile(areas), mileage, depth, unworn[0], own))
    places = np.stack([unworn[:, None, :] - normal[:, None, :] * np.stack(depths)])[0]
    variables: dict[str, Any] = {
        name: ("point", np.array([row[name] for row in rows]), {"units": unit, "long_name": words})
        for name, (_, _, unit, words) in COLUMNS.items()
    }
    variables |= {
        "u": (("point", "place"), places[0], {"units": "m", "long_name": "outward coordinate of the profile"}),
        "w": (("point", "place"), places[1], {"units": "m", "long_name": "height of the profile"}),
        "depth": (("point", "place"), np.stack(depths), {"units": "m", "long_name": "depth along the normal"}),
        "unworn_u": ("place", unworn[0], {"units": "m", "long_name": "outward coordinate of the unworn profile"}),
    }
    about = {"format": FORMAT, "title": service.given.title, "law": service.law, "wheel": service.unworn.name}
    about |= {"service_text": service.given.text, "cases_text": service.cases_text, "scenario_text": service.base.text}
    return xr.Dataset(
        variables, attrs=about | {"conicity_amplitude_m": 1e-3 * service.spec.conicity_amplitude_mm} | versions()
    )


def _numbers(
    service: Service, profile: Profile, mileage: float, depth: np.ndarray, u: np.ndarray, step: Step | None
) -> dict[str, float]:
    """One row of the table."""
    nothing = float("nan")
    at = int(np.argmax(depth))
    try:
        flange = flange_dimensions(profile, 1e-3 * service.spec.flange_back_mm)
        sizes = flange.thickness, flange.height, flange.steepness
    except InputError:  # a cone has none
        sizes = nothing, nothing, nothing
    return {
        "mileage": mileage,
        "flange_thickness": sizes[0],
        "flange_height": sizes[1],
        "flange_steepness": sizes[2],
        "conicity": _conicity(service, profile),
        "deepest": float(depth[at]),
        "deepest_u": float(u[at]) if depth[at] > 0.0 else nothing,
        "tread": nothing if step is None else step.tread,
        "flange": nothing if step is None else step.flange,
    }


def _conicity(service: Service, profile: Profile) -> float:
    """Equivalent conicity of the wheelset on the rails of the service; not-a-number where it does not swing."""
    setup = service.setup
    own = setup.wheelset
    wheelset = replace(own, left=replace(own.left, profile=profile), right=replace(own.right, profile=profile))
    plan = ConicityPlan(amplitudes=(1e-3 * service.spec.conicity_amplitude_mm,))
    try:
        found = conicity(wheelset, setup.rails, setup.track.nominal_gauge, plan, service.given.title)
    except InputError:
        return float("nan")
    return float(found.dataset["equivalent_conicity"].values.ravel()[0])


def write_history(
    service: Service, steps: Sequence[Step], directory: Path, pictures: bool
) -> tuple[xr.Dataset, list[Path]]:
    """Write the history, the worn wheel as a model file, and pictures into the folder of a service."""
    dataset = history(service, steps)
    files = [
        write_netcdf(directory / NUMBERS, dataset),
        write_atomically(directory / TABLE, as_csv(as_rows(table_of(dataset)))),
        write_atomically(directory / REPORT, as_json(report_of(dataset))),
    ]
    if steps:
        areas, label = np.array(steps[-1].areas), f"{1e-3 * steps[-1].end:.6g} km"
        wheel = write_wheel(service, directory, areas, label, WORN)
        files += [wheel] if wheel != service.wheel else []
    if pictures:
        files += save_all(service_figures(dataset), directory)
    return dataset, files
