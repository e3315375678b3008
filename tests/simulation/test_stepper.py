"""A vehicle that others move on step by step, beside the usual run; its inputs, its limits."""

import numpy as np
import pytest
from support.allocations import allocations
from support.runs import FAST, arc, straight, transition
from support.vehicles import ROOT

from wrsim import InputError, SimulationError, load, stepper
from wrsim.core.body import stepper as kernel
from wrsim.simulation.integrate import Integration
from wrsim.simulation.system import BodySystem

COACH = load(ROOT / "scenarios/manchester_r300.toml").with_values(
    FAST
    | {
        "track.segments": [straight(26.0), transition(15.0), arc(80.0, 300.0, 100.0)],
        "track.irregularities": [{"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1, "wavelength_m": [3, 60]}],
        "run.start_distance_m": 12.0,
        "run.distance_m": 70.0,
        "vehicle.loads": [
            {"name": "push", "on": "carbody", "at_mm": [0.0, 0.0, 1500.0], "axes": "track", "force_kN": [0.0, 0.0, 0.0]}
        ],
        "vehicle.efforts": [{"moment_kNm": 0.0}],
    }
)


def test_steps_with_a_fixed_number_of_iterations_follow_the_usual_run() -> None:
    """Into a curve on an uneven track: bodies within 0.05 mm rms, and no memory is allocated in a step."""
    own = stepper(COACH)
    law, q, q_t = own.law, own.q.copy(), own.q_t.copy()
    states = [q]
    for _ in range(300):
        own.step(10)
        states.append(own.q.copy())
    assert own.time == pytest.approx(3.0)
    assert own.residual[1] < 0.02
    count = allocations(lambda _, *arguments: kernel.advance(*arguments), 0, own.memory.buffer, own.memory.index)
    assert count == 0
    law.look_near(12.0)
    usual = Integration(BodySystem(law.bodies, law), duration=3.0, step=2e-3, sample_interval=10e-3).run(q, q_t)
    bodies = 6 * len(law.bodies)
    off = (np.array(states) - usual.q)[:, :bodies].reshape(len(states), -1, 6)
    heading = usual.q[:, 3:bodies:6]
    assert np.ptp(heading) > 0.08
    across = np.cos(heading) * off[:, :, 2] - np.sin(heading) * off[:, :, 1]
    assert np.sqrt((across**2).mean()) < 5e-5
    assert np.sqrt((off[:, :, 0] ** 2).mean()) < 5e-5


def test_inputs_act_from_one_step_to_the_next() -> None:
    """A braking moment on every axle changes the momentum of the train by its impulse; a side force moves the car."""
    free = COACH.with_values({"vehicle.drive": "free", "track.irregularities": []})
    pushed, plain = stepper(free), stepper(free)
    moment, torques = -2e3, [f"{m.name}.torque_Nm" for m in pushed.law.vehicle.wheelsets]
    struts = {name for name in pushed.inputs if name.endswith(".control_N")}
    assert set(pushed.inputs) == {*torques, *struts, *(f"push.force_{axis}_N" for axis in "xyz")}
    assert {name.removesuffix(".control_N") + ".force_N" for name in struts} <= set(pushed.outputs)
    for name in torques:
        pushed.inputs[name][:] = moment
    for each in (pushed, plain):
        each.step(500)
    vehicle = pushed.law.vehicle
    # per axle M / r brakes the whole, and with it what turns
    mass = sum(body.mass for body in pushed.law.bodies)
    turning = sum(m.wheelset.inertia[1] / m.wheelset.mean_radius**2 for m in vehicle.wheelsets)
    expected = sum(moment / m.wheelset.mean_radius for m in vehicle.wheelsets) / (mass + turning) * pushed.time
    car = 6 * vehicle.index("carbody")
    slower = float(pushed.outputs["carbody.speed_m_s"][0] - plain.outputs["carbody.speed_m_s"][0])
    assert slower == pytest.approx(expected, rel=0.05)
    before = pushed.q[car + 2] - plain.q[car + 2]
    pushed.inputs["push.force_y_N"][:] = 5e3
    for each in (pushed, plain):
        each.step(200)
    assert pushed.q[car + 2] - plain.q[car + 2] > before + 1e-3


def test_what_cannot_be_taken_step_by_step_is_refused() -> None:
    with pytest.raises(InputError, match=r"must be above 0 and at most 0\.005 s"):
        stepper(COACH, step=0.1)
    with pytest.raises(InputError, match="only with the fast models"):
        stepper(COACH.with_values({"contact.normal": "half-space"}))
    with pytest.raises(InputError, match="only runs along the track"):
        stepper(load(ROOT / "scenarios/static_s1002.toml"))
    for amount, words in ((1e4, "has left the track"), (np.nan, "is not a number")):
        own = stepper(COACH)
        own.q[1] += amount
        with pytest.raises(SimulationError, match=words):
            own.step()
