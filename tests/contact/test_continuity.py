"""Forces over the pose: no jumps where places of contact appear, grow together or change order; N grows with depth.

A wheel is carried sideways on a smooth path of heights, as in service. Where its force changes most between two samples
the interval is halved until it is a few nanometres wide: what then remains of the difference is a jump.
"""

import numpy as np
import pytest
from support.sweeps import jumps, normal_forces

# Root of S1002 and gauge corner of 60E1 both have a radius of 13 mm: over some 10 mm the two are as far apart
# everywhere, and the main point, which alone decides the pressure [S 29], runs along the corner within micrometres.
EQUAL_RADII = (6.3e-3, 6.8e-3)


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


@pytest.mark.parametrize("yaw", [0.0, 0.012])
@pytest.mark.parametrize("pair", ["S1002/60E1 1:40", "S1002/60E1 1:20", "worn/60E1 1:40", "worn/worn 1:40"])
def test_normal_force_grows_with_depth_at_a_given_pose(pair, yaw):
    depths = np.arange(1, 101) * 1.5e-6
    for lateral in np.arange(-6e-3, 9.1e-3, 1e-3):
        forces = normal_forces(pair, lateral, yaw, depths)
        assert (np.diff(forces) > 0.0).all(), (lateral, depths[np.argmin(np.diff(forces))])
