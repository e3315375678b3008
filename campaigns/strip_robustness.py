"""Random poses for the strip model: is every one solved, is any force out of proportion, how long does it take?

    python campaigns/strip_robustness.py [--poses 100000] [--strips 16] [--seed 1] [--keep FILE] [--json FILE]
    python campaigns/strip_robustness.py --loads 1000000 [--seed 1] [--json FILE]
    python campaigns/strip_robustness.py --walks 600 [--strips 16] [--seed 1] [--json FILE]

Six pairs of profiles, lateral shift +-12 mm, yaw +-60 mrad, approach from 1 to 300 um by its logarithm; poses that bear
1 to 500 kN count. Every pose is solved afresh; "fewer": solved with fewer strips (docs/theory/strip_model.md).
Kik-Piotrowski screens the force: where the strip model has more than SUSPECT of it, or less than one over that, the
half-space solver is asked. Poses come in blocks of their own seeds; --keep adds each to a file when it is done, and a
run taken up again leaves out what stands there.

--loads lets a wheel down to loads up to 200 kN, with roll up to 10 and yaw up to 40 mrad: residuals over the median,
loads at which the strip model has no solution (static poses ask the half-space solver there), contacts of
Kik-Piotrowski among the others.

--walks carries a wheel along its rail in small steps, as runs do: shift, yaw and approach go smoothly from one random
pose to another some millimetres away, lobes come and go. The model that follows its last contact is set beside one that
solves afresh.
"""

import argparse
import json
import time
from collections import Counter
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from wrsim.contact.batch import search_for
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.models import contact_model
from wrsim.contact.prescribed_load import meet_load
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.records import STATUS_DISCONTINUOUS, STATUS_NOT_CONVERGED
from wrsim.contact.settings import USUAL, ContactSettings
from wrsim.contact.status import UNSOLVED, status_words
from wrsim.simulation.pose_solver import PoseSolver

MODELS = Path(__file__).parents[1] / "models"
PAIRS = (
    ("S1002", "60E1", 40), ("S1002", "60E1", 20), ("S1002", "54E1", 20), ("S1002_worn", "60E1", 40),
    ("S1002_worn", "60E1_worn", 40), ("S1002", "60E1_worn", 40),
)  # fmt: skip
RADIUS = 0.46
STRIPS = USUAL["strips"].strips
LEAST, MOST = 1e3, 500e3  # normal force [N]
SUSPECT = 1.6
TOO_MUCH = 1.3  # of the half-space solver's force, or one over it
BLOCK = 5000  # poses
SLOTS = np.logspace(1.0, 6.0, 2001)  # of times [us]: half a per cent each
STEPS, KNOTS = 500, 21  # of a walk
HIGHEST = np.array([12e-3, 40e-3, 10e-3])  # loads: lateral shift [m], yaw, roll [rad]
LONGEST = np.array([4e-3, 10e-3])  # walk: lateral shift [m], yaw [rad]
DIFFERENT, JUMP = 1e-6, 5e-3  # of the force: followed from afresh; a step from the two beside it


def stand(pair: tuple[str, str, int], settings: ContactSettings) -> PoseSolver:
    """A wheel on the left rail of a track of 1435 mm; pair: wheel, rail, one over the rail's inclination."""
    wheel, rail, inclination = pair
    profile = load_profile(MODELS / f"rails/{rail}.toml").inclined(1.0 / inclination)
    model = contact_model(load_profile(MODELS / f"wheels/{wheel}.toml"), profile, RADIUS, settings, 0.3)
    origin = (0.7175 - profile.gauge_point()[0], -profile.top[1])
    return PoseSolver([WheelOnRail(model, 1, 0.75, origin)], False, RADIUS)


class Stand:
    """A wheel on a rail, by the strip model, by Kik-Piotrowski, and by the half-space solver."""

    def __init__(self, pair: tuple[str, str, int], strips: int) -> None:
        wheel, rail, inclination = pair
        self.name = f"{wheel}/{rail} 1:{inclination}"
        self.wanted = strips
        plain = {"tangential": "none", "damping": 0.0}
        self.strips = stand(pair, ContactSettings(normal="strips", strips=strips, **plain))  # type: ignore[arg-type]
        self.screen = stand(pair, ContactSettings(normal="kik-piotrowski", strips=40, **plain))  # type: ignore[arg-type]
        self.arrays = self.strips.wheels[0].model.arrays

    def touching(self, lateral: float, yaw: float) -> float | None:
        """Height at which the wheel touches its rail [m]."""
        height = RADIUS + 0.02
        arrays = self.screen.wheels[0].model.arrays
        for _ in range(60):
            self.screen.evaluate(lateral, height, yaw, 0.0)
            closest = float(arrays.total["closest"])
            if abs(closest) < 1e-9:
                return height
            height -= closest
            if height < RADIUS - 0.08:
                break
        return None

    def exact(self) -> float:
        """N of the half-space solver at the pose of the strip model."""
        model = self.screen.wheels[0].model
        model.arrays.pose[:] = self.arrays.pose
        return float(HalfSpace(resolution=20).solve_pose(model).normal_force)


def force(bench: PoseSolver) -> float:
    """Normal forces of all lobes."""
    arrays = bench.wheels[0].model.arrays
    return float(arrays.patches["N"][: arrays.total["lobes"]].sum())


def pose_block(stands: list[Stand], seed: tuple[int, int], wanted: int) -> dict[str, object]:
    """Solve random poses afresh; figures, and in words those to look at."""
    random = np.random.default_rng(seed)
    count: Counter[str] = Counter()
    times, iterations, said, worst = [], [], [], 0.0
    while count["poses"] < wanted:
        stand = stands[random.integers(len(stands))]
        lateral, yaw = random.uniform(-12e-3, 12e-3), random.uniform(-60e-3, 60e-3)
        height = stand.touching(lateral, yaw)
        if height is None:
            continue
        for _ in range(10):
            depth = np.exp(random.uniform(np.log(1e-6), np.log(300e-6)))
            stand.screen.evaluate(lateral, height - depth, yaw, 0.0)
            plain = force(stand.screen)
            if not LEAST < plain < MOST:
                continue
            stand.strips.evaluate(lateral, height - depth, yaw, 0.0)
            memo = stand.arrays.rows.memo[0]
            began = time.thread_time()
            status = stand.arrays.evaluate()
            times.append(1e6 * (time.thread_time() - began))
            iterations.append(int(memo["iterations"]))
            ours, strips = force(stand.strips), int(memo["strips"])
            place = f"{stand.name} y {lateral:.9f} yaw {yaw:.9f} depth {depth:.9g}"
            unsolved = bool(status & STATUS_NOT_CONVERGED)
            count += Counter(poses=1, fewer=0 < strips < stand.wanted, unsolved=unsolved)
            if unsolved:
                said.append(f"unsolved: {place} ({ours / plain:.3f} of Kik-Piotrowski)")
            if not plain / SUSPECT < ours < SUSPECT * plain:
                ratio = max(ours / stand.exact(), 1e-9)
                count["suspects"] += 1
                worst = max(worst, ratio, 1.0 / ratio)
                if not 1.0 / TOO_MUCH < ratio < TOO_MUCH:
                    count["wrong"] += 1
                    said.append(f"wrong: {place}: {ratio:.3f} of the half-space")
    slots, number = np.unique(np.digitize(times, SLOTS), return_counts=True)
    return {
        "seed": list(seed), "count": dict(count), "worst_over_half_space": worst, "said": said,
        "times": [slots.tolist(), number.tolist()], "slowest_us": max(times), "most_residuals": max(iterations),
    }  # fmt: skip


def poses(arguments: argparse.Namespace) -> dict[str, object]:
    """All blocks, those kept before as well."""
    stands = [Stand(pair, arguments.strips) for pair in PAIRS]
    keep = arguments.keep
    kept = [json.loads(line) for line in keep.read_text().splitlines()] if keep and keep.exists() else []
    blocks = {tuple(block["seed"]): block for block in kept}
    wanted = [(arguments.seed, k) for k in range(-(-arguments.poses // BLOCK))]
    for seed in wanted:
        if seed in blocks:
            continue
        blocks[seed] = pose_block(stands, seed, min(BLOCK, arguments.poses - BLOCK * seed[1]))
        for line in blocks[seed]["said"]:
            print(line, flush=True)
        if keep:
            with keep.open("a") as file:
                file.write(json.dumps(blocks[seed]) + "\n")
    chosen = [blocks[seed] for seed in wanted]
    names = ("poses", "unsolved", "fewer", "suspects", "wrong")
    total = {name: sum(block["count"].get(name, 0) for block in chosen) for name in names}
    slots = np.zeros(len(SLOTS) + 1)
    for block in chosen:
        slots[block["times"][0]] += block["times"][1]
    share = np.cumsum(slots) / slots.sum()
    median, late = (float(SLOTS[np.searchsorted(share, part) - 1]) for part in (0.5, 0.99))
    slowest = max(block["slowest_us"] for block in chosen)
    return total | {
        "strips": arguments.strips, "worst_over_half_space": max(b["worst_over_half_space"] for b in chosen),
        "median_us": median, "p99_us": late, "slowest_us": slowest, "slowest_over_median": slowest / median,
        "most_residuals": max(block["most_residuals"] for block in chosen),
    }  # fmt: skip


def loads(arguments: argparse.Namespace) -> dict[str, object]:
    """Random poses at loads; those of which the strip model has no solution are printed."""
    random, began = np.random.default_rng(arguments.seed), time.monotonic()
    pairs = [*PAIRS, ("S1002", "60E1_worn", 20), ("S1002_worn", "60E1_worn", 20)]
    stands = [stand(p, ContactSettings(normal="strips", tangential="none", damping=0.0)) for p in pairs]
    residuals, count = np.zeros(arguments.loads, dtype=int), Counter[str]()
    for i in range(arguments.loads):
        pair = int(random.integers(len(pairs)))
        lateral, yaw, roll = random.uniform(-1.0, 1.0, 3) * HIGHEST
        a = stands[pair].wheels[0].model.arrays
        stands[pair].place(lateral, RADIUS + 0.03, yaw, roll)
        search = search_for([random.uniform(LEAST, 200e3)], a.pose[2], RADIUS, a.model.E)[0]
        status = int(meet_load(a.buffer, a.index, search))
        residuals[i] = search["residuals"]
        if status & UNSOLVED:
            where = f"y {lateral:.9f} yaw {yaw:.9f} roll {roll:.9f} load {search['load']:.3f}"
            print(f"{status_words(status & UNSOLVED)}: {pairs[pair]} {where}, {residuals[i]} residuals", flush=True)
        count += Counter(
            jumps=bool(status & STATUS_DISCONTINUOUS), unsolved=bool(status & STATUS_NOT_CONVERGED),
            kik_piotrowski=not status & UNSOLVED and int(a.rows.memo[0].strips) == 0 and float(a.total["Fb"]) > 0.0,
            fewer=0 < int(a.rows.memo[0].strips) < STRIPS,
        )  # fmt: skip
    median = float(np.median(residuals))
    return {name: count[name] for name in ("jumps", "unsolved", "kik_piotrowski", "fewer")} | {
        "poses": arguments.loads, "median_residuals": median, "largest_over_median": float(residuals.max() / median),
        "above_50_medians": int(np.count_nonzero(residuals > 50.0 * median)), "seconds": time.monotonic() - began,
    }  # fmt: skip


def walk(followed: Stand, afresh: Stand, random: np.random.Generator) -> Counter[str] | None:
    """One walk; None where it leaves the rail or its load."""
    start = random.uniform([-12e-3, -60e-3], [12e-3, 60e-3])
    end = np.clip(start + random.uniform(-1.0, 1.0, 2) * LONGEST, [-12e-3, -60e-3], [12e-3, 60e-3])
    knots = np.linspace(0.0, 1.0, KNOTS)
    heights = [afresh.touching(*(start + (end - start) * t)) for t in knots]
    if None in heights:
        return None
    depth = np.exp(PchipInterpolator(knots[::5], random.uniform(np.log(10e-6), np.log(150e-6), 5))(knots))
    height = PchipInterpolator(knots, np.array(heights, dtype=float) - depth)
    followed.arrays.follow(True)
    count: Counter[str] = Counter(walks=1)
    normal, lobes = [], []
    for t in np.linspace(0.0, 1.0, STEPS):
        lateral, yaw = start + (end - start) * t
        for stand in (followed, afresh):
            stand.strips.evaluate(lateral, float(height(t)), yaw, 0.0)
        normal.append([force(followed.strips), force(afresh.strips)])
        lobes.append(int(followed.arrays.total["lobes"]))
        memo = followed.arrays.rows.memo[0]
        count += Counter(
            steps=1, residuals=int(memo["iterations"]), jacobians=int(memo["factorisations"]),
            fewer=0 < int(memo["strips"]) < followed.wanted,
            unsolved=bool(followed.arrays.status & STATUS_NOT_CONVERGED),
            unsolved_afresh=bool(afresh.arrays.status & STATUS_NOT_CONVERGED),
        )  # fmt: skip
    forces = np.array(normal)
    load = np.maximum(forces[:, 1], LEAST)
    apart = np.abs(forces[:, 0] - forces[:, 1]) / load
    change = np.diff(forces, axis=0) / load[1:, None]
    beside = np.maximum(np.abs(change[:-2]), np.abs(change[2:]))
    jumps = np.abs(change[1:-1]) - beside > JUMP
    count["changes_of_lobes"] = int(np.count_nonzero(np.diff(lobes)))
    count["different"] = int(np.count_nonzero(apart > DIFFERENT))
    count["different_by_1e-3"] = int(np.count_nonzero(apart > 1e-3))
    count["jumps"], count["jumps_afresh"] = (int(n) for n in np.count_nonzero(jumps, axis=0))
    count["largest_ppm"] = int(1e6 * apart.max())
    return count


def walks(arguments: argparse.Namespace) -> dict[str, object]:
    """All walks."""
    random = np.random.default_rng(arguments.seed)
    pairs = [(Stand(pair, arguments.strips), Stand(pair, arguments.strips)) for pair in PAIRS]
    total: Counter[str] = Counter()
    largest = 0
    while total["walks"] < arguments.walks:
        counts = walk(*pairs[random.integers(len(pairs))], random)
        if counts is not None:
            largest = max(largest, counts.pop("largest_ppm"))
            total += counts
    names = (
        "walks", "steps", "residuals", "jacobians", "changes_of_lobes", "fewer", "unsolved",
        "unsolved_afresh", "different", "different_by_1e-3", "jumps", "jumps_afresh",
    )  # fmt: skip
    return {name: total[name] for name in names} | {"strips": arguments.strips, "largest_difference": 1e-6 * largest}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=100_000)
    parser.add_argument("--walks", type=int, default=0, help="Walks instead of poses.")
    parser.add_argument("--loads", type=int, default=0, help="Poses at loads instead of heights.")
    parser.add_argument("--strips", type=int, default=STRIPS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="File of blocks, added to.")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    kind = loads if arguments.loads else walks if arguments.walks else poses
    result = kind(arguments)
    print(json.dumps(result, indent=1))
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
