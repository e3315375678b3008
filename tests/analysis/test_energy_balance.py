"""Energy of runs: work of drive and pull is motion, height, creep and what dampers and friction take."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from support.boxes import AT, FIXED, MASS, box, displaced, motion, on_springs, slides, spring
from support.runs import straight
from support.vehicles import COARSE, ROOT, manchester

from wrsim.analysis import run
from wrsim.results import Result
from wrsim.scenario.loading import load
from wrsim.simulation.placement import design_state
from wrsim.vehicle.elements import TRACK, Element, PlaneFriction, Slider, Strut

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


# --- runs -------------------------------------------------------------------------------------------------
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
    found = ride(*cases).summary()["energy"]
    work = found["work_of_drive_kJ"] + found["work_of_pull_kJ"]
    assert work > 200.0 and found["lost_in_creep_kJ"] > 0.0 and found["lost_in_dampers_kJ"] > 0.0
    assert (found["work_of_drive_kJ"] == 0.0) == ("pulled" in cases)
    if "uphill" in cases or "through a hollow" in cases:
        assert found["gained_in_height_kJ"] > 0.3 * work
    # springs are as at the start, or nearly so
    assert abs(found["left_over_kJ"]) < 1e-3 * work


def test_the_height_gained_is_that_of_the_line():
    data = ride("through a hollow").dataset
    down, up = 50.0 - float(data["distance"][0]), float(data["distance"][-1]) - 50.0
    rise = up * np.sin(np.arctan(0.02)) - down * np.sin(np.arctan(0.01))
    gained = float(data["potential_energy"][-1] - data["potential_energy"][0])
    assert gained == pytest.approx(manchester().mass * manchester().gravity * rise, rel=1e-3)


def test_a_run_that_starts_on_a_grade_is_pulled_by_the_part_of_its_weight():
    data = ride("uphill", "pulled", "at once").dataset
    down = manchester().weight * np.sin(np.arctan(0.02))
    # rolling costs a little: creep of wheels that are not quite conical alike
    assert data["drive_force"].values == pytest.approx(down, rel=5e-3)
    assert np.ptp(data["kinetic_energy"].values) < 1e-4 * float(data["kinetic_energy"][0])


# --- what dampers and friction take -----------------------------------------------------------------------
def test_dampers_take_what_does_not_turn_round_with_the_velocities():
    """Springs take a power that changes its sign with all velocities, dampers one that does not."""
    law = on_springs(manchester())
    q, q_t = displaced(law)
    n = 6 * len(law.bodies)
    q_t = law.settled_rates(q, q_t)  # nothing in the springs behind dampers
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
    own = spring(stiffness=(4e5, 0.0, 0.0))
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
    return (FIXED, own, *elements[kind])


@pytest.mark.parametrize(
    "kind",
    ["damper", "damper by a table", "damper behind a spring", "field", "coulomb", "coulomb with damping", "in a plane",
     "fancher", "berg"],
)  # fmt: skip
def test_what_is_told_as_lost_is_what_a_swing_has_lost(kind):
    law = on_springs(box(*struts(kind)))
    q, q_t = design_state(law)
    q_t[7] = 0.3
    found = motion(law, q, q_t, 1.2, 2.5e-4, "rk44")
    lost = []
    for t, state, rates in zip(found.times, found.q, found.q_t, strict=True):
        law(t, state, rates, np.zeros(law.size))
        lost.append(float(law.elements["loss"].sum()))
    # Berg's friction gives way on the way back before its force has turned: k z^2/2 is a little more than it holds
    assert min(lost) >= (-0.1 * max(lost) if kind == "berg" else -1e-9)
    x, v = found.q[:, 7] - 100.0, found.q_t[:, 7]
    held = 0.5 * MASS * v**2 + 0.5 * 4e5 * x**2
    slips = found.q_t[:, 12:]
    if kind == "damper behind a spring":
        held += 0.5 * 2e5 * (x - slips[:, 0]) ** 2
    elif slips.shape[1]:
        stiffness = 4e5 if kind in ("fancher", "berg") else 4e6
        held += 0.5 * stiffness * (x - slips[:, 0]) ** 2
    total = cumulative_trapezoid(lost, found.times, initial=0.0)
    assert total[-1] > 0.5 * held[0]
    assert np.abs(held[0] - held - total).max() < 2e-3 * held[0]
