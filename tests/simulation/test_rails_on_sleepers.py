"""Rails on sleepers in time: receptances, waves, energy, and the same run after an interruption."""

from dataclasses import replace

import numpy as np
import pytest
from support.vehicles import on_track, shipped

from wrsim.core.body import sleepers as kernel
from wrsim.geometry.track.sleepers import Layer, RailBeam, SleeperTrack
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.rails import RailsOnSleepers
from wrsim.simulation.steady_state import steady_state
from wrsim.simulation.system import BodySystem

TRACK = SleeperTrack(
    RailBeam(loss_factor=0.0), Layer((50e6, 200e6), (20e3, 30e3)), Layer((20e6, 50e6), (40e3, 60e3)), sleeper_mass=324.0
)


def standing(track: SleeperTrack, start: float) -> RailsOnSleepers:
    """The rails under a wheelset that stands at a place [m], at rest without load; its forces are prescribed."""
    rails = on_track(shipped("wheelset_s1002"), structure=track, start=start).law.on_sleepers
    assert rails is not None
    rails._state[1] = 1.0
    rails.ties["push_b"] = 0.0
    for pair in (rails.rails.vertical, rails.rails.lateral):
        pair.rows[:] = 0.0
    return rails


def push(rails: RailsOnSleepers, step: float, forces: np.ndarray) -> np.ndarray:
    """One step under forces (wheels, 2) at its end; displacements of the rails under the wheels (wheels, 2)."""
    q, q_t, q_tt = np.zeros((3, forces.size))
    rails.begin(step, q, q_t, q_tt)
    ties = rails.ties
    n, b = forces[:, 0] - ties["push_n"], forces[:, 1] - ties["push_b"]
    q[0::2] += ties["nn"] * n + ties["nb"] * b
    q[1::2] += ties["nb"] * n + ties["bb"] * b
    rails.end(q, q_t)
    return np.array([kernel.read(kernel.U, i, rails.rails) for i in range(len(forces))])


@pytest.mark.parametrize(
    ("way", "frequency"),
    [
        ("vertical", 400.0),
        ("lateral", 60.0),
        *(
            pytest.param(*case, marks=pytest.mark.campaign)
            for case in (
                ("vertical", 60.0), ("vertical", 1500.0), ("lateral", 400.0), ("lateral", 1500.0),
            )
        ),
    ],
)  # fmt: skip
def test_a_harmonic_force_moves_the_rail_as_its_receptance_says(frequency: float, way: str) -> None:
    track, turns = replace(TRACK, elements=12), 160
    rails = standing(track, 60.0)  # above a sleeper
    step = 1.0 / (frequency * turns)
    periods = max(6, int(0.06 * frequency))
    found = 0.0
    for k in range(1, periods * turns + 1):
        phase = 2.0 * np.pi * k / turns
        forces = np.zeros((2, 2))
        forces[0, 0 if way == "lateral" else 1] = np.cos(phase)
        moved = push(rails, step, forces)[0, 0 if way == "lateral" else 1]
        if k > (periods - 1) * turns:
            found += 2.0 / turns * moved * np.exp(-1j * phase)
    assert rails.ties["last_b"] == pytest.approx(forces[:, 1], abs=1e-6)
    exact = track.receptance([frequency], 60.0, way, elements=12)[0]
    assert found == pytest.approx(exact, rel=0.01)


def energy(rails: RailsOnSleepers) -> float:
    """Kinetic and elastic energy of all systems [J]."""
    total = 0.0
    for pair in (rails.rails.vertical, rails.rails.lateral):
        for r in range(2):
            u, u_t = pair.rows[r, kernel.U], pair.rows[r, kernel.U_T]
            total += 0.5 * u_t @ times(pair.mass[r], u_t) + 0.5 * u @ times(pair.stiffness[r], u)
    return total


def lost(rails: RailsOnSleepers) -> float:
    """Power of all dampers [W]."""
    total = 0.0
    for pair in (rails.rails.vertical, rails.rails.lateral):
        for r in range(2):
            u_t = pair.rows[r, kernel.U_T]
            total += u_t @ times(pair.damping[r], u_t) + pair.drag[r] @ u_t**2
    return total


def times(band: np.ndarray, x: np.ndarray) -> np.ndarray:
    out = np.zeros_like(x)
    kernel.subtract_product(band, x, out)
    return -out


def test_the_work_of_a_blow_is_stored_or_lost_in_dampers() -> None:
    rails, step = standing(TRACK, 60.2), 5e-6  # between two nodes
    work = dissipated = 0.0
    last, power, force = np.zeros((2, 2)), lost(rails), np.zeros((2, 2))
    for k in range(1, 1601):
        now = np.zeros((2, 2))
        now[0] = np.array([20e3, -100e3]) * np.sin(np.pi * min(k * step / 2e-3, 1.0)) ** 2
        moved = push(rails, step, now)
        work += float(np.sum(0.5 * (now + force) * (moved - last)))
        dissipated += 0.5 * step * (power + lost(rails))
        last, power, force = moved, lost(rails), now
        if k == 200:
            half = work, energy(rails) + dissipated
    assert half[1] == pytest.approx(half[0], rel=1e-3)
    assert energy(rails) + dissipated == pytest.approx(work, rel=1e-3)
    assert energy(rails) < 0.05 * work


def test_waves_do_not_come_back_from_the_ends_of_the_window() -> None:
    def after_a_blow(margin: float) -> np.ndarray:
        rails = standing(replace(TRACK, margin=margin, elements=2), 60.0)
        found = []
        for k in range(400):
            force = np.array([[0.0, -50e3 * np.sin(np.pi * k / 8) if k < 8 else 0.0], [0.0, 0.0]])
            found.append(push(rails, 5e-5, force)[0, 1])
        return np.array(found)

    near, far = after_a_blow(10.0), after_a_blow(40.0)
    assert np.abs(near - far).max() < 0.01 * np.abs(far).max()


def law_of_a_wheelset() -> VehicleOnTrack:
    return on_track(shipped("wheelset_s1002"), 25.0, structure=replace(TRACK, scatter=0.02, seed=5)).law


def test_a_run_goes_on_from_its_snapshot_to_the_bit() -> None:
    law = law_of_a_wheelset()
    start = steady_state(law)
    law.look_near(law.start)
    going = {"step": 1e-3, "segment": 60, "weight": law.vehicle.weight}
    whole = Integration(BodySystem(law.bodies, law), duration=0.12, **going).run(start.q, start.q_t)
    law = law_of_a_wheelset()
    law.look_near(law.start)
    half = Integration(BodySystem(law.bodies, law), duration=0.06, **going).run(start.q, start.q_t)
    state = law.get_state()
    law = law_of_a_wheelset()
    law.set_state(state)
    rest = Integration(BodySystem(law.bodies, law), duration=0.06, start=0.06, **going).run(half.q[-1], half.q_t[-1])
    assert np.array_equal(rest.q[-1], whole.q[-1])
    assert np.array_equal(rest.q_t[-1], whole.q_t[-1])


def test_wheels_on_sleepers_rise_and_sink_with_the_sleepers() -> None:
    law = on_track(shipped("wheelset_s1002"), 20.0, structure=TRACK).law
    start = steady_state(law)
    law.look_near(law.start)
    motion = Integration(BodySystem(law.bodies, law), duration=0.24, step=1e-3, weight=law.vehicle.weight).run(
        start.q, start.q_t
    )  # 8 sleepers
    sunk = motion.q[120:, -3]
    assert sunk == pytest.approx(np.mean(sunk), rel=0.1)
    parts = np.abs(np.fft.rfft(sunk - sunk.mean()))
    assert np.argmax(parts) == round(0.12 / (0.6 / 20.0))
