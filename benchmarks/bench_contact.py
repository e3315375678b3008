"""Time of one wheel on one rail, against the bare arithmetic inside it. Run: python benchmarks/bench_contact.py

Prints microseconds (minimum of repeats) for some poses, and where they go: the call from Python, the search, the
curved patch with its pressure, the creep forces. The bare arithmetic is measured in the same run: as many K - E
evaluations and FASTSIM cells in a plain loop as one patch needs, once with the cells one after the other along each
strip ("scalar") and once as the kernel does it, all strips side by side ("side by side"). A second table holds the
tangential models: the time of each, what a strip more costs and what a cell more costs. A third one holds the strip
model with FaStrip: cold as in static analyses, and from the last contact as in runs, at rest and moving sideways by
up to 0.6 um from call to call. Grids: docs/theory/strip_model.md. A fourth one holds poses at a prescribed load over a
sweep of the shift: the time of a pose beside that of the cold contacts that a root finder on the height takes.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import blas_threads  # noqa: F401 (before numpy)
import numpy as np

from wrsim.contact import records as k
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.creep.fastsim import fastsim
from wrsim.contact.creep.flexibility import Creepages, Flexibilities, Rolling
from wrsim.contact.creep.laws import CREEP_LAWS, KERNEL_LAWS
from wrsim.contact.kik_piotrowski import strip_potential
from wrsim.contact.models import contact_model
from wrsim.contact.pose import Pose
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import ContactSettings, Friction
from wrsim.contact.wheel_rail import search as search_contacts
from wrsim.contact.wheel_rail import wheel_rail
from wrsim.jit import kernel
from wrsim.simulation.pose_solver import PoseSolver

MODELS = Path(__file__).parents[1] / "models"
POSES = (("tread, two lobes", 0.0, 0.002), ("tread", 3e-3, 0.002), ("tread and root", 5.06e-3, 0.001),
         ("gauge corner", 6.5e-3, 0.005), ("flange", 8e-3, 0.01))  # fmt: skip
YAWED = (("flange, slanted", 8e-3, 0.02), ("bent locus, 6.7 mm", 6.7e-3, 0.016), ("6.6 mm", 6.6e-3, 0.016),
         ("6.5 mm", 6.5e-3, 0.02))  # fmt: skip


def microseconds(function: Callable[[], object], calls: int = 200, repeats: int = 60) -> float:
    """Minimum over the repeats of the mean over the calls."""
    function()
    best = np.inf
    for _ in range(repeats):
        began = time.perf_counter()
        for _ in range(calls):
            function()
        best = min(best, (time.perf_counter() - began) / calls)
    return 1e6 * best


@kernel
def bare(strips, n, reps, shape, work, side_by_side, cells):  # type: ignore[no-untyped-def]
    """reps times: n K - E evaluations and n x cells FASTSIM cells."""
    total = 0.0
    for _ in range(reps):
        for i in range(n):
            total += strip_potential(strips[i].a, strips[i].s)
        if side_by_side:
            on = Rolling(strips, n, Flexibilities(1e-12, 1e-12, 1e-12), 1.0, shape, work, work[:0], work[:0])
            fastsim(on, Creepages(1e-4, 1e-4, 0.0), 1.0)
            continue
        for i in range(n):
            qx = 0.0
            qy = 0.0
            step = strips[i].xi * strips[i].a * 1e10
            for j in range(cells):
                qx -= step
                qy -= step * (1.0 - j)
                bound = 0.3 * strips[i].p * shape[j]
                size = np.sqrt(qx * qx + qy * qy)
                if size > bound:
                    qx *= bound / size
                    qy *= bound / size
                total += qx + qy
    return total


@kernel
def nothing(buffer, index):  # type: ignore[no-untyped-def]
    """Takes what the kernel takes."""
    return 0


LADDER = [f"{name}{kind}" for name in KERNEL_LAWS for kind in ("", ", blended")[: 1 + CREEP_LAWS[name].flexibility]]


def creep_time(
    wheel: Profile, rail: Profile, tangential: str, friction: float | Friction, strips: int, cells: int
) -> float:
    """Time of a tangential model alone: the whole evaluation on the tread less that without creep forces [us]."""
    origin = (0.7175 - rail.gauge_point()[0], -rail.top[1])
    name, _, option = tangential.partition(", ")
    settings = ContactSettings(
        "kik-piotrowski", strips=strips, cells=cells, tangential=name, flexibility=option or "three"
    )  # type: ignore[arg-type]
    times = []
    for chosen in (settings, replace(settings, tangential="none")):
        model = contact_model(wheel, rail, 0.46, chosen, friction)
        PoseSolver([WheelOnRail(model, 1, 0.75, origin)], True, 0.46).solve(Pose("tread", 3e-3, 0.002, 55e3))
        arguments = model.arrays.buffer, model.arrays.index
        times.append(microseconds(lambda arguments=arguments: wheel_rail(*arguments)))
    return times[0] - times[1]


def ladder(wheel: Profile, rail: Profile) -> None:
    """Print the time of every tangential model, and how it grows with strips and cells."""
    print(f"\n{'creep forces alone, us':24s}{'40 x 20':>8s}{'a strip':>10s}{'a cell':>10s}{'falling, zones':>16s}")
    law = Friction(0.35, gauge_corner=0.2, falling_ratio=0.4)
    for name in LADDER:
        first, longer, wider = (creep_time(wheel, rail, name, 0.35, n, m) for n, m in ((40, 20), (40, 60), (80, 20)))
        cell = (longer - first) / (40 * 40)
        strip = (wider - first) / 40 - 20 * cell
        with_law = creep_time(wheel, rail, name, law, 40, 20)
        print(f"  {name:22s}{first:8.2f}{strip:10.4f}{cell:10.4f}{with_law - first:+16.2f}")


def strip_model(wheel: Profile, rail: Profile) -> None:
    """Print the time of the strip model, and how it grows with the strips."""
    heads = "".join(f"{head:>9s}" for head in ("strips", "grids", "cold", "at rest", "moving", "a strip"))
    print(f"\n{'strip model, us':24s}{heads}")
    origin = (0.7175 - rail.gauge_point()[0], -rail.top[1])
    for name, lateral, yaw in POSES + YAWED:
        last: tuple[int, float] | None = None
        for strips in (16, 20, 24):
            settings = ContactSettings(normal="strips", strips=strips)
            model = contact_model(wheel, rail, 0.46, settings, 0.35)
            PoseSolver([WheelOnRail(model, 1, 0.75, origin)], True, 0.46).solve(Pose(name, lateral, yaw, 55e3))
            a = model.arrays
            arguments = a.buffer, a.index
            cold = microseconds(lambda arguments=arguments: wheel_rail(*arguments), 20, 20)
            a.follow(True)
            at_rest = microseconds(lambda arguments=arguments: wheel_rail(*arguments), 50, 30)
            place, phase = a.pose[1], [0.0]

            def move(a=a, arguments=arguments, place=place, phase=phase) -> None:  # type: ignore[no-untyped-def]
                phase[0] += 0.3
                a.pose[1] = place + 2e-6 * np.sin(phase[0])
                wheel_rail(*arguments)

            moving = microseconds(move, 50, 30)
            more = f"{(moving - last[1]) / (strips - last[0]):9.2f}" if last else ""
            count = int(a.rows.memo[0]["grids"])
            print(f"  {name:22s}{strips:9d}{count:9d}{cold:9.1f}{at_rest:9.1f}{moving:9.1f}{more}")
            last = strips, moving


ROOT_FINDER = 21.5  # cold contacts a pose of Brent's method from two heights on, the mean over this sweep


def prescribed_load(wheel: Profile, rail: Profile) -> None:
    """Print the time of a pose at a prescribed load, beside that of a cold contact in the same run."""
    print(f"\n{'prescribed load, us':24s}{'a pose':>9s}{'cold':>9s}{'a pose / cold':>15s}{'root finder / a pose':>22s}")
    origin = (0.7175 - rail.gauge_point()[0], -rail.top[1])
    for normal in ("kik-piotrowski", "strips"):
        model = contact_model(wheel, rail, 0.46, ContactSettings(normal=normal), 0.35)  # type: ignore[arg-type]
        bench = PoseSolver([WheelOnRail(model, 1, 0.75, origin)], True, 0.46)
        poses = np.empty((141, k.POSE))
        for row, shift in zip(poses, np.linspace(-6e-3, 8e-3, len(poses)), strict=True):
            bench.place(float(shift), 0.48, 2e-3, 0.0)
            row[:] = model.arrays.pose
        loaded = model.solve_many(poses, 55e3, threads=1).poses
        pose, cold = (
            microseconds(call, 1, 5) / len(poses)
            for call in (
                lambda model=model, poses=poses: model.solve_many(poses, 55e3, threads=1),
                lambda model=model, loaded=loaded: model.evaluate_many(loaded, threads=1),
            )
        )
        print(f"  {normal:22s}{pose:9.1f}{cold:9.1f}{pose / cold:15.2f}{ROOT_FINDER * cold / pose:22.1f}")


def main() -> None:
    """Print the tables."""
    wheel = load_profile(MODELS / "wheels/S1002.toml")
    rail = load_profile(MODELS / "rails/60E1.toml").inclined(1 / 40)
    origin = (0.7175 - rail.gauge_point()[0], -rail.top[1])
    print(f"{'us':24s}{'total':>8s}{'call':>8s}{'search':>8s}{'patch':>8s}{'creep':>8s}{'lobes':>7s}{'x bare':>8s}")
    for strips, cells in ((40, 20), (25, 12)):
        settings = ContactSettings("kik-piotrowski", strips=strips, cells=cells)
        model = contact_model(wheel, rail, 0.46, settings, 0.35)
        bench = PoseSolver([WheelOnRail(model, 1, 0.75, origin)], True, 0.46)
        frictionless = contact_model(wheel, rail, 0.46, replace(settings, tangential="none"), 0.35).arrays
        a = model.arrays
        arguments = a.buffer, a.index
        call = microseconds(lambda arguments=arguments: nothing(*arguments))
        floors: dict[str, float] = {}
        measured = min(strips, 20)  # strips in the bare loop, scaled up
        for name, lateral, yaw in POSES:
            bench.solve(Pose(name, lateral, yaw, 55e3))
            if not floors:
                rows = a.strips[0]
                for kind, side_by_side in (("scalar", False), ("side by side", True)):
                    floors[kind] = microseconds(
                        lambda rows=rows, s=side_by_side, a=a, n=measured, c=cells: bare(
                            rows, n, 100, a.rows.shape, a.rows.work, s, c
                        ),
                        2, 30,
                    ) / 100 * strips / measured  # fmt: skip
                print(
                    f"{strips} strips x {cells} cells; bare arithmetic "
                    + ", ".join(f"{kind} {value:.2f}" for kind, value in floors.items())
                )
            total = microseconds(lambda arguments=arguments: wheel_rail(*arguments))
            lobes = int(a.total["lobes"])
            frictionless.pose[:] = a.pose
            bare_arguments = frictionless.buffer, frictionless.index
            normal = microseconds(lambda arguments=bare_arguments: wheel_rail(*arguments))
            search = microseconds(lambda arguments=arguments: search_contacts(*arguments)) - call
            print(
                f"  {name:22s}{total:8.2f}{call:8.2f}{search:8.2f}{normal - call - search:8.2f}"
                f"{total - normal:8.2f}{lobes:7d}{total / floors['scalar']:8.2f}"
            )
    ladder(wheel, rail)
    strip_model(wheel, rail)
    prescribed_load(wheel, rail)


if __name__ == "__main__":
    main()
