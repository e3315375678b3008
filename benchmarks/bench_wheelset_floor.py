"""The floor under every run: what a time step costs before any contact is evaluated.

    python benchmarks/bench_wheelset_floor.py

One wheelset in a curve, RK44 (four evaluations of the force law a step). Each line adds something to the line above;
times are the least of several repeats in this run, on one core. Compare ratios, not microseconds, between machines.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numba import njit

from wrsim.core.body.carrier import carrier_forces
from wrsim.core.body.kinematics import generalised_forces, kinematics
from wrsim.core.track.path import frame, locate
from wrsim.geometry.track.segments import Arc
from wrsim.geometry.track.track import Track
from wrsim.simulation.carrier import carrier_parameters
from wrsim.simulation.integrate import integrate
from wrsim.simulation.placement import place_on_track
from wrsim.simulation.system import RigidBody, System
from wrsim.vehicle.wheelset import Suspension, Wheel, Wheelset

STEPS, STEP, REPEATS = 10_000, 5e-4, 7


@njit(cache=True)
def nothing(t, q, q_t, out):
    """A compiled law without forces."""
    out[0] = 0.0


@njit(cache=True)
def without_rails(t, q, q_t, path, step, parameters, memory, out):
    """All forces but those of the rails."""
    body = kinematics(q, q_t)
    s, status = locate(path, step, body[0], body[1], body[2], memory[0])
    memory[0] = s
    f = carrier_forces(t, body, frame(path, step, s), path, step, parameters)
    generalised_forces(body, (f[0], f[1], f[2]), (f[3], f[4], f[5]), out)
    return status


@njit(cache=True)
def loop(n, t, q, q_t, path, step, parameters, memory, out):
    """n evaluations without Python in between."""
    total = 0.0
    for _ in range(n):
        without_rails(t, q, q_t, path, step, parameters, memory, out)
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
    wheelset = Wheelset(
        "floor",
        1813.0,
        (1120.0, 112.0, 1120.0),
        1.5,
        wheel,
        wheel,
        Suspension((1e6, 1e6, 1e6), (1e4, 1e4, 1e4), 1.0),
        # no rails: a force that carries the weight
        constant_force=(0.0, 0.0, 1813.0 * 9.80665),
    )
    track = Track.build([Arc(400.0, 300.0, cant=0.1)])
    path, path_step = track.centre.table, track.centre.step
    q, q_t = place_on_track(track.centre, 10.0, speed=15.0, height=0.46, spin_rate=32.0)
    parameters = carrier_parameters(wheelset, speed=15.0, start=10.0)
    memory = np.array([10.0])
    body = RigidBody.of(wheelset)
    out = np.zeros(6)

    def solve(law: Callable[..., object]) -> float:
        system = System([body], law)
        return least(lambda: system.solve(q, q_t, 0.0, STEP, STEPS, lambda t: True)) / STEPS

    def run(law: Callable[..., object], **keys: float) -> float:
        system = System([body], law)
        return least(lambda: integrate(system, q, q_t, duration=STEPS * STEP, step=STEP, **keys)) / STEPS

    def python_law(t: float, q: object, q_t: object, out: object) -> None:
        pass

    def carried(t: float, q: object, q_t: object, out: object) -> None:
        without_rails(t, q, q_t, path, path_step, parameters, memory, out)

    def evaluations() -> None:
        loop(STEPS, 0.0, q, q_t, path, path_step, parameters, memory, out)

    bare = 4 * least(evaluations) / STEPS
    rows = [
        ("Exudyn with an empty Python law", solve(python_law)),
        ("... the law an empty compiled function", solve(nothing)),
        ("... kinematics, track, suspension, sprung mass", solve(carried)),
        ("... finite check and a sample every 10th step", run(carried, sample_interval=10 * STEP)),
        ("... a sample every step", run(carried)),
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
