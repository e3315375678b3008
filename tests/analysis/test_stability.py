"""Stability of vehicles: published critical speeds, growth rates two ways, limit cycles from above and from below."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.knife_edge import KnifeEdge, KnifeEdgeForces, example_wheelset
from support.rows import rows_of
from support.runs import SCENARIOS

from wrsim import InputError, Result, Scenario, load, run
from wrsim.analysis.stability.cycles import CycleSearch, nonlinear_outcome
from wrsim.analysis.stability.rolling import RollingVehicle
from wrsim.analysis.stability.run import run_stability
from wrsim.analysis.stationary.statics import static_state
from wrsim.plots import standard_pictures
from wrsim.results.tables import tables
from wrsim.scenario.build import Setup, build
from wrsim.scenario.sections.stability import StabilityPlan
from wrsim.simulation.integrate import Integration
from wrsim.simulation.modes import linearise
from wrsim.simulation.step_size import SAFETY, stable_step
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.loads import Load
from wrsim.vehicle.preload import preloads

table = rows_of(__file__)


def cooperrider(**values) -> Scenario:
    """The shipped scenario with some keys of [stability] changed."""
    scenario = load(SCENARIOS / "stability_cooperrider.toml")
    return scenario.with_values({f"stability.{key}": value for key, value in values.items()})


@cache
def modes() -> Result:
    return run(cooperrider(nonlinear=False, speed_kmh=[100, 180, 240, 260]))


def test_cooperriders_bogie_begins_to_hunt_at_the_published_speed():
    attributes = modes().dataset.attrs
    # 68.64 m/s at 3.998 Hz: plane model of the reference (published 68.66); the issue asks for 0.1 m/s and 0.5 %
    assert attributes["critical_speed_m_s"] == pytest.approx(68.64, abs=0.1)
    assert attributes["critical_frequency_Hz"] == pytest.approx(3.998, rel=0.005)
    assert "frame lateral" in attributes["critical_mode"]
    growth = modes().dataset["growth_max"].values
    assert (growth[:3] < 0.0).all() and growth[3] > 0.0


def test_the_same_mode_is_followed_from_speed_to_speed():
    dataset = modes().dataset
    unstable = int(np.nanargmax(dataset["mode_growth"].values[-1]))
    number = dataset["mode_branch"].values[-1, unstable]
    frequency = [
        dataset["mode_frequency"].values[i, j]
        for i, j in zip(*np.nonzero(dataset["mode_branch"].values == number), strict=True)
    ]
    assert len(frequency) == 4
    assert np.all(np.diff(frequency) > 0.0)  # hunting quickens with the speed


@pytest.mark.parametrize(
    ("speed", "growth", "frequency"), table("eigenvalues_of_the_three_dimensional_example_are_its_growth_rates")
)
def test_eigenvalues_of_the_three_dimensional_example_are_its_growth_rates(speed, growth, frequency):
    vehicle, law = example_wheelset(), KnifeEdge()
    forces = KnifeEdgeForces(vehicle, speed, law=law)
    rest = forces.rolling({"z": law.radius - law.approach(50e3)}, ("z",))
    values = np.linalg.eigvals(linearise(forces, forces.bodies, rest.q, rest.q_t).state_matrix)
    hunting = values[np.argmin(np.abs(values - 1j * frequency))]
    # three digits of the reference
    assert hunting.real == pytest.approx(growth, rel=0.01)
    assert hunting.imag == pytest.approx(frequency, rel=1e-3)


def test_growth_in_time_is_the_eigenvalue_s_for_a_whole_bogie():
    speed = 270.0 / 3.6
    rolling = RollingVehicle(build(cooperrider()), speed)
    values, vectors = np.linalg.eig(linearise(rolling.law, rolling.law.bodies, *rolling.state(speed)).state_matrix)
    most = int(np.argmax(values.real))
    q, q_t = rolling.state(speed)
    law = rolling.law
    n = law.size
    shape = vectors[:, most] / np.abs(vectors[: 6 * len(law.bodies), most]).max()
    q += 2e-6 * shape[:n].real
    q_t += 2e-6 * shape[n:].real
    system = BodySystem(law.bodies, law)
    step = min(SAFETY * stable_step(system, q, q_t), 5e-4)
    rolling.law.set_search_start(200.0)
    period = 2.0 * np.pi / values[most].imag
    motion = Integration(system, duration=4.0 * period, step=step, integrator="rk44", sample_interval=1e-3).run(q, q_t)
    lateral = motion.q[:, 2] * np.exp(-values[most].real * motion.times)
    first, last = (lateral[(motion.times > a * period) & (motion.times <= (a + 1.0) * period)] for a in (0.0, 3.0))
    growth = values[most].real + np.log(np.ptp(last) / np.ptp(first)) / (3.0 * period)
    assert growth == pytest.approx(values[most].real, rel=0.02)  # the 2 %


def test_below_the_linear_critical_speed_a_small_kick_dies_and_a_limit_cycle_lives_on():
    above, between, below = 262.0 / 3.6, 242.0 / 3.6, 215.0 / 3.6
    setup = build(cooperrider())
    search = CycleSearch(RollingVehicle(setup, above), setup.plan.cycles, [], lambda part: None)
    first, state = search.hold(above, "from above", search.kicked(above, 9e-3))
    large, later = search.hold(between, "from above", search.slowed(state, above - between))
    small, _ = search.hold(between, "from below", search.kicked(between, 0.3e-3))
    slower, _ = search.hold(below, "from above", search.slowed(later, between - below))
    assert [c.ending for c in (first, large, small, slower)] == ["cycle", "cycle", "rest", "rest"]
    # between the flanges, which touch at 9.1 mm, and a little into their springs
    assert 9.1e-3 < large.amplitudes.max() < first.amplitudes.max() < 11.5e-3
    assert 3.5 < large.frequency < first.frequency < 4.3
    assert search.cycles == [first, large, small, slower]


def test_an_interrupted_or_useless_search_for_limit_cycles_says_so():
    """Where the two agree the search ends a little above: straight running is unstable there without any cycle."""
    soft = nonlinear_outcome(233.4 / 3.6, 231.5 / 3.6, 60.0 / 3.6)
    assert np.isnan(soft["nonlinear_critical_speed_m_s"])
    assert "no limit cycle below the linear critical speed; the lowest one found is at 233.4 km/h" in soft.values()
    hard = nonlinear_outcome(220.0 / 3.6, 231.5 / 3.6, 60.0 / 3.6)
    assert hard == {"nonlinear_critical_speed_m_s": 220.0 / 3.6}
    dataset = run(cooperrider(speed_kmh=100, cycle_start_kmh=120, longest_s=3)).dataset
    assert np.isnan(dataset.attrs["nonlinear_critical_speed_m_s"])
    assert dataset.attrs["nonlinear_note"].startswith("no limit cycle at 120 km/h, where the search begins: ")
    assert dataset.sizes["cycle"] == 1


@pytest.mark.usefixtures("sketched")
def test_a_study_reads_well_on_screen_on_disk_and_as_pictures(tmp_path):
    result = run(
        cooperrider(
            speed_kmh=[200, 260], cycle_start_kmh=250, cycle_step_kmh=15, tolerance_kmh=15, window_s=0.4, longest_s=1.0
        )
    )
    assert result.dataset["cycle_amplitude"].dims == ("cycle", "wheelset")
    written = tables(result.dataset)
    assert written["modes"][0][:2] == ["pose_speed_kmh", "mode_branch"]
    assert len(written["cycles"]) == 1 + result.dataset.sizes["cycle"]
    head, _, held = result.numbers()
    assert head.notes[0].startswith("linear critical speed 247") and held.rows[0][1] == "from above"
    pictures = standard_pictures(result.dataset, tmp_path)
    assert [p.stem for p in pictures] == ["modes", "bifurcation"]
    result.save(tmp_path / "result.nc")
    assert Result.load(tmp_path / "result.nc").dataset.identical(result.dataset)


def test_an_interrupted_study_keeps_the_speeds_it_has():
    calls = []

    def impatient(fraction: float, left: float) -> None:
        calls.append(fraction)
        if len(calls) == 2:
            raise KeyboardInterrupt

    result = run(cooperrider(speed_kmh=[60, 80, 100, 120]), impatient)
    assert result.status == "stopped" and "interrupted" in result.stop_reason
    assert result.dataset.sizes["pose"] == 2
    assert result.summary()["linear_critical_speed_kmh"] is None


@pytest.mark.parametrize(("values", "message"), table("bad_input_is_answered_with_one_clear_line"))
def test_bad_input_is_answered_with_one_clear_line(values, message):
    with pytest.raises(InputError, match=message):
        build(load(SCENARIOS / "stability_cooperrider.toml").with_values(values))


def test_conical_wheels_are_for_stability_alone(tmp_path):
    base = SCENARIOS / "stability_cooperrider.toml"
    (tmp_path / "rest.toml").write_text(f'base = "{base}"\nanalysis = "equilibrium"\n')
    with pytest.raises(InputError, match=r"conical.*stability"):
        build(load(tmp_path / "rest.toml"))


# The CRH380A: weights, its yaw dampers, and two ends of one speed; on cones, for which no contact has to be solved.
BETWEEN = 480
"""Above 401 and 256, below 557 km/h, the linear critical speeds of docs/user/stability.md."""


@cache
def setup(conicity: float = 0.3, yaw_dampers: bool = True) -> Setup[StabilityPlan]:
    """The shipped scenario without its limit cycles."""
    values = {"contact.conical.conicity": conicity, "stability.nonlinear": False, "stability.speed_kmh": BETWEEN}
    complete = build(load(SCENARIOS / "stability_crh380a.toml").with_values(values))
    if yaw_dampers:
        return complete
    remaining = tuple(e for e in complete.vehicle.elements if "yaw damper" not in e.name)
    assert len(remaining) == len(complete.vehicle.elements) - 4
    return replace(complete, vehicle=replace(complete.vehicle, elements=remaining))


def growth(conicity: float = 0.3, yaw_dampers: bool = True) -> float:
    """Largest growth rate at that speed [1/s]."""
    return float(run_stability(setup(conicity, yaw_dampers)).dataset["growth_max"].item())


def test_its_springs_carry_the_masses_of_the_source_and_sink_by_both_stages_in_series():
    vehicle = setup().vehicle
    total = 40840.0 + 2.0 * 2280.0 + 4.0 * 1901.8
    loads = static_state(vehicle).wheel_loads
    assert loads == pytest.approx(np.full((4, 2), total * vehicle.gravity / 8.0), rel=1e-9)
    up = {e.name: preload.force[-1] for e, preload in zip(vehicle.elements, preloads(vehicle), strict=True)}
    air = [abs(force) for name, force in up.items() if "air spring" in name]
    assert air == pytest.approx([40840.0 * vehicle.gravity / 4.0] * 4, rel=1e-9)
    assert [force for name, force in up.items() if "bushing" in name] == pytest.approx([0.0] * 8, abs=1e-6)
    # the arms swing: upright they leave the springs alone, 4 x 260 kN/m on 8 x 1176
    vehicle = setup().vehicle
    force = 10e3
    load = Load.constant("load", "carbody", (0.0, 0.0, -force), (0.0, 0.0, 1.52))
    places = [body.name for body in vehicle.bodies]
    sunk = static_state(replace(vehicle, loads=(load,))).moved[places.index("carbody")][1]
    assert -sunk == pytest.approx(force / (4 * 260e3) + force / (8 * 1176e3), rel=1e-3)


def test_steeper_wheels_and_missing_yaw_dampers_make_it_hunt():
    assert growth() < 0.0
    assert growth(conicity=0.5) > 0.0
    assert growth(yaw_dampers=False) > 0.0
