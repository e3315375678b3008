"""Whatever the pose: finite, pushing, within friction, dissipating; the same numbers whatever came before."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from support.contacts import HALF_SPACING, PAIRS, RADIUS, pair_model, rail_origin, strips_of
from support.examples import examples

from wrsim.contact import records as k
from wrsim.contact.creep.laws import KERNEL_LAWS
from wrsim.contact.settings import Friction

speeds = st.sampled_from([0.0, 1e-3, -0.5, 20.0, 100.0])
states = st.fixed_dictionaries(
    {
        "pair": st.sampled_from(sorted(PAIRS)),
        "friction": st.sampled_from([0.0, 0.3, 2.0, Friction(0.5, 0.1, falling_ratio=0.4)]),
        "tangential": st.sampled_from(KERNEL_LAWS),
        "bound": st.sampled_from(["elliptic", "parabolic"]),
        "flexibility": st.sampled_from(["three", "blended"]),
        "approach": st.sampled_from(["projected", "constant"]),
        "damping": st.sampled_from([0.0, 2.0]),
        "lateral": st.floats(-0.03, 0.03),
        "yaw": st.floats(-0.0873, 0.0873),  # 5 degrees
        "roll": st.floats(-0.03, 0.03),
        "depth": st.floats(0.0, 5e-3),
        "speed": speeds,
        "creep": st.tuples(*[st.floats(-0.05, 0.05)] * 3),
        "closing": st.floats(-1.0, 1.0),
    }
)


def model_of(state):
    choices = {name: state[name] for name in ("friction", "tangential", "flexibility", "approach", "damping")}
    return pair_model(state["pair"], traction_bound=state["bound"], strips=16, cells=8, **choices)


def press(state):
    """Lower a wheel on its rail and press it in; slipping and turning as the state says."""
    model = model_of(state)
    o, _ = rail_origin(model.rail)
    yaw, roll, speed = state["yaw"], state["roll"], state["speed"]
    axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    origin = np.array([0.0, HALF_SPACING + state["lateral"] - o, RADIUS + 0.04])
    while origin[2] > RADIUS - 0.05 and (closest := model.evaluate(origin, axle).closest) > 0.0:
        origin[2] -= max(closest, 1e-6)
    origin[2] -= state["depth"]
    along, across, turning = state["creep"]
    velocity = np.array([speed, across * speed, -state["closing"]])
    omega = (1.0 + along) * speed / RADIUS * axle + [0.0, 0.0, turning * speed]
    return model, model.evaluate(origin, axle, velocity, omega)


@settings(max_examples=examples(100))
@given(state=states)
def test_the_same_pose_gives_the_same_numbers_whatever_came_before(state):
    # scratch arrays carry nothing over
    model, contact = press(state)
    pose = model.arrays.pose.copy()
    rows = model.arrays.rows
    for array in (rows.work, rows.contacts, rows.patches, rows.strips, rows.total):
        array.view(np.float64)[:] = np.nan
    again = model.evaluate(pose[:3], pose[3:6], pose[6:9], pose[9:])
    np.testing.assert_array_equal(again.force, contact.force)
    np.testing.assert_array_equal(again.moment, contact.moment)
    # the one number that is meant to be carried over: the strip model's half lengths, for its next call in a run
    for name in k.STRIP.names:
        np.testing.assert_array_equal(strips_of(again)[name], strips_of(contact)[name])


def test_zero_friction_and_no_tangential_model_are_the_same():
    without = pair_model("S1002/60E1 1:40", tangential="none")
    slippery = pair_model("S1002/60E1 1:40", friction=0.0)
    o, _ = rail_origin(without.rail)
    pose = ((0.0, HALF_SPACING + 2e-3 - o, RADIUS - 2e-4), (0.0, 1.0, 0.0), (20.0, 0.1, 0.0), (0.0, 40.0, 0.0))
    a, b = without.evaluate(*pose), slippery.evaluate(*pose)
    assert len(a.patches) > 0
    np.testing.assert_array_equal(a.force, b.force)
    np.testing.assert_array_equal(a.moment, b.moment)
