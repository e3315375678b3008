"""Equivalent linear elements: modes against swings of every kind of element, limits of the harmonic balance."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from support import boxes
from support.boxes import motion

from wrsim.simulation.modes import natural_modes
from wrsim.simulation.placement import design_state
from wrsim.vehicle.dynamics.friction import BERG, COULOMB, FANCHER
from wrsim.vehicle.element_tables import KINDS, VEHICLE_AXES, Joint
from wrsim.vehicle.elements import TRACK
from wrsim.vehicle.equivalent import SMALL_STROKE, Stroke, damper_coefficient, slider_coefficients

HEIGHT = 1e3 * boxes.HEIGHT
POINT: dict[str, Any] = {"at_mm": [0, 0, HEIGHT]}
ALONG_Z = POINT | {"direction": "z"}
LINE: dict[str, Any] = {"body_mm": [0, 0, HEIGHT - 600], "to_mm": [0, 0, HEIGHT]}
SWINGING: dict[str, dict[str, Any]] = {
    "spring": POINT | {"stiffness_kN_per_m": [0, 0, 1400], "damping_kNs_per_m": [0, 0, 8]},
    "shear-spring": LINE | {"stiffness_kN_per_m": [0, 0, 1400], "damping_kNs_per_m": [0, 0, 8]},
    "tabulated-spring": ALONG_Z | {"travel_mm_force_kN": [[-50, -70], [50, 70]], "damping_kNs_per_m": 8},
    "bump-stop": ALONG_Z | {"travel_mm_force_kN": [[0, 0], [60, 84]]},
    "damper": ALONG_Z | {"velocity_m_per_s_force_kN": [[0, 0], [0.02, 2], [0.1, 3]], "series_stiffness_kN_per_m": 900},
    "traction-rod": LINE | {"stiffness_kN_per_m": 1400, "damping_kNs_per_m": 8},
    "anti-roll-bar": {"stiffness_kNm_per_rad": 400},
    "friction": ALONG_Z | {"friction": 0.3, "normal_force_kN": 4, "stick_stiffness_kN_per_m": 700},
    "leaf-spring": ALONG_Z | {"stiffness_kN_per_m": 1400, "friction_force_kN": 0.7, "friction_travel_mm": 2},
    "rubber-spring": ALONG_Z
    | {"stiffness_kN_per_m": 1400, "friction_force_kN": 2, "friction_travel_mm": 2}
    | {"series_stiffness_kN_per_m": 500, "damping_kNs_per_m": 10},
    "air-spring": ALONG_Z
    | {"stiffness_kN_per_m": 1000, "series_stiffness_kN_per_m": 1000, "orifice_damping": 150}
    | {"friction_force_kN": 1, "friction_travel_mm": 3},
    "bilinear-spring": ALONG_Z | {"stiffness_kN_per_m": 900, "second_stiffness_kN_per_m": 700, "second_from_kN": 15},
}
"""An element of every kind on which a mass swings at 2 to 4 Hz, well into the law of its friction or its damper."""
BESIDE = boxes.spring(name="beside", stiffness=(0.0, 0.0, 1e6))
"""Carries the mass beside elements that do not."""


def swings(law: Any, place: int, reach: float) -> list[tuple[float, float]]:
    """Frequency [Hz] and amplitude of each full swing from ``reach`` on, between passages of its middle upwards."""
    q, q_t = design_state(law)
    middle = q[place]
    q[place] += reach
    swung = motion(law, q, law.relaxed_rates(q, q_t), 1.4, 5e-4, "rk44")
    x = swung.q[:, place] - middle
    turns = np.flatnonzero(np.diff(np.sign(np.diff(x)))) + 1
    levels = [0.5 * (x[a] + x[b]) for a, b in pairwise(turns)]
    result = []
    for k in range(len(turns) - 2):
        passages = []
        for a, b, level in ((turns[k], turns[k + 1], levels[k]), (turns[k + 1], turns[k + 2], levels[k + 1])):
            part = slice(a, b + 1)
            order = np.argsort(x[part])
            passages.append(np.interp(level, x[part][order], swung.times[part][order]))
        result.append((0.5 / (passages[1] - passages[0]), abs(x[turns[k + 1]] - 0.5 * (levels[k] + levels[k + 1]))))
    return result


@pytest.mark.parametrize("kind", KINDS)
def test_the_linear_mode_of_a_mass_on_an_element_is_within_2_percent_of_its_swings(kind: str) -> None:
    """Each half swing has the frequency of the damped mode at its own amplitude and frequency."""
    table = KINDS[kind].model_validate({"kind": kind, "name": kind, "body": "track", "to": ["box"]} | SWINGING[kind])
    element = table.element(Joint(kind, kind, TRACK, "box"), VEHICLE_AXES)
    roll, place = kind == "anti-roll-bar", boxes.Z + 4 * (kind == "anti-roll-bar")
    held = boxes.spring(name="held", stiffness=(4e6, 4e6, 4e6 * roll), turning_stiffness=(4e6 * (not roll), 4e6, 4e6))
    beside = (BESIDE,) if kind in ("damper", "friction") else ()
    vehicle = boxes.box(held, element, *beside)
    measured = swings(boxes.on_springs(vehicle, vehicle.gravity), place, 5e-3)[:4]
    assert len(measured) == 4
    for frequency, amplitude in measured:
        modes = natural_modes(vehicle, Stroke(amplitude, frequency))
        (mode,) = (m for m in modes if m.name == f"box {'roll' if roll else 'vertical'}")
        assert mode.frequency * np.sqrt(1.0 - mode.damping**2) == pytest.approx(frequency, rel=0.02), amplitude


@pytest.mark.parametrize("exponent", [1.0, 1.5, 1.8, 2.0])
def test_no_orifice_is_stiffer_than_both_springs_or_softer_than_the_slow_one(exponent: float) -> None:
    """At strokes from 1 um to 1 m the mode lies between those of the two stiffnesses, and falls as the stroke grows
    less: the orifice opens at small velocities."""
    keys = {"stiffness_kN_per_m": 400, "series_stiffness_kN_per_m": 500, "orifice_damping": 60}
    table = {"kind": "air-spring", "name": "air", "body": "track", "to": ["box"], "orifice_exponent": exponent}
    element = KINDS["air-spring"].model_validate(table | ALONG_Z | keys)
    held = boxes.spring(name="held", stiffness=(4e6, 4e6, 0.0), turning_stiffness=(4e6,) * 3)
    vehicle = boxes.box(held, element.element(Joint("air", "air-spring", TRACK, "box"), VEHICLE_AXES))
    frequencies = []
    for amplitude in np.geomspace(1e-6, 1.0, 7):
        modes = natural_modes(vehicle, Stroke(float(amplitude), 1.7))
        frequencies += [m.frequency for m in modes if m.name == "box vertical"]
    slow, stiff = (np.sqrt(k / boxes.MASS) / (2.0 * np.pi) for k in (4e5, 9e5))
    assert len(frequencies) == 7
    assert slow * (1.0 - 1e-6) < min(frequencies) <= max(frequencies) < stiff * (1.0 + 1e-6)
    assert np.all(np.diff(frequencies) > -1e-9)


def test_a_slider_sticks_in_small_strokes_and_brakes_like_coulomb_in_large_ones() -> None:
    """Equivalent damping of Coulomb friction in full slip: 4 F / (pi w A)."""
    stick, bound = 5e6, 1e4
    for law in (COULOMB, FANCHER, BERG):
        k, loss = slider_coefficients(law, stick, bound, 1e-6 * bound / stick)
        assert (k, loss) == pytest.approx((stick, 0.0), rel=1e-5, abs=1e-5 * stick)
        k, loss = slider_coefficients(law, stick, bound, 1e4 * bound / stick)
        assert k < 2e-3 * stick * 1e-2
        assert loss == pytest.approx(4.0 * bound / np.pi / (1e4 * bound / stick), rel=2e-2)
    assert slider_coefficients(COULOMB, stick, 0.0, 1e-3)[1] == 0.0


def test_a_damper_that_blows_off_has_the_harmonic_of_its_force() -> None:
    """Force F sign(v) beyond a steep start: 4 F / (pi V); within its first slope that slope; an orifice of exponent 2:
    8 C V / (3 pi)."""
    rows = np.array([(-1.0, -5e3), (-1e-6, -5e3), (1e-6, 5e3), (1.0, 5e3)])
    stroke = Stroke(0.01, 1.0)
    v = stroke.rate * stroke.amplitude
    assert damper_coefficient(rows, stroke) == pytest.approx(4.0 * 5e3 / (np.pi * v), rel=1e-5)
    assert damper_coefficient(rows, Stroke(1e-8, 1.0)) == pytest.approx(5e9, rel=1e-9)
    grid = np.linspace(-0.2, 0.2, 4001)
    square = np.column_stack([grid, 1e5 * grid * np.abs(grid)])
    assert damper_coefficient(square, stroke) == pytest.approx(8e5 * v / (3.0 * np.pi), rel=1e-4)
    rising = np.array([(-1.0, -5e3), (-0.02, -4e3), (0.02, 4e3), (1.0, 5e3)])
    behind = damper_coefficient(rising, stroke, 4e5)  # the spring takes a part of the stroke
    rest = v * 4e5 / np.hypot(4e5, stroke.rate * behind)
    assert rest < 0.5 * v
    assert behind == pytest.approx(damper_coefficient(rising, Stroke(rest / stroke.rate, 1.0)), rel=1e-6)
    assert "6.283 mm/s" in SMALL_STROKE.label
