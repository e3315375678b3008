"""Suspension elements: laws that hold for every one of them, closed forms of simple systems; no rails needed."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from support.boxes import HEIGHT, INERTIA, MASS, box, derivatives, displaced, moment_kept, on_springs, spring, symmetric
from support.commands import refusal
from support.runs import FAST
from support.vehicles import ROOT, manchester, shipped

import wrsim
from wrsim.analysis.contacts import force_law
from wrsim.errors import InputError
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.bodies import Solid, mass_matrix, velocity_forces
from wrsim.simulation.integrate import Integration
from wrsim.simulation.modes import linearise, natural_modes
from wrsim.simulation.placement import design_state
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.elements import TRACK, Strut


@pytest.mark.parametrize("name", ["manchester_1", "cooperrider_bogie"])
def test_springs_have_a_potential_at_any_displacement(name: str) -> None:
    """The derivative of the generalised forces with respect to the coordinates is symmetric where nothing moves."""
    law = on_springs(shipped(name))
    q, q_t = displaced(law)
    q_t[: 6 * len(law.bodies)] = 0.0
    spins = range(5, 6 * len(law.vehicle.wheelsets), 6)  # which move no spring
    assert symmetric(derivatives(law, q, q_t, 6 * len(law.bodies)), *spins)


def test_elements_between_bodies_keep_momentum_and_angular_momentum() -> None:
    law = on_springs(manchester())
    q, q_t = displaced(law)
    law(0.0, q, q_t, np.zeros(law.size))
    moment_kept(law)


def test_a_mass_on_springs_swings_at_its_natural_frequency() -> None:
    k = (2e5, 3e5, 4e5)
    modes = natural_modes(box(spring(stiffness=k, turning_stiffness=(1e5, 2e5, 3e5))))
    x, y, z = np.sqrt(np.array(k) / MASS) / (2.0 * np.pi)
    roll, pitch, yaw = np.sqrt(np.array((1e5, 2e5, 3e5)) / np.array(INERTIA)) / (2.0 * np.pi)
    expected = {"longitudinal": x, "lateral": y, "vertical": z, "roll": roll, "pitch": pitch, "yaw": yaw}
    found = {mode.name.removeprefix("box "): mode for mode in modes}
    assert set(found) == set(expected)
    for name, frequency in expected.items():
        assert found[name].frequency == pytest.approx(frequency, rel=1e-6)
        assert abs(found[name].damping) < 1e-9


@pytest.mark.parametrize("damping", [5e2, 2e4, 5e5])
def test_a_mass_on_a_spring_and_a_damper_behind_a_spring_has_the_roots_of_its_cubic(damping: float) -> None:
    """m x_tt + k x + k_s (x - x_d) = 0, c x_d,t = k_s (x - x_d)."""
    k, series = 4e5, 6e5
    struts = Strut("d", "damper", TRACK, "box", ((0.0, 0.0, HEIGHT),) * 2, 2, damping=damping, series_stiffness=series)
    modes = natural_modes(box(spring(stiffness=(1e7, 2e7, k)), struts))
    mode = next(m for m in modes if m.name == "box vertical")
    lag = damping / series
    roots = np.roots([MASS * lag, MASS, (k + series) * lag, k])
    root = roots[np.argmax(roots.imag)]
    assert mode.frequency == pytest.approx(abs(root) / (2.0 * np.pi), rel=1e-6)
    assert mode.damping == pytest.approx(-root.real / abs(root), rel=1e-6)


def test_a_flexible_column_bends_like_a_cantilever() -> None:
    """Shear stiffness 12 E I/h^3 and bending stiffness E I/h at its middle: the loaded end yields by F h^3/(3 E I)."""
    stiffness, h = 2e6, 0.6
    column = spring(
        (0.0, 0.0, HEIGHT - 0.5 * h),
        stiffness=(12.0 * stiffness / h**3, 12.0 * stiffness / h**3, 1e8),
        turning_stiffness=(stiffness / h, stiffness / h, 1e8),
        column=True,
    )
    vehicle = box(column)
    weightless = replace(vehicle, bodies=(replace(vehicle.bodies[0], mass=1e-3),))  # a load would push the column over
    law = on_springs(weightless)
    q, q_t = design_state(law)
    matrix = linearise(law, law.bodies, q, q_t).stiffness[6:12, 6:12]
    yields = np.linalg.inv(matrix)
    assert yields[2, 2] == pytest.approx(h**3 / (3.0 * stiffness), rel=1e-6)
    assert abs(yields[4, 2]) == pytest.approx(h**2 / (2.0 * stiffness), rel=1e-6)  # slope of the end


def test_a_bump_stop_follows_its_table_both_ways_and_goes_on_beyond_it() -> None:
    stop = next(e for e in manchester().elements if e.name == "front.lateral stop")
    assert isinstance(stop, Strut)
    assert stop.limits == (-0.065, 0.065)
    law = on_springs(box(replace(stop, first=TRACK, second="box"), spring(stiffness=(1.0, 0.0, 1e6))))
    q, q_t = design_state(law)
    out = np.zeros(law.size)
    for travel, force in ((0.02, 0.0), (0.03, 600.0), (0.0425, 5300.0), (0.065, 230e3), (0.066, 270160.0)):
        for side in (1.0, -1.0):
            q[6 + 2] = side * travel
            law(0.0, q, q_t, out)
            assert out[6 + 2] == pytest.approx(-side * force, rel=1e-9, abs=1e-9)


def test_the_bodies_of_exudyn_accelerate_as_mass_matrix_and_velocity_forces_say() -> None:
    body = Solid(10.0, (2.0, 3.0, 4.0))

    def twist(t: float, q: np.ndarray, q_t: np.ndarray, out: np.ndarray) -> None:
        out[:] = (1.0, 2.0, 3.0, 0.4, 0.5, 0.6)

    system = BodySystem([body], twist)
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.3, -0.5])
    q_t = np.array([0.0, 0.0, 0.0, 1.1, -0.7, 0.9])
    step = 1e-4
    motion = Integration(system, duration=2 * step, step=step, integrator="rk44").run(q, q_t)
    found = (motion.q_t[2] - motion.q_t[0]) / (2 * step)
    out = np.zeros(6)
    twist(step, motion.q[1], motion.q_t[1], out)
    h = velocity_forces([body], motion.q[1], motion.q_t[1])
    middle = np.linalg.solve(mass_matrix([body], motion.q[1]), out - h)
    assert np.allclose(found, middle, rtol=1e-6, atol=1e-6)


# Contacts that several threads compute side by side.
SCENARIO = ROOT / "scenarios/manchester_r300.toml"


def test_threads_change_no_bit():
    # strips start from their last answer, so that every state tells what the one before has left
    setup = build(load(SCENARIO).with_values({"contact.strips": 12, "run.start_distance_m": 70.0}))
    found = []
    for threads in (1, 2):
        law = force_law(replace(setup, threads=threads))
        q, q_t = design_state(law)
        wheels = slice(6 * len(law.wheels))
        rng, out = np.random.default_rng(3), np.zeros(law.size)
        law.follow(True)
        for _ in range(6):
            q[wheels] += 2e-5 * rng.standard_normal(q[wheels].shape)
            law(0.0, q, q_t, out)
            found.append(out.tobytes() + law.get_state().tobytes())
    assert found[:6] == found[6:]
    assert len(set(found)) == 6


def test_more_threads_than_cores_are_refused(monkeypatch):
    with pytest.raises(InputError, match=r"threads: must be a whole number from 1 to \d+.*not 100000"):
        force_law(replace(build(load(SCENARIO).with_values(FAST)), threads=100_000))
    assert "threads: must be" in refusal("run", str(SCENARIO), "--threads", "100000")
    monkeypatch.setitem(sys.modules, "numba.np.ufunc.omppool", None)
    with pytest.raises(InputError, match="need OpenMP"):
        wrsim.run(load(SCENARIO), threads=2)
