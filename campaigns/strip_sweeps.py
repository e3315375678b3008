"""The strip model beside the half-space solver on sweeps over the lateral shift: p0, N, and strips that stand out.

    python campaigns/strip_sweeps.py [--strips 16] [--load 54] [--every 5] [--from -4 --to 4] [--yaw 0] [--json FILE]

Steps of 20 um at the load; the strip model finds the height, the half-space solver is asked at every N-th of these
poses, at the same height (never with --every 0). "ends": what the end of a stretch of contact, or of a lobe within it,
carries a unit of width, over the larger of its two neighbours (law: at most 1.25). Several loads and yaws make a sweep
each.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from strip_robustness import PAIRS, STRIPS, Stand

from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.pose import Pose
from wrsim.contact.workspace import KernelArrays

STEP = 20e-6
NO_GAP = 1e-8  # between strips that touch [m]


def worst_end(arrays: KernelArrays) -> float:
    """Largest force per width of an end strip over the larger of its neighbours'.

    Ends of a stretch of contact without a gap have one neighbour; where two lobes of a stretch meet the strips on
    either side have two. A lobe of one or two strips beyond a gap has a maximum of its own and does not count: the
    half-space solver has such regions too, with the same force.
    """
    number, lobes = int(arrays.total["lobes"]), arrays.patches
    strips_of_lobes = [arrays.strips[i, : lobes["n_strips"][i]] for i in range(number)]
    lobe = np.repeat(np.arange(number), [len(strips) for strips in strips_of_lobes])
    strips = np.concatenate(strips_of_lobes)
    if not len(strips):
        return 0.0
    place, width = strips["s"] + lobes["arc_rail"][lobe], strips["ds"]
    order = np.argsort(place)
    place, width, lobe, q = place[order], width[order], lobe[order], (strips["N"] / strips["ds"])[order]
    gap = np.flatnonzero(np.diff(place) - 0.5 * (width[1:] + width[:-1]) > NO_GAP) + 1
    worst = 0.0
    for run, lobe_of in zip(np.split(q, gap), np.split(lobe, gap), strict=True):
        if len(run) < 3:
            continue
        worst = max(worst, run[0] / run[1], run[-1] / run[-2])
        for j in np.flatnonzero(np.diff(lobe_of)):
            for k in (j, j + 1):
                if 0 < k < len(run) - 1:
                    worst = max(worst, run[k] / max(run[k - 1], run[k + 1]))
    return float(worst)


def sweep(stand: Stand, yaw: float, load: float, shifts: np.ndarray, every: int, worse: float) -> dict[str, object]:
    """One sweep; yaw [mrad], load [kN], shifts [m]."""
    solver = HalfSpace()
    errors, ends, at_end, poses, places = [], 0.0, 0.0, 0, []
    for i, y in enumerate(shifts):
        solved = stand.strips.solve(Pose("", float(y), 1e-3 * yaw, 1e3 * load))
        if solved.message:
            print(f"  {stand.name} y {1e3 * y:.3f} yaw {yaw:g} {load:g} kN: {solved.message}", flush=True)
            continue
        poses += 1
        arrays = stand.arrays
        lobes = arrays.patches[: arrays.total["lobes"]]
        end = worst_end(arrays)
        if end > ends:
            ends, at_end = end, float(1e3 * y)
        if not every or i % every:
            continue
        model = stand.screen.wheels[0].model
        model.arrays.pose[:] = arrays.pose
        exact = solver.solve_pose(model)
        peak = max(patch.p0 for patch in exact.patches)
        area = sum(patch.area for patch in exact.patches)
        errors.append(
            (
                lobes["p0"].max() / peak - 1.0,
                lobes["N"].sum() / exact.normal_force - 1.0,
                lobes["area"].sum() / area - 1.0,
            )
        )
        places.append(1e3 * y)
        if abs(errors[-1][0]) > worse:
            print(f"  {stand.name} y {1e3 * y:.3f} yaw {yaw:g} {load:g} kN: p0 {errors[-1][0]:+.4f} "
                  f"N {errors[-1][1]:+.4f} {len(lobes)} lobes", flush=True)  # fmt: skip
    row: dict[str, object] = {
        "pair": stand.name, "yaw_mrad": yaw, "load_kN": load, "poses": poses, "ends": ends, "ends_at_mm": at_end,
        "compared": len(errors),
    }  # fmt: skip
    if errors:
        e = np.abs(errors)
        row["p0_worst_at_mm"] = float(places[int(e[:, 0].argmax())])
        for k, name in enumerate(("p0", "N", "area")):
            row[f"{name}_median"], row[f"{name}_worst"] = float(np.median(e[:, k])), float(e[:, k].max())
    return row


def main() -> None:
    """Print a line for each sweep."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--strips", type=int, default=STRIPS)
    parser.add_argument("--load", type=float, nargs="+", default=[54.0], help="[kN]")
    parser.add_argument("--every", type=int, default=5)
    parser.add_argument("--from", dest="first", type=float, default=-4.0, help="[mm]")
    parser.add_argument("--to", type=float, default=4.0, help="[mm]")
    parser.add_argument("--yaw", type=float, nargs="+", default=[0.0], help="[mrad]")
    parser.add_argument("--worse", type=float, default=0.03, help="error of p0 from which poses are printed")
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    rows = []
    shifts = np.arange(1e-3 * a.first, 1e-3 * a.to + 1e-9, STEP)
    for pair in PAIRS:
        stand = Stand(pair, a.strips)
        for yaw in a.yaw:
            for load in a.load:
                rows.append({"strips": a.strips} | sweep(stand, yaw, load, shifts, a.every, a.worse))
                print(json.dumps(rows[-1]), flush=True)
    if a.json:
        a.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
