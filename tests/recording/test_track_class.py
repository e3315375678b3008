"""Class of track by 49 CFR 213: limits as printed in the law, in inches for classes 1 to 5."""

from pathlib import Path

import numpy as np
import pytest

from wrsim import Arc, Straight, Transition
from wrsim.inputs.us_units import FOOT, chord_curvature
from wrsim.recording.columns import ChannelSection, ColumnsFile
from wrsim.recording.design import Plateau
from wrsim.recording.reading import TrackRecording
from wrsim.recording.restoring import Restored
from wrsim.recording.track_class import INCH, WINDOW, ClassWindow, class_table, curve_speed, quantities, track_classes
from wrsim.track.irregularities import Bump
from wrsim.track.segments import Segment, laws

LENGTH, MIDDLE, CHORD = 600.0, 310.0, 62.0 * FOOT
NONE = float("inf")
LAW: dict[str, tuple[float, ...]] = {
    "gage at most": (58, 57.75, 57.75, 57.5, 57.5),  # 213.53(b)
    "gage at least": (56, 56, 56, 56, 56),
    "alinement over 62 ft": (5, 3, 1.75, 1.5, 0.75),  # 213.55(a), tangent
    "alinement over 62 ft, curve": (5, 3, 1.75, 1.5, 0.625),
    "alinement over 31 ft, curve": (NONE, NONE, 1.25, 1, 0.5),
    "elevation, curve": (8, 8, 7, 7, 7),  # 213.57(a)
    "surface over 62 ft": (3, 2.75, 2.25, 2, 1.25),  # 213.63(a)
    "crosslevel": (3, 2, 1.75, 1.25, 1),
    "reverse crosslevel, curve": (3, 2, 1.75, 1.25, 1),
    "warp over 62 ft, curve": (3, 2.25, 2, 1.75, 1.5),
    "warp, elevation of 6 in over 62 ft, curve": (1.5, 1.5, 1.5, 1.5, 1.5),  # footnote 1
}
SPEEDS = ((0, 0), (10, 15), (25, 30), (40, 60), (60, 80), (80, 90))  # 213.9(a), freight and passenger, mph


def windows_of(quantity: str, inches: float) -> tuple[ClassWindow, ...]:
    """Verdicts on a track whose only fault is this one in its middle: a straight, or a left curve of 1000 m."""
    s = np.arange(0.0, LENGTH + 0.1, 0.25)
    cant = 0.0
    lateral, vertical = np.zeros((2, s.size)), np.zeros((2, s.size))
    size, long = inches * INCH, 300.0
    chord = 0.5 * CHORD if "31 ft" in quantity else CHORD
    bump = Bump(MIDDLE - 0.5 * chord, chord, 1.0).jet(s)[0]
    swell = Bump(MIDDLE - 0.5 * long, long, 1.0).jet(s)[0]  # too long for a chord
    if quantity.startswith("gage"):
        lateral[0] = (size - 56.5 * INCH) * swell
    elif quantity.startswith("alinement"):
        lateral[:] = size * bump
    elif quantity.startswith("surface"):
        vertical[:] = -size * bump
    elif quantity == "crosslevel":
        vertical[1] = size * swell
    elif quantity.startswith("reverse"):
        vertical[1] = -size * swell
    elif quantity.startswith("elevation"):
        cant = size
    else:  # warp: the rails to either side, so that neither leaves its profile
        cant = (4.0 if quantity.startswith("warp over") else 6.05) * INCH
        vertical[0], vertical[1] = -0.5 * size * bump, 0.5 * size * bump
    segments: list[Segment] = [Straight(LENGTH)]
    plateaus: tuple[Plateau, ...] = (Plateau(0.0, LENGTH, 0.0, 0.0),)
    if quantity.endswith("curve"):
        segments = [Straight(20.0), Transition(110.0), Arc(LENGTH - 130.0, 1000.0, cant)]
        plateaus = (Plateau(0.0, 20.0, 0.0, 0.0), Plateau(130.0, LENGTH, 1e-3, cant))
    kinds = ("cant", "gauge", "alignment_left", "alignment_right", "level_left", "level_right")
    channels = [
        ChannelSection.model_validate({"column": kind, "quantity": kind} | ({"band": "D1"} if "_" in kind else {}))
        for kind in kinds
    ]
    along = ChannelSection.model_validate({"column": "distance", "quantity": "distance"})
    columns = ColumnsFile.model_validate({"channels": [along, *channels], "gauge_mm": 1435.1})
    records = tuple((channel, np.zeros(s.size)) for channel in channels)
    recording = TrackRecording(Path("line.csv"), columns, 1000.0, 0.25, records, False, ())
    law = laws(segments, 1.4351, 1.0)
    restored = Restored(recording, plateaus, tuple(segments), law, lateral, vertical, (), ())
    return track_classes(restored, quantities(restored))


@pytest.mark.parametrize("quantity", LAW)
def test_a_class_holds_up_to_its_printed_limit_and_not_beyond(quantity: str) -> None:
    """1 % to either side; of the gage 0.1 %, which is 0.06 in."""
    share = {"gage at least": -1e-3, "gage at most": 1e-3}.get(quantity, 0.01)
    limits = [limit for limit in LAW[quantity] if np.isfinite(limit)]
    first = len(LAW[quantity]) - len(limits) + 1
    for limit in set(limits):
        highest = max(c for c, class_limit in enumerate(limits, first) if class_limit == limit)
        lowest = min(c for c, class_limit in enumerate(limits, first) if class_limit == limit)
        inside = min(windows_of(quantity, (1.0 - share) * limit), key=lambda w: w.track_class)
        beyond = windows_of(quantity, (1.0 + share) * limit)[int(MIDDLE // WINDOW)]
        name = quantity.removesuffix(", curve")
        if quantity.startswith("warp, "):  # 7.6 in of elevation are beyond classes 3 to 5
            assert inside.track_class == 2
        else:
            assert inside.track_class == highest
        assert beyond.track_class == lowest - 1 and beyond.limited_by == name
        assert beyond.limit_in == limit and beyond.value_in == pytest.approx((1.0 + share) * limit, rel=2e-3)
        assert (beyond.freight_mph, beyond.passenger_mph) == SPEEDS[beyond.track_class]


def test_a_fault_counts_in_its_own_100_ft_and_with_half_of_it_31_ft_away() -> None:
    """There a chord has one end on the fault's top: 1 in is class 4."""
    windows = windows_of("alinement over 62 ft", 2.0)
    assert len(windows) == 20 and windows[0].from_m == 1000.0 and windows[0].to_m == pytest.approx(1000.0 + WINDOW)
    low = [w for w in windows if w.track_class == 2]
    assert len(low) == 1 and low[0].from_m < 1000.0 + MIDDLE < low[0].to_m and low[0].place_m == 1310.0
    notes = " ".join(class_table(windows, 5).notes)
    assert (
        "1 of class 2, 1 of class 4, 18 of class 5; the whole is class 2" in notes and "listed: the 5 lowest" in notes
    )


@pytest.mark.parametrize(
    "degrees, inches, mph",
    [(0.5, 0, 93), (1, 0, 65), (1, 6, 113), (2, 3, 65), (3, 4.5, 60), (5, 6, 51), (9, 2, 28), (12, 0, 19), (12, 6, 33)],
)
def test_speeds_in_curves_are_those_of_appendix_a(degrees: float, inches: float, mph: int) -> None:
    """Part 213, Appendix A, table 1, three inches of unbalance, whole miles per hour."""
    speed = curve_speed(np.array([float(inches)]), np.array([chord_curvature(degrees)]))[0]
    assert speed == pytest.approx(mph, abs=0.51)
    assert curve_speed(np.array([0.0]), np.array([0.0]))[0] > 1e4


def test_a_curve_has_its_speed_in_its_body_alone() -> None:
    """A left curve of 1000 m with 4 in: D = 1.746 degrees, sqrt(7 / (0.0007 D)) = 75.7 mph."""
    windows = windows_of("warp over 62 ft, curve", 0.0)
    assert windows[0].curve_mph is None and windows[12].curve_mph == pytest.approx(75.7, abs=0.1)
