"""The floor under every run: what a time step costs before any contact is evaluated.

    python benchmarks/bench_wheelset_floor.py

One wheelset in a curve, RK44 (four evaluations of the force law a step). Each line adds something to the line above;
times are the least of several repeats in this run, on one core. Compare ratios, not microseconds, between machines.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from wrsim.core.body.vehicle_forces import vehicle_forces
from wrsim.core.compiling import kernel
from wrsim.geometry.track.segments import Arc
from wrsim.geometry.track.track import Track
from wrsim.simulation.integrate import integrate
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import place_on_track
from wrsim.simulation.system import System
from wrsim.vehicle.loads import Load
from wrsim.vehicle.single_wheelset import single_wheelset
from wrsim.vehicle.wheelset import Wheel, Wheelset

STEPS, STEP, REPEATS = 10_000, 5e-4, 7


@kernel
def nothing(t, q, q_t, out):  # type: ignore[no-untyped-def]
    """A compiled law without forces."""
    out[0] = 0.0


@kernel
def loop(n, q, q_t, out, buffer, index):  # type: ignore[no-untyped-def]
    """n evaluations without Python in between."""
    total = 0.0
    for _ in range(n):
        vehicle_forces(0.0, q, q_t, out, buffer, index)
        total += out[2]
    return total


def least(function: Callable[[], object]) -> float:
    """Least time of ``REPEATS`` calls [s]; one call before them compiles."""
    function()
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        function()
        times.append(time.perf_counter() - begin)
    return min(times)


def main() -> None:
    """Measure and print."""
    wheel = Wheel(profile=None, radius=0.46)  # type: ignore[arg-type]
    wheelset = Wheelset("floor", 1813.0, (1120.0, 112.0, 1120.0), 1.5, wheel, wheel)
    vehicle = single_wheelset(wheelset, stiffness=(1e6, 1e6, 1e6), damping=(1e4, 1e4, 1e4), carried_mass=1.0)
    # no rails: a force that carries the weight
    lift = Load.constant("lift", "wheelset", (0.0, 0.0, vehicle.weight), (0.0, 0.0, wheelset.mean_radius))
    track = Track.build([Arc(400.0, 300.0, cant=0.1)])
    guided = VehicleOnTrack(replace(vehicle, loads=(lift,)), track, (), speed=15.0, start=10.0)
    q, q_t = place_on_track(track.centre, 10.0, speed=15.0, height=0.46, spin_rate=32.0)
    out = np.zeros(6)

    def solve(law: Callable[..., object]) -> float:
        system = System(guided.bodies, law)
        return least(lambda: system.solve(q, q_t, 0.0, STEP, STEPS, lambda t: True)) / STEPS

    def run(law: Callable[..., object], **keys: float) -> float:
        system = System(guided.bodies, law)
        return least(lambda: integrate(system, q, q_t, duration=STEPS * STEP, step=STEP, **keys)) / STEPS

    def python_law(t: float, q: object, q_t: object, out: object) -> None:
        pass

    def evaluations() -> None:
        loop(STEPS, q, q_t, out, guided.arena.buffer, guided.arena.index)

    bare = 4 * least(evaluations) / STEPS
    rows = [
        ("Exudyn with an empty Python law", solve(python_law)),
        ("... the law an empty compiled function", solve(nothing)),
        ("... kinematics, track, suspension, carried mass", solve(guided)),
        ("... finite check and a sample every 10th step", run(guided, sample_interval=10 * STEP)),
        ("... a sample every step", run(guided)),
    ]
    floor = rows[0][1]
    print(f"{'us a step':>10} {'us an evaluation':>17} {'ratio':>6}")
    for name, seconds in rows:
        print(f"{seconds * 1e6:10.2f} {seconds * 0.25e6:17.2f} {seconds / floor:6.2f}  {name}")
    print(f"{bare * 1e6:10.2f} {bare * 0.25e6:17.2f} {bare / floor:6.2f}  (the arithmetic of the third line alone)")
    share = rows[3][1] / STEP
    print(f"real time factor without contact at h = {STEP:g} s: {1.0 / share:.0f}")


if __name__ == "__main__":
    main()
