"""Points that instruments and drawings leave: parts scanned twice, straight parts without points, corners far from any
contact. Each repair gives a note; what would change the shape where wheels and rails touch is refused elsewhere.
"""

from dataclasses import replace

import numpy as np

from wrsim.contact.profiles.points import LARGEST_TURN, ProfilePoints, turns
from wrsim.contact.profiles.profile import Array, Kind, plane_cross

SCANNED_TWICE = 25e-3  # longest part of a scan that is scanned twice [m]: over the tip of a flange
SAME_CURVE = 0.3e-3  # how far two scans of one part may be apart [m]: play of the joints of an arm, some 0.2 mm
MOST_MERGED = 20  # pairs of points that are merged where two scans alternate
ARC_HEIGHT = 0.15e-3
"""Height of the arc over a chord up to which a gap is filled [m]: that of 4 mm on a radius of 13 mm, the coarsest
points that are interpolated."""
FILLED = 0.5e-3  # distance of points put on a chord [m]
END_PART = 0.1  # part of a gap's length over which the direction beside it is taken
FILLET = 1e-3  # length of a chord that a rounded corner takes at most [m]
FILLET_STEPS = 10  # points of a rounded corner
RUNNING_SLOPE: dict[Kind, float] = {"wheel": np.radians(20.0), "rail": np.radians(80.0)}
"""Slope of a chord, outside of which nothing touches: of a wheel outside of its tread, of a rail below its sides."""


def joined(points: ProfilePoints) -> tuple[ProfilePoints, list[str]]:
    """The points of a scan without what was scanned twice: runs back along the curve and forward again, and pairs of
    points of two scans that alternate."""
    notes, merged, apart_by = list[str](), list[int](), 0.0
    while (back := np.flatnonzero(np.abs(turns(points)) > 0.5 * np.pi) + 1).size and len(merged) < MOST_MERGED:
        last, again = int(back[0]), int(back[min(1, back.size - 1)])
        far = float(np.hypot(*(points.places[again] - points.places[last])))
        if again > last and 2.0 * SAME_CURVE < far <= SCANNED_TWICE:
            kept, apart = _last_before(points, last, points.places[again])
            if apart > SAME_CURVE:
                break
            where = f"line {points.line[again]}: {1e3 * far:.1f} mm scanned twice, {1e3 * apart:.2f} mm apart"
            notes.append(f"{where}: joined")
            points = points[np.r_[0:kept, again : len(points)]]
            continue
        chords = points.chords
        i = last if last + 1 == len(points) or chords[last - 1] > chords[last] else last - 1
        if chords[i] > SAME_CURVE:
            break
        merged.append(int(points.line[i]))
        apart_by = max(apart_by, float(chords[i]))
        points = _with(points, i, i + 1, points.places[i : i + 2].mean(axis=0, keepdims=True))
    if merged:
        lines = f"lines {min(merged)} to {max(merged)}" if len(merged) > 1 else f"line {merged[0]}"
        notes.append(f"{lines}: points of two scans, {1e3 * apart_by:.2f} mm apart: merged")
    return points, notes


def _last_before(points: ProfilePoints, last: int, place: Array) -> tuple[int, float]:
    """How many points up to one of them lie before the place on their curve that is nearest to a place, and how far
    that is from it [m]."""
    p = points.places[: last + 1]
    d = np.diff(p, axis=0)
    part = np.clip(((place - p[:-1]) * d).sum(axis=1) / (d * d).sum(axis=1), 0.0, 1.0)
    apart = np.hypot(*(p[:-1] + part[:, None] * d - place).T)
    i = int(np.argmin(apart))
    before = part[i] * np.hypot(*d[i]) > 0.1 * float(np.median(points.chords))
    return max(i + int(before), 1), float(apart[i])


def rounded(points: ProfilePoints, body: Kind, least: float) -> tuple[ProfilePoints, list[str]]:
    """Upright points with corners above a turn [rad] rounded where no contact reaches: outside of a wheel's tread, at
    the foot of a rail's head."""
    places: list[float] = []
    for i in (np.flatnonzero(np.abs(turns(points)) > least) + 1)[::-1]:
        if not (_outside(points, int(i) - 1, body) or _outside(points, int(i), body)):
            continue
        before, after = np.diff(points.places[i - 1 : i + 2], axis=0)
        a, b = np.hypot(*before), np.hypot(*after)
        t = min(FILLET, 0.4 * a, 0.4 * b)
        corner, e, f = points.places[i], before / a, after / b
        x = np.linspace(0.0, 1.0, FILLET_STEPS + 1)[:, None]
        # a parabola between the chords, and one more point on each of them
        arc = corner - t * (1.0 - x) ** 2 * e + t * x**2 * f
        beside = [corner - (t + 0.2 * (a - t)) * e], [corner + (t + 0.2 * (b - t)) * f]
        arc = np.concatenate([beside[0], arc, beside[1]])
        places.append(1e3 * float(corner[0]))
        points = _with(points, int(i), int(i), arc)
    where = f"{min(places):.1f} mm" + (f" to {max(places):.1f} mm" if len(places) > 1 else "") if places else ""
    return points, [f"far from any contact, {len(places)} corner(s) rounded at u = {where}"] if places else []


def filled(points: ProfilePoints, body: Kind, gap: float) -> tuple[ProfilePoints, list[str]]:
    """Upright points with more of them on chords longer than a gap [m] over which the curve hardly turns, or where
    nothing touches: on a cubic that goes on in the directions beside the chord."""
    longest, count = 0.0, 0
    for i in np.flatnonzero(points.chords > gap)[::-1]:
        p, chord = points.places, float(points.chords[i])
        s = np.concatenate([[0.0], np.cumsum(points.chords)])
        before = min(int(np.searchsorted(s, s[i] - END_PART * chord, side="right")) - 1, int(i) - 1)
        after = max(int(np.searchsorted(s, s[i + 1] + END_PART * chord)), int(i) + 2)
        d = p[i + 1] - p[i]
        ends = [p[i] - p[before] if before >= 0 else d, p[after] - p[i + 1] if after < len(p) else d]
        turn = max(abs(float(np.arctan2(plane_cross(d, e), e @ d))) for e in ends)
        touched = not _outside(points, int(i), body)
        if turn > LARGEST_TURN or (touched and 2.0 * turn * chord / 8.0 > ARC_HEIGHT):
            continue
        x = np.arange(1, n := int(np.ceil(chord / FILLED)))[:, None] / n
        first, second = (chord * e / np.hypot(*e) for e in ends)
        curve = p[i] + x * (first + x * (3.0 * d - 2.0 * first - second + x * (first + second - 2.0 * d)))
        points = _with(points, int(i) + 1, int(i), curve)
        longest, count = max(longest, chord), count + 1
    subject = "gap" if count == 1 else f"{count} gaps of up to"
    return points, [f"{subject} {1e3 * longest:.3g} mm filled, over which the curve hardly turns"] if count else []


def _outside(points: ProfilePoints, i: int, body: Kind) -> bool:
    """Whether the chord behind a point is steeper than where wheels and rails touch."""
    du, dw = np.diff(points.places[i : i + 2], axis=0)[0]
    return bool((body == "rail" or points.u[i + 1] > 0.0) and np.arctan2(abs(dw), du) >= RUNNING_SLOPE[body])


def _with(points: ProfilePoints, begin: int, end: int, new: Array) -> ProfilePoints:
    """The points with those from begin to end replaced by new ones (n, 2), which have the line of the first."""
    places = np.concatenate([points.places[:begin], new, points.places[end + 1 :]])
    line = np.full(len(new), points.line[min(begin, len(points) - 1)])
    lines = np.concatenate([points.line[:begin], line, points.line[end + 1 :]])
    return replace(points, u=places[:, 0], w=places[:, 1], line=lines)
