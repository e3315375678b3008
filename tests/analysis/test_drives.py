"""Speed along the line, motors and brakes: where the frame is, what the energy becomes, what adhesion lets through."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad
from support.rows import rows_of
from support.runs import straight
from support.scenario_texts import CURVE, faults
from support.vehicles import COARSE, ROOT, manchester, on_track

from wrsim.analysis import run
from wrsim.analysis.contacts import force_law
from wrsim.core.body.vehicle_forces import PIECE, motion_at
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario, load
from wrsim.simulation.placement import design_state
from wrsim.vehicle.loads import Effort
from wrsim.vehicle.speed import SpeedProfile

table = rows_of(__file__)

COACH = ROOT / "scenarios/manchester_r300.toml"


def on_straight(**keys: object) -> Scenario:
    """The coach on 90 m of straight track, with further keys (dots written as two underscores)."""
    own = {"track.segments": [straight(90.0)], "run.start_distance_m": 14.0, "run.output_interval_ms": 10.0}
    return load(COACH).with_values(COARSE | own | {key.replace("__", "."): value for key, value in keys.items()})


# --- the frame --------------------------------------------------------------------------------------------
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
            lambda at: float(profile.speed(at)), 0.0, t, points=[p[0] for p in profile.pieces if 0 < p[0] < t]
        )
        assert float(profile.way(t)) == pytest.approx(way, rel=1e-9)
        assert profile.time(float(profile.way(t))) == pytest.approx(t, rel=1e-12)
        pieces = np.array(list(profile.pieces), PIECE)
        assert motion_at(t, pieces)[:2] == pytest.approx((way, float(profile.speed(t))), rel=1e-9)
    assert profile.until(9.0) == (4.0, 16.0)


# --- adhesion ---------------------------------------------------------------------------------------------

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


@pytest.mark.parametrize("creepage", [0.01, 0.05])
def test_slip_control_keeps_the_slip_below_its_limit(creepage):
    result = braked(creepage)
    first = result.dataset.sel(wheelset="front.outer")
    assert 0.5 * creepage < float(first["axle_creepage"].max()) < creepage
    # what it gives is what the rails take; the wheels do not slow down any more than the vehicle
    given = float(first["drive_moment"][-1])
    assert given == pytest.approx(-0.1 * float(first["Q"].sum("wheel")[-1]) * 0.46, rel=0.05)
    labels = [str(text) for text in result.dataset["event_label"].values]
    assert any("braked beyond adhesion" in label for label in labels)


def test_channels_of_the_drive_belong_together():
    data = braked(0.05).dataset
    assert float(data["drive_moment"].sel(wheelset="rear.outer").min()) == 0.0
    power = data["drive_moment"] * data["spin_rate"]
    first = "front.outer"
    assert data["drive_power"].sel(wheelset=first).values == pytest.approx(power.sel(wheelset=first).values, rel=5e-3)
    assert float(data["drive_work"].sel(wheelset=first)[-1]) < -50e3


# --- runs -------------------------------------------------------------------------------------------------
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


# --- what is refused --------------------------------------------------------------------------------------
@pytest.mark.parametrize(("line", "said"), table("bad_speeds_and_efforts_are_refused_with_file_and_key"))
def test_bad_speeds_and_efforts_are_refused_with_file_and_key(tmp_path, line, said):
    found = faults(CURVE.replace("speed_kmh = 54", line), tmp_path)
    assert len(found) == 1
    assert found[0].startswith("case.toml:")
    assert "vehicle." in found[0]
    assert said in found[0]


def test_a_speed_that_nothing_holds_is_refused(tmp_path):
    text = CURVE.replace("wheelset_s1002", "manchester_1").replace(
        "speed_kmh = 54", 'drive = "free"\nspeed_kmh = { time_s_speed_kmh = [[0, 60], [9, 50]] }'
    )
    (fault,) = faults(text, tmp_path)
    assert fault.startswith('case.toml:5: vehicle.drive = "free": must be')
