"""Jumps of the contact forces over lateral shift, yaw, approach and load.

    python campaigns/contact_continuity.py [--over shift yaw approach load] [--normal strips] [--strips 16] [--step 1]
        [--pair 0 1 2 3 4] [--yaw 0 12] [--load 24 100] [--lateral 2 6] [--from -10 --to 10]

A wheel is carried along a smooth path of heights: those at which Kik-Piotrowski bears the load, which is given or goes
from 5 to 150 kN, or down from where the wheel touches its rail to where Kik-Piotrowski bears 150 kN. Where its force
changes most from one step to the next the step is halved twelve times: what is left of the change is a jump. Prints the
largest of them over the load, and the time of a pose. Steps of 20 um find the jumps of a sweep in a minute, steps of
1 um the smaller ones too (loads go by as many kN). Over approach and load every lateral shift is swept at every yaw.
Pairs 6 to 8 are not those of the other campaigns. Beside each jump over shift stand the contacts on both of its sides:
strips, residuals, and of each grid its bounds and edges, in brackets if it does not touch.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator
from strip_robustness import PAIRS, STRIPS, Stand, force, stand

from wrsim.contact.pose import Pose
from wrsim.contact.settings import ContactSettings
from wrsim.simulation.pose_solver import PoseSolver

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from support.sweeps import HALVINGS, steepest

STEEPEST = 12  # steps looked into
SMALL = 0.005  # of the load: jumps whose sides are shown
KNOTS = 31  # of the load over the approach
OTHERS = (("S1002", "60E1_worn", 20), ("S1002_worn", "60E1_worn", 20), ("S1002_worn", "54E1", 30))
LOADS = np.arange(5e3, 150e3 + 1.0, 5e3)  # [N]


Way = Callable[[float], tuple[float, float, float, float]]
"""Lateral shift, height, yaw [m, rad] and the load that stands for the force [N] at a place of a sweep."""


def smooth(knots: np.ndarray, varied: int, state: tuple[float, float, float], heights: PoseSolver):  # type: ignore[no-untyped-def]
    """A path along which Kik-Piotrowski bears the load, smooth between knots: the path, its ends.

    state: lateral shift, yaw and load [m, rad, MN]; ``varied``: number of the one that goes along the knots.
    """

    def states(x: float) -> tuple[float, float, float]:
        lateral, yaw, load = (x if i == varied else value for i, value in enumerate(state))
        return lateral, yaw, 1e6 * load

    solved_heights = np.array([heights.solve(Pose("", *states(x))).height for x in knots])
    good = np.isfinite(solved_heights)
    height = PchipInterpolator(knots[good], solved_heights[good])

    def path(x: float) -> tuple[float, float, float, float]:
        lateral, yaw, load = states(x)
        return lateral, float(height(x)), yaw, load

    return path, knots[good][0], knots[good][-1]


def downwards(stands: Stand, lateral: float, yaw: float):  # type: ignore[no-untyped-def]
    """A path straight down from a micrometre of approach on: the path, its ends [m]."""
    touching = stands.touching(lateral, yaw)
    lowest = stands.screen.solve(Pose("", lateral, yaw, LOADS[-1])).height
    if touching is None or not np.isfinite(lowest):
        return None
    knots = np.linspace(0.0, touching - lowest, KNOTS)
    loads = []
    for x in knots:
        stands.screen.evaluate(lateral, touching - x, yaw, 0.0)
        loads.append(max(force(stands.screen), LOADS[0]))
    load = PchipInterpolator(knots, loads)

    def path(x: float) -> tuple[float, float, float, float]:
        return lateral, touching - x, yaw, float(load(x))

    return path, 1e-6, touching - lowest


def largest_jump(bench: PoseSolver, path: Way, start: float, end: float, step: float) -> tuple[float, str]:
    """The largest jump of a sweep over the load there; also in words."""

    def forces_at(x: float) -> np.ndarray:
        lateral, height, yaw, load = path(x)
        bench.evaluate(lateral, height, yaw, 0.0)
        return bench.force / load

    xs = np.arange(start, end, step)
    forces = np.empty((len(xs), 3))
    began = time.perf_counter()
    for i, x in enumerate(xs):
        forces[i] = forces_at(x)
    cost = 1e6 * (time.perf_counter() - began) / len(xs)
    jumps = steepest(forces_at, xs, STEEPEST, forces)
    where, worst = jumps[jumps[:, 1].argmax()].tolist()
    report = f"{worst:9.4f} at {1e3 * where:8.4f}{len(xs):8d} poses{cost:8.0f} us"
    width = step / 2.0**HALVINGS
    for x in (
        (where - width, where + 2.0 * width) if worst > SMALL and bench.wheels[0].model.normal.solves_for_strips else ()
    ):
        forces_at(x)
        report += f"\n    {contact(bench)}"
    return worst, report


def contact(bench: PoseSolver) -> str:
    """Strips, residuals and grids of the strip model's last contact, in words."""
    rows = bench.wheels[0].model.arrays.rows
    memo, grids = rows.memo[0], []
    for grid in rows.grids[: memo["grids"]]:
        ends = [f"{1e3 * grid[name]:.3f}" for name in ("least", "start", "end", "most")]
        grids.append(" ".join(ends) if grid["active"] else f"({ends[0]} {ends[3]})")
    return f"{memo['strips']} strips, {memo['iterations']} residuals; " + ", ".join(grids)


def sweeps(stands: Stand, chosen: argparse.Namespace) -> Iterator[tuple[str, Any]]:
    """All sweeps of a pair: in words, path with its ends."""
    shifts, yaws = (
        np.arange(1e-3 * chosen.first, 1e-3 * chosen.to + 1e-9, 2.5e-4),
        np.arange(-20e-3, 20e-3 + 1e-9, 5e-4),
    )
    for load in chosen.load:
        for yaw in chosen.yaw if "shift" in chosen.over else ():
            yield (
                f"{load:g} kN, yaw {yaw:g} mrad, y [mm]",
                smooth(shifts, 0, (0.0, 1e-3 * yaw, 1e-3 * load), stands.screen),
            )
        for y in chosen.lateral if "yaw" in chosen.over else ():
            yield f"{load:g} kN, y {y:g} mm, yaw [mrad]", smooth(yaws, 1, (1e-3 * y, 0.0, 1e-3 * load), stands.screen)
    for yaw in chosen.yaw:
        for y in chosen.lateral:
            place = f"yaw {yaw:g} mrad, y {y:g} mm"
            if "approach" in chosen.over and (descent := downwards(stands, 1e-3 * y, 1e-3 * yaw)):
                yield f"{place}, approach [mm]", descent
            if "load" in chosen.over:
                yield f"{place}, load [kN]", smooth(1e-6 * LOADS, 2, (1e-3 * y, 1e-3 * yaw, 0.0), stands.screen)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--over", nargs="+", choices=("shift", "yaw", "approach", "load"), default=["shift", "yaw"])
    parser.add_argument("--normal", default="strips")
    parser.add_argument("--strips", type=int, default=STRIPS)
    parser.add_argument("--step", type=float, default=1.0, help="[um, urad, kN]")
    parser.add_argument("--pair", type=int, nargs="+", default=range(5), help="Numbers of the pairs.")
    parser.add_argument("--yaw", type=float, nargs="+", default=[0.0, 12.0], help="[mrad]")
    parser.add_argument("--load", type=float, nargs="+", default=[24.0, 100.0], help="[kN]")
    parser.add_argument("--lateral", type=float, nargs="+", default=[2.0, 6.0], help="[mm]")
    parser.add_argument("--from", dest="first", type=float, default=-10.0, help="Over shift [mm].")
    parser.add_argument("--to", type=float, default=10.0, help="[mm]")
    parser.add_argument("--json", action="store_true", help="One line of numbers at the end.")
    chosen = parser.parse_args()
    ours = ContactSettings(normal=chosen.normal, strips=chosen.strips, tangential="none", damping=0.0)
    jumps: dict[str, float] = {}
    for number in chosen.pair:
        pair = (*PAIRS, *OTHERS)[number]
        stands = Stand(pair, chosen.strips)
        bench = stand(pair, ours)
        for label, (path, start, end) in sweeps(stands, chosen):
            key = f"{stands.name}, {label}"
            step = 1e-6 * chosen.step * (1e3 if label.endswith("load [kN]") else 1.0)
            jumps[key], report = largest_jump(bench, path, start, end, step)
            print(f"{key}: {report}", flush=True)
    if chosen.json:
        print(json.dumps({"jumps": {chosen.normal: jumps}}))


if __name__ == "__main__":
    main()
