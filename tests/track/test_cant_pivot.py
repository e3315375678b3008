"""What cant turns about: heights of both rails, smoothness where the low rail changes side, refused pivots."""

from collections.abc import Sequence
from dataclasses import replace
from math import comb
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from support.runs import FAST, SCENARIOS

from wrsim import Arc, InputError, Straight, Track, Transition, load, run
from wrsim.simulation.integrate import CONTACT_TOLERANCE
from wrsim.track.alignment import Cant, Plan, alignment_laws
from wrsim.track.cant import PIVOTS, Pivot
from wrsim.track.forms import Form
from wrsim.track.piecewise import Piecewise
from wrsim.track.segments import ROUNDING, Grade, Laws, Segment

BASE = 1.5
OUTER = (0.5 * (BASE - 1.435), 0.0)  # a rail whose origin is where cant is measured
ROW: Sequence[Segment] = (
    Straight(30.0), Transition(80.0, "sine"), Arc(60.0, 500.0, 0.1), Transition(100.0, "bloss"),
    Arc(60.0, -400.0, 0.12), Transition(60.0), Straight(30.0),
)  # fmt: skip
SWAP = (170.0, 270.0)  # in this transition the low rail changes side


def track(pivot: Pivot = "centre line", row: Sequence[Segment] = ROW, **options: Any) -> Track:
    return Track.build(row, pivot=pivot, left_offset=OUTER, right_offset=OUTER, cant_base=BASE, **options)


def heights(pivot: Pivot, cant: np.ndarray) -> np.ndarray:
    """Heights of the left and right rail top above the grade line."""
    zero = 0.0 * cant
    return {
        "centre line": np.array((-0.5 * cant, 0.5 * cant)),
        "left rail": np.array((zero, cant)),
        "right rail": np.array((-cant, zero)),
        "low rail": np.maximum((-cant, cant), 0.0),
        "high rail": np.minimum((-cant, cant), 0.0),
    }[pivot]


@pytest.mark.parametrize("pivot", PIVOTS)
def test_the_pivot_stays_at_the_height_of_the_grade_line(pivot: Pivot) -> None:
    level = track(pivot)
    for k, (curve, path) in enumerate(((level.left_curve, level.left), (level.right_curve, level.right))):
        s = curve.distance(path.step * np.arange(len(path.table)))
        far = np.abs(level.cant(s)) > 0.006  # elsewhere the low rail changes side within the rounding
        deviation = path.table[:, 2] - heights(pivot, level.cant(s))[k]
        assert np.abs(deviation[far | (s < 170.0) | (s > 270.0)]).max() < 2e-7  # 0.06 m (1 - cos 2.5 mrad)
        # rounding takes 3/16 J w of a kink J, here twice the slope of the cant's half
        slope = np.abs(level.left_curve.cant(s, 1)[~far]).max()
        assert np.abs(deviation).max() < 1.01 * 3.0 / 16.0 * slope * ROUNDING
    grades = [Grade(0.0, 0.01), Grade(200.0, -0.005, 3000.0)]
    climbing, line = track(pivot, grades=grades), track(grades=grades)
    s = np.linspace(0.0, level.length, 301)
    lift, places = 0.5 * np.sum(climbing.rail_heights(s), axis=0), climbing.centre_line.position(s)
    same = s.copy()  # distances along the other line of the same places in plan
    for _ in range(4):
        frame = line.centre_line.position(same) - places, line.centre_line.tangent(same)
        same -= np.sum(frame[0][:, :2] * frame[1][:, :2], axis=1) / np.sum(frame[1][:, :2] ** 2, axis=1)
    assert np.abs(places[:, :2] - line.centre_line.position(same)[:, :2]).max() < 1e-10
    assert np.abs(places[:, 2] - line.centre_line.position(same)[:, 2] - lift).max() < 1e-11


def test_left_and_right_exchanged_the_low_rail_is_the_low_rail() -> None:
    row = [replace(s, radius=-s.radius) if isinstance(s, Arc) else s for s in ROW]
    right_hand, left_hand = track("low rail"), track("low rail", row)
    s = np.linspace(0.0, right_hand.length, 201)
    assert (
        np.abs(right_hand.centre_line.position(s) * (1.0, -1.0, 1.0) - left_hand.centre_line.position(s)).max() < 1e-10
    )
    assert np.abs(np.array(right_hand.rail_heights(s)) - left_hand.rail_heights(s)[::-1]).max() < 1e-12


@pytest.mark.parametrize("pivot", ["low rail", "high rail"])
def test_where_the_low_rail_changes_side_the_slope_is_continuous(pivot: Pivot) -> None:
    law = track(pivot).centre_line.pitch_law
    s = np.linspace(*SWAP, 100_001)
    jump = 2.0 * 0.5 * np.abs(track().left_curve.cant(s, 1)).max()  # of the slope, turned over twice the half length
    assert np.abs(np.diff(law(s))).max() / (s[1] - s[0]) < 1.01 * 0.75 * jump / ROUNDING
    before, behind = law.joints(1)
    inner = (law.breaks[1:-1] > SWAP[0] + 0.01) & (law.breaks[1:-1] < SWAP[1] - 0.01)
    # the size of the cant bends the other way behind its zero: half of twice its second derivative, 1/R of 125 km
    bend = np.abs(track().left_curve.cant(law.breaks[1:-1][inner], 2)).max()
    assert np.abs(before - behind)[inner].max() < 1.01 * bend < 2e-5


@pytest.mark.parametrize(("form", "order"), [("bloss", 1), ("helmert", 1), ("cosine", 1), ("sine", 2), ("viennese", 3)])
def test_curvature_and_cant_are_smooth_in_the_rails_axes_to_the_order_of_the_form(form: Form, order: int) -> None:
    ramp = Transition(80.0, form, centre_of_gravity_height=0.0 if form == "viennese" else None)
    # about a rail the centre line's height bends by half of the cant's second derivative, and the axes are canted
    curve = track("centre line", [Straight(50.0), ramp, Arc(50.0, 300.0, 0.1)]).left_curve

    def quantities(s: np.ndarray) -> np.ndarray:
        first, second = curve.components(s)
        along = np.linalg.norm(first, axis=1)
        tangent = first / along[:, None]
        bend = (second - np.sum(second * tangent, axis=1)[:, None] * tangent) / along[:, None] ** 2
        return np.stack((bend[:, 1], curve.roll(s)[0]))

    def quotient(joint: float, n: int, step: float) -> np.ndarray:
        """The n-th difference across a joint over the n-th power of the step."""
        k = np.arange(n + 1)
        weights = np.array([(-1.0) ** (n - i) * comb(n, i) for i in k])
        return np.asarray(quantities(joint + (k - 0.5 * n) * step) @ weights / step**n)

    for joint in (50.0, 130.0):
        for n in range(1, order + 1):  # derivatives that are zero there: their quotients vanish with the step
            far, near = (np.abs(quotient(joint, n, step)) for step in (2.0, 1.0))
            assert np.all(near < 0.6 * far)
        far, near = (np.abs(quotient(joint, order + 1, step)) for step in (2.0, 1.0))  # the next one jumps
        assert np.all(near > 0.8 * far)


def test_measured_cant_turns_about_rails_too() -> None:
    s = np.linspace(0.0, 60.0, 61)
    cant = Piecewise(CubicSpline(s, 0.05 * np.sin(s / 9.0)))
    zero = Piecewise.through(s[[0, -1]], np.zeros(2))
    laid = Track.from_laws(Laws(zero, cant, zero, zero), pivot="high rail")
    x = np.linspace(0.0, 60.0, 241)
    x = x[np.abs(laid.cant(x)) > 0.01]
    assert np.abs(np.array(laid.rail_heights(x)) - heights("high rail", laid.cant(x))).max() < 1e-12
    assert laid.centre_line.position(30.0)[2] == pytest.approx(-0.5 * abs(float(cant(30.0))), abs=1e-9)


def test_in_a_full_curve_on_uneven_sleepers_forces_do_not_know_the_pivot() -> None:
    layer = {"vertical_stiffness_MN_per_m": 100, "vertical_damping_kNs_per_m": 40}
    layer |= {"lateral_stiffness_MN_per_m": 40, "lateral_damping_kNs_per_m": 30}
    sleepers = {"kind": "sleepers", "spacing_mm": 600, "sleeper_mass_kg": 324, "pad": layer, "ballast": layer}
    dip = {"at_m": 102, "length_m": 2, "amplitude_mm": 3, "rail": "right"}
    uneven = [{"kind": "dip", **dip}, {"kind": "alignment", **dip}]
    values = {"track.structure": sleepers, "track.irregularities": uneven, "run.output_interval_ms": 1}
    values |= {"run.start_distance_m": 101, "run.distance_m": 2.5, "output.patches_at_m": []}
    forces = []
    for pivot in ("centre line", "high rail"):
        data = run(load(SCENARIOS / "curve_r300.toml").with_values(FAST | values | {"track.pivot": pivot})).dataset
        forces.append(np.stack((data["Y"], data["Q"])))
    assert np.ptp(forces[0], axis=1).max() > 1e4  # the dip is felt
    # a constant height is left: its rounding moves what contacts leave unsolved, so much of the weight
    assert np.abs(forces[1] - forces[0]).max() < CONTACT_TOLERANCE * 109e3


def test_what_is_assumed_is_said_and_what_contradicts_is_refused() -> None:
    assert track("low rail").assumptions.startswith("over 1500 mm, turns about the low rail, whose top stays")
    assert "about the centre line" in track().assumptions
    assert Track.build([Straight(10.0)]).assumptions == ""
    with pytest.raises(InputError, match=r"pivot = 'low'; allowed: .*'low rail'.*did you mean 'low rail'"):
        Track.build(ROW, pivot="low")
    law, _ = alignment_laws([Plan(50.0)], [Cant(0.0, 50.0, (0.0, 0.02), (0.0, 0.02))])
    assert "by the heights of both rails" in Track.from_laws(law).assumptions
    for options, word in (({"pivot": "high rail"}, "pivot = 'high rail'"), ({"grades": [Grade(0.0, 0.01)]}, "grades")):
        with pytest.raises(InputError, match=f"{word} cannot be given with an alignment"):
            Track.from_laws(law, **options)
