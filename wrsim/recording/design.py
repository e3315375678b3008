"""The design of a recorded line: straights, transitions and arcs nearest to recorded curvature and cant.

Transitions are clothoids or Bloss curves. First pieces of straight lines are laid through the smoothed records so that
the sum of their squared distances and a price for each piece is least (dynamic programming). Steep pieces are
transitions, the rest straights and arcs. Then the ends of every transition, and the values before and behind it, are
fitted by least squares to the smoothed records, with the corners smoothed alike, so that the smoothing moves nothing: a
ramp x > 0 under a Gaussian of deviation w is x Phi(x/w) + w phi(x/w). The forms of all transitions are those nearest to
the records, where a change of form along the line has its price.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import least_squares
from scipy.special import ndtr

from wrsim.track.piecewise import Array

Form = Literal["clothoid", "bloss"]
FORMS: tuple[Form, ...] = ("clothoid", "bloss")

SMOOTHING = 6.0  # deviation of the Gaussian that records are smoothed with [m]: irregularities are not the design
NODE = 5.0  # distance of the rows that pieces are laid through [m]
LONGEST_PIECE = 2000.0  # [m]; longer straights and arcs are put together from several
PRICE = 120.0  # price of a piece in squares of the records' noise
LAG = 20.0  # distance over which the noise is separated from the records' bends [m]
LEAST_CURVATURE, LEAST_CANT = 4e-5, 6e-3  # least change of curvature [1/m] and cant [m]: a radius of 25 km is straight
QUIETEST = (2e-6, 2e-4)  # least noise that is believed [1/m, m]
SHORTEST = 2.0  # shortest transition, straight or arc [m]
CHANGE = 30.0  # price of another form than that of the transition before, in half squares of the records' noise
REACH = 200.0  # how far before and behind a transition the records are fitted [m]


@dataclass(frozen=True)
class Plateau:
    """Straight or arc from start to end [m]: curvature [1/m], cant [m] with the right rail higher."""

    start: float
    end: float
    curvature: float
    cant: float
    form: Form = "clothoid"
    """Form of the transition before it."""

    @property
    def is_straight(self) -> bool:
        """True where it does not curve."""
        return abs(self.curvature) < LEAST_CURVATURE


def fit_design(
    distance: Array, curvature: Array, cant: Array, spread: float = 0.0, forms: Sequence[Form] = FORMS
) -> tuple[Plateau, ...]:
    """Straights and arcs of a line: of even distances from 0 [m], curvature [1/m] and cant [m], each (n,).

    Between two of them lies a transition. spread: deviation over which the curvature was measured already [m];
    forms: of transitions that may be.
    """
    step = distance[1] - distance[0]
    widths = (np.sqrt(max(SMOOTHING**2 - spread**2, 1.0)), SMOOTHING)
    pairs = zip((curvature, cant), widths, strict=True)
    records = np.stack([gaussian_filter1d(r, w / step, mode="nearest") for r, w in pairs])
    noise = np.array(
        [noise_of(r, max(1, round(LAG / step)), least) for r, least in zip(records, QUIETEST, strict=True)]
    )
    every = max(1, round(NODE / step))
    nodes, rows = distance[::every], records[:, ::every] / noise[:, None]
    plateaus = _plateaus(distance, records, noise, [(nodes[i], nodes[j]) for i, j in _pieces(nodes, rows)])
    if len(plateaus) < 2:
        return (replace(plateaus[0], start=0.0, end=float(distance[-1])),)
    fine = max(1, round(1.0 / step))
    thin = distance[::fine], records[:, ::fine]
    for _ in range(2):
        plateaus = _refined(plateaus, *thin, noise, forms)
    return tuple(plateaus)


def noise_of(record: Array, lag: int, least: float) -> float:
    """Standard deviation of what is no straight line, by the median of second differences."""
    if record.size <= 2 * lag:
        return least
    bend = record[: -2 * lag] - 2.0 * record[lag:-lag] + record[2 * lag :]
    return max(float(1.4826 * np.median(np.abs(bend)) / np.sqrt(6.0)), least)


def _pieces(nodes: Array, rows: Array) -> list[tuple[int, int]]:
    """First and last node of the pieces of straight lines through rows (channels, n)."""
    n, x = nodes.size, nodes - nodes[0]
    most = max(3, round(LONGEST_PIECE / (nodes[1] - nodes[0]))) if n > 1 else 1
    sums = [np.concatenate(([0.0], np.cumsum(v))) for v in (np.ones(n), x, x * x)]
    centred = rows - rows.mean(axis=1)[:, None]
    moments = [[np.concatenate(([0.0], np.cumsum(v))) for v in (r, r * x, r * r)] for r in centred]
    best, before = np.full(n + 1, np.inf), np.zeros(n + 1, dtype=int)
    best[0] = 0.0
    for j in range(1, n + 1):
        i = np.arange(max(0, j - most), j)
        count, sx, sxx = (s[j] - s[i] for s in sums)
        spread = np.maximum(sxx - sx * sx / count, 1e-12)
        cost = np.zeros(i.size)
        for a, ax, aa in moments:
            sy, sxy, syy = a[j] - a[i], ax[j] - ax[i], aa[j] - aa[i]
            cross = sxy - sx * sy / count
            cost += np.maximum(syy - sy * sy / count - np.where(count > 1, cross * cross / spread, 0.0), 0.0)
        total = best[i] + cost + PRICE
        least = int(np.argmin(total))
        best[j], before[j] = total[least], i[least]
    pieces, j = [], n
    while j > 0:
        pieces.append((int(before[j]), j - 1))
        j = int(before[j])
    return pieces[::-1]


def _plateaus(distance: Array, records: Array, noise: Array, pieces: list[tuple[float, float]]) -> list[Plateau]:
    """The level ones of the pieces; equal neighbours are one."""
    enough = np.maximum(5.0 * noise, (LEAST_CURVATURE, LEAST_CANT))
    plateaus: list[Plateau] = []
    hand = 0.0
    for start, end in pieces:
        inside = (distance >= start) & (distance <= end)
        x, rows = distance[inside], records[:, inside]
        slope = np.array([np.polyfit(x, r, 1)[0] if x.size > 2 else 0.0 for r in rows])
        change = slope[0] * (end - start)
        if abs(change) > enough[0]:
            # two ramps that turn round without an arc between them meet in one of no length
            if hand * change < 0.0:
                nearest = int(np.argmin(np.abs(distance - start)))
                plateaus.append(Plateau(start, start, *records[:, nearest].tolist()))
            hand = change
            continue
        hand = 0.0
        level = np.median(rows, axis=1)
        now = Plateau(start, end, *level.tolist())
        if plateaus and np.all(np.abs(level - (plateaus[-1].curvature, plateaus[-1].cant)) < enough):
            last = plateaus[-1]
            share = (last.end - last.start) / max(end - last.start - (start - last.end), 1e-9)
            mixed = share * np.array((last.curvature, last.cant)) + (1.0 - share) * level
            plateaus[-1] = Plateau(last.start, end, *mixed.tolist())
        elif plateaus and abs(level[0] - plateaus[-1].curvature) < enough[0]:
            plateaus[-1] = replace(plateaus[-1], end=end)  # cant alone changes: no transition of the line
        else:
            plateaus.append(now)
    whole = float(distance[-1])
    if not plateaus or plateaus[0].start > 2.0 * NODE:
        plateaus.insert(0, Plateau(0.0, 0.0, *records[:, 0].tolist()))
    if plateaus[-1].end < whole - 2.0 * NODE:
        plateaus.append(Plateau(whole, whole, *records[:, -1].tolist()))
    return [replace(p, curvature=0.0, cant=0.0) if p.is_straight else p for p in plateaus]


def _refined(
    plateaus: list[Plateau], distance: Array, records: Array, noise: Array, forms: Sequence[Form]
) -> list[Plateau]:
    """The same with the ends of transitions and the values beside them fitted by least squares."""
    windows = [
        (max(0.5 * (p.start + p.end), p.end - REACH), min(0.5 * (q.start + q.end), q.start + REACH))
        for p, q in pairwise(plateaus)
    ]
    fits = [
        [_transition(p, q, distance, records, noise, window, form) for form in forms]
        for (p, q), window in zip(pairwise(plateaus), windows, strict=True)
    ]
    likeliest = _likeliest(np.array([[fit.off for fit in row] for row in fits]))
    chosen = [row[i] for row, i in zip(fits, likeliest, strict=True)]
    edges = [0.0]
    levels: list[list[tuple[Array, float]]] = [[] for _ in plateaus]
    for i, (fit, (low, high)) in enumerate(zip(chosen, windows, strict=True)):
        begin = min(max(fit.begin, edges[-1] + SHORTEST), distance[-1] - 2.0 * SHORTEST)
        end = min(max(begin + fit.length, begin + SHORTEST), distance[-1] - SHORTEST)
        levels[i].append((fit.before, begin - low))
        levels[i + 1].append((fit.behind, high - end))
        edges += [begin, end]
    edges.append(float(distance[-1]))
    taken: list[Form] = ["clothoid", *(fit.form for fit in chosen)]
    done = []
    for p, start, end, row, form in zip(plateaus, edges[::2], edges[1::2], levels, taken, strict=True):
        weight = np.array([max(w, 1.0) for _, w in row])
        curvature, cant = (weight @ np.array([v for v, _ in row])) / weight.sum()
        level = (0.0, 0.0) if p.is_straight else (float(curvature), float(cant))
        done.append(Plateau(start, end, *level, form))
    return done


def _likeliest(off: Array) -> list[int]:
    """The forms of all transitions with the least sum of ``off`` (transitions, forms) and prices of changes."""
    count = off.shape[1]
    change = CHANGE * (1.0 - np.eye(count))
    total, before = off[0], []
    for costs in off[1:]:
        paths = total + change
        before.append(paths.argmin(axis=1))
        total = costs + paths.min(axis=1)
    chosen = [int(total.argmin())]
    for step in reversed(before):
        chosen.append(int(step[chosen[-1]]))
    return chosen[::-1]


class _Fit(NamedTuple):
    """A transition: start and length [m], values (curvature, cant) before and behind it, sum of squared residuals."""

    form: Form
    begin: float
    length: float
    before: Array
    behind: Array
    off: float


def _transition(
    p: Plateau, q: Plateau, distance: Array, records: Array, noise: Array, window: tuple[float, float], form: Form
) -> _Fit:
    """The transition of a form between two plateaus that comes nearest to the records in a window [m]."""
    inside = (distance >= window[0]) & (distance <= window[1])
    s, rows = distance[inside], records[:, inside] / noise[:, None]
    held = np.array([0.0 if plateau.is_straight else 1.0 for plateau in (p, q)])
    ends = np.array([(t.curvature, t.cant) for t in (p, q)])
    length = max(q.start - p.end, SHORTEST)
    if s.size < 8:
        return _Fit(form, p.end, length, ends[0], ends[1], np.inf)

    def fitted(x: Array) -> tuple[Array, Array]:
        """For a start and a length: the values (2, 2) before and behind that come nearest, and what they leave over."""
        part = _part(s - x[0], x[1], form)
        shares = np.stack([1.0 - part, part]) * held[:, None]
        levels = np.linalg.lstsq(shares.T, rows.T)[0]
        return levels, np.asarray((levels.T @ shares - rows).ravel())

    low = np.array([window[0] - SMOOTHING, SHORTEST])
    high = np.array([window[1] + SMOOTHING, max(window[1] - window[0], SHORTEST) + SHORTEST])
    start = np.clip([p.end, length], low + 1e-6, high - 1e-6)
    best = least_squares(lambda x: fitted(x)[1], start, bounds=(low, high))
    before, behind = fitted(best.x)[0] * noise
    return _Fit(form, float(best.x[0]), float(best.x[1]), before, behind, float(best.cost))


HERMITE = np.polynomial.hermite_e.hermegauss(12)  # places and weights of a mean over a Gaussian


def _part(x: Array, length: float, form: Form) -> Array:
    """Share of a transition from 0 to its length [m] at x, smoothed by the Gaussian."""
    if form == "bloss":
        places, weights = HERMITE
        u = np.clip((x[:, None] + SMOOTHING * places) / length, 0.0, 1.0)
        return np.asarray(u * u * (3.0 - 2.0 * u) @ weights / weights.sum())

    def ramp(x: Array) -> Array:
        z = x / SMOOTHING
        return np.asarray(x * ndtr(z) + SMOOTHING * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi))

    return np.asarray((ramp(x) - ramp(x - length)) / length)
