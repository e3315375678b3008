"""The exact half-space solver on a table of static poses: predictions and times.

    python benchmarks/scoreboard_half_space.py CASES.csv --profiles DIR -o PREDICTIONS.csv [--every N]
        [--elements table] [--pairing level] [--influence angle-corrected] [--resolution 36]

CASES.csv: columns case_id, wheel, rail, cant_label ("1:40"), y_ws_mm, yaw_rad, Fz_req_N and, where present, method,
patch (the first row of a case counts), tang (0 frictionless, 3 rolling), dx_eff_mm. One right wheel, R 460 mm, gauge
1435 mm, profile spacing 1500 mm, G 82 GPa, nu 0.28, mu 0.3; CONTACT's track frame (y to the right, z down).
DIR holds profiles that are not shipped as WHEEL.prw and RAIL.prr, "worn" being S1002_worn or 60E1_worn.
--elements table takes the element size of every row (dx_eff_mm) and counts the area as CONTACT does, element by
element; otherwise elements are the solver's own choice and the area is extrapolated to the edge of contact.
"""

from __future__ import annotations

import argparse
import csv
import time
from functools import cache
from pathlib import Path

import numpy as np

from wrsim.analysis.half_space_bench import HalfSpaceBench
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.half_space import HalfSpace
from wrsim.contact.model import ContactModel
from wrsim.contact.settings import ContactSettings, Material
from wrsim.geometry.profile import Profile
from wrsim.geometry.profile_files import read_profile
from wrsim.geometry.profile_models import load_profile
from wrsim.scenario.cases import StaticPose

MODELS = Path(__file__).parents[1] / "models"
STEEL = Material(2.0 * 82e9 * 1.28, 0.28)
RADIUS, HALF_SPACING, HALF_GAUGE, FRICTION = 0.46, 0.75, 0.7175, 0.3


def profile(name: str, kind: str, directory: Path | None) -> Profile:
    """A shipped profile, or one from the directory."""
    if name == "worn":
        name = {"wheels": "S1002_worn", "rails": "60E1_worn"}[kind]
    shipped = MODELS / kind / f"{name}.toml"
    if shipped.exists():
        return load_profile(shipped)
    if directory is None:
        raise SystemExit(f"profile '{name}' is not shipped: say where it is with --profiles")
    return read_profile(directory / f"{name}.{'prw' if kind == 'wheels' else 'prr'}", measured=False)


@cache
def wheel_on_rail(wheel: str, rail: str, cant: str, rolling: bool, directory: Path | None) -> WheelOnRail:
    """One wheel on one inclined rail."""
    inclined = profile(rail, "rails", directory).inclined(1.0 / float(cant.split(":")[1]))
    settings = ContactSettings(
        normal="half-space", tangential="half-space" if rolling else "none", wheel=STEEL, rail=STEEL, damping=0.0
    )
    model = ContactModel.build(profile(wheel, "wheels", directory), inclined, RADIUS, settings, FRICTION)
    return WheelOnRail(model, 1, HALF_SPACING, (HALF_GAUGE - inclined.gauge_point()[0], -inclined.top[1]))


def main() -> None:
    """Solve the cases, write the predictions, print the times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--profiles", type=Path)
    parser.add_argument("--every", type=int, default=1, help="take every N-th case")
    parser.add_argument("--elements", choices=("own", "table"), default="own")
    parser.add_argument("--pairing", choices=("opposite", "level"), default="opposite")
    parser.add_argument("--influence", choices=("half-space", "angle-corrected"), default="half-space")
    parser.add_argument("--resolution", type=int, default=HalfSpace().resolution)
    choices = parser.parse_args()
    with choices.cases.open(newline="") as file:
        cases: dict[str, dict[str, str]] = {}
        for row in csv.DictReader(file):
            cases.setdefault(row["case_id"], row)
    predictions, seconds, normal_seconds, evaluations = [], [], [], []
    for row in list(cases.values())[:: choices.every]:
        rolling = row.get("tang", "3") == "3"
        wheel = wheel_on_rail(row["wheel"], row["rail"], row["cant_label"], rolling, choices.profiles)
        element = (1e-3 * float(row["dx_eff_mm"]),) * 2 if choices.elements == "table" else None
        solver = HalfSpace(element, choices.resolution, choices.influence, pairing=choices.pairing)
        bench = HalfSpaceBench([wheel], rolling, RADIUS, solver)
        # the mirror image of a right wheel in CONTACT's axes: lateral shift and yaw keep their numbers
        pose = StaticPose(row["case_id"], 1e-3 * float(row["y_ws_mm"]), float(row["yaw_rad"]), float(row["Fz_req_N"]))
        began = time.perf_counter()
        solved = bench.solve(pose)
        seconds.append(time.perf_counter() - began)
        evaluations.append(bench.evaluations)
        contact = bench.contacts[0]
        if solved.message or contact is None or not contact.patches or contact.status:
            print(row["case_id"], solved.message, contact.status if contact is not None else "")
        if contact is None or not contact.patches:
            continue
        patch = contact.patches[0]
        area = patch.counted_area if choices.elements == "table" else patch.area
        predictions.append(
            {
                "case_id": row["case_id"],
                "p0_MPa": 1e-6 * patch.p0,
                "area_mm2": 1e6 * area,
                "approach_mm": 1e3 * patch.approach,
                "N_N": patch.normal_force,
                "Fx_N": -contact.force[0],
                "n_patches": len(contact.patches),
            }
        )
        frictionless = wheel_on_rail(row["wheel"], row["rail"], row["cant_label"], False, choices.profiles).model
        frictionless.arrays.pose[:] = wheel.model.arrays.pose
        began = time.perf_counter()
        solver.solve_pose(frictionless)
        normal_seconds.append(time.perf_counter() - began)
    with choices.output.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(predictions[0]))
        writer.writeheader()
        writer.writerows(predictions)
    for what, times in (("load found", seconds), ("normal problem at a pose", normal_seconds)):
        ms = 1e3 * np.array(times)
        print(f"{what}: median {np.median(ms):.1f} ms, 95 % {np.percentile(ms, 95):.1f} ms, {len(ms)} cases")
    print(f"evaluations for a load: {np.mean(evaluations):.2f}")


if __name__ == "__main__":
    main()
