"""Grades and vertical curves: how steeply the centre line climbs, over the distance along it.

A line's vertical alignment is a row of grades; each holds from its point of change on. Around that point a circular
curve of the vertical radius leads from one grade to the next, half of its length before the point and half behind:
the angle of slope runs linearly over |change of angle| times radius.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wrsim.errors import InputError
from wrsim.geometry.piecewise import Piecewise
from wrsim.geometry.track.segments import within

STEEPEST = 0.15
"""Largest grade: 150 per thousand; adhesion railways use up to 80."""
TIGHTEST = 200.0
"""Smallest vertical radius [m]; light rail goes down to 350 m, marshalling humps to 250 m."""


@dataclass(frozen=True)
class Grade:
    """From a distance on [m] the track climbs by ``slope`` (rise over length along the level; 0.008 is 8 per
    thousand). radius: of the vertical curve at the change [m]; without meaning for a grade that begins at 0."""

    start: float
    slope: float
    radius: float = 10_000.0


def pitch_law(grades: Sequence[Grade], length: float) -> Piecewise:
    """Angle of slope [rad], positive uphill, over the distance along a track of that length [m].

    Level where there are no grades, and before the first. Raises InputError, with the grade's number, for wrong
    values and for vertical curves that overlap or reach beyond the track.
    """
    starts, rows = [0.0], [0.0]  # knots of the piecewise linear angle
    angle, free = 0.0, 0.0
    for number, grade in enumerate(grades, 1):
        _check(number, grade, grades[number - 2].start if number > 1 else None, length)
        target = math.atan(grade.slope)
        if grade.start == 0.0:
            rows[0] = angle = target
            continue
        half = 0.5 * abs(target - angle) * grade.radius
        if half == 0.0:
            continue
        begin, end = grade.start - half, grade.start + half
        if begin < free - 1e-9 or end > length + 1e-9:
            where = "the end of the track" if end > length else "the one before, or the start of the track"
            raise InputError(
                f"grades[{number - 1}]: its vertical curve runs from {begin:g} to {end:g} m and meets {where}; "
                f"allowed: a smaller vertical_radius_m (now {grade.radius:g}), or grades further apart"
            )
        if begin > starts[-1] + 1e-9:
            starts.append(begin)
            rows.append(angle)
        starts.append(min(end, length))
        rows.append(target)
        angle, free = target, end
    if length > starts[-1] + 1e-9:
        starts.append(length)
        rows.append(angle)
    return Piecewise.through(np.array(starts), np.array(rows))


def _check(number: int, grade: Grade, before: float | None, length: float) -> None:
    where = f"grades[{number - 1}]"
    low = 0.0 if before is None else before
    if not (low if before is None else low + 1e-9) <= grade.start < length:
        after = "0" if before is None else f"above {before:g} (the grade before)"
        raise InputError(f"{where}: from_m = {grade.start:g}; allowed: {after} to {length:g}, on the track and rising")
    within(where, "grade_permille", grade.slope, -STEEPEST, STEEPEST, 1e3)
    within(where, "vertical_radius_m", grade.radius, TIGHTEST, 1e7)
