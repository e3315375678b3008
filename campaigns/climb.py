"""Distances to climb beside TCRP Report 71: four angles of the flange, three lengths, five angles of attack.

    python campaigns/climb.py [--model kik-piotrowski] [--tip 9.5] [--corner 13]

Y/Q 1.99, friction 0.5, 18 km/h, 54.5 kN a wheel. Every row: ratio of the distance to that of the formula; then, here
and there, what distance = width / (attack + lift) has for it, width [mm] and lift [mrad]. --tip: radius of the flange's
tip [mm]; --corner: that of the rail's gauge corner [mm], a head of arcs of 300, 80 mm and this; 60E1 unless given.
"""

import argparse
import tempfile
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis import run
from wrsim.scenario.loading import load

Array = NDArray[np.float64]
ANGLES, LENGTHS, ATTACKS = (68.0, 70.0, 72.0, 75.0), (0.5, 0.6, 0.7), [0.0, 5.0, 10.0, 15.0, 20.0]
INCH = 25.4  # [mm]
SCENARIO = Path(__file__).parents[1] / "scenarios" / "climb.toml"
WHEEL = """name = "flange"
body = "wheel"
kind = "flanged"
date = 2026-11-27
source = "definition"
flange_angle_deg = {}
flange_length_mm = {}
tip_radius_mm = {}
"""
RAIL = """name = "head"
body = "rail"
kind = "rail-head"
date = 2026-11-27
source = "definition"
radii_mm = [300, 80, {}]
half_widths_mm = [10, 26]
side_slope = 0.05
depth_mm = 40
"""


def width_and_lift(distance: Array) -> tuple[float, float]:
    """What fits the distances [m] at the angles of attack above 0 best: width [mm], lift [mrad]."""
    slope, level = np.polyfit(ATTACKS[1:], 1.0 / distance[1:], 1)
    return 1.0 / slope, level / slope


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", default="kik-piotrowski")
    parser.add_argument("--tip", type=float, default=9.5)
    parser.add_argument("--corner", type=float)
    arguments = parser.parse_args()
    ratios = []
    print(f"angle  length  ratio at {ATTACKS} mrad")
    with tempfile.TemporaryDirectory() as folder:
        values = {"climb.angle_of_attack_mrad": ATTACKS, "climb.Y_over_Q": [1.99], "climb.longest_m": 40.0}
        values |= {"contact.normal": arguments.model, "vehicle.wheel": str(Path(folder, "wheel.toml"))}
        if arguments.corner is not None:
            Path(folder, "rail.toml").write_text(RAIL.format(arguments.corner), encoding="utf-8")
            values["track.rail"] = str(Path(folder, "rail.toml"))
        for angle, length in product(ANGLES, LENGTHS):
            Path(folder, "wheel.toml").write_text(WHEEL.format(angle, length * INCH, arguments.tip), encoding="utf-8")
            climbs = run(load(SCENARIO).with_values(values)).dataset
            computed, reference = (climbs[name].values for name in ("climb_distance", "climb_distance_tcrp"))
            ratios.append(computed / reference)
            pairs = zip(width_and_lift(computed), width_and_lift(reference), strict=True)
            patch = "  ".join(f"{name} {a:.1f}, {b:.1f}" for name, (a, b) in zip(("width", "lift"), pairs, strict=True))
            print(f"{angle:g}  {length:g}  {' '.join(f'{r:.2f}' for r in ratios[-1])}  {patch}", flush=True)
    within = np.abs(np.array(ratios) - 1.0) <= 0.15
    each = within.sum(axis=0).tolist()
    print(f"within 15 %: {within.sum()} of {within.size}; by angle of attack {each} of {len(ratios)} each")


if __name__ == "__main__":
    main()
