"""Laws of a path: the interpolated curve, its frame, and the search for a cross-section."""

import numpy as np
import pytest
from support.paths import curvature, locate

from wrsim.core.linalg import Vec
from wrsim.core.track import path as core
from wrsim.geometry.track.path import COLUMNS, Path


def helix(radius: float, slope: float, turns: float, step: float, roll_rate: float = 0.0) -> Path:
    """A helix: every coordinate, tangent and curvature is known. Angle cos(slope) s / R."""
    n = round(2.0 * np.pi * radius * turns / step) + 1
    s = np.arange(n) * step
    c, d = np.cos(slope), np.sin(slope)
    a = c * s / radius
    table = np.zeros((n, len(COLUMNS)))
    table[:, 0:3] = np.column_stack((radius * np.sin(a), radius * (1 - np.cos(a)), d * s))
    table[:, 3:6] = np.column_stack((c * np.cos(a), c * np.sin(a), np.full(n, d)))
    table[:, 6] = 0.1 * np.sin(roll_rate * s)
    table[:, 7] = 0.1 * roll_rate * np.cos(roll_rate * s)
    table[:, 8:10] = c**2 / radius * np.column_stack((-np.sin(a), np.cos(a)))
    return Path(table, step)


@pytest.fixture(scope="module")
def spiral() -> Path:
    """Two turns of 30 m radius, climbing, rolling."""
    return helix(30.0, 0.03, 2.0, 0.25, roll_rate=0.05)


def test_frame_is_orthonormal_right_handed_and_its_roll_is_the_tilt_of_n(spiral: Path) -> None:
    s = np.linspace(-5.0, spiral.length + 5.0, 1000)
    axes = spiral.frame(s)[:, 1:]
    gram = axes @ axes.transpose(0, 2, 1)
    assert np.abs(gram - np.eye(3)).max() < 1e-14
    assert np.abs(np.linalg.det(axes) - 1.0).max() < 1e-14
    inside = np.clip(s, 0.0, spiral.length)
    cos_slope = np.hypot(axes[:, 0, 0], axes[:, 0, 1])
    # n.z = sin(roll) cos(slope); tolerance: cubic Hermite of a sine of 0.1 rad and 0.05 rad/m
    assert np.abs(axes[:, 1, 2] - np.sin(0.1 * np.sin(0.05 * inside)) * cos_slope).max() < 1e-10


def test_interpolation_converges_with_order_six_in_position_five_in_tangent_four_in_curvature() -> None:
    errors = []
    for step in (8.0, 4.0, 2.0):
        radius = 30.0
        path = helix(radius, 0.0, 1.0, step)
        s = np.linspace(0.0, path.length, 2001)
        a = s / radius
        frame = path.frame(s)
        exact = np.column_stack((radius * np.sin(a), radius * (1.0 - np.cos(a))))
        tangent = np.column_stack((np.cos(a), np.sin(a)))
        errors.append(
            (
                np.abs(frame[:, 0, :2] - exact).max(),
                np.abs(frame[:, 1, :2] - tangent).max(),
                np.abs(curvature(path, s) - 1.0 / radius).max(),
            )
        )
    order = np.log2(np.array(errors[1]) / np.array(errors[2]))
    assert order == pytest.approx([6.0, 5.0, 4.0], abs=0.15)


def test_position_tangent_and_curvature_are_continuous_at_every_row() -> None:
    """Also where the data of the rows do not fit together, as at a joint: here they are noise on a line."""
    rng = np.random.default_rng(3)
    table = np.zeros((20, len(COLUMNS)))
    table[:, 0] = np.arange(20.0)
    table[:, 3] = 1.0
    table[:, 1] = 0.01 * rng.normal(size=20)
    table[:, 9] = 0.01 * rng.normal(size=20)
    path = Path(table, 1.0)
    rows = np.arange(1.0, 19.0)
    tiny = 1e-9
    before, behind = path.frame(rows - tiny), path.frame(rows + tiny)
    assert np.abs(before - behind)[:, 0].max() < 3.0 * tiny  # the point moves by 2 tiny
    assert np.abs(before - behind)[:, 1:].max() < 1.0 * tiny  # slopes here are below 0.5 / m
    assert np.abs(curvature(path, rows - tiny) - curvature(path, rows + tiny)).max() < 20.0 * tiny


def test_path_continues_straight_at_both_ends(spiral: Path) -> None:
    for end, sign in ((0.0, -1.0), (spiral.length, 1.0)):
        at, beyond = spiral.frame(end), spiral.frame(end + sign * 7.0)
        assert np.abs(beyond[0] - (at[0] + sign * 7.0 * at[1])).max() < 1e-13
        assert np.abs(beyond[1:] - at[1:]).max() < 1e-15
        assert curvature(spiral, end + sign * 7.0) == 0.0
        assert core.frame_rates(spiral.curve, end + sign * 7.0) == ((0.0, 0.0, 0.0), 0.0)


def test_frame_rates_turn_the_frame(spiral: Path) -> None:
    h = 1e-4
    for s in (0.3, 11.11, 200.0, spiral.length - 0.2):
        omega, droll = core.frame_rates(spiral.curve, s)
        slope = (spiral.frame(s + h)[1:] - spiral.frame(s - h)[1:]) / (2.0 * h)
        turned = np.cross(np.array(omega), spiral.frame(s)[1:])
        assert np.abs(slope - turned).max() < 1e-9  # differences of 1e-16 / 1e-4, and of the table's roll
        assert droll == pytest.approx(0.005 * np.cos(0.05 * s), abs=1e-9)


def test_locate_is_the_inverse_of_frame_and_does_not_care_for_the_guess(spiral: Path) -> None:
    rng = np.random.default_rng(1)
    s = rng.uniform(-3.0, spiral.length + 3.0, 400)
    frame = spiral.frame(s)
    points = (
        frame[:, 0]
        + rng.uniform(-1.5, 1.5, 400)[:, None] * frame[:, 2]
        + rng.uniform(-1.0, 1.0, 400)[:, None] * frame[:, 3]
    )
    found = locate(spiral, points, s + rng.uniform(-4.0, 4.0, 400))
    assert np.abs(found - s).max() < 1e-12 * 400.0
    again = locate(spiral, points, s + rng.uniform(-1e-3, 1e-3, 400))
    assert np.abs(found - again).max() < 1e-12 * 400.0


def test_locate_says_when_it_has_no_answer(spiral: Path) -> None:
    curve = spiral.curve
    assert core.locate(curve, Vec(np.nan, 0.0, 0.0), 1.0)[1] == core.LOCATE_NOT_FINITE
    assert core.locate(curve, Vec(0.0, 0.0, 0.0), np.nan)[1] == core.LOCATE_NOT_FINITE
    assert core.locate(curve, Vec(1.0, np.inf, 0.0), 1.0)[1] == core.LOCATE_NOT_FINITE
    line = helix(1e9, 0.0, 1e-9, 0.25)  # hardly bent: a guess 1000 km away is out of reach
    assert core.locate(line.curve, Vec(1e6, 0.0, 0.0), 0.0)[1] == core.LOCATE_NOT_CONVERGED
    assert np.isnan(locate(line, np.array([1e6, 0.0, 0.0]), 0.0))
