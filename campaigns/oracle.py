"""A second judge of the normal problem: ContactMechanics' half-space on the same poses of seeded worn profiles.

    pip install ContactMechanics            # 1.8.3; no extra of ours has it
    python campaigns/oracle.py [--poses 300] [--seed 1] [--write]

ContactMechanics (L. Pastewka and others, MIT licence) solves the contact of a plane half-space that is not periodic
(FreeFFTElasticHalfSpace: influence of rectangles of constant pressure, constrained conjugate gradients). It gets the
gap of the two bodies along the normal at the main point on a grid, at the approach of the pose. That gap is computed
here from the points of the profiles, without the kernels, of surfaces of revolution by Newton's method. Both codes see
the same smoothed profiles, so the smoothing is not judged. After the rails a third of the poses is on rollers.

Six pairs of profiles: a standard one with bells of wear and noise of 1 um, points every 0.1 mm, all seeded; smoothed as
a file of points is. Poses: shift -5 to 5 mm, yaw -8 to 8 mrad, 20 to 120 kN, frictionless. One counts as planar where
there is one patch in which the normals turn by less than 3 degrees. --write: docs/data/standing/oracle.csv.
"""

import argparse
import csv
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim import ContactModel, ContactSettings, Profile, contact_model, load_profile
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.half_space.solver import HalfSpace
from wrsim.contact.models import exact_model
from wrsim.contact.pose import Pose
from wrsim.contact.profiles.points import ProfilePoints, smoothed
from wrsim.contact.tables import combined_modulus
from wrsim.simulation.pose_solver import PoseSolver

Array = NDArray[np.float64]

STANDING = Path(__file__).parents[1] / "docs/data/standing/oracle.csv"
WHEELS, RAILS = ("S1002", "S1002_worn"), (("60E1", 40), ("54E1", 20), ("60E1_worn", 40))
RADIUS, HALF_SPACING, HALF_GAUGE = 0.46, 0.75, 0.7175
SPACING, NOISE = 1e-4, 1e-6  # of the points of a scan, and of a point [m]
BELLS, DEEPEST = 3, 0.3e-3  # bells of wear on a profile, and the deepest of them [m]
NARROWEST, WIDEST = 8e-3, 25e-3  # half length of a bell [m]
PLANAR = np.radians(3.0)
ROLLER, FLAT = 0.8, 1e6  # radius of the rollers; of rails, as good as straight [m]
GRID = 160  # elements to either side of the patch
MARGIN = 1.25  # of the grid over the patch
COMPARED = ("half-space N", "half-space p0", "strips N", "strips p0")
MOST_DRAWN = 20  # poses drawn for one that is planar


def scan(profile: Profile, rng: np.random.Generator) -> Profile:
    """A worn profile as a measured one: bells d cos^2(pi x/2) of wear into the material, normal noise, smoothed."""
    arc = np.arange(0.0, profile.length, SPACING)
    (u, w), (tu, tw) = profile.at(arc), profile.tangent(arc)
    depth = rng.normal(0.0, NOISE, arc.size)
    for _ in range(BELLS):
        half, middle = rng.uniform(NARROWEST, WIDEST), rng.uniform(0.2, 0.8) * profile.length
        x = np.clip((arc - middle) / half, -1.0, 1.0)
        depth += rng.uniform(0.0, DEEPEST) * np.cos(0.5 * np.pi * x) ** 2
    into = -1.0 if profile.kind == "rail" else 1.0
    name = f"{profile.name}, seeded wear"
    points = ProfilePoints(name, u - into * depth * tw, w + into * depth * tu, np.arange(arc.size))
    return smoothed(points, name, profile.kind)


def height_over(
    foot: Array, out: Array, centre: Array, axle: Array, radius: float, profile: Profile, sign: float
) -> Array:  # fmt: skip
    """How far along ``out`` points (..., 3) are below a surface of revolution [m], by Newton's method: at the distance
    radius - w from the axle (sign 1, a wheel) or radius + w (sign -1, a roller)."""
    u, w = profile.at(np.linspace(0.0, profile.length, 20_000))
    rising = np.append(True, u[1:] > np.maximum.accumulate(u)[:-1] + 1e-9)
    height = scipy.interpolate.CubicSpline(u[rising], w[rising])
    h = np.zeros(foot.shape[:-1])
    for _ in range(12):
        arm = foot + h[..., None] * out - centre
        along = arm @ axle
        radial = arm - along[..., None] * axle
        rho = np.linalg.norm(radial, axis=-1)
        rate = -sign * (radial @ out) / rho - height(along, 1) * (out @ axle)
        h -= (sign * (radius - rho) - height(along)) / rate
    return h


def gap_along(model: ContactModel, lobe: Any, pose: Array, x: Array, s: Array) -> Array:
    """Interpenetration of the undeformed bodies along the normal of the main point, (x, s) [m]."""
    tangent, out = np.array([0.0, lobe["nb"], -lobe["no"]]), np.array([0.0, lobe["no"], lobe["nb"]])
    foot = np.array([0.0, lobe["o"], lobe["b"]]) + s[:, None] * tangent + x[:, None, None] * np.array([1.0, 0.0, 0.0])
    below = model.roller or FLAT
    rail = height_over(foot, out, np.array([0.0, 0.0, -below]), np.array([0.0, 1.0, 0.0]), below, model.rail, -1.0)
    return rail - height_over(foot, out, pose[:3], pose[3:6], model.radius, model.wheel, 1.0)


def judged(model: ContactModel, lobe: Any, pose: Array, region: Any) -> tuple[float, float]:
    """Normal force [N] and largest pressure [Pa] by ContactMechanics."""
    from ContactMechanics import FreeFFTElasticHalfSpace, make_system
    from SurfaceTopography import Topography

    x = 0.5 * (region.starts.min() + region.ends.max()), 0.5 * MARGIN * np.ptp([region.starts.min(), region.ends.max()])
    s_main = region.s[0] - lobe["start"]
    s = np.mean(region.s) - s_main, 0.5 * MARGIN * np.ptp(region.s)
    cells = (np.arange(GRID) + 0.5) / GRID * 2.0 - 1.0
    pen = gap_along(model, lobe, pose, x[0] + x[1] * cells, s[0] + s[1] * cells)
    sizes = 2.0 * x[1], 2.0 * s[1]
    substrate = FreeFFTElasticHalfSpace((GRID, GRID), combined_modulus(model.settings), sizes)
    system = make_system(interaction="hardwall", substrate=substrate, surface=Topography(pen, sizes))
    solved = system.minimize_proxy(offset=0.0, pentol=1e-5 * pen.max(), forcetol=1e-9)
    force = np.asarray(substrate.force)[:GRID, :GRID]
    if not solved.success:
        raise SystemExit(f"ContactMechanics has no solution: {solved.message}")
    return float(force.sum()), float(force.max()) / (sizes[0] * sizes[1] / GRID**2)


def compare(stand: PoseSolver, pose: Pose) -> tuple[bool, dict[str, float]] | None:
    """A pose by three codes, all at the strip model's height for the load; whether it is planar; None off that."""
    if stand.solve(pose).message:
        return None
    wheel = stand.wheels[0].model
    fast = {name: wheel.arrays.patches[: wheel.arrays.total.lobes][name].copy() for name in ("N", "p0")}
    exact = exact_model(wheel)
    exact.arrays.pose[:] = wheel.arrays.pose
    contact = HalfSpace.of(exact.settings.half_space).solve_pose(exact)
    regions = contact.largest(9)
    if contact.status or len(regions) != 1:
        return None
    (_, region), row = regions[0], wheel.arrays.pose.copy()
    exact.solve()
    turn = abs(region.angle[1] - region.angle[0])
    if turn >= PLANAR:
        return False, {}
    force, pressure = judged(exact, exact.arrays.patches[0], row, region)
    return True, {
        "y_mm": 1e3 * pose.lateral, "yaw_mrad": 1e3 * pose.yaw, "turn_deg": np.degrees(turn), "N_kN": force / 1e3,
        "p0_MPa": pressure / 1e6, "half-space N": region.normal_force / force - 1.0,
        "half-space p0": region.p0 / pressure - 1.0, "strips N": fast["N"].sum() / force - 1.0,
        "strips p0": fast["p0"].max() / pressure - 1.0,
    }  # fmt: skip


def stands(rng: np.random.Generator, roller: float | None) -> list[tuple[str, PoseSolver]]:
    """Six pairs of scans, each with a wheel over its rail."""
    pairs = []
    for wheel in WHEELS:
        for rail, slope in RAILS:
            profiles = (
                scan(load_profile(f"wheels/{wheel}.toml"), rng),
                scan(load_profile(f"rails/{rail}.toml").inclined(1.0 / slope), rng),
            )
            plain = ContactSettings(tangential="none", damping=0.0)
            model = contact_model(*profiles, RADIUS, plain, 0.0, roller=roller)
            origin = HALF_GAUGE - profiles[1].gauge_point()[0], -profiles[1].top[1]
            stand = PoseSolver([WheelOnRail(model, 1, HALF_SPACING, origin)], False, RADIUS)
            pairs.append((f"{wheel}/{rail} 1:{slope}", stand))
    return pairs


def judge(roller: float | None, poses: int, seed: int) -> list[dict[str, Any]]:
    """Rows of so many planar poses; prints medians and largest differences."""
    rng, below = np.random.default_rng(seed), "rails" if roller is None else f"rollers of {1e3 * roller:g} mm"
    pairs, rows, curved, left_out, drawn = stands(rng, roller), [], 0, 0, 0
    while len(rows) < poses and drawn < MOST_DRAWN * poses:
        name, stand = pairs[drawn % len(pairs)]
        y, yaw, load = rng.uniform(-5e-3, 5e-3), rng.uniform(-8e-3, 8e-3), rng.uniform(20e3, 120e3)
        answer = compare(stand, Pose("", y, yaw, load))
        drawn += 1
        left_out, curved = left_out + (answer is None), curved + (answer is not None and not answer[0])
        if answer is not None and answer[0]:
            rows.append({"below": below, "pair": name, **answer[1]})
    print(f"{below}: {len(rows)} planar poses; left out: {curved} that turn more, {left_out} of several patches")
    for key in COMPARED:
        errors = np.array([row[key] for row in rows])
        worst, most = int(np.argmax(np.abs(errors))), np.percentile(np.abs(errors), 95)
        place = ", ".join(f"{v:.5g}" if isinstance(v, float) else v for v in [*rows[worst].values()][1:7])
        print(f"{key}: median {np.median(errors):+.2e}, 95 % {most:.2e}, worst {errors[worst]:+.2e} ({place})")
    return rows


def main() -> None:
    """On rails and on rollers; writes the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    rows = judge(None, asked.poses, asked.seed) + judge(ROLLER, max(asked.poses // 3, 1), asked.seed)
    if asked.write:
        with STANDING.open("w", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(rows[0])
            table.writerows([[f"{v:.5g}" if isinstance(v, float) else v for v in row.values()] for row in rows])


if __name__ == "__main__":
    main()
