"""Check rails beside plain rails, and wheels whose profile ends before the back of the flange."""

from dataclasses import replace

import numpy as np
import pytest
from support.contacts import GAUGE, RADIUS, contact_model, rail_profile, wheel_profile

from wrsim import InputError
from wrsim.contact.profiles.check_rail import ends_before_its_back, with_check_rail
from wrsim.contact.profiles.flange import with_back
from wrsim.contact.records import STATUS_PROFILE_END

WHEEL, RAIL = wheel_profile("S1002"), rail_profile("60E1", 40)
BACK_TO_BACK = 1.36
GAUGE_U = RAIL.gauge_point()[0]
CENTRED = 0.5 * (BACK_TO_BACK + 0.14 - GAUGE) + GAUGE_U
"""Outward place of the wheel's origin on its rail's profile in the middle of the track [m]."""


def cut(missing):
    """The wheel without the last of its flange, so far before the back [m]."""
    return WHEEL.clipped(float(WHEEL.arclength_of(-0.07 + missing)), WHEEL.length)


def guided(wheel, rail, outward):
    """Lateral force of the guard face on the wheel [N], and the status, at a place from the middle of the track [m]."""
    contact = contact_model(wheel, rail, **{"tangential": "none"}).evaluate((0.0, CENTRED + outward, RADIUS - 6e-5))
    patches = contact.patches[contact.patches["o"] < GAUGE_U - 0.02]
    return float((patches["N"] * patches["no"]).sum()), contact.status


@pytest.mark.parametrize("flangeway, height", [(0.041, 0.0), (0.038, 0.02), (0.045, -0.005)])
def test_a_check_rail_guides_when_the_back_has_moved_by_flangeway_less_clearance(flangeway, height):
    """The back is an arc of 20.5 mm whose plane lies in the flange's back, and touches a face of 6:1 that is as wide as
    the flangeway 14 mm below the top, where the tangent of the arc is as steep."""
    rail, lean, radius = with_check_rail(RAIL, flangeway, height), np.arctan(1.0 / 6.0), 0.0205
    centre_w = float(WHEEL.w[0])  # the arc ends level with its centre
    depth = -(centre_w - radius * np.sin(lean)) + 6e-5 + RAIL.top[1]
    beside = radius * (1.0 - np.cos(lean)) + (0.014 - depth) * np.tan(lean)
    moved = flangeway - 0.5 * (GAUGE - BACK_TO_BACK) + beside
    assert rail.gauge_point() == pytest.approx(RAIL.gauge_point(), abs=1e-12) and rail.top == pytest.approx(RAIL.top)
    assert guided(WHEEL, rail, -moved + 1e-5)[0] == 0.0
    assert guided(WHEEL, rail, -moved - 3e-5)[0] > 1e3


@pytest.mark.parametrize("missing", [0.1e-3, 0.17e-3, 0.19e-3, 1e-3, 3e-3])
def test_a_scan_that_ends_before_the_flange_back_finds_the_guard_face_or_is_refused(missing):
    rail, outward = with_check_rail(RAIL, 0.041, 0.0), -0.004
    whole, short = guided(WHEEL, rail, outward)[0], cut(missing)
    fault = ends_before_its_back(short, rail, -CENTRED)
    assert whole > 2e4
    if missing < 0.18e-3:
        assert not fault and guided(short, rail, outward)[0] == pytest.approx(whole, rel=0.02)
    else:
        assert "ends before the flange back" in fault and "guard face of 80.5 degrees" in fault
    assert not ends_before_its_back(short, RAIL, -CENTRED)
    # an arc to the back that the file does not hold
    assert guided(with_back(short, 0.07), rail, outward)[0] == pytest.approx(whole, rel=0.02)


def test_an_end_of_a_profile_in_the_steel_is_told():
    rail = with_check_rail(RAIL, 0.041, 0.0)
    for outward in (-0.0045, -0.0085):
        force, status = guided(cut(0.4e-3), rail, outward)
        assert force == 0.0 and status & STATUS_PROFILE_END


def test_a_check_rail_needs_room_and_a_back_an_arc():
    with pytest.raises(InputError, match="no room for a check rail 10 mm beside it"):
        with_check_rail(RAIL, 0.01, 0.0)
    with pytest.raises(InputError, match=r"flange_back_mm = 90: profile 'S1002' ends 20\.4 mm before it"):
        with_back(replace(cut(0.4e-3), name="S1002"), 0.09)
