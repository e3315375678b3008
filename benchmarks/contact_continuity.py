"""Jumps of the contact forces over lateral shift and yaw.

    python benchmarks/contact_continuity.py [--normal strips] [--strips 20] [--step 1] [--yaw 0 12] [--load 24 100]

A wheel is carried along a smooth path of heights (those at which Kik-Piotrowski bears the load at every quarter of a
millimetre). Where its force changes most from one step to the next the step is halved twelve times: what is left of
the change is a jump. Prints the largest of them over the load, and the time of a pose. Steps of 20 um find the jumps
of a sweep in a minute, steps of 1 um the smaller ones too.
"""

from __future__ import annotations

import argparse
import json
import time

import numpy as np
from scipy.interpolate import PchipInterpolator
from strip_robustness import stand

from wrsim.analysis.poses.solver import PoseSolver
from wrsim.contact.settings import ContactSettings
from wrsim.scenario.cases import Pose

PAIRS = (
    ("S1002", "60E1", 40), ("S1002", "60E1", 20), ("S1002", "54E1", 20), ("S1002_worn", "60E1", 40),
    ("S1002_worn", "60E1_worn", 40),
)  # fmt: skip
STEEPEST = 12  # steps looked into
HALVINGS = 12


def sweep(bench: PoseSolver, heights: PoseSolver, load: float, states, knots, step: float):  # type: ignore[no-untyped-def]
    """One sweep: ``states`` gives (lateral, yaw) of a number between the ends of ``knots``. Largest jump, in words."""
    path = [heights.solve(Pose("", *states(x), load)).height for x in knots]
    good = np.isfinite(path)
    height = PchipInterpolator(knots[good], np.array(path)[good])

    def force(x: float) -> np.ndarray:
        lateral, yaw = states(x)
        bench.evaluate(lateral, float(height(x)), yaw, 0.0)
        return bench.force / load

    xs = np.arange(knots[good][0], knots[good][-1], step)
    forces = np.empty((len(xs), 3))
    began = time.perf_counter()
    for i, x in enumerate(xs):
        forces[i] = force(x)
    cost = 1e6 * (time.perf_counter() - began) / len(xs)
    change = np.abs(np.diff(forces, axis=0)).max(axis=1)
    usual = np.array([np.median(change[max(0, i - 4) : i + 5]) for i in range(len(change))])
    worst, where = 0.0, 0.0
    for i in np.argsort(usual - change)[:STEEPEST]:
        left, right = xs[i], xs[i + 1]
        at_left, at_right = force(left), force(right)
        for _ in range(HALVINGS):
            middle = 0.5 * (left + right)
            between = force(middle)
            if np.abs(between - at_left).max() > np.abs(at_right - between).max():
                right, at_right = middle, between
            else:
                left, at_left = middle, between
        jump = float(np.abs(at_right - at_left).max())
        if jump > worst:
            worst, where = jump, left
    return worst, f"{worst:9.4f} at {1e3 * where:8.4f}{len(xs):8d} poses{cost:8.0f} us"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--normal", default="strips")
    parser.add_argument("--strips", type=int, default=20)
    parser.add_argument("--step", type=float, default=1.0, help="[um, urad]")
    parser.add_argument("--yaw", type=float, nargs="+", default=[0.0, 12.0], help="[mrad]")
    parser.add_argument("--load", type=float, nargs="+", default=[24.0, 100.0], help="[kN]")
    parser.add_argument("--json", action="store_true", help="One line of numbers at the end.")
    chosen = parser.parse_args()
    ours = ContactSettings(normal=chosen.normal, strips=chosen.strips, tangential="none", damping=0.0)
    plain = ContactSettings(normal="kik-piotrowski", tangential="none", damping=0.0)
    jumps: dict[str, float] = {}
    for pair in PAIRS:
        bench, heights = stand(pair, ours), stand(pair, plain)
        for load in chosen.load:
            name = f"{pair[0]} / {pair[1]} 1:{pair[2]}, {load:g} kN"
            lateral = np.arange(-10e-3, 10e-3 + 1e-9, 2.5e-4)
            yaws = np.arange(-12e-3, 12e-3 + 1e-9, 5e-4)
            sweeps = [(f"yaw {yaw:g} mrad, y [mm]", lambda y, yaw=yaw: (y, 1e-3 * yaw), lateral) for yaw in chosen.yaw]
            sweeps += [(f"y {y:g} mm, yaw [mrad]", lambda a, y=y: (1e-3 * y, a), yaws) for y in (2.0, 6.0)]
            for words, states, knots in sweeps:
                key = f"{name}, {words}"
                jumps[key], found = sweep(bench, heights, 1e3 * load, states, knots, 1e-6 * chosen.step)
                print(f"{key}: {found}", flush=True)
    if chosen.json:
        print(json.dumps({"jumps": {chosen.normal: jumps}}))


if __name__ == "__main__":
    main()
