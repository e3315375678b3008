"""Forces over the pose: no jumps where places of contact appear, grow together or change order; N grows with depth.

A wheel is carried sideways on a smooth path of heights, as in service. Where its force changes most between two samples
the interval is halved until it is a few nanometres wide: what then remains of the difference is a jump.
"""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from support.contacts import PLAIN, bench, contact_of, pair_model, settle

STEP = 10e-6
HALVINGS = 12  # to 2.4 nm
# Root of S1002 and gauge corner of 60E1 both have a radius of 13 mm: over some 10 mm the two are as far apart
# everywhere, and the main point, which alone decides the pressure [S 29], runs along the corner within micrometres.
EQUAL_RADII = (6.3e-3, 6.8e-3)


def jumps(pair, yaw, load, span, most=15, **choices):
    """(lateral shift, largest jump of a force component over the load) at the steepest places of a sweep."""
    stand = bench(pair_model(pair, **choices))
    knots = np.arange(span[0], span[1] + 1e-9, 2.5e-4)
    path = PchipInterpolator(knots, [settle(stand, y, yaw, load)[0].height for y in knots])

    def force(y):
        stand.evaluate(y, float(path(y)), yaw, 0.0)
        return stand.force / load

    return steepest(force, np.arange(knots[0], knots[-1], STEP), most)


def steepest(force, xs, most):
    """(place, change) of a function of one number at its steepest places, halved until a jump is left."""
    change = np.abs(np.diff([force(x) for x in xs], axis=0)).max(axis=1)
    usual = np.array([np.median(change[max(0, i - 4) : i + 5]) for i in range(len(change))])
    rows = []
    for i in np.argsort(usual - change)[:most]:
        left, right = xs[i], xs[i + 1]
        at_left, at_right = force(left), force(right)
        for _ in range(HALVINGS):
            middle = 0.5 * (left + right)
            between = force(middle)
            if np.abs(between - at_left).max() > np.abs(at_right - between).max():
                right, at_right = middle, between
            else:
                left, at_left = middle, between
        rows.append((left, np.abs(at_right - at_left).max()))
    return np.array(rows)


@pytest.mark.parametrize("yaw", [0.0, 0.012])
@pytest.mark.parametrize("pair", ["S1002/60E1 1:40", "S1002/60E1 1:20", "worn/60E1 1:40", "worn/worn 1:40"])
def test_forces_do_not_jump_by_more_than_two_permille_of_the_load(pair, yaw):
    # measured: 0.0018 and less. What is left comes from ripples of the distance that are narrower than the search's
    # stride (0.8 mm), seen only when they have grown.
    found = jumps(pair, yaw, 60e3, (-8e-3, 8.75e-3))
    if pair.startswith("S1002") and yaw:
        found = found[(found[:, 0] < EQUAL_RADII[0]) | (found[:, 0] > EQUAL_RADII[1])]
    assert found[:, 1].max() < 2e-3


def test_a_light_load_sees_a_ripple_of_seven_permille():
    # the worst of a larger search over yaw -12 .. 12 mrad, 24 .. 100 kN: a second lobe on the worn root
    found = jumps("worn/worn 1:40", -0.012, 24e3, (5e-3, 7e-3))
    assert found[:, 1].max() < 7e-3


@pytest.mark.xfail(strict=True, reason="one main point decides the force of a patch between equal radii")
@pytest.mark.parametrize(("pair", "load"), [("S1002/60E1 1:20", 60e3), ("S1002/60E1 1:40", 24e3)])
def test_forces_do_not_jump_between_equal_radii_at_yaw(pair, load):
    # the law wanted; measured 0.07 and 0.10 of the load (0.15 at the most, 1:20, 24 kN)
    assert jumps(pair, -0.012, load, (6e-3, 7e-3))[:, 1].max() < 2e-3


def normal_forces(pair, lateral, yaw, depths, **choices):
    """Sum of N over the wheel's descent below its touching height."""
    stand = bench(pair_model(pair, **PLAIN, **choices), rolling=False)
    touching = settle(stand, lateral, yaw, 10.0)[0].height
    forces = []
    for depth in depths:
        stand.evaluate(lateral, touching - depth, yaw, 0.0)
        forces.append(contact_of(stand).patches["N"].sum())
    return np.array(forces)


@pytest.mark.parametrize("yaw", [0.0, 0.012])
@pytest.mark.parametrize("pair", ["S1002/60E1 1:40", "S1002/60E1 1:20", "worn/60E1 1:40", "worn/worn 1:40"])
def test_normal_force_grows_with_depth_at_a_given_pose(pair, yaw):
    depths = np.arange(1, 101) * 1.5e-6
    for lateral in np.arange(-6e-3, 9.1e-3, 1e-3):
        forces = normal_forces(pair, lateral, yaw, depths)
        assert (np.diff(forces) > 0.0).all(), (lateral, depths[np.argmin(np.diff(forces))])


@pytest.mark.xfail(strict=True, reason="one main point decides the force of a patch between equal radii")
def test_normal_force_grows_with_depth_between_equal_radii():
    # measured: N falls by 5 % within 1 um at 55 um of depth, where the main point leaves the end of the corner
    forces = normal_forces("S1002/60E1 1:20", 6.5e-3, 0.0, np.arange(1, 101) * 1e-6)
    assert (np.diff(forces) > 0.0).all()
