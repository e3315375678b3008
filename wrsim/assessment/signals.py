"""Filtered signals of a run and their values section by section: of wheelsets, sides of bogies, points.

Ride characteristics are of points on car bodies, instability also of bogie frames; sections of points go by the
distance of the vehicle's reference body.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy
import xarray as xr
from numpy.typing import NDArray

from wrsim.assessment.limits import Limit, LimitContext
from wrsim.assessment.nadal import Climbing, longest_stretch
from wrsim.assessment.outcome import Array, AssessedSection, Value
from wrsim.assessment.rules import ClauseSection, RulesFile
from wrsim.assessment.sections import STRAIGHT, TRANSITION
from wrsim.assessment.settings import AssessmentSettings
from wrsim.errors import InputError
from wrsim.inputs.section import given
from wrsim.results import filters
from wrsim.results.channels import BOGIE_FRAME, CAR_BODY

SIDES = (("left", 0), ("right", 1))
BAND = (1.5, 10.0)  # in which the frequency of an instability lies [Hz]
LOWEST = 0.4  # least lower edge of its band [Hz]
FULL_CURVES = ("Y_qst", "Y_qst_reduced", "Q_qst", "B_qst")
"""What the outer wheel bears."""


def about(section: AssessedSection, settings: AssessmentSettings, axle_load: float = 0.0) -> LimitContext:
    """What limits in a section depend on; axle_load [N]."""
    return LimitContext(settings.kind, axle_load, section.zone, abs(section.radius), section.speed)


class Hunting:
    """A lateral signal of a running gear about the frequency f0 of an instability (EN 14363, 7.5.3).

    frequency: f0 [Hz], that of the highest peak of the power spectrum in ``BAND`` unless given; middles (k,) of the
    windows [m], rms (k,) over them of the signal in the band of the clause about f0.
    """

    def __init__(
        self, distance: Array, signal: Array, rate: float, frequency: float | None, clause: ClauseSection
    ) -> None:
        """rate: samples a second."""
        half, window, step = given(clause.half_band_Hz), given(clause.window_m), given(clause.step_m)
        self.frequency = frequency or _highest_peak(signal, rate)
        narrow = filters.band_pass(signal, rate, max(self.frequency - half, LOWEST), self.frequency + half)
        self.middles = filters.windows(distance, window, step)
        self.rms = filters.sliding_rms(distance, narrow, self.middles, window)

    def largest(self, section: AssessedSection) -> float | None:
        """Largest rms in a section; None without a window there."""
        inside = section.holds(self.middles)
        return float(self.rms[inside].max()) if inside.any() else None


def _highest_peak(signal: Array, rate: float) -> float:
    """Its frequency in the power spectrum, in ``BAND`` [Hz]."""
    length = min(signal.size, max(256, int(4.0 * rate)))
    frequencies, power = scipy.signal.welch(signal, rate, nperseg=length, detrend="linear")
    inside = (frequencies >= BAND[0]) & (frequencies <= BAND[1])
    return float(frequencies[inside][np.argmax(power[inside])]) if inside.any() else 0.5 * sum(BAND)


def hunting(
    clause: ClauseSection | None, distance: Array, signal: Array, rate: float, settings: AssessmentSettings
) -> Hunting | None:
    """A lateral signal about the frequency of an instability, where there is a clause about it."""
    if clause is None:
        return None
    return Hunting(distance, signal, rate, settings.instability_frequency, clause)


class Forces:
    """Forces of wheels over distance, filtered once for every low-pass, and what slides over them.

    distance (n,) [m]; load: static one of a wheelset [N].
    """

    def __init__(self, distance: Array, rate: float, y: Array, q: Array, load: float) -> None:
        """y, q: unfiltered forces (n, 2) [N]; rate: samples a second."""
        self.distance, self.rate, self.load = distance, rate, load
        self._raw, self._filtered = (y, q), dict[float, tuple[Array, Array]]()
        self._slid: dict[str, tuple[Array, Array]] = {}

    def forces(self, low_pass: float | None) -> tuple[Array, Array]:
        """Y and Q (n, 2) below a frequency [Hz], or unfiltered."""
        if low_pass is None:
            return self._raw
        if low_pass not in self._filtered:
            y, q = (filters.low_pass(values, self.rate, low_pass) for values in self._raw)
            self._filtered[low_pass] = y, q
        return self._filtered[low_pass]

    def quotient(self, low_pass: float | None) -> Array:
        """Y/Q (n, 2); beyond any limit where a wheel is pushed outward without load, 0 where it is without either."""
        y, q = self.forces(low_pass)
        free = q <= 0.0
        return np.where(free, np.where(y > 1e3, np.inf, 0.0), y / np.where(free, 1.0, q))

    def sum_y(self, low_pass: float | None) -> Array:
        """Left minus right Y (n,)."""
        y, _ = self.forces(low_pass)
        return np.asarray(y[:, 0] - y[:, 1])

    def mean(self, signal: Array, window: float, step: float) -> tuple[Array, Array]:
        """Middles of windows [m] and the mean of a signal over them; infinite where the signal is."""
        middles = filters.windows(self.distance, window, step)
        endless = ~np.isfinite(signal)
        means, touched = (
            filters.sliding_mean(self.distance, part, middles, window)
            for part in (np.where(endless, 0.0, signal), endless.astype(float))
        )
        return middles, np.where(touched > 1e-12, np.inf, means)

    def statistic(self, clause: ClauseSection, section: AssessedSection, signal: Callable[[], Array]) -> Array | None:
        """The percentile of a signal (n, ...) in a section as the clause has it; None without a window there.

        Windows of a mean lie in the section; where a value has to be held, their middles do.
        """
        window, step, lowest = clause.window_m, clause.step_m, clause.judged.lowest
        if clause.id not in self._slid:
            places, values = self.distance, signal()
            if window is not None and clause.over == "mean":
                places, values = self.mean(values, window, given(step))
            elif window is not None:
                places = filters.windows(self.distance, window, given(step))
                values = filters.sliding_held(self.distance, values, places, window, lowest)
            self._slid[clause.id] = places, values
        places, values = self._slid[clause.id]
        half = 0.0 if window is None or clause.over == "held" else 0.5 * window - 1e-6
        inside = (places - half >= section.start) & (places + half <= section.end)
        return filters.percentiles(values[inside], given(clause.percentile)) if inside.any() else None


SIGNALS: dict[str, Callable[[Forces, float | None], Array]] = {
    "sum_Y": Forces.sum_y,
    "sum_Y_qst": Forces.sum_y,
    "Y": lambda axle, low_pass: axle.forces(low_pass)[0],
    "Y_over_Q": Forces.quotient,
    "Y_over_Q_qst": Forces.quotient,
    "Y_over_Q_nadal": Forces.quotient,
    "sum_Y_share": lambda axle, low_pass: np.abs(axle.sum_y(low_pass)) / axle.load,
    "Q_share": lambda axle, low_pass: axle.forces(low_pass)[1] / (0.5 * axle.load),
    "Q": lambda axle, low_pass: axle.forces(low_pass)[1],
    "side_Q_share": lambda axle, low_pass: axle.forces(low_pass)[1] / axle.load,
    "side_Y_over_Q": Forces.quotient,
}
"""Signals (n,) of a wheelset or (n, 2) of wheels, of which percentiles are judged."""


class AxleSignals(Forces):
    """Signals of one wheelset. label: name with its number from the front, for tables; load: of both wheels [N]."""

    def __init__(
        self, name: str, label: str, dataset: xr.Dataset, settings: AssessmentSettings, rules: RulesFile
    ) -> None:
        def of_wheels(channel: str) -> Array:
            return np.asarray(dataset[channel].transpose("time", "wheel").sel(wheel=["left", "right"]).values)

        y, q = of_wheels("Y"), of_wheels("Q")
        if not (np.isfinite(y).all() and np.isfinite(q).all()):
            raise InputError("the result cannot be assessed: some of its wheel forces are not numbers")
        load = settings.axle_load if settings.axle_load is not None else float(q.sum(axis=1).mean())
        super().__init__(dataset["distance"].values, filters.sampling_rate(dataset["time"].values), y, q, load)
        self.name, self.label = name, label
        self.hunting = hunting(rules.about("instability"), self.distance, self.sum_y(None), self.rate, settings)
        self.wear = of_wheels("T_gamma") if "T_gamma" in dataset else None
        self.attack, self.shift = (dataset[n].values if n in dataset else None for n in ("yaw", "lateral_shift"))

    def values(
        self, section: AssessedSection, settings: AssessmentSettings, rules: RulesFile, climbing: Climbing
    ) -> Iterator[Value]:
        """Everything in one section but the quasi-static values of full curves."""
        inside = section.holds(self.distance)
        if inside.sum() < 2:
            return
        context = about(section, settings, self.load)
        for clause in rules.judging("axle"):
            nadal = climbing.nadal(clause.friction)
            result = self._found(clause, section, inside, None if nadal is None else nadal[0], climbing)
            if result is None:
                continue
            limit = clause.limit_at(replace(context, nadal=nadal))
            if np.ndim(result) == 0:
                yield self.value(clause, section, float(result), limit)
            for wheel, side in SIDES if np.ndim(result) else ():
                yield self.value(clause, section, np.asarray(result)[side], limit, wheel)

    def _found(
        self,
        clause: ClauseSection,
        section: AssessedSection,
        inside: NDArray[np.bool_],
        nadal: float | None,
        climbing: Climbing,
    ) -> Array | float | None:
        """What a clause judges in a section, of the wheelset or of both wheels (2,); None where there is nothing.

        inside: the samples that lie in it (n,); nadal: Nadal's limit.
        """
        key, low_pass = clause.quantity, clause.low_pass_Hz
        if key in SIGNALS and (key != "Y_over_Q_nadal" or nadal is not None):
            return self.statistic(clause, section, lambda: SIGNALS[key](self, low_pass))
        if key in ("climb_distance", "climb_share") and nadal is not None:
            above = self.quotient(low_pass)[inside] - nadal
            way = self.distance[inside]
            if key == "climb_distance":
                return np.array([longest_stretch(way, above[:, side]) for _, side in SIDES])
            parts = []
            for side, sign in enumerate((1.0, -1.0)):  # the left flange attacks where the wheelset yaws to the left
                needed = None if self.attack is None else climbing.distance(sign * self.attack[inside])
                if needed is None:
                    return None
                share = scipy.integrate.cumulative_trapezoid(1.0 / needed, way, initial=0.0)
                parts.append(longest_stretch(share, above[:, side]))
            return np.array(parts)
        if key == "instability" and self.hunting is not None:
            return self.hunting.largest(section)
        if key == "unloading":
            q = self.forces(low_pass)[1][inside]
            return 1.0 - filters.percentiles(q, given(clause.percentile)) / (0.5 * self.load)
        if key == "T_gamma" and self.wear is not None:
            return np.array([self.wear[inside, side].mean() for _, side in SIDES])
        if key == "T_gamma_max" and (wear := self.wear) is not None:
            return self.statistic(clause, section, lambda: wear)
        if key == "angle_of_attack" and self.attack is not None:
            return abs(float(np.median(self.attack[inside])))
        if key == "lateral_shift" and self.shift is not None:
            return filters.percentiles(self.shift[inside], given(clause.percentile))
        return None

    def value(
        self, clause: ClauseSection, section: AssessedSection, value: float, limit: Limit | None, wheel: str = ""
    ) -> Value:
        """One value of this wheelset, or of a wheel of it."""
        return Value(clause.judged, section, self.name, wheel, float(value), limit, label=self.label)


class BogieSignals(Forces):
    """Forces of both sides of a bogie: sums over its wheels. name: of its frame; load: mean of its wheelsets' [N]."""

    def __init__(self, name: str, axles: Sequence[AxleSignals]) -> None:
        self.name, self.axles = name, axles
        y, q = (sum(axle.forces(None)[i] for axle in axles) for i in (0, 1))
        distance = np.mean([axle.distance for axle in axles], axis=0)
        super().__init__(distance, axles[0].rate, np.asarray(y), np.asarray(q), axles[0].load)

    def values(self, section: AssessedSection, settings: AssessmentSettings, rules: RulesFile) -> Iterator[Value]:
        """Everything in one section."""
        self.load = float(np.mean([axle.load for axle in self.axles]))
        context = about(section, settings, self.load)
        for clause in rules.judging("bogie"):
            signal = SIGNALS[clause.quantity]
            result = self.statistic(clause, section, lambda: signal(self, clause.low_pass_Hz))  # noqa: B023
            if result is None:
                continue
            for wheel, side in SIDES:
                yield Value(clause.judged, section, "", wheel, result[side], clause.limit_at(context), self.name)


def quasi_static(
    runs: Sequence[tuple[AxleSignals, Sequence[AssessedSection]]], radii: Mapping[str, float], rules: RulesFile
) -> Iterator[Value]:
    """What the outer wheel bears in the full curves of each class.

    runs: a wheelset in every run, with the sections of that; radii: the mean one of each class [m].
    """
    clauses = [clause for key in FULL_CURVES if (clause := rules.about(key)) is not None]
    less = rules.about("Y_qst_reduced")
    for zone, radius in radii.items():
        context = LimitContext(zone=zone, radius=radius)
        members = [
            (axle, section, inside, 1 if section.radius > 0.0 else 0)
            for axle, sections in runs
            for section in sections
            if section.zone == zone and (inside := section.holds(axle.distance)).sum() >= 2
        ]
        lean, reduced = [0.0] * len(members), False  # Y/Q of the inner wheel
        if members and less is not None and less.limit_at(context) is not None:
            quotients = ((axle.quotient(less.low_pass_Hz), inside, outer) for axle, _, inside, outer in members)
            lean = [float(np.median(quotient[inside, 1 - outer])) for quotient, inside, outer in quotients]
            reduced = float(np.mean(lean)) > given(less.lean)
        for (axle, section, inside, outer), inner in zip(members, lean, strict=True):
            for clause in clauses:
                key = clause.quantity
                if key == "Y_qst_reduced" and not reduced:
                    continue
                y, q = (float(np.median(force[inside, outer])) for force in axle.forces(clause.low_pass_Hz))
                evaluated = {"Y_qst": y, "Q_qst": q}.get(key, 0.0)
                if key == "Y_qst_reduced":
                    evaluated = y - 1e3 * given(clause.lean_force_kN) * (inner - given(clause.lean))
                elif key == "B_qst":
                    evaluated = abs(y) + given(clause.part) * q
                limit = None if key == "Y_qst" and reduced else clause.limit_at(context)
                yield axle.value(clause, section, evaluated, limit, SIDES[outer][0])


class AssessedPoint:
    """Accelerations [m/s2] of one point on a car body or a bogie frame."""

    def __init__(self, data: xr.Dataset, level: str, settings: AssessmentSettings, rules: RulesFile) -> None:
        """one: what a result has of the point; level: ``CAR_BODY`` or ``BOGIE_FRAME``."""
        self.name, self.is_frame = str(data["point"].item()), level == BOGIE_FRAME
        self.bogie_mass = float(data["point_bogie_mass"]) if "point_bogie_mass" in data else np.nan
        self.distance, self.rate = data["distance"].values, filters.sampling_rate(data["time"].values)
        self.signals = {"ay": data["point_ay"].values, "az": data["point_az"].values}
        clause = rules.about("frame_instability")
        self.hunting = hunting(clause, self.distance, self.signals["ay"], self.rate, settings)
        self.clauses = rules.judging("frame" if self.is_frame else "body")
        self._filtered = {clause.id: self._signal(clause) for clause in self.clauses}

    def _signal(self, clause: ClauseSection) -> Array:
        """What a clause looks at (n,): a filtered acceleration."""
        signal = self.signals["az" if clause.quantity.startswith("body_az") else "ay"]
        if clause.least_rate_Hz is not None and self.rate < clause.least_rate_Hz * (1.0 - 1e-6):
            raise InputError(
                f"{clause.id}: needs {clause.least_rate_Hz:g} samples a second; the result has {self.rate:.4g}: "
                f"run it with output_interval_ms = {1e3 / clause.least_rate_Hz:g} or less"
            )
        if clause.band_Hz is not None:
            signal = filters.band_pass(signal, self.rate, *clause.band_Hz)
            if clause.window_s is not None:
                return filters.moving_deviation(signal, round(clause.window_s * self.rate))
            return signal
        return signal if clause.low_pass_Hz is None else filters.low_pass(signal, self.rate, clause.low_pass_Hz)

    def values(self, section: AssessedSection, settings: AssessmentSettings) -> Iterator[Value]:
        """Everything in one section."""
        inside = section.holds(self.distance)
        context = replace(about(section, settings), bogie_mass=self.bogie_mass)
        for clause in self.clauses:
            key, signal = clause.quantity, self._filtered[clause.id][inside]
            result: float | None = None
            if key == "frame_instability" and self.hunting is not None:
                result = self.hunting.largest(section)
            elif inside.sum() < 2:
                continue
            elif key in ("body_ay", "body_az"):
                result = float(filters.percentiles(signal, given(clause.percentile)))
            elif key == "frame_hunting":
                result = float(np.nanmax(signal)) if np.isfinite(signal).any() else None
            elif key in ("body_ay_rms", "body_az_rms"):
                result = float(np.sqrt((signal**2).mean()))
            elif section.zone not in (STRAIGHT, TRANSITION):
                result = abs(float(np.median(signal)))
            if result is not None:
                yield Value(clause.judged, section, "", "", result, clause.limit_at(context), self.name)


def assessed_points(dataset: xr.Dataset, settings: AssessmentSettings, rules: RulesFile) -> Iterator[AssessedPoint]:
    """Points on car bodies and bogie frames with their accelerations; none where the result has none."""
    if "point_ay" not in dataset or "point_az" not in dataset:
        return
    for i in range(dataset.sizes["point"]):
        data = dataset.isel(point=i)
        level = str(data["point_level"].item()) if "point_level" in data else CAR_BODY
        if level in (CAR_BODY, BOGIE_FRAME):
            yield AssessedPoint(data, level, settings, rules)
