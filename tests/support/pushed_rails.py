"""Rails on sleepers in time: under prescribed forces, and under wheels that roll along them."""

import numpy as np

from support.vehicles import on_track, shipped
from wrsim.simulation.integrate import Integration, Monitor, Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.rails import RailsOnSleepers
from wrsim.simulation.steady_state import steady_state
from wrsim.simulation.system import BodySystem
from wrsim.track.sleepers import Layer, RailBeam, SleeperTrack
from wrsim.vehicle.dynamics import sleepers as kernel

TRACK = SleeperTrack(
    RailBeam(loss_factor=0.0), Layer((50e6, 200e6), (20e3, 30e3)), Layer((20e6, 50e6), (40e3, 60e3)), sleeper_mass=324.0
)


def standing(track: SleeperTrack, start: float) -> RailsOnSleepers:
    """The rails under a wheelset that stands at a place [m], at rest without load; its forces are prescribed."""
    rails = on_track(shipped("wheelset_s1002"), structure=track, start=start).law.on_sleepers
    assert rails is not None
    rails._state[1] = 1.0
    rails.wheels["push_b"] = 0.0
    for pair in (rails.rails.vertical, rails.rails.lateral):
        pair.rows[:] = 0.0
    return rails


def push(rails: RailsOnSleepers, step: float, forces: np.ndarray) -> np.ndarray:
    """One step under forces (wheels, 2) at its end; displacements of the rails under the wheels (wheels, 2)."""
    q, q_t, q_tt = np.zeros((3, forces.size))
    rails.begin(step, q, q_t, q_tt)
    wheels = rails.wheels
    n, b = forces[:, 0] - wheels["push_n"], forces[:, 1] - wheels["push_b"]
    q[0::2] += wheels["nn"] * n + wheels["nb"] * b
    q[1::2] += wheels["nb"] * n + wheels["bb"] * b
    rails.end(q)
    return np.array([kernel.read(kernel.U, i, rails.rails.loads, rails.rails) for i in range(len(forces))])


def response(rails: RailsOnSleepers, frequency: float, way: str, turns: int = 160) -> complex:
    """Amplitude of the rail under the left wheel, with its phase, under a harmonic force of 1 N there [m]; way:
    "vertical" or "lateral"; turns: steps a period."""
    step, amplitude, direction = 1.0 / (frequency * turns), 0.0 + 0.0j, 0 if way == "lateral" else 1
    periods = max(6, int(0.06 * frequency))
    for k in range(1, periods * turns + 1):
        phase = 2.0 * np.pi * k / turns
        forces = np.zeros((2, 2))
        forces[0, direction] = np.cos(phase)
        moved = push(rails, step, forces)[0, direction]
        if k > (periods - 1) * turns:
            amplitude += 2.0 / turns * moved * np.exp(-1j * phase)
    assert abs(rails.wheels["last_b"] - forces[:, 1]).max() < 1e-6
    return amplitude


def rolling(law: VehicleOnTrack, duration: float, step: float, monitor: Monitor | None = None) -> Motion:
    """A vehicle that goes on from its steady motion; monitor: called after every step."""
    start = steady_state(law)
    law.set_search_start(law.start)
    system = BodySystem(law.bodies, law)
    going = Integration(system, duration=duration, step=step, weight=law.vehicle.weight, monitor=monitor)
    return going.run(start.q, start.q_t)


def rolled(track: SleeperTrack, speed: float) -> dict[str, float]:
    """Means over both wheels of a wheelset that rolls along a track: how far the rail goes down under a wheel for its
    load ``down_m_per_N``, and its slope uphill for the load, ``slope_per_N``."""
    law, rows = on_track(shipped("wheelset_s1002"), speed, structure=track).law, []
    rails = law.on_sleepers
    assert rails is not None

    def look(t: float, q: np.ndarray, q_t: np.ndarray) -> None:
        load = -rails.wheels["last_b"]
        slope = [wheel.slope_b for wheel in law.wheel_records(0)]
        rows.append((np.mean(-q[-3::2] / load), np.mean(slope / load)))

    rolling(law, 0.2, 2e-4, look)
    down, slope = np.mean(rows[len(rows) // 2 :], axis=0)
    return {"down_m_per_N": float(down), "slope_per_N": float(slope)}
