"""The strip model beside the half-space solver at the same height, on random poses of four kinds.

    python campaigns/strip_accuracy.py [--strips 16] [--poses 200] [--seed 7] [--resolution 24] [--json FILE]

Six pairs of profiles. "root": flange root, shift 5.5 to 7.3 mm, yaw 0 and 2 mrad, 10 to 150 kN; "corner": bands of
60 um beside it where the penetration bends within a tenth of a millimetre, 5 to 24 kN; "yawed": 6.1 to 7 mm, 5 to 25
mrad, where the contact locus turns aside; "wide": -6 to 8.5 mm, up to 12 mrad; "others": eight pairs of other standards
and of trams, to 14 mm, 40 mrad and 200 kN. Errors are abs(strips/half-space - 1):
median, 95 %, largest, and the numbers of poses beyond 2 and 5 %; then how many were solved with fewer strips, and
Jacobians a pose.
"""

import argparse
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from strip_robustness import PAIRS, STRIPS, Stand

from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.pose import Pose

OTHERS = (
    ("AAR-1B_approx", "136RE", 40), ("AAR_1in20", "115RE", 40), ("S1002", "136RE", 40), ("S1002_worn", "54E1", 20),
    ("AAR-1B_approx", "60E1_worn", 20), ("tram", "grooved", 1e9), ("tram", "grooved_narrow", 1e9), ("tram", "54E1", 40),
)  # fmt: skip
LOADS = (10.0, 25.0, 60.0, 100.0)  # [kN]
Drawn = tuple[int, float, float, float]
"""Number of a pair, lateral shift [mm], yaw [mrad], load [kN]."""


def root(random: np.random.Generator) -> Drawn:
    """On the flange root."""
    return int(random.integers(6)), random.uniform(5.5, 7.3), random.choice((0.0, 2.0)), random.choice((*LOADS, 150.0))


def corner(random: np.random.Generator) -> Drawn:
    """Where the penetration bends sharply."""
    pair, start = ((0, 6.60), (1, 6.47))[random.integers(2)]
    return pair, start + random.uniform(0.0, 0.06), 0.0, random.choice((5.0, 10.0, 15.0, 24.0))


def yawed(random: np.random.Generator) -> Drawn:
    """Between equal radii at large yaw."""
    yaw = random.choice((-1.0, 1.0)) * random.uniform(5.0, 25.0)
    return int(random.integers(6)), random.uniform(6.1, 7.0), yaw, random.choice(LOADS)


def wide(random: np.random.Generator) -> Drawn:
    """Tread to flange."""
    yaw = random.choice((0.0, random.uniform(-12.0, 12.0)))
    return int(random.integers(6)), random.uniform(-6.0, 8.5), yaw, random.choice(LOADS)


def unfamiliar(random: np.random.Generator) -> Drawn:
    """Profiles that the model was not made with."""
    pair, yaw = len(PAIRS) + int(random.integers(len(OTHERS))), random.uniform(-40.0, 40.0)
    return pair, random.uniform(-14.0, 14.0), yaw, float(np.exp(random.uniform(0.0, np.log(200.0))))


KINDS: tuple[Callable[[np.random.Generator], Drawn], ...] = (root, corner, yawed, wide, unfamiliar)


def compare(stand: Stand, drawn: Drawn, exact: HalfSpace) -> tuple[float, float, int, int]:
    """N and p0 over those of the half-space less 1, with how many strips the pose was solved, Jacobians."""
    _pair, lateral, yaw, load = drawn
    stand.strips.solve(Pose("", 1e-3 * lateral, 1e-3 * yaw, 1e3 * load))
    stand.arrays.evaluate()
    lobes, memo = stand.arrays.patches[: stand.arrays.total["lobes"]], stand.arrays.rows.memo[0]
    ours = float(lobes["N"].sum()), float(lobes["p0"].max())
    model = stand.screen.wheels[0].model
    model.arrays.pose[:] = stand.arrays.pose
    truth = exact.solve_pose(model)
    peak = max(patch.p0 for patch in truth.patches)
    return ours[0] / truth.normal_force - 1.0, ours[1] / peak - 1.0, int(memo["strips"]), int(memo["factorisations"])


def spread(errors: np.ndarray) -> dict[str, float]:
    """Median, 95 %, largest, numbers beyond 2 and 5 %."""
    size = np.abs(errors)
    return {
        "median": float(np.median(size)), "95 %": float(np.quantile(size, 0.95)), "largest": float(size.max()),
        "> 2 %": int((size > 0.02).sum()), "> 5 %": int((size > 0.05).sum()),
    }  # fmt: skip


def main() -> None:
    """Print a line for each kind."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--strips", type=int, default=STRIPS)
    parser.add_argument("--poses", type=int, default=200)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--resolution", type=int, default=24)
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    stands = [Stand(pair, a.strips) for pair in (*PAIRS, *OTHERS)]
    exact, spreads = HalfSpace(resolution=a.resolution), {}
    for kind in KINDS:
        random = np.random.default_rng(a.seed)
        drawn = [kind(random) for _ in range(a.poses)]
        rows = np.array([compare(stands[pose[0]], pose, exact) for pose in drawn])
        spreads[kind.__name__] = {
            "N": spread(rows[:, 0]), "p0": spread(rows[:, 1]),
            "with fewer strips": int((rows[:, 2] < a.strips).sum()), "Jacobians": float(rows[:, 3].mean()),
        }  # fmt: skip
        print(kind.__name__, json.dumps(spreads[kind.__name__]), flush=True)
    if a.json:
        a.json.write_text(json.dumps(spreads, indent=1) + "\n")


if __name__ == "__main__":
    main()
