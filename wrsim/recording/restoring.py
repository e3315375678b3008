"""From a recording to the track: its design, and where each rail lies beside it.

The share of the design in a record is taken off before the record is inverted: the versine of a curve, the ramps of
cant under one rail's level. Alignment of many cars is free of the curve already; the record itself shows whether it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import binary_erosion, gaussian_filter1d

from wrsim.errors import InputError
from wrsim.recording.columns import ChannelSection
from wrsim.recording.design import FORMS, LEAST_CURVATURE, SMOOTHING, Form, Plateau, fit_design
from wrsim.recording.dropouts import runs
from wrsim.recording.reading import TrackRecording
from wrsim.recording.systems import SKIRTS, Chord, Complex, InverseFilter, Plain, ShapeSystem, filtered
from wrsim.track.cant import cant_angle, cant_base
from wrsim.track.piecewise import Array
from wrsim.track.segments import LONGEST, Arc, Laws, Segment, Straight, Transition, laws, lift_of
from wrsim.track.track import ROUNDING

SIDES = {"_left": 1.0, "_right": -1.0}
LEAST_WIDENING = 1.5e-3  # mean gauge of an arc beyond the nominal one that counts as designed [m]
LARGEST_SPREAD = 0.15  # largest standard deviation of a curve's share in a record of alignment that decides
UNDECIDED = (0.3, 0.7)  # shares that decide nothing


@dataclass(frozen=True, eq=False)
class Restored:
    """A recorded track.

    plateaus: straights and arcs; segments, law: the design as laid; lateral, vertical: of the left and right rail
    beside it, to the left and up, (2, n) [m]; inverses: filters of the records; notes: for the user.
    """

    recording: TrackRecording
    plateaus: tuple[Plateau, ...]
    segments: tuple[Segment, ...]
    law: Laws
    lateral: Array
    vertical: Array
    inverses: tuple[tuple[ChannelSection, InverseFilter], ...]
    notes: tuple[str, ...]

    @property
    def longest(self) -> float:
        """Longest finite wavelength of the inverted records [m]: so far their ends reach inward."""
        bands = [i.kept() for _, i in self.inverses if np.isfinite(i.band[1])]
        return max((float(kept[-1, 1]) for kept in bands if len(kept)), default=0.0)


def restore(
    recording: TrackRecording, band: tuple[float, float], amplification: float, forms: Sequence[Form] = FORMS
) -> Restored:
    """Design and irregularities; band: wavelengths of these [m]; amplification: see `InverseFilter`;
    forms: of transitions that may be.

    Raises InputError for a band that the rows do not resolve, a recording shorter than two of the longest waves, and
    opposite signs of alignment and curvature.
    """
    step, s = recording.step, recording.distance
    if band[0] < 4.0 * step:
        rows = f"rows {step:g} m apart resolve no waves shorter than {4.0 * step:g} m"
        raise InputError(f"{recording.path}: {rows}; the shortest wanted is {band[0]:g} m (--wavelength-m)")
    if recording.length < 2.0 * band[1]:
        waves = f"two of the longest waves wanted, {band[1]:g} m each (--wavelength-m), or more"
        raise InputError(f"{recording.path}: is {recording.length:g} m long; must be {waves}")
    work = _Work(recording, band, amplification, [], [*recording.notes])
    gauge = recording.columns.gauge_mm / 1e3
    recorded = work.first("gauge")
    off_gauge = work.first("gauge_deviation") if recorded is None else recorded - gauge
    curvature, spread = work.curvature()
    recorded_cant = work.first("cant")
    cant = work.cant_of_twist(curvature) if recorded_cant is None else recorded_cant
    plateaus = fit_design(s, curvature, np.zeros(s.size) if cant is None else cant, spread, forms)
    segments = _segments(plateaus, s, off_gauge)
    if (longest := max(segment.length for segment in segments)) > LONGEST:
        message = f"a segment of {longest / 1e3:.4g} km follows from these rows; must be at most {LONGEST / 1e3:g} km"
        raise InputError(f"{recording.path}: {message}: check the unit of the distance, or cut it (--from-m, --to-m)")
    try:
        law = laws(segments, gauge, ROUNDING)
    except InputError as error:
        ends = f"{s[0]:g} to {s[-1]:g} m"
        raise InputError(f"{recording.path}: {ends}: no track's design follows from these rows: {error}") from None
    lift = lift_of(law.cant, recording.columns.pivot)
    design = _Design(law.curvature(s), law.cant(s), law.widening(s), np.zeros(s.size) if lift is None else lift(s))
    arcs = [p for p in plateaus if not p.is_straight and abs(p.cant) > 0.01]
    outward = sum(p.cant * p.curvature < 0.0 for p in arcs)
    if 2 * outward > len(arcs):
        curves = f"{outward} of {len(arcs)} curves"
        work.notes.append(f"the cant leans outward in {curves}: is the sign of curvature or cant another?")

    wide = None if off_gauge is None else work.undone_plain(off_gauge - design.widening, "gauge", "gauge_deviation")
    cross = None if recorded_cant is None else work.undone_plain(recorded_cant - design.cant, "cant")
    twist = recording.of("twist")
    if twist and recorded_cant is not None:
        cant = recorded_cant
        base = twist[0][0].base
        back = max(1, round(base / step))
        off = (cant[back:] - cant[:-back]) * base / (back * step) - twist[0][1][back:]
        work.notes.append(f"twist and the cant's own over {base:g} m differ by {1e3 * _rms(off):.3g} mm (rms)")
    elif twist:
        cross = work.undone(*twist[0], design.cant - law.cant(s - twist[0][0].base))
    lateral = _rails(work, "alignment", design, wide, (0.5, -0.5))
    vertical = _rails(work, "level", design, cross, (-0.5, 0.5))
    return Restored(recording, plateaus, segments, law, lateral, vertical, tuple(work.inverses), tuple(work.notes))


class _Design(NamedTuple):
    """Curvature [1/m], cant, widening and height of the centre line above the grade line [m] at the rows."""

    curvature: Array
    cant: Array
    widening: Array
    lift: Array


@dataclass(frozen=True)
class _Work:
    """Settings of the inversion, and its filters and notes so far."""

    recording: TrackRecording
    band: tuple[float, float]
    amplification: float
    inverses: list[tuple[ChannelSection, InverseFilter]]
    notes: list[str]

    def first(self, quantity: str) -> Array | None:
        """The record of a quantity that is measured as it is."""
        records = self.recording.of(quantity)
        return records[0][1] if records else None

    def curvature(self) -> tuple[Array, float]:
        """The recorded curvature, or that of the alignment's versines, and the deviation over which it was measured."""
        records = self.recording.of("curvature")
        if records:
            return records[0][1], records[0][0].base / np.sqrt(24.0)
        s = self.recording.distance
        for side in ("", "_left", "_right"):
            for channel, record in self.recording.of(f"alignment{side}"):
                if isinstance(channel.system, Chord):
                    a, b = channel.system.behind, channel.system.ahead
                    source = f"it is that of the versines in column '{channel.column}'"
                    self.notes.append(f"no curvature was recorded: {source}")
                    # of long waves the versine is that at (b - a) / 3 ahead
                    versine = np.interp(s - (b - a) / 3.0, s, record)
                    return -2.0 / (a * b) * versine, float(np.sqrt((a * a + a * b + b * b) / 18.0))
        self.notes.append("no curvature was recorded: the track is laid straight")
        return np.zeros(s.size), 0.0

    def cant_of_twist(self, curvature: Array) -> Array | None:
        """The cant that the twist over its base adds up to, level on straights; curvature: tells these [1/m].

        A base sees the mean slope of the cant over it, so that its value counts half a base behind.
        """
        if not (twist := self.recording.of("twist")):
            if np.abs(curvature).max() > LEAST_CURVATURE:
                self.notes.append("no cant was recorded, nor twist: the cant of the curves is unknown and laid as 0")
            return None
        channel, record = twist[0]
        s = self.recording.distance
        summed = cumulative_trapezoid(np.interp(s + 0.5 * channel.base, s, record) / channel.base, s, initial=0.0)
        smooth = gaussian_filter1d(curvature, SMOOTHING / self.recording.step, mode="nearest")
        straight = binary_erosion(
            np.abs(smooth) < LEAST_CURVATURE, iterations=round(3.0 * SMOOTHING / self.recording.step)
        )
        source = f"no cant was recorded: it is that of the twist in column '{channel.column}' over {channel.base:g} m"
        if not straight.any():
            self.notes.append(f"{source}, added up from a level start; no straight tells its error")
            return np.asarray(summed)
        drift = np.interp(s, s[straight], summed[straight])
        removed = 1e3 * float(np.ptp(drift))
        # a sum of n independent errors, held at both of its ends, has in its middle sqrt(n) / 2 of one of them
        curve = max((end - begin for begin, end in runs(~straight)), default=0)
        left = 1e3 * float(np.std(record[straight])) / channel.base * self.recording.step * np.sqrt(curve) / 2.0
        where = (
            f"a drift of {removed:.2g} mm is removed, by straights, where cant is 0; in curves some {left:.2g} mm stay"
        )
        self.notes.append(f"{source}, added up; {where} unknown")
        return np.asarray(summed - drift)

    def inner(self, record: Array) -> Array:
        """A record without its ends, into which the unknown beyond them reaches."""
        ends = min(int(SKIRTS[1] * self.band[1] / self.recording.step), record.size // 4)
        return record[ends : record.size - ends]

    def undone(self, channel: ChannelSection, record: Array, design: Array) -> Array:
        """The shape that a record is of; design: its share in the record."""
        inverse = InverseFilter(channel.system, self.band, self.amplification)
        return self._inverted(channel, inverse, record - design, SKIRTS[1] * self.band[1])

    def undone_plain(self, record: Array, *quantities: str) -> Array:
        """Gauge and cant: all waves but the shortest."""
        channel = next(c for c, _ in self.recording.records if c.quantity in quantities)
        inverse = InverseFilter(Plain(), (self.band[0], np.inf), self.amplification)
        return self._inverted(channel, inverse, record, 4.0 * self.band[0])

    def _inverted(self, channel: ChannelSection, inverse: InverseFilter, record: Array, longest: float) -> Array:
        self.inverses.append((channel, inverse))
        return filtered(record, self.recording.step, inverse.response, longest)


def _rails(work: _Work, kind: str, design: _Design, apart: Array | None, weights: tuple[float, float]) -> Array:
    """Left and right rail (2, n) from records of alignment or level; apart: gauge or cross-level, with its weights on
    the left and the right rail."""
    size = work.recording.distance.size
    shapes: dict[str, Array] = {}
    for side in ("", "_left", "_right"):
        parts = [
            work.undone(c, r, _left_by_design(work, c, system, r, design))
            for c, r in work.recording.of(f"{kind}{side}")
            if (system := c.shape_system) is not None
        ]
        if parts:
            shapes[side] = np.sum(parts, axis=0)
    if not shapes:
        work.notes.append(f"no {kind} was recorded: the rails' mean is taken as even")
    left, right = shapes.get("_left"), shapes.get("_right")
    if left is not None and right is not None:
        mean, difference = 0.5 * (left + right), (left - right) / (weights[0] - weights[1])
        if apart is None:
            apart = difference
        else:
            rms = f"{1e3 * _rms(work.inner(difference - _in_band(work, kind, apart))):.3g} mm (rms)"
            taken = "gauge" if kind == "alignment" else "cant"
            differ = f"{kind} left less right and the {taken} differ by {rms} in their common band"
            work.notes.append(f"{differ}; the {taken} is taken")
    elif left is not None or right is not None:
        record, weight = (left, weights[0]) if left is not None else (right, weights[1])
        mean = np.zeros(size) if record is None else record
        if apart is None:
            work.notes.append(f"{kind} of one rail alone, and no distance of the rails: both are taken alike")
        else:
            mean = mean - weight * _in_band(work, kind, apart)
    else:
        mean = shapes.get("", np.zeros(size))
    apart = np.zeros(size) if apart is None else apart
    return np.stack([mean + weight * apart for weight in weights])


def _in_band(work: _Work, kind: str, record: Array) -> Array:
    """The share of a record that the systems of alignment or level measure and their inverses return."""
    inverses = {i.system: i for c, i in work.inverses if c.kind == kind}.values()

    def response(k: Array) -> Complex:
        return np.asarray(np.sum([i.response(k) * i.system.response(k) for i in inverses], axis=0))

    return filtered(record, work.recording.step, response, SKIRTS[1] * work.band[1])


def _left_by_design(work: _Work, channel: ChannelSection, system: ShapeSystem, record: Array, design: _Design) -> Array:
    """The share of the design in a record of alignment or level of this system."""
    reach, step = system.reach, work.recording.step
    side = next((sign for end, sign in SIDES.items() if channel.quantity.endswith(end)), 0.0)
    # systems measure in the plane of the rails and across it: cant turns a share of the curve upward
    columns = work.recording.columns
    roll = cant_angle(design.cant, cant_base(columns.gauge_mm, columns.cant_base_mm))
    if channel.kind == "level":
        up = filtered(design.curvature * np.sin(roll), step, system.of_curvature, reach, held=True)
        return up + filtered(design.lift - side * 0.5 * design.cant, step, system.response, reach, held=True)
    left = side * filtered(0.5 * design.widening, step, system.response, reach, held=True)
    curve = filtered(design.curvature * np.cos(roll), step, system.of_curvature, reach, held=True)
    if _holds_curve(work, channel, record - left, curve):
        left = left + curve
    return np.asarray(left)


def _holds_curve(work: _Work, channel: ChannelSection, record: Array, curve: Array) -> bool:
    """Whether a record of alignment holds the curve itself. Raises InputError where its sign is opposite."""
    if channel.with_curvature is not None:
        return channel.with_curvature
    size = float(curve @ curve)
    share = float(curve @ record) / size if size > 0.0 else 1.0
    # irregularities are alike over a quarter of the longest wave or so
    alike = 0.25 * work.band[1] / work.recording.step
    if size == 0.0 or _rms(record - share * curve) * np.sqrt(alike / size) > LARGEST_SPREAD:
        return True
    name, key = f"column '{channel.column}'", "give with_curvature = true or false in its [[channels]]"
    if share < -UNDECIDED[0]:
        key = "the sign of alignment, or that of curvature, is opposite (positive = ... in a column map)"
    if share < -UNDECIDED[0] or UNDECIDED[0] < share < UNDECIDED[1]:
        raise InputError(f"{work.recording.path}: {name} holds {share:.2f} of the versine of its curves: {key}")
    verdict = "holds the curves" if share > UNDECIDED[1] else "is freed of the curves"
    work.notes.append(f"{name} {verdict} ({share:.3g} of their versine)")
    return share > UNDECIDED[1]


def _segments(plateaus: tuple[Plateau, ...], s: Array, off_gauge: Array | None) -> tuple[Segment, ...]:
    segments: list[Segment] = []
    for i, p in enumerate(plateaus):
        if i:
            segments.append(Transition(p.start - plateaus[i - 1].end, p.form))
        if p.is_straight:
            segments.append(Straight(p.end - p.start))
            continue
        inside = (s >= p.start) & (s <= p.end)
        widening = 0.0 if off_gauge is None or not inside.any() else float(np.median(off_gauge[inside]))
        widening = widening if widening > LEAST_WIDENING else 0.0
        segments.append(Arc(p.end - p.start, 1.0 / p.curvature, float(p.cant * np.sign(p.curvature)), widening))
    return tuple(segments)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
