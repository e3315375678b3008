"""Trains on rails: each vehicle alone is what it is without a train, ends of vehicles swing as chords do, forces along
the train, a run that is cut off."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from support.runs import FAST, SCENARIOS, arc, straight
from support.vehicles import coaches, manchester, on_track

from wrsim import Arc, Scenario, Straight, load, run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.analysis.stability.rolling import RollingVehicle
from wrsim.jit.compiling import cores, use_threads
from wrsim.plots.histories import vehicle_figures
from wrsim.scenario.build import build
from wrsim.simulation.integrate import Integration
from wrsim.simulation.steady_state import TOLERANCE, SteadyMotion, steady_state
from wrsim.simulation.step_size import eigenvalues, growing_modes

TRAIN = (SCENARIOS.parent / "models/trains/manchester_3.toml").read_text(encoding="utf-8")
LENGTH, PIVOTS = 26.4, 19.0
FREE = (("pretension_kN = 20 ", "#"), ("= 6000 ", "= 1 "), ("= 3000 ", "= 1 "), ("preload_kN = 15 ", "#"),
        ("preload_kN = 10 ", "#"), ("plate_friction", "#"))  # fmt: skip
"""Couplings that hold nothing."""


def scenario(folder: Path, *changes: tuple[str, str], **keys: Any) -> Scenario:
    """The shipped scenario with a train of other words and a fast contact."""
    text = TRAIN
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "train.toml").write_text(text, encoding="utf-8")
    base: dict[str, Any] = {"vehicle.model": str(folder / "train.toml"), "vehicle.loads": [], "output.patches_at_m": []}
    return load(SCENARIOS / "train_s_curve.toml").with_values(base | FAST | keys)


def test_vehicles_that_nothing_couples_run_as_each_does_alone() -> None:
    """Two coaches into a curve, RK44: states within 1e-9 m and rad of those of either coach on its own."""
    train, speed, start = coaches(2), 15.0, 60.0
    inner = train.elements[: 2 * len(manchester().elements)]
    assert not any("-coach" in element.name for element in inner)
    segments = (Straight(start + 11.0), Arc(200.0, 300.0))
    pair = on_track(replace(train, elements=inner, couplings=()), speed, segments, start)
    q, q_t = np.zeros((2, pair.law.size))
    alone = []
    axles = len(manchester().wheelsets)
    for k, places in enumerate(pair.law.coordinates_of_units()):
        behind = train.wheelsets[k * axles].x - manchester().wheelsets[0].x
        single = on_track(manchester(), speed, segments, start + behind)
        rest = steady_state(single.law)
        q[places], q_t[places] = rest.q, rest.q_t
        alone.append(
            (places, Integration(single.system, duration=0.1, step=5e-4, integrator="rk44").run(rest.q, rest.q_t))
        )
    together = Integration(pair.system, duration=0.1, step=5e-4, integrator="rk44").run(q, q_t)
    assert np.ptp(alone[0][1].q[:, 2]) > 2e-5  # the first one is in the curve, and steers
    bodies = 6 * 7
    for places, motion in alone:
        np.testing.assert_allclose(together.q[:, places[:bodies]], motion.q[:, :bodies], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(together.q_t[:, places], motion.q_t, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize(
    "segment",
    [pytest.param(straight(200.0), marks=pytest.mark.campaign), arc(200.0, 300.0, 100.0)],
    ids=["straight", "curve"],
)
def test_coupled_coaches_start_on_uneven_track(segment: dict[str, Any], tmp_path: Path) -> None:
    """Neighbours stand some millimetres beside each other in height: plates and buffers stick there, which slip by the
    first derivative; in the curve the first wheelsets of the bogies lie on their flanges. The forces balance within the
    tolerance."""
    keys = {"track.segments": [segment], "vehicle.speed_kmh": 60.0, "run.start_distance_m": 150.0,
            "run.distance_m": 10.0, "track.irregularities": [{"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1,
            "wavelength_m": [3, 100]}]}  # fmt: skip
    setup = build(scenario(tmp_path, ("count = 3", "count = 2"), **keys))
    law = force_law(setup)
    assert SteadyMotion(law).largest(*start_state(setup, law)) < TOLERANCE


@pytest.mark.campaign
def test_the_ends_of_vehicles_swing_through_an_s_curve_as_chords_do(tmp_path: Path) -> None:
    """Slowly, with couplings that hold nothing: pivots on the centre line, ends on the chords through them. The largest
    lateral offset within 1 %, the angle at every place within 1 % of its largest value."""
    curves = [straight(14.0), arc(26.0, 190.0), straight(6.0), arc(26.0, -190.0), straight(30.0)]
    keys = {"track.segments": curves, "run.start_distance_m": 1.0, "run.distance_m": 59.0, "vehicle.speed_kmh": 10.0}
    asked = scenario(
        tmp_path, ("count = 3", "count = 2"), *FREE, **keys, **{"run.step_us": 10_000, "run.output_interval_ms": 50.0}
    )
    d = run(asked).dataset
    line, s = build(asked).track.centre, d["wheelset_distance"].values
    ends = []
    for k in (0, 1):
        front, rear = (line.position(s[:, i : i + 2].mean(axis=1)) for i in (4 * k, 4 * k + 2))
        along = (front - rear) / np.linalg.norm(front - rear, axis=1, keepdims=True)
        np.testing.assert_allclose(np.linalg.norm(front - rear, axis=1), PIVOTS, atol=0.01)
        middle = 0.5 * (front + rear)
        ends.append((middle + (-1.0 if k == 0 else 1.0) * 0.5 * LENGTH * along, along))
    (end_ahead, ahead), (end_behind, behind) = ends
    forward = (ahead + behind) / np.linalg.norm(ahead + behind, axis=1, keepdims=True)
    left = np.stack([-forward[:, 1], forward[:, 0]], axis=1)
    offset = np.einsum("ij,ij->i", (end_ahead - end_behind)[:, :2], left)
    yaw = np.arcsin(np.cross(behind, ahead)[:, 2])
    offsets = d["coupling_offset"].values[:, 0]
    assert np.abs(offset).max() > 0.35
    assert np.abs(offsets).max() == pytest.approx(np.abs(offset).max(), rel=0.01)
    assert np.abs(offsets - offset).max() < 0.02 * np.abs(offset).max()  # the coaches sway on their springs
    assert np.abs(d["coupling_yaw"].values[:, 0] - yaw).max() < 0.01 * np.abs(yaw).max()
    # in the full arc, in closed form: the overhang of either end beyond the centre line is alike on both coaches
    overhang = ((0.5 * LENGTH) ** 2 - (0.5 * PIVOTS) ** 2) / (2.0 * 190.0)
    assert np.abs(offset).max() < 2.0 * overhang  # the two ends lie on opposite sides at most
    assert np.abs(d["coupling_force"].values).max() < 500.0


def test_fast_modes_of_a_train_are_those_of_each_vehicle_between_neighbours_that_stand_still(tmp_path: Path) -> None:
    """Above 20 Hz wheelsets and bogies move; couplings act on the carbodies, which take part by some 1e-5."""
    track = {"track.segments": [straight(300.0)], "run.start_distance_m": 90.0}
    setup = build(scenario(tmp_path, ("count = 3", "count = 2"), **track))
    law = force_law(setup)
    state = law, law.bodies, *start_state(setup, law), 0.0
    whole = eigenvalues(*state)
    decaying = growing_modes(*state, -1.0)  # by e and more in 1 s
    expected = whole[(whole.imag > 2.0 * np.pi * 20.0) & (whole.real < -1.0)]
    assert len(decaying) == len(expected) > 20
    assert max(np.abs(expected - value).min() / abs(value) for value in decaying) < 1e-4


def test_modes_of_a_train_that_hardly_anything_couples_are_those_of_each_vehicle(tmp_path: Path) -> None:
    """Eigenvalues of two coaches at 100 km/h: those of one, twice, within 1e-3 of their size."""
    (tmp_path / "train.toml").write_text(TRAIN.replace("count = 3", "count = 2"), encoding="utf-8")
    base = load(SCENARIOS / "stability_manchester.toml")
    eigenvalues = []
    for model in ("vehicles/manchester_1.toml", str(tmp_path / "train.toml")):
        setup = build(base.with_values({"vehicle.model": model} | FAST))
        inner = [element for element in setup.vehicle.elements if "-coach" not in element.name]
        loose = replace(setup, vehicle=replace(setup.vehicle, elements=tuple(inner), couplings=()))
        rolling = RollingVehicle(loose, 27.8)
        eigenvalues.append(rolling.modes(27.8, replace(setup.plan, highest=30.0)).values)
    of_coach, of_train = eigenvalues
    assert len(of_train) == 2 * len(of_coach) > 20
    apart = np.abs(np.repeat(of_coach, 2)[:, None] - of_train[None, :]) / np.abs(of_train)
    assert apart[linear_sum_assignment(apart)].max() < 1e-3


def test_forces_of_a_coupling_are_those_of_its_elements_and_of_both_sides(tmp_path: Path) -> None:
    """In a curve with a tight coupling: hook and buffers add up to what the coupling says, and what acts on the vehicle
    behind, turned by the angle between the bodies, acts on that ahead the other way round."""
    keys = {"track.segments": [straight(14.0), arc(60.0, 190.0)], "run.start_distance_m": 1.0, "run.distance_m": 25.0}
    keys |= {"run.step_us": 10_000, "run.output_interval_ms": 50.0}
    asked = scenario(tmp_path, ("count = 3", "count = 2"), **keys)
    result = run(asked)
    d = result.dataset
    names = [f"coach1-coach2 {each}" for each in ("draw gear", "buffer left", "buffer right")]
    hook, left, right = (d["suspension_fx"].sel(suspension=name).values for name in names)
    force, ahead, behind, yaw = (
        d[f"coupling_{name}"].values[:, 0] for name in ("force", "fy_ahead", "fy_behind", "yaw")
    )
    tight = np.abs(left) > 60e3  # in a left curve the left buffer is pressed
    assert tight.sum() > 10
    assert np.abs(right[tight]).max() < 0.1 * np.abs(left[tight]).min()
    np.testing.assert_allclose(force[tight], (hook + left + right)[tight], atol=0.02 * np.abs(left).max())
    turned = (behind + ahead) / (2.0 * np.sin(0.5 * yaw))
    np.testing.assert_allclose(turned[tight], force[tight], atol=0.02 * np.abs(left).max())
    assert vehicle_figures(d)["vehicle_couplings"]().axes
    assert {"coach1.front.frame", "coach2.rear.frame"} <= set(d["body"].values)


def test_a_train_of_three_takes_all_cores_and_a_coach_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Unless told otherwise, and where threads can be had."""
    asked: list[int] = []
    monkeypatch.setattr("wrsim.analysis.resolved", lambda _: lambda setup, *_: asked.append(setup.threads))
    train, coach = load(SCENARIOS / "train_s_curve.toml"), load(SCENARIOS / "manchester_r300.toml")
    for case, options in ((train, {}), (train, {"threads": 1}), (coach, {})):
        run(case, **options)
    assert asked == [cores(), 1, 1]
    monkeypatch.setattr("wrsim.jit.compiling.use_threads", lambda _: use_threads(10**6))
    run(train)
    assert asked[-1] == 1
