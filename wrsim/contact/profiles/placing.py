"""Points of a file in the axes used here, by what is stated and by their shape.

What is stated wins, what the shape contradicts is refused, and what is assumed stands in a note. A flange is where the
curve turns back: from the face over the tip to the back. A rail shows its gauge side by a groove, its inclination or
wear.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim.contact.profiles.flange import BACK, FLANGE_FROM, LEVEL
from wrsim.contact.profiles.formats import Scan, Side
from wrsim.contact.profiles.points import ProfilePoints, turns
from wrsim.contact.profiles.profile import GAUGE_DEPTH, Array, Kind, Profile
from wrsim.errors import InputError

Heights = Literal["up", "down"]
Origin = Literal["tape circle", "flange back"]
SIGNS = {"positive": 1.0, "negative": -1.0, "up": 1.0, "down": -1.0, None: 0.0}
WIDTHS: dict[Kind, tuple[float, float]] = {"wheel": (0.06, 0.2), "rail": (0.025, 0.3)}
"""Widths of profiles [m]: wheels are 120 to 150 mm wide, heads of rails 36 to 76, with a check rail some 200. A width
in cm or inches that is taken for mm lies outside."""
STEP, WINDOW = 0.5e-3, 5  # distance of the samples of which the direction is taken [m], and of how many it is a mean
BACK_SLOPE = np.radians(70.0)  # where a scan of the back ends at this slope, an arc of 20 mm goes on for 1.2 mm
TREAD_SLOPE = np.radians(25.0)  # no tread is steeper, with its root and wear
TREAD_LENGTH = 15e-3  # of a tread beside its flange, at least [m]
BACK_TOLERANCE = 2.5e-3
"""How far the flange back may lie from where it should [m]: between the tolerance of wheelsets, 1.5 mm a wheel
(distance of the backs 1357 to 1363 mm), and 5 mm, which no contact geometry forgives."""
TIP_RANGE = (8e-3, 25e-3)  # of a flange's tip from its back [m]: 15 mm in EN 13715, some 10 of trams, 20 if worn flat
TIPS = (-95e-3, -25e-3)  # of the tip of a flange from the tape circle [m], 50 to 100 mm of which are to the back
THICKNESS = (20e-3, 38e-3)  # of flanges [m]: 22 mm in service by EN 15313, 36 mm of thick new ones
GROOVE = 10e-3  # depth from which a valley beside the head is a groove [m]
ALIKE = 0.25e-3  # how far the halves of a head may differ [m]: half of the tolerance of its width, EN 13674-1
WORN = 0.5e-3  # mean width of what is missing on one side from which it is worn [m]: the tolerance of new heads
SIDE_SLOPE = np.radians(60.0)  # the sides of a head are steeper
INCLINED = 1.0 / 80.0  # half of the smallest inclination of rails
HEAD_DEPTH = 30e-3  # of the head that is compared with its mirror image [m]
OUTER = 45e-3
"""u from which a wheel's tread does not meet the rail [m]: half of a head, 36 mm, and the play of a wheelset."""
OVERHANG = np.radians(95.0)  # slope of the curve below a head, beyond its upright sides
ERROR = 20e-6  # distance from which a point counts less [m]: some scatter of an instrument
FAR, LARGEST_TILT = 15e-3, 0.1  # distance of a scan laid on its mark [m] and its tilt [rad], at most
FEWEST = 20  # points on the parts that do not wear
SHORTEST_BASE = 10e-3  # extent of these parts, without which they do not hold the turn [m]


@dataclass(frozen=True)
class Placed:
    """Points in the axes used here; back: distance of the flange back from the tape circle where a wheel has one [m];
    notes: what was assumed."""

    points: ProfilePoints
    back: float | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class FlangeShape:
    """Flange of an upright wheel: u of its tip and its back [m], None where the points do not reach it, and of its face
    10 mm below the tread beside it."""

    tip: float | None
    back: float | None
    face: float


def placed(points: ProfilePoints, body: Kind, scan: Scan, options: Mapping[str, Any], shift: float | None) -> Placed:
    """Place the points of a scan, whose unit is applied.

    options: of `contact.profiles.files.read_points`; shift: lateral one that follows [m], None for points that are
    aligned and so have any origin. Raises InputError where the shape contradicts or does not decide.
    """
    heights, field_side = options.get("heights", scan.heights), options.get("field_side", scan.field_side)
    back, by = options.get("back", scan.back), "as stated"
    if back is None and (back := options.get("usual_back")):
        by = "as of the wheelset"
    if body == "rail":
        return _placed_rail(points, scan, heights, field_side)
    upright_wheel = _upright_wheel(points)
    notes: list[str] = []
    if upright_wheel is None:
        if heights is None:
            message = "the direction of its heights is unknown; give heights: up or down"
            raise InputError(f"{points.file}: {message}, unless it is a rail: no flange is seen")
        return Placed(_signed(points, SIGNS[field_side or scan.convention] or 1.0, SIGNS[heights]), back, ())
    sign_u, sign_w, shape = upright_wheel
    if shape.tip is not None:
        if SIGNS[heights] not in (0.0, sign_w):
            message = f"the flange points the wrong way up with heights '{heights}'; is it the other one?"
            raise InputError(f"{points.file}: {message}")
        if SIGNS[field_side] not in (0.0, sign_u):
            raise InputError(f"{points.file}: the flange is on the field side with field_side '{field_side}'")
    else:
        sign_u, sign_w = SIGNS[field_side] or sign_u, SIGNS[heights] or sign_w
        notes.append("no tip of a flange: its steep end is taken for the face")
    if scan.convention == "positive" and sign_u < 0.0 and not field_side:
        notes.append("the flange is at positive y: mirrored")
    upright = _signed(points, sign_u, sign_w)
    if shift is None:
        return Placed(upright, back, tuple(notes))
    moved, distance, note = _from_tape_circle(points.file, shape, options.get("origin"), back, by, shift)
    return Placed(replace(upright, u=upright.u + moved), distance, (*notes, *note))


def _signed(points: ProfilePoints, sign_u: float, sign_w: float) -> ProfilePoints:
    return replace(points, u=sign_u * points.u, w=sign_w * points.w).in_order()


def _sampled(points: ProfilePoints) -> tuple[Array, Array]:
    """Places (n, 2) along the points, a mean of neighbours, and the direction there [rad], continuous."""
    s = np.concatenate([[0.0], np.cumsum(points.chords)])
    even = np.arange(0.0, s[-1], STEP)
    mean = np.ones(WINDOW) / WINDOW
    p = np.column_stack([np.convolve(np.interp(even, s, x), mean, "valid") for x in (points.u, points.w)])
    d = np.gradient(p, axis=0)
    return p, np.unwrap(np.arctan2(d[:, 1], d[:, 0]))


def _upright_wheel(points: ProfilePoints) -> tuple[float, float, FlangeShape] | None:
    """Signs of u and w that put the flange upright and inside, and its shape; None where that is not unique."""
    candidates = [
        (u, w, shape) for u, w in product((1.0, -1.0), repeat=2) if (shape := _flange_of(_signed(points, u, w)))
    ]
    whole = [each for each in candidates if each[2].tip is not None]
    return (whole or candidates)[0] if len(whole or candidates) == 1 else None


def _flange_of(points: ProfilePoints) -> FlangeShape | None:
    """The flange if the points are an upright wheel: left of the tread, with or without its tip."""
    p, angle = _sampled(points)
    long = int(TREAD_LENGTH / STEP)
    steep = angle >= FLANGE_FROM
    for begin in np.flatnonzero(steep & ~np.concatenate([[False], steep[:-1]])):
        flat = np.flatnonzero(angle[begin:] <= TREAD_SLOPE)
        end = begin + int(flat[0]) if flat.size else angle.size
        if angle.size - end < long or np.abs(angle[end : end + long]).max() > TREAD_SLOPE:
            continue
        level = float(np.median(p[end : end + long, 1])) - LEVEL
        face = float(np.interp(level, p[begin:end, 1], p[begin:end, 0]))
        falling = np.flatnonzero(angle[:begin] < 0.0)
        if not falling.size:
            return FlangeShape(None, None, face)
        tip = int(falling[-1])
        inside = points.u[: 1 + int(np.argmin(points.w[points.u < face]))] if (points.u < face).any() else points.u[:1]
        return FlangeShape(float(p[tip, 0]), float(inside.min()) if angle[:tip].min() <= -BACK_SLOPE else None, face)
    return None


def _from_tape_circle(
    file: str, shape: FlangeShape, origin: Origin | None, back: float | None, by: str, shift: float
) -> tuple[float, float, tuple[str, ...]]:
    """How far the points move so that u is counted from the tape circle, where its flange back is [m], and notes."""
    distance = back or BACK
    zeros: dict[Origin, float] = {"tape circle": -distance, "flange back": 0.0}

    def fits(zero: float) -> bool:
        """Whether the flange back may lie there."""
        if shape.back is not None:
            return abs(shape.back + shift - zero) <= BACK_TOLERANCE
        near_tip = shape.tip is None or TIP_RANGE[0] <= shape.tip + shift - zero <= TIP_RANGE[1]
        return near_tip and THICKNESS[0] <= shape.face + shift - zero <= THICKNESS[1]

    chosen = next((name for name in zeros if origin in (None, name) and fits(zeros[name])), None)
    circle = f"tape circle at {1e3 * distance:.6g} mm"
    if chosen is None:
        marks = {
            "the flange back": shape.back,
            "the tip of the flange": shape.tip,
            "the face of the flange": shape.face,
        }
        part, mark = next((part, mark) for part, mark in marks.items() if mark is not None)
        place = f"{part} lies at u = {1e3 * (mark + shift):.1f} mm"
        wrong = f"with its {origin} at u = 0" if origin else "u = 0 is neither its tape circle nor its flange back"
        needed = f"{circle} from the flange back{'' if back else ' (assumed)'}"
        raise InputError(f"{file}: {wrong}: {place}, {needed}. Set back_to_tape_circle_mm, origin, or shift_mm")
    known = by if back else "assumed (back_to_tape_circle_mm)"
    thick = (
        f"so the flange is some {1e3 * (shape.face + shift - zeros[chosen]):.0f} mm thick: its back was not measured"
    )
    if chosen == "flange back":
        doubt = "" if shape.back is not None else f", {thick}"
        return -distance, distance, (f"x from the flange back, {circle} {known}{doubt}",)
    if origin:
        return 0.0, distance, ()
    seen = thick if shape.back is None else f"the flange back is at {1e3 * (shape.back + shift):.1f} mm"
    return 0.0, distance, (f"u = 0 is taken for the tape circle (origin), {seen}",)


def _placed_rail(points: ProfilePoints, scan: Scan, heights: Heights | None, field_side: Side | None) -> Placed:
    # From left to right over an upright head the tangent turns down by nearly half a turn.
    total = float(turns(points.in_order()).sum())
    up = -np.sign(total) if abs(total) > np.radians(30.0) else 0.0
    if not (up or heights):
        raise InputError(f"{points.file}: the direction of its heights is unknown; give heights: up or down")
    if heights and up not in (0.0, SIGNS[heights]):
        raise InputError(f"{points.file}: the head is the wrong way up with heights '{heights}'; is it the other one?")
    upright = _signed(points, 1.0, SIGNS[heights] or up)
    if field_side:
        return Placed(_signed(upright, SIGNS[field_side], 1.0), None, ())
    sign, reason = field_side_of(upright)
    usual = SIGNS[scan.convention]
    side = {1.0: "field", -1.0: "gauge"}
    if usual * sign < 0.0:
        message = f"x counts to the {side[usual]} side in these files, and by {reason} it does not"
        raise InputError(f'{points.file}: {message}: give field_side, "positive" or "negative"')
    if usual:
        note = f"x to the {side[usual]} side, as its format has it (field_side)"
    elif sign:
        note = f"x to the {side[sign]} side by {reason} (field_side)"
    else:
        note = "both sides alike" if reason else "x to the field side assumed: its shape does not show it (field_side)"
    return Placed(_signed(upright, usual or sign or 1.0, 1.0), None, (note,))


def check_gauge_side(rail: ProfilePoints) -> None:
    """Raise InputError for a rail of which only the side away from the gauge reaches down to the gauge point."""
    top = int(np.argmax(rail.w))
    gauge, field = (float(rail.w[top] - part.min()) for part in (rail.w[: top + 1], rail.w[top:]))
    if gauge < GAUGE_DEPTH <= field:
        deep = f"its gauge side goes {1e3 * gauge:.1f} mm deep and its field side {1e3 * field:.1f} mm"
        raise InputError(f"{rail.file}: {deep}: give field_side, or cut off with clip_mm what is not the head")


def check_tread(profile: Profile) -> None:
    """Raise InputError for a wheel with a flange whose tread is not at u = 0, whatever its tape circle is."""
    if profile.kind == "wheel" and profile.length > TREAD_LENGTH:
        every = max(profile.u.size // 1000, 1)
        points = ProfilePoints(profile.name, profile.u[::every], profile.w[::every], np.arange(0))
        shape = _flange_of(points)
        if shape and shape.tip is not None and not TIPS[0] <= shape.tip <= TIPS[1]:
            place = f"the tip of its flange lies at u = {1e3 * shape.tip:.1f} mm"
            allowed = f"allowed: {1e3 * TIPS[0]:g} to {1e3 * TIPS[1]:g} mm"
            raise InputError(f"profile '{profile.name}': u = 0 is not on its tread: {place}; {allowed}")


def groove_of(rail: ProfilePoints) -> int | None:
    """Index of the lowest point of the groove between an upright head and what lies beside it, if there is one."""
    left, right = np.maximum.accumulate(rail.w), np.maximum.accumulate(rail.w[::-1])[::-1]
    depth = np.minimum(left, right) - rail.w
    i = int(np.argmax(depth))
    return i if depth[i] > GROOVE else None


def field_side_of(rail: ProfilePoints) -> tuple[float, str]:
    """Sign of u on the field side of an upright rail, and what shows it; 0 where nothing does, with a word where both
    sides are alike."""
    if (i := groove_of(rail)) is not None:
        return (1.0 if rail.u[i] < 0.0 else -1.0), "the groove"
    p, _ = _sampled(rail)
    p = p[p[:, 1] > p[:, 1].max() - HEAD_DEPTH]
    lean, apart = _folded(p)
    if apart <= ALIKE:
        if abs(lean) < INCLINED:
            return 0.0, "alike"
        return float(np.sign(lean)), f"its inclination of 1:{1.0 / abs(lean):.0f}"
    missing = _missing(p)
    return (
        (float(np.sign(missing)), f"wear of {1e3 * abs(missing):.1f} mm in the mean")
        if abs(missing) > WORN
        else (0.0, "")
    )


def _missing(p: Array) -> float:
    """How much less of the box about it the left half of a head (n, 2) fills than the right one, over its depth [m]; 0
    for a head that does not reach to its sides."""
    ends = p[[3, -1]] - p[[0, -4]]
    if (np.abs(ends[:, 1]) < np.tan(SIDE_SLOPE) * np.abs(ends[:, 0])).any():
        return 0.0
    left, right = int(np.argmin(p[:, 0])), int(np.argmax(p[:, 0]))
    u, depth = p[left : right + 1, 0], p[:, 1].max() - p[left : right + 1, 1]
    area = np.concatenate([[0.0], np.cumsum(0.5 * (depth[1:] + depth[:-1]) * np.diff(u))])
    half = float(np.interp(0.5 * (u[0] + u[-1]), u, area))
    return (2.0 * half - float(area[-1])) / HEAD_DEPTH


def _folded(head: Array) -> tuple[float, float]:
    """Lean of the axis about which an upright head (n, 2) is nearest to its mirror image, positive with the top at
    smaller u, and how far 95 % of the image lies from it [m]; infinite for a head of which one side is missing."""
    top = float(head[:, 1].max())
    low = max(head[0, 1], head[-1, 1])
    if top - low < 0.4 * HEAD_DEPTH:
        return 0.0, np.inf
    head = head[head[:, 1] >= low]
    head = head - (0.5 * (head[0, 0] + head[-1, 0]), top)

    def turned(x: Array) -> Array:
        return np.asarray(head @ np.array([[1.0, -x[1]], [x[1], 1.0]]) + (x[0], 0.0))

    def apart(x: Array) -> Array:
        points = turned(x)
        image, d = points * (-1.0, 1.0), np.gradient(points, axis=0)
        normal = np.column_stack([-d[:, 1], d[:, 0]]) / np.hypot(*d.T)[:, None]
        nearest = scipy.spatial.cKDTree(points).query(image)[1]
        inside = (nearest > 2) & (nearest < len(points) - 3)
        return np.where(inside, ((image - points[nearest]) * normal[nearest]).sum(axis=1), 0.0)

    fit = scipy.optimize.least_squares(
        apart, np.zeros(2), loss="soft_l1", f_scale=0.2 * ALIKE, x_scale=(1e-3, 0.01),
        bounds=([-0.01, -0.07], [0.01, 0.07]), diff_step=1e-3,
    )  # fmt: skip
    return float(fit.x[1]), float(np.quantile(np.abs(apart(fit.x)), 0.95))


def aligned(points: ProfilePoints, unworn: Profile) -> tuple[ProfilePoints, str]:
    """The upright points of a scan moved and turned onto an unworn profile, and a note of it.

    They are laid on it by the parts that do not wear: of a wheel the back of its flange and its outer face, of a rail
    the field side and what overhangs below its head. Robust least squares of the distances along the normal of the
    unworn curve: a part that wears after all counts little. Raises InputError where too little of these was scanned.
    """
    curve = np.column_stack([unworn.u, unworn.w])
    normal = np.column_stack([-np.sin(unworn.angle), np.cos(unworn.angle)])
    keeps = _unworn_parts(unworn)
    tree = scipy.spatial.cKDTree(curve)
    x = np.array([*(_mark(curve, unworn.kind) - _mark(points.places, unworn.kind)), 0.0])
    reach = np.array([FAR, FAR, LARGEST_TILT])
    for _ in range(4):  # which points lie on these parts follows from where the scan lies
        near, node = tree.query(_moved(points, x).places)
        # beyond an end of the unworn curve there is nothing to be on
        chosen = np.flatnonzero(keeps[node] & (near < FAR) & (node > 0) & (node < len(curve) - 1))
        part = points[chosen]
        if len(part) < FEWEST or float(np.hypot(*np.ptp(part.places, axis=0))) < SHORTEST_BASE:
            message = f"{len(part)} points on the parts of {unworn.name} that do not wear; needed are {FEWEST}"
            raise InputError(f"{points.file}: cannot be aligned: {message}, over {1e3 * SHORTEST_BASE:g} mm")

        def distances(x: Array, part: ProfilePoints = part) -> Array:
            p = _moved(part, x).places
            i = tree.query(p)[1]
            return np.asarray(((p - curve[i]) * normal[i]).sum(axis=1))

        fit = scipy.optimize.least_squares(
            distances, x, loss="soft_l1", f_scale=ERROR, x_scale=(1e-3, 1e-3, 1e-2),
            bounds=(x - reach, x + reach),
        )  # fmt: skip
        x = fit.x
    u, w, turn = x
    residual = 1e3 * float(np.median(np.abs(distances(x))))
    moved = f"moved by {1e3 * u:.3f}, {1e3 * w:.3f} mm, turned by {1e3 * turn:.2f} mrad"
    return _moved(points, x), f"aligned on {unworn.name}: {moved}, residual {residual:.3f} mm of {len(part)} points"


def _mark(places: Array, kind: Kind) -> Array:
    """A point of a curve (n, 2) by which it is laid roughly: a flange's tip; the top and the field end of a rail."""
    if kind == "wheel":
        return places[int(np.argmin(places[:, 1]))]
    return places.max(axis=0)


def _moved(points: ProfilePoints, x: Array) -> ProfilePoints:
    turned = points.turned(float(x[2]))
    return replace(turned, u=turned.u + x[0], w=turned.w + x[1])


def _unworn_parts(unworn: Profile) -> NDArray[np.bool_]:
    """Nodes of a profile where it does not wear, (n,)."""
    u, slope = unworn.u, np.abs(unworn.angle)
    if unworn.kind == "wheel":
        return (u >= OUTER) | (u <= u[int(np.argmin(unworn.w))])
    return np.asarray((slope >= OVERHANG) | ((u > unworn.top[0]) & (slope >= SIDE_SLOPE)))
