"""The GZ18 metro car on the wheel, rail and irregularities of its source, which are not part of this repository.

Run: python campaigns/gz18.py REFERENCE [--json] [MODEL ...]. How fast it runs through the curve of 300 m with AAR5
irregularities at 60 km/h: simulated over processor time of the integration, least of the repetitions, one core; beside
that of Kik-Piotrowski with RK44 at 0.5 ms in the same process.

REFERENCE: folder of reference tables; those of this car lie in ``gz18``. Their axes are y right, z down; here they
become ours.
"""

import gzip
import json
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.run import chosen_step
from wrsim.analysis.motion.start import start_state
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario, load
from wrsim.simulation.integrate import Integration
from wrsim.simulation.system import BodySystem

ROOT = Path(__file__).parents[1]
RUN_M = 150.0
REPETITIONS = 2
REFERENCE = "kik-piotrowski, rk44"
KIK_PIOTROWSKI = {"contact.normal": "kik-piotrowski", "contact.strips": 25}
CASES: dict[str, dict[str, Any]] = {
    REFERENCE: KIK_PIOTROWSKI | {"run.integrator": "rk44", "run.step_us": 500},
    "kik-piotrowski": KIK_PIOTROWSKI,
    "strips": {"contact.normal": "strips"},
}
"""Keys of the models that are timed."""

CANT_MM = {"r300": 120.0, "r600": 100.0, "r800": 110.0}
"""The lines of the source by their names, which say the radius [m]."""

PROFILE = """\
name = "{name}"
body = "{body}"
kind = "points"
date = 2026-11-22
source = "ORVD 4706df9"
file = "{file}"
format = "columns"
measured = false
unit = "mm"
heights = "down"
field_side = "positive"
"""
RAIL = "rail_profile_uic60_right.csv"


def reference_folder(argument: str) -> Path:
    """The folder of reference tables that an argument names; ends the program where those of this car are missing."""
    folder = Path(argument)
    if not (folder / "gz18").is_dir():
        raise SystemExit(f"{folder}: must be the folder of reference tables; it has no folder gz18")
    return folder.resolve()


def _profiles(reference: Path, folder: Path, car: str) -> dict[str, str]:
    """Profile files of wheel and rail, written to ``folder``."""
    files = {}
    for body, file in {"wheel": f"wheel_profile_{car}_right.csv", "rail": RAIL}.items():
        place = folder / f"{car}_{body}.toml"
        place.write_text(PROFILE.format(name=f"{body} of the source", body=body, file=reference / "gz18" / file))
        files[body] = str(place)
    return files


def scenario(
    reference: Path, folder: Path, line: str = "r300", values: Mapping[str, Any] | None = None, car: str = "gz18"
) -> Scenario:
    """The shipped scenario of a car with the profiles of the source, on one of its lines; files go to ``folder``."""
    keys: dict[str, Any] = {
        "track.segments": [
            {"kind": "straight", "length_m": 50.0},
            {"kind": "transition", "length_m": 50.0, "form": "bloss"},
            {"kind": "arc", "radius_m": -float(line[1:]), "length_m": 500.0, "cant_mm": CANT_MM[line]},
            {"kind": "transition", "length_m": 50.0, "form": "bloss"},
            {"kind": "straight", "length_m": 450.0},
        ]
    }
    files = _profiles(reference, folder, car)
    keys |= {"vehicle.wheel": files["wheel"], "track.rail": files["rail"]}
    return load(ROOT / "scenarios" / f"{car}_r300.toml").with_values(keys | dict(values or {}))


STEADY = """\
title = "{car} in a steady curve"
analysis = "steady"
[vehicle]
model = "vehicles/{car}.toml"
wheel = "{wheel}"
[track]
gauge_mm = 1435
gauge_depth_mm = 16
rail = "{rail}"
inclination = "1:40"
[contact]
cells = 12
friction = {{ static = 0.3, falling_ratio = 0.4, falling_decay_s_per_m = 0.55 }}
[steady]
radius_m = -{radius}
cant_mm = {cant}
speed_kmh = 59.9
"""


def steady(
    reference: Path, folder: Path, line: str = "r300", values: Mapping[str, Any] | None = None, car: str = "gz18"
) -> Scenario:
    """A car in the full curve of a line, at the speed that is left there in the source; files go to ``folder``."""
    place = folder / f"{car}_{line}.toml"
    place.write_text(STEADY.format(**_profiles(reference, folder, car), car=car, radius=line[1:], cant=CANT_MM[line]))
    return load(place).with_values(dict(values or {}))


def irregularity(reference: Path, folder: Path, name: str) -> dict[str, Any]:
    """An entry of [[track.irregularities]] of a table of the source (aar5, aar6): its rows in our axes and columns."""
    with gzip.open(reference / "gz18" / f"irregularity_{name}.csv.gz", "rt") as file:
        distance, right, down = np.loadtxt(file, delimiter=",", skiprows=1).T
    place = folder / f"{name}.csv"
    rows = np.column_stack([distance, -right, -down])
    np.savetxt(place, rows, delimiter=",", header="distance_m,alignment_mm,level_mm", comments="", fmt="%.9g")
    return {"kind": "table", "file": str(place), "fade_m": 0.1}


def timed(reference: Path, folder: Path, values: Mapping[str, Any]) -> dict[str, float]:
    """Times real time, step [ms] and evaluations a step of a run from smooth into uneven parts of the curve."""
    uneven = {"track.irregularities": [irregularity(reference, folder, "aar5")], "run.start_distance_m": 150.0}
    setup = build(scenario(reference, folder, "r300", uneven | {"run.distance_m": RUN_M} | values))
    plan = setup.plan
    best, result = np.inf, {}
    for _ in range(REPETITIONS):
        law = force_law(setup)
        system = BodySystem(law.bodies, law)
        q, q_t = start_state(setup, law)
        step = chosen_step(setup, law, q, q_t)
        began = time.process_time()
        motion = Integration(system, duration=plan.duration, step=step, integrator=plan.integrator,
            sample_interval=plan.output_interval, weight=law.vehicle.weight,
        ).run(q, q_t)  # fmt: skip
        spent = time.process_time() - began
        if motion.status != "completed":
            raise SystemExit(f"the run stopped: {motion.reason}")
        if spent < best:
            best = spent
            evaluations = motion.work.evaluations / (motion.end / step)
            result = {"real_time": motion.end / spent, "step_ms": 1e3 * step, "evaluations": evaluations}
    return result


def main(arguments: list[str]) -> int:
    """Print how fast the models run."""
    if not arguments:
        raise SystemExit("python campaigns/gz18.py REFERENCE [--json] [MODEL ...]")
    reference = reference_folder(arguments[0])
    names = [name for name in arguments if name in CASES] or list(CASES)
    speeds: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            speeds[name] = timed(reference, Path(folder), CASES[name])
            speed = speeds[name]["real_time"]
            if REFERENCE in speeds:
                speeds[name]["times_rk44"] = speed / speeds[REFERENCE]["real_time"]
            print(f"{name}: " + ", ".join(f"{key} {value:.3g}" for key, value in speeds[name].items()), flush=True)
    if "--json" in arguments:
        print(json.dumps({"gz18": {"r300_aar5": speeds}}))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
