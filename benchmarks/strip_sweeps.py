"""The strip model beside the half-space solver on sweeps over the lateral shift: p0, N, and strips that stand out.

    python benchmarks/strip_sweeps.py [--strips 20] [--load 54] [--every 5] [--from -4 --to 4] [--yaw 0] [--json FILE]

Steps of 20 um at the load; the strip model finds the height, the half-space solver is asked at every N-th of these
poses, at the same height. "outer": largest half length of a strip at an inner end of a lobe, or of any strip, over the
larger of its two neighbours' (laws: at most 1.25).
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from strip_robustness import PAIRS, Stand

from wrsim.contact.half_space.solver import HalfSpace
from wrsim.scenario.cases import Pose

STEP = 20e-6


def outstanding(strips: np.ndarray) -> float:
    """Largest force per width of a strip over the larger of its two neighbours'."""
    q = strips["N"] / strips["ds"]
    if len(q) < 3:
        return 0.0
    return float((q[1:-1] / np.maximum(q[:-2], q[2:])).max())


def main() -> None:
    """Print a line for each pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--strips", type=int, default=20)
    parser.add_argument("--load", type=float, default=54.0, help="[kN]")
    parser.add_argument("--every", type=int, default=5)
    parser.add_argument("--from", dest="first", type=float, default=-4.0, help="[mm]")
    parser.add_argument("--to", type=float, default=4.0, help="[mm]")
    parser.add_argument("--yaw", type=float, default=0.0, help="[mrad]")
    parser.add_argument("--worse", type=float, default=0.03, help="error of p0 from which poses are printed")
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    rows = []
    for pair in PAIRS:
        stand = Stand(pair, a.strips)
        solver = HalfSpace()
        errors, outer, poses, places = [], 0.0, 0, []
        for i, y in enumerate(np.arange(1e-3 * a.first, 1e-3 * a.to + 1e-9, STEP)):
            solved = stand.strips.solve(Pose("", float(y), 1e-3 * a.yaw, 1e3 * a.load))
            if solved.message:
                print(f"  {stand.name} y {1e3 * y:.3f}: {solved.message}")
                continue
            poses += 1
            arrays = stand.arrays
            lobes = arrays.patches[: arrays.total["lobes"]]
            strips = np.concatenate([arrays.strips[k, : lobe["n_strips"]] for k, lobe in enumerate(lobes)])
            outer = max(outer, outstanding(strips))
            if i % a.every:
                continue
            model = stand.screen.wheels[0].model
            model.arrays.pose[:] = arrays.pose
            exact = solver.solve_pose(model)
            peak = max(patch.p0 for patch in exact.patches)
            errors.append((lobes["p0"].max() / peak - 1.0, lobes["N"].sum() / exact.normal_force - 1.0))
            places.append(1e3 * y)
            if abs(errors[-1][0]) > a.worse:
                print(f"  {stand.name} y {1e3 * y:.3f}: p0 {errors[-1][0]:+.4f} N {errors[-1][1]:+.4f} "
                      f"{len(lobes)} lobes", flush=True)  # fmt: skip
        e = np.abs(errors)
        worst = int(e[:, 0].argmax())
        row = {
            "pair": stand.name, "strips": a.strips, "poses": poses, "compared": len(e),
            "p0_median": float(np.median(e[:, 0])), "p0_worst": float(e[:, 0].max()), "at_mm": float(places[worst]),
            "N_median": float(np.median(e[:, 1])), "N_worst": float(e[:, 1].max()), "outer": outer,
        }  # fmt: skip
        rows.append(row)
        print(json.dumps(row), flush=True)
    if a.json:
        a.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
