"""Speed along the line, motors and brakes: where the frame is, what the energy becomes, what adhesion lets through."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, quad
from support.boxes import AT, FIXED, MASS, box, displaced, motion, on_springs, slides, spring
from support.rows import rows_of
from support.runs import straight
from support.scenario_texts import CURVE, faults
from support.vehicles import COARSE, ROOT, manchester, on_track

from wrsim import Result, Scenario, load, run
from wrsim.analysis.contacts import force_law
from wrsim.scenario.build import build
from wrsim.simulation.placement import design_state
from wrsim.vehicle.dynamics.vehicle_forces import PIECE, motion_at
from wrsim.vehicle.elements import TRACK, Element, PlaneFriction, Slider, Strut
from wrsim.vehicle.loads import Effort
from wrsim.vehicle.speed import SpeedProfile

table = rows_of(__file__)

COACH = ROOT / "scenarios/manchester_r300.toml"


def on_straight(**keys: object) -> Scenario:
    """The coach on 90 m of straight track, with further keys (dots written as two underscores)."""
    keys_of_track = {"track.segments": [straight(90.0)], "run.start_distance_m": 14.0, "run.output_interval_ms": 10.0}
    return load(COACH).with_values(
        COARSE | keys_of_track | {key.replace("__", "."): value for key, value in keys.items()}
    )


@pytest.mark.parametrize(
    "profile",
    [
        SpeedProfile.over_time([(0.5, 10.0), (2.0, 16.0), (3.0, 4.0)]),
        SpeedProfile.over_distance([(105.0, 10.0), (125.0, 16.0), (135.0, 4.0)], 100.0),
    ],
)
def test_the_frame_runs_as_far_as_its_speed_says(profile):
    for t in (0.2, 1.7, 2.9, 6.0):
        way, _ = quad(
            lambda instant: float(profile.speed(instant)), 0.0, t, points=[p[0] for p in profile.pieces if 0 < p[0] < t]
        )
        assert float(profile.way(t)) == pytest.approx(way, rel=1e-9)
        assert profile.time(float(profile.way(t))) == pytest.approx(t, rel=1e-12)
        pieces = np.array(list(profile.pieces), PIECE)
        assert motion_at(t, pieces)[:2] == pytest.approx((way, float(profile.speed(t))), rel=1e-9)
    assert profile.until(9.0) == (4.0, 16.0)


SLIPPERY = {"contact.friction": 0.1, "vehicle.drive": "free", "vehicle.speed_kmh": 60, "run.time_s": 1.2}
HARD = [{"on": ["front.outer"], "time_s_moment_kNm": [[0.05, 0], [0.15, -9]]}]
"""More than the 5 kN m that a friction of 0.1 lets through under 54 kN a wheel."""


@cache
def braked(creepage: float | None):
    """The coach whose first axle is braked beyond adhesion."""
    control = {} if creepage is None else {"vehicle.slip_control": {"creepage": creepage}}
    return run(on_straight().with_values(SLIPPERY | {"vehicle.efforts": HARD} | control))


@pytest.mark.parametrize(
    ("spin", "share"), [(40.0, 1.0), (0.5, 1.0), (0.1, 0.2), (0.0, 0.0), (-0.25, -0.5), (-3.0, -1.0)]
)
def test_a_brake_fades_with_the_spin_of_its_wheels_and_turns_round_with_it(spin, share):
    """From .5 rad/s on it has its whole moment, of the second axle here."""
    brake = Effort(manchester().wheelsets[1].name, ((0.0, -9e3),))
    law = on_track(replace(manchester(), efforts=(brake,)), 20.0).law
    q, q_t = design_state(law)
    q_t[6 + 5] = spin
    law(0.0, q, q_t, np.zeros(law.size))
    assert law.axles["moment"] == pytest.approx([0.0, -9e3 * share, 0.0, 0.0])


def test_a_brake_beyond_adhesion_stops_the_wheels_and_is_told():
    result = braked(None)
    first = result.dataset.sel(wheelset="front.outer")
    assert float(first["axle_creepage"].max()) > 0.3
    label = next(str(text) for text in result.dataset["event_label"].values if "beyond adhesion" in str(text))
    assert label.startswith("wheelset front.outer is braked beyond adhesion and slides for")
    # friction carries what it can: the weight of the axle times 0.1
    force = -first["X"].sum("wheel").values[-1]
    assert force == pytest.approx(-0.1 * first["Q"].sum("wheel").values[-1], rel=0.02)


def test_slip_control_keeps_the_slip_below_its_limit():
    creepage = 0.05
    result = braked(creepage)
    first = result.dataset.sel(wheelset="front.outer")
    assert 0.5 * creepage < float(first["axle_creepage"].max()) < creepage
    # what it gives is what the rails take; the wheels do not slow down any more than the vehicle
    moment = float(first["drive_moment"][-1])
    assert moment == pytest.approx(-0.1 * float(first["Q"].sum("wheel")[-1]) * 0.46, rel=0.05)
    labels = [str(text) for text in result.dataset["event_label"].values]
    assert any("braked beyond adhesion" in label for label in labels)


def test_channels_of_the_drive_belong_together():
    data = braked(0.05).dataset
    assert float(data["drive_moment"].sel(wheelset="rear.outer").min()) == 0.0
    power = data["drive_moment"] * data["spin_rate"]
    first = "front.outer"
    assert data["drive_power"].sel(wheelset=first).values == pytest.approx(power.sel(wheelset=first).values, rel=5e-3)
    assert float(data["drive_work"].sel(wheelset=first)[-1]) < -50e3


def test_a_run_follows_the_speed_of_its_table():
    rows = [[20, 60], [40, 72]]
    keys = {"vehicle.speed_kmh": {"distance_m_speed_kmh": rows}, "run.distance_m": 50, "vehicle.drive": "wheels"}
    scenario = on_straight().with_values(keys | {"output.patches_at_m": [30.0]})
    result = run(scenario)
    plan = build(scenario).plan
    data = result.dataset
    # 6 m at 60, 20 m at 66 on average, 24 m at 72 km/h
    assert plan.duration == pytest.approx(6 / (60 / 3.6) + 20 / (66 / 3.6) + 24 / 20)
    assert float(data["time"][-1]) == pytest.approx(plan.duration, abs=3e-3)
    ahead = force_law(build(scenario)).vehicle.parts[manchester().reference].centre[0]
    assert float(data["distance"][-1]) == pytest.approx(64.0 + ahead, abs=0.05)
    planned = plan.profile.speed(data["time"].values)
    assert np.abs(data["speed"].values - planned).max() < 0.12  # the car swings on its traction rods
    assert "at 30 m" in [str(label) for label in data["snapshot_label"].values]


def test_motors_alone_accelerate_the_mass_and_the_turning_wheels():
    on = [{"time_s_moment_kNm": [[0, 0], [0.3, 4]]}]
    result = run(on_straight().with_values({"vehicle.efforts": on, "vehicle.drive": "free", "run.time_s": 1.0}))
    vehicle = manchester()
    expected = 4 * (0.5 * 0.3 + 0.7) * 4e3 / 0.46 / vehicle.moved_mass
    speed = result.dataset["speed"].values
    assert speed[-1] - speed[0] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("line", "said"), table("bad_speeds_and_efforts_are_refused_with_file_and_key"))
def test_bad_speeds_and_efforts_are_refused_with_file_and_key(tmp_path, line, said):
    messages = faults(CURVE.replace("speed_kmh = 54", line), tmp_path)
    assert len(messages) == 1
    assert messages[0].startswith("case.toml:")
    assert "vehicle." in messages[0]
    assert said in messages[0]


def test_a_speed_that_nothing_holds_is_refused(tmp_path):
    text = CURVE.replace("wheelset_s1002", "manchester_1").replace(
        "speed_kmh = 54", 'drive = "free"\nspeed_kmh = { time_s_speed_kmh = [[0, 60], [9, 50]] }'
    )
    (fault,) = faults(text, tmp_path)
    assert fault.startswith('case.toml:5: vehicle.drive = "free": must be')


# Energy of runs: work of drive and pull is motion, height, creep and what dampers and friction take.
SPEEDING = {"time_s_speed_kmh": [[0.1, 54], [0.9, 60], [2.4, 60]]}


@cache
def ride(*cases: str) -> Result:
    """The coach on straight track, driven by its wheels; cases: what is different."""
    uphill = [{"from_m": 0, "grade_permille": 20}]
    hollow = [{"from_m": 0, "grade_permille": -10}, {"from_m": 50, "grade_permille": 20, "vertical_radius_m": 1000}]
    long = {"track.segments": [straight(220.0)]}
    keys = {
        "speeding": {"vehicle.speed_kmh": SPEEDING, "run.time_s": 5.0},
        "uphill": {"track.grades": uphill},
        "through a hollow": long | {"track.grades": hollow, "vehicle.speed_kmh": 54, "run.time_s": 6.0},
        "pulled": {"vehicle.drive": "train"},
        "at once": {"run.time_s": 0.3},
    }
    values = COARSE | {"track.segments": [straight(160.0)], "vehicle.drive": "wheels"}
    values |= {"run.start_distance_m": 14.0, "run.output_interval_ms": 5.0}
    for case in cases:
        values |= keys[case]
    return run(load(ROOT / "scenarios/manchester_r300.toml").with_values(values))


@pytest.mark.parametrize(
    "cases",
    [
        pytest.param(("speeding",), marks=pytest.mark.campaign),
        pytest.param(("speeding", "uphill"), marks=pytest.mark.campaign),
        ("through a hollow",),
        pytest.param(("through a hollow", "pulled"), marks=pytest.mark.campaign),
    ],
    ids=", ".join,
)
def test_work_of_the_drive_is_motion_height_creep_and_dampers(cases):
    energy = ride(*cases).summary()["energy"]
    work = energy["work_of_drive_kJ"] + energy["work_of_pull_kJ"]
    assert work > 200.0 and energy["lost_in_creep_kJ"] > 0.0 and energy["lost_in_dampers_kJ"] > 0.0
    assert (energy["work_of_drive_kJ"] == 0.0) == ("pulled" in cases)
    if "uphill" in cases or "through a hollow" in cases:
        assert energy["gained_in_height_kJ"] > 0.3 * work
    # springs are as at the start, or nearly so
    assert abs(energy["left_over_kJ"]) < 1e-3 * work


def test_a_grade_raises_and_its_part_of_the_weight_is_pulled():
    data = ride("through a hollow").dataset
    down, up = 50.0 - float(data["distance"][0]), float(data["distance"][-1]) - 50.0
    rise = up * np.sin(np.arctan(0.02)) - down * np.sin(np.arctan(0.01))
    gained = float(data["potential_energy"][-1] - data["potential_energy"][0])
    assert gained == pytest.approx(manchester().mass * manchester().gravity * rise, rel=1e-3)
    data = ride("uphill", "pulled", "at once").dataset
    down = manchester().weight * np.sin(np.arctan(0.02))
    # rolling costs a little: creep of wheels that are not quite conical alike
    assert data["drive_force"].values == pytest.approx(down, rel=5e-3)
    assert np.ptp(data["kinetic_energy"].values) < 1e-4 * float(data["kinetic_energy"][0])


def test_dampers_take_what_does_not_turn_round_with_the_velocities():
    """Springs take a power that changes its sign with all velocities, dampers one that does not."""
    law = on_springs(manchester())
    q, q_t = displaced(law)
    n = 6 * len(law.bodies)
    q_t = law.relaxed_rates(q, q_t)  # nothing in the springs behind dampers
    power, taken = [], []
    for sign in (1.0, -1.0):
        rates, out = q_t.copy(), np.zeros(law.size)
        rates[:n] *= sign
        law(0.0, q, rates, out)
        power.append(-float(out[:n] @ rates[:n]))
        taken.append(float(law.elements["loss"].sum()))
    assert taken[0] > 1e3
    assert power[0] + power[1] == pytest.approx(2.0 * taken[0], rel=1e-9)
    assert taken[0] == pytest.approx(taken[1], rel=1e-9)


def struts(kind: str) -> tuple[Element, ...]:
    """A spring along x and what takes the energy of a swing on it."""
    along = spring(stiffness=(4e5, 0.0, 0.0))
    damper = Strut("damper", "damper", TRACK, "box", (AT, AT), 0, damping=4e3)
    table = ((-1.0, -6e3), (-0.1, -2e3), (0.1, 2e3), (1.0, 6e3))
    elements: dict[str, tuple[Element, ...]] = {
        "damper": (damper,),
        "damper by a table": (Strut("damper", "damper", TRACK, "box", (AT, AT), 0, damper_table=table),),
        "damper behind a spring": (Strut("d", "damper", TRACK, "box", (AT, AT), 0, damping=4e3, series_stiffness=2e5),),
        "field": (spring(name="other", damping=(4e3, 0.0, 0.0)),),
        "coulomb": (slides(800.0, 4e6),),
        "coulomb with damping": (slides(800.0, 4e6, damping=300.0),),
        "in a plane": (
            PlaneFriction("friction", "friction", TRACK, "box", AT, 2, slider=Slider("coulomb", 4e6, 800.0)),
        ),
        "fancher": (Strut("f", "leaf", TRACK, "box", (AT, AT), 0, slider=Slider("fancher", 4e5, 800.0)),),
        "berg": (Strut("b", "rubber", TRACK, "box", (AT, AT), 0, slider=Slider("berg", 4e5, 800.0)),),
    }
    return (FIXED, along, *elements[kind])


@pytest.mark.parametrize("kind", table("what_is_told_as_lost_is_what_a_swing_has_lost"))
def test_what_is_told_as_lost_is_what_a_swing_has_lost(kind):
    law = on_springs(box(*struts(kind)))
    q, q_t = design_state(law)
    q_t[7] = 0.3
    swung = motion(law, q, q_t, 1.2, 2.5e-4, "rk44")
    lost = []
    for t, state, rates in zip(swung.times, swung.q, swung.q_t, strict=True):
        law(t, state, rates, np.zeros(law.size))
        lost.append(float(law.elements["loss"].sum()))
    # Berg's friction gives way on the way back before its force has turned: k z^2/2 is a little more than it holds
    assert min(lost) >= (-0.1 * max(lost) if kind == "berg" else -1e-9)
    x, v = swung.q[:, 7] - 100.0, swung.q_t[:, 7]
    held = 0.5 * MASS * v**2 + 0.5 * 4e5 * x**2
    slips = swung.q_t[:, 12:]
    if kind == "damper behind a spring":
        held += 0.5 * 2e5 * (x - slips[:, 0]) ** 2
    elif slips.shape[1]:
        stiffness = 4e5 if kind in ("fancher", "berg") else 4e6
        held += 0.5 * stiffness * (x - slips[:, 0]) ** 2
    total = cumulative_trapezoid(lost, swung.times, initial=0.0)
    assert total[-1] > 0.5 * held[0]
    assert np.abs(held[0] - held - total).max() < 2e-3 * held[0]
