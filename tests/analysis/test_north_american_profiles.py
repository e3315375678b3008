"""Profiles of AREMA and AAR: the figures that were read, remembered ones as the files state them; in inches."""

import json
import math

import numpy as np
import pytest
from support.commands import ok
from support.hertz import COMPLIANCE, hertz

from wrsim import load_profile, load_text, run

INCH = 0.0254


@pytest.mark.parametrize(
    ("name", "width", "radii"), [("136RE", 2 + 15 / 16, (8, 1.25, 9 / 16)), ("115RE", 2 + 23 / 32, (8, 1.25, 3 / 8))]
)
def test_heads_have_their_width_and_the_radii_of_their_arcs(name: str, width: float, radii: tuple[float, ...]) -> None:
    rail = load_profile(f"rails/{name}.toml")
    rows, _ = rail.table(5e-5)
    u, w, bend = rows[:, 0], rows[:, 1], np.abs(rows[:, 4])
    side = u > 0.03
    assert 2.0 * np.interp(0.625 * INCH, -w[side], u[side]) == pytest.approx(width * INCH, abs=2e-6)
    assert 2.0 * np.interp(0.625 * INCH, -w[u < -0.03][::-1], -u[u < -0.03][::-1]) == pytest.approx(
        width * INCH, abs=2e-6
    )
    assert w.max() == pytest.approx(0.0, abs=1e-7)
    for radius in radii:
        assert np.mean(np.abs(bend * radius * INCH - 1.0) < 1e-4) > 0.1, radius  # of the outline


@pytest.mark.parametrize(("name", "angle"), [("AAR_1in20", 70.0), ("AAR-1B_approx", 75.0)])
def test_wheels_have_their_taper_flange_angle_height_and_thickness(name: str, angle: float) -> None:
    """Taper 1:20 and flange angles: Cummings, WRI 2018; flange 1 in high and 1 5/32 in thick [mem]."""
    wheel = load_profile(f"wheels/{name}.toml")
    rows, _ = wheel.table(2e-5)
    u, w, slope = rows[:, 0], rows[:, 1], np.degrees(np.arctan2(rows[:, 3], rows[:, 2]))
    assert slope.max() == pytest.approx(angle, abs=1e-3)
    assert slope[u > -9e-3] == pytest.approx(math.degrees(math.atan(0.05)), abs=1e-6)
    assert w.min() == pytest.approx(-INCH, abs=1e-9)
    flank = np.flatnonzero((u > -0.0455) & (u < 0.0))
    assert np.interp(-0.375 * INCH, w[flank], u[flank]) - u.min() == pytest.approx((1 + 5 / 32) * INCH, abs=2e-4)


@pytest.mark.parametrize("inclination", ["1:40", "1:20"])
def test_a_new_wheel_rolls_on_its_cone(inclination: str) -> None:
    """Equivalent conicity of a cone is its taper; the rail's crown of 8 in bears it inside of the fillet."""
    options = ("--flange-back-mm", "1355.7", "--radius-mm", "457.2", "--inclination", inclination, "--json")
    answer = json.loads(ok("conicity", "wheels/AAR_1in20.toml", "rails/136RE.toml", *options).stdout)
    conicities = [*answer["equivalent_conicity"].values()]
    assert conicities == pytest.approx([0.05] * len(conicities), abs=1e-6) and len(conicities) > 2


LAID = """
title = "a wheel of 263 kip on its rail"
analysis = "static"
[vehicle]
model = "vehicles/three_piece_100t.toml"
[track]
gauge_in = 56.5
gauge_depth_in = 0.625
rail = "rails/136RE.toml"
inclination = "1:40"
[static]
target = "wheel"
lateral_mm = 0
load_kip = 32.875
[contact]
friction = 0.0
"""


@pytest.mark.parametrize("inclination", ["1:40", "1:20"])
def test_the_pressure_of_a_laden_wheel_is_that_of_hertz(inclination: str) -> None:
    """Crown of 8 in under a cone of 1:20 on a wheel of 36 in: p0 by Hertz for the normal force."""
    dataset = run(load_text(LAID.replace("1:40", inclination))).dataset
    normal = float(dataset["N"].max())
    rolling, crown = 1.0 / (2.0 * 18.0 * INCH * math.hypot(1.0, 0.05)), 1.0 / (2.0 * 8.0 * INCH)
    unit = hertz(rolling / crown)
    p0 = unit.p0 * (normal / unit.force) ** (1 / 3) * (COMPLIANCE.modulus * crown) ** (2 / 3)
    assert float(dataset["p0"].max()) == pytest.approx(p0, rel=3e-3)  # 16 strips
