"""Errors of the time step in micrometres and newtons: runs beside the same runs solved far more tightly.

Run: python campaigns/step_error.py [REFERENCE] [--write FOLDER] [CASE ...]

The tight run is RK44 with contacts solved to 1e-9 of their depth, in the short steps of ``CASES``; steps twice as long
show how tight it is. Differences are those of the samples of a run, unfiltered: lateral shift and yaw of
every wheelset, N, Q and Y of every wheel. --write: rows go to step_error.csv there, in place of those of the same
cases.

REFERENCE: folder of reference tables; gz18 needs its profiles and irregularities, and runs as in the comparison of
integrators of ORVD: R 300 m on AAR5 at 60 km/h, over 16 s.
"""

import argparse
import csv
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from campaigns import gz18
from wrsim.analysis import run
from wrsim.results import Result
from wrsim.scenario.loading import Scenario, load

SCENARIOS = Path(__file__).parents[1] / "scenarios"
CASES: dict[str, tuple[str, dict[str, Any], int]] = {
    "coach": ("manchester_r300.toml", {"run.start_distance_m": 20.0, "run.distance_m": 60.0}, 250),
    "coach-erri-low": ("manchester_ride_160.toml", {"run.distance_m": 100.0}, 250),
    "freight": ("freight_r300_laden.toml", {"run.distance_m": 50.0}, 125),
    "tram": ("tram_car_r25.toml", {"run.distance_m": 8.0}, 50),
    "gz18": ("", {"run.distance_m": 260.0}, 125),
}
"""Scenario, keys and step [us] of the tight run of a case: at low speed RK44 is stable with short ones only."""
FINER_US = (1000, 500)
"""Steps of generalised alpha beside the default one."""
QUANTITIES = {
    "lateral": ("lateral_shift", 1e6, "um"), "yaw": ("yaw", 1e6, "urad"), "N": ("N", 1.0, "N"), "Q": ("Q", 1.0, "N"),
    "Y": ("Y", 1.0, "N"),
}  # fmt: skip
"""Channel, factor from SI units and unit of what is compared."""
COLUMNS = ("case", "method", "step_us", "evaluations", "quantity", "unit", "rms_least", "rms_most", "rms", "max")
"""rms_least, rms_most: of the wheelsets or wheels; rms: of all together."""


def scenario_of(case: str, reference: Path | None, folder: Path) -> Scenario:
    """The case; files of profiles go to ``folder``."""
    file, keys, _ = CASES[case]
    keys = {"output.patches_at_m": []} | keys
    if file:
        return load(SCENARIOS / file).with_values(keys)
    if reference is None:
        raise SystemExit(f"{case}: needs REFERENCE, the folder of reference tables")
    uneven = {"track.irregularities": [gz18.irregularity(reference, folder, "aar5")]}
    return gz18.scenario(reference, folder, "r300", uneven | keys)


def series(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Quantities (sample, wheelset or wheel) in the units of ``QUANTITIES``."""
    quantities = {}
    for name, (channel, factor, _) in QUANTITIES.items():
        values = dataset[channel].sum("patch") if "patch" in dataset[channel].dims else dataset[channel]
        quantities[name] = factor * values.values.reshape(dataset.sizes["time"], -1)
    return quantities


def differences(result: Result, tight: Result) -> dict[str, list[float]]:
    """rms of the wheelset or wheel with the least and the largest, of all, and the largest difference."""
    coarse, fine = result.dataset, tight.dataset
    if coarse.attrs["status"] != "completed" or not np.allclose(coarse["time"], fine["time"], rtol=0.0, atol=1e-9):
        raise SystemExit(f"{coarse.attrs['title']}: has stopped, or the samples of the runs differ")
    expected, errors = series(fine), {}
    for name, values in series(coarse).items():
        off = values - expected[name]
        each = np.sqrt((off**2).mean(0))
        errors[name] = [each.min(), each.max(), np.sqrt((off**2).mean()), np.abs(off).max()]
    return errors


def errors(case: str, reference: Path | None, folder: Path) -> list[list[str]]:
    """Rows of ``COLUMNS``: the default step, finer ones, and the tight run with twice its step."""
    scenario = scenario_of(case, reference, folder)
    rows = []
    tight = run(scenario.with_values({"run.integrator": "rk44", "run.step_us": CASES[case][2]}))
    steps: list[tuple[str, int | None]] = [("rk44", 2 * CASES[case][2]), ("default", None)]
    for method, step in [*steps, *(("generalised-alpha", step) for step in FINER_US)]:
        keys = {} if step is None else {"run.step_us": step, "run.integrator": method}
        result = run(scenario.with_values(keys))
        attributes = result.dataset.attrs
        head = [case, method, f"{1e6 * attributes['step_s']:g}", str(attributes["evaluations"])]
        for name, numbers in differences(result, tight).items():
            rows.append([*head, name, QUANTITIES[name][2], *(f"{number:.3g}" for number in numbers)])
            print(",".join(rows[-1]), flush=True)
    return rows


def main() -> None:
    """Print the rows, and write them."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("arguments", nargs="*", metavar="[REFERENCE] [CASE ...]")
    parser.add_argument("--write", type=Path)
    chosen = parser.parse_intermixed_args()
    cases = [name for name in chosen.arguments if name in CASES] or list(CASES)
    folders = [name for name in chosen.arguments if name not in CASES]
    reference = gz18.reference_folder(folders[0]) if folders else None
    print(",".join(COLUMNS))
    for case in cases:
        with tempfile.TemporaryDirectory() as folder:
            rows = errors(case, reference, Path(folder))
        if chosen.write is not None:
            file = chosen.write / "step_error.csv"
            known = list(csv.reader(file.open(newline="")))[1:] if file.is_file() else []
            rows += [row for row in known if row[0] != case]
            rows.sort(key=lambda row: list(CASES).index(row[0]))
            with file.open("w", newline="") as stream:
                csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *rows])


if __name__ == "__main__":
    main()
