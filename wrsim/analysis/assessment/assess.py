"""From a result to its assessment: filtered signals, their values section by section, limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.analysis.assessment import limits
from wrsim.analysis.assessment import quantities as q
from wrsim.analysis.assessment.filters import low_pass, on_raster, sampling_rate, sliding_mean, windows
from wrsim.analysis.assessment.hunting import hunting_frequency, hunting_rms
from wrsim.analysis.assessment.nadal import limit_of, longest_stretch
from wrsim.analysis.assessment.points import points_of
from wrsim.analysis.assessment.sections import STRAIGHT, TRANSITION, sections_of
from wrsim.analysis.assessment.stops import stop_values
from wrsim.analysis.assessment.track_quality import track_quality
from wrsim.errors import InputError
from wrsim.results import Result
from wrsim.results.assessment import Assessment, Limit, Section, Value
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets
from wrsim.scenario.loading import load_text
from wrsim.scenario.sections.assessment import AssessmentSection, AssessmentSettings

Array = NDArray[np.float64]

NEEDED = ("distance", "Y", "Q")


def assess(result: Result, settings: AssessmentSettings | None = None) -> Assessment:
    """Assess a run by EN 14363 and what else is known of its wheels.

    settings: by default those of [assessment] in the scenario that the result carries. Works on any run with the
    channels distance, Y and Q on both wheels; other channels add their quantities.
    Raises InputError for a result that is no run, or that the filters cannot work on.
    """
    dataset, settings = result.dataset, settings or _settings_of(result.dataset)
    if "time" not in dataset.dims:
        raise InputError(f'a result of analysis = "{result.analysis}" has no history; only runs can be assessed')
    missing = [name for name in NEEDED if name not in dataset.variables]
    if missing or dataset.sizes.get("wheel", 0) < 2:
        raise InputError(f"the result cannot be assessed: it has no {missing[0] if missing else 'second wheel'}")
    dataset = on_raster(dataset)
    sampling_rate(dataset["time"].values)  # enough of them, evenly spaced
    if np.any(np.diff(dataset["distance"].values) <= 0.0):
        raise InputError("the result cannot be assessed: the vehicle does not move forward all the time")
    passed = float(np.ptp(dataset["distance"].values))
    if passed < q.WINDOW:
        raise InputError(f"the run is {passed:.2f} m long; sliding means are taken over {q.WINDOW:g} m")
    sections = sections_of(dataset, settings.section_length, settings.straight_deficiency)
    radii = _mean_radii(sections)
    notes: list[str] = []
    names = wheelsets(dataset)
    several, labels = len(names) > 1, numbered(names)
    axles = [
        _Axle.of(name if several else "", labels[name] if several else "", of_wheelset(dataset, name), settings)
        for name in names
    ]
    nadal = limit_of(dataset, settings, notes)
    if not any(axle.rms.size for axle in axles):
        notes.append(f"instability: the run is shorter than the window of {q.STABILITY_WINDOW:g} m")
    if settings.axle_load is None:
        notes.append("static loads: the mean of Q over the run; [assessment] axle_load_kN sets them")
    values: list[Value] = []
    for axle in axles:
        for section in sections:
            values += axle.values(section, settings, nadal)
        values += axle.quasi_static(sections, radii)
    points = points_of(dataset, settings)
    values += [v for point in points for section in sections for v in point.values(section, settings)]
    values += list(stop_values(dataset, sections))
    if "event_label" in dataset:
        places = zip(dataset["event_distance"].values, dataset["event_label"].values, strict=True)
        notes += [f"event at {place:.1f} m: {label}" for place, label in places]
    quality = track_quality(dataset, sections, notes)
    order = list(q.QUANTITIES)
    values.sort(key=lambda v: order.index(v.quantity.key))
    known: dict[str, float | str] = {"vehicle_kind": settings.kind}
    for axle in axles:
        name = f"_{axle.name}" if axle.name else ""
        known |= {f"axle_load{name}_kN": axle.load / 1e3, f"instability_frequency{name}_Hz": axle.frequency}
    known |= {f"instability_frequency_{p.name}_Hz": p.frequency for p in points if p.is_frame}
    if nadal is not None:
        known["nadal_limit"] = nadal.value
    return Assessment(
        result.title, sections, tuple(values), tuple(notes), known, _signals(axles), quality,
        settings.estimate_over, settings.estimate_at,
    )  # fmt: skip


def _settings_of(dataset: xr.Dataset) -> AssessmentSettings:
    """[assessment] of the scenario that the result carries; the defaults where that says nothing."""
    try:
        section = load_text(str(dataset.attrs.get("scenario_text", ""))).table(AssessmentSection)
    except InputError:  # a result without a scenario, or of an older wrsim
        return AssessmentSettings()
    return section.settings()


def _mean_radii(sections: Sequence[Section]) -> dict[str, float]:
    """Mean radius of the sections of every class of curves [m]."""
    curves = [s for s in sections if s.zone not in (STRAIGHT, TRANSITION)]
    return {
        zone: float(np.mean([abs(s.radius) for s in curves if s.zone == zone])) for zone in {s.zone for s in curves}
    }


def _quotient(y: Array, load: Array) -> Array:
    """Y/Q; beyond any limit where the wheel is pushed outward without load, 0 where it is without either."""
    free = load <= 0.0
    return np.where(free, np.where(y > 1e3, np.inf, 0.0), y / np.where(free, 1.0, load))


@dataclass(frozen=True, eq=False)
class _Axle:
    """Filtered signals of one wheelset: over its samples (n,), and over the middles of windows (m,), (k,)."""

    name: str
    label: str
    load: float
    frequency: float
    distance: Array
    y: Array
    q: Array
    quotient: Array
    middles: Array
    sum_y_mean: Array
    quotient_mean: Array
    stability_middles: Array
    rms: Array
    wear: Array | None
    wear_mean: Array | None
    attack: Array | None
    shift: Array | None

    @classmethod
    def of(cls, name: str, label: str, dataset: xr.Dataset, settings: AssessmentSettings) -> _Axle:
        """Filter the channels of one wheelset."""
        distance = dataset["distance"].values
        rate = sampling_rate(dataset["time"].values)

        def of_wheels(channel: str) -> Array:
            return np.asarray(dataset[channel].transpose("time", "wheel").sel(wheel=["left", "right"]).values)

        raw_y, raw_q = of_wheels("Y"), of_wheels("Q")
        if not (np.isfinite(raw_y).all() and np.isfinite(raw_q).all()):
            raise InputError("the result cannot be assessed: some of its wheel forces are not numbers")
        y, load = (low_pass(values, rate, q.CUT_OFF) for values in (raw_y, raw_q))
        quotient = _quotient(y, load)
        middles = windows(distance, q.WINDOW, q.STEP)
        raw_sum = raw_y[:, 0] - raw_y[:, 1]
        frequency = settings.instability_frequency or hunting_frequency(raw_sum, rate)
        stability, rms = hunting_rms(distance, raw_sum, rate, frequency)
        wear = of_wheels("T_gamma") if "T_gamma" in dataset else None
        return cls(
            name=name,
            label=label,
            load=settings.axle_load if settings.axle_load is not None else float(raw_q.sum(axis=1).mean()),
            frequency=frequency,
            distance=distance,
            y=y,
            q=load,
            quotient=quotient,
            middles=middles,
            sum_y_mean=sliding_mean(distance, y[:, 0] - y[:, 1], middles, q.WINDOW),
            quotient_mean=_mean_of_quotient(distance, quotient, middles),
            stability_middles=stability,
            rms=rms,
            wear=wear,
            wear_mean=None if wear is None else sliding_mean(distance, wear, middles, q.WINDOW),
            attack=dataset["yaw"].values if "yaw" in dataset else None,
            shift=dataset["lateral_shift"].values if "lateral_shift" in dataset else None,
        )

    def values(self, section: Section, settings: AssessmentSettings, nadal: Limit | None) -> Iterator[Value]:
        """Everything that can be said of one section."""
        inside = self._inside(section)
        if inside.sum() < 2:
            return
        yield from self._safety(section, inside, settings, nadal)
        yield from self._loading(section, inside)
        yield from self._information(section, inside)

    def _inside(self, section: Section) -> NDArray[np.bool_]:
        """Samples that lie in a section."""
        return np.asarray((self.distance >= section.start) & (self.distance <= section.end))

    def _within(self, section: Section) -> NDArray[np.bool_]:
        """Windows of 2 m that lie in a section."""
        half = 0.5 * q.WINDOW - 1e-6
        return (self.middles - half >= section.start) & (self.middles + half <= section.end)

    def _safety(
        self, section: Section, inside: NDArray[np.bool_], settings: AssessmentSettings, nadal: Limit | None
    ) -> Iterator[Value]:
        within = self._within(section)
        if within.any():
            sum_y = np.abs(np.percentile(self.sum_y_mean[within], [q.LOW, q.HIGH])).max()
            yield self._value("sum_Y", section, sum_y, limits.track_shift(self.load, settings.kind))
            for wheel, side in _SIDES:
                quotient = _high(self.quotient_mean[within, side])
                yield self._value("Y_over_Q", section, quotient, limits.derailment(section.radius), wheel)
                if nadal is not None:
                    yield self._value("Y_over_Q_nadal", section, quotient, nadal, wheel)
        if nadal is not None:
            for wheel, side in _SIDES:
                beyond = longest_stretch(self.distance[inside], self.quotient[inside, side] - nadal.value)
                yield self._value("climb_distance", section, beyond, limits.CLIMB_DISTANCE, wheel)
        middle = (self.stability_middles >= section.start) & (self.stability_middles <= section.end)
        if middle.any():
            limit = limits.instability(self.load, settings.kind)
            yield self._value("instability", section, self.rms[middle].max(), limit)

    def _loading(self, section: Section, inside: NDArray[np.bool_]) -> Iterator[Value]:
        for wheel, side in _SIDES:
            limit = limits.vertical_force(0.5 * self.load, section.speed)
            yield self._value("Q", section, np.percentile(self.q[inside, side], q.HIGH), limit, wheel)
            lowest = np.percentile(self.q[inside, side], q.LOW)
            yield self._value("unloading", section, 1.0 - lowest / (0.5 * self.load), None, wheel)

    def quasi_static(self, sections: Sequence[Section], radii: Mapping[str, float]) -> Iterator[Value]:
        """What the outer wheel bears in the full curves of each class; radii: the mean one of each class [m]."""
        for zone, radius in radii.items():
            own = [(s, inside) for s in sections if s.zone == zone and (inside := self._inside(s)).sum() >= 2]
            outer = [1 if s.radius > 0.0 else 0 for s, _ in own]
            lean = [
                float(np.median(self.quotient[inside, 1 - side])) for (_, inside), side in zip(own, outer, strict=True)
            ]
            limit = limits.quasi_static_guiding(radius)
            reduced = limit is not None and len(own) > 0 and float(np.mean(lean)) > q.LEAN
            for (section, inside), side, inner in zip(own, outer, lean, strict=True):
                wheel = _SIDES[side][0]
                y, load = np.median(self.y[inside, side]), np.median(self.q[inside, side])
                yield self._value("Y_qst", section, y, None if reduced else limit, wheel)
                if reduced:
                    yield self._value("Y_qst_reduced", section, y - q.LEAN_FORCE * (inner - q.LEAN), limit, wheel)
                yield self._value("Q_qst", section, load, limits.quasi_static_vertical(), wheel)
                yield self._value("B_qst", section, abs(y) + q.Q_SHARE * load, limits.combined(radius), wheel)

    def _information(self, section: Section, inside: NDArray[np.bool_]) -> Iterator[Value]:
        if self.wear is not None and self.wear_mean is not None:
            within = self._within(section)
            for wheel, side in _SIDES:
                yield self._value("T_gamma", section, self.wear[inside, side].mean(), None, wheel)
                if within.any():
                    largest = np.percentile(self.wear_mean[within, side], q.HIGH)
                    yield self._value("T_gamma_max", section, largest, None, wheel)
        if self.attack is not None:
            yield self._value("angle_of_attack", section, abs(np.median(self.attack[inside])), None)
        if self.shift is not None:
            shift = np.abs(np.percentile(self.shift[inside], [q.LOW, q.HIGH])).max()
            yield self._value("lateral_shift", section, shift, None)

    def _value(self, key: str, section: Section, value: float, limit: Limit | None, wheel: str = "") -> Value:
        return Value(q.QUANTITIES[key], section, self.name, wheel, float(value), limit, label=self.label)


_SIDES = (("left", 0), ("right", 1))


def _high(values: Array) -> float:
    """Percentile 99.85 %; infinite as soon as one value is."""
    return float(np.percentile(values, q.HIGH)) if np.isfinite(values).all() else np.inf


def _mean_of_quotient(distance: Array, quotient: Array, middles: Array) -> Array:
    """Sliding mean; infinite in windows in which the quotient is."""
    lifted = ~np.isfinite(quotient)
    mean = sliding_mean(distance, np.where(lifted, 0.0, quotient), middles, q.WINDOW)
    touched = sliding_mean(distance, lifted.astype(float), middles, q.WINDOW)
    return np.where(touched > 1e-12, np.inf, mean)


def _signals(axles: list[_Axle]) -> xr.Dataset:
    """What was evaluated, against distance: dimensions wheelset, place [m], wheel; not-a-number where none was."""
    first, last = min(a.middles[0] for a in axles), max(a.middles[-1] for a in axles)
    place = np.arange(first, last + 0.5 * q.STEP, q.STEP)

    def at(a: _Axle, of: Array, values: Array) -> Array:
        columns = values.reshape(values.shape[0], -1).T
        found = [np.interp(place, of, column, left=np.nan, right=np.nan) for column in columns]
        return np.stack(found, axis=-1).reshape(place.size, *values.shape[1:])

    dims = ("wheelset", "place", "wheel")
    return xr.Dataset(
        {
            "sum_Y": (dims[:2], np.stack([at(a, a.middles, a.sum_y_mean) for a in axles])),
            "Y_over_Q": (dims, np.stack([at(a, a.middles, a.quotient_mean) for a in axles])),
            "Y": (dims, np.stack([at(a, a.distance, a.y) for a in axles])),
            "Q": (dims, np.stack([at(a, a.distance, a.q) for a in axles])),
        },
        coords={"place": place, "wheelset": [a.name for a in axles], "wheel": ["left", "right"]},
    )
