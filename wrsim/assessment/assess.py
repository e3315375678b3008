"""From results to their assessment: filtered signals, their values section by section, limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.assessment.estimates import zones_of
from wrsim.assessment.limits import Limit
from wrsim.assessment.nadal import Climbing
from wrsim.assessment.outcome import AssessedSection, Assessment, Value
from wrsim.assessment.rules import HistorySection, RulesFile, rule_set
from wrsim.assessment.sections import STRAIGHT, TRANSITION, counts, sections_of
from wrsim.assessment.settings import AssessmentSection, AssessmentSettings
from wrsim.assessment.signals import AssessedPoint, AxleSignals, BogieSignals, Forces, assessed_points, quasi_static
from wrsim.assessment.track_quality import track_quality
from wrsim.errors import InputError
from wrsim.inputs.lookup import shipped_models
from wrsim.results import Result
from wrsim.results.filters import on_raster, sampling_rate
from wrsim.results.summary import events
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets
from wrsim.scenario.loading import load_text

NEEDED = ("distance", "Y", "Q")


def assess_runs(
    results: Result | Sequence[Result],
    settings: AssessmentSettings | None = None,
    names: Sequence[str] = (),
    rules: str | Path | RulesFile | None = None,
) -> Assessment:
    """Assess a run, or several runs of one vehicle as one test, by a rule set.

    results: each works that has the channels distance, Y and Q on both wheels; other channels add their quantities.
    Sections of several runs count together: in the worst value, the estimated maximum and the mean radius of a class.
    settings: by default those of [assessment] in the scenario that the results carry. names: of the runs, where there
    are several; by default their numbers. rules: a rule set, its name or its file; by default that of the settings.
    Raises InputError for a result that is no run, or that the filters cannot work on, and for runs that are not of one
    vehicle or not to be assessed alike.
    """
    several = [results] if isinstance(results, Result) else list(results)
    if not several:
        raise InputError("there is no run to assess")
    labels = list(names) or [str(i) for i in range(1, len(several) + 1)]
    settings = settings or _common_settings(several, labels)
    rule_file = rules if isinstance(rules, RulesFile) else rule_set(settings.rules if rules is None else rules)
    if rule_file.history is None:
        raise InputError(f"{rule_file.title}: has no clause about runs")
    runs = _filtered_runs(several, labels, settings, rule_file, rule_file.history)
    _check_alike(runs)
    axles = list(zip(*(run.axles for run in runs), strict=True))
    if settings.axle_load is None:
        _average_loads(axles)
    sections = tuple(s for run in runs for s in run.sections)
    values, radii = [v for run in runs for v in run.values()], _mean_radii(sections)
    for each in axles:
        values += quasi_static([(axle, run.sections) for axle, run in zip(each, runs, strict=True)], radii, rule_file)
    order = [clause.quantity for clause in rule_file.clauses]
    values.sort(key=lambda v: order.index(v.quantity.key))
    notes = [f"run {run.name}: {note}" if run.name else note for run in runs for note in run.notes]
    if settings.axle_load is None:
        notes.append("static loads: the mean of Q over the run; [assessment] axle_load_kN sets them")
    known: dict[str, float | str] = {"rules": rule_file.title, "vehicle_kind": settings.kind}
    known |= {f"axle_load{f'_{a.name}' if a.name else ''}_kN": a.load / 1e3 for a in runs[0].axles}
    return Assessment(
        title=_title(several),
        sections=sections,
        values=tuple(values),
        zones=tuple(zones_of(values, settings, rule_file.statistics)),
        notes=tuple(notes),
        settings=known | dict(pair for run in runs for pair in run.known()),
        signals={run.name: _signals(run.axles, rule_file.history) for run in runs},
        rules=rule_file,
        track=tuple(t for run in runs for t in run.track),
        estimate_over=settings.estimate_over,
        lone=all("body" not in run.dataset.dims and len(run.axles) == 1 for run in runs),
    )


def _common_settings(results: Sequence[Result], labels: Sequence[str]) -> AssessmentSettings:
    """[assessment] of the scenarios of all runs. Raises InputError where they differ."""
    settings = [_settings_of(result.dataset) for result in results]
    for label, run_settings in zip(labels, settings, strict=True):
        if run_settings != settings[0]:
            raise InputError(
                f"the runs {labels[0]} and {label} have different [assessment] in their scenarios; "
                "name one for all of them (--scenario)"
            )
    return settings[0]


def _filtered_runs(
    results: Sequence[Result], labels: Sequence[str], settings: AssessmentSettings, rules: RulesFile,
    history: HistorySection,
) -> list[_Run]:  # fmt: skip
    """The runs, with sections that are numbered through. Raises InputError that names the run, if of several."""
    runs: list[_Run] = []
    for label, result in zip(labels, results, strict=True):
        try:
            before = sum(len(run.sections) for run in runs)
            runs.append(_Run(result, settings, rules, history, label if len(results) > 1 else "", before))
        except InputError as problem:
            raise (InputError(f"run {label}: {problem}") if len(results) > 1 else problem) from None
    return runs


def _average_loads(axles: Sequence[Sequence[AxleSignals]]) -> None:
    """Give every axle the mean of its load over all runs, which have the same vehicle."""
    for each in axles:
        load = float(np.average([axle.load for axle in each], weights=[axle.distance.size for axle in each]))
        for axle in each:
            axle.load = load


class _Run:
    """A run and what its filters leave of it.

    name: empty for the only one; notes: what is missing, events; sections are numbered on from those of other runs.
    """

    def __init__(
        self,
        result: Result,
        settings: AssessmentSettings,
        rules: RulesFile,
        history: HistorySection,
        name: str,
        before: int,
    ) -> None:
        """before: how many sections other runs have."""
        self.name, self.settings, self.rules = name, settings, rules
        self.dataset = dataset = _checked(result, history)
        self.notes: list[str] = []
        deficiency = settings.straight_deficiency
        if deficiency is None and rules.straight_deficiency_mm is not None:
            deficiency = 1e-3 * rules.straight_deficiency_mm
        tested = (0.0, inf) if rules.statistics is None else rules.statistics.tested
        self.sections = [
            replace(s, number=before + s.number, run=name, counts=counts(s, settings.admissible_deficiency, tested))
            for s in sections_of(dataset, rules.classes, settings.section_length, deficiency)
        ]
        labels = numbered(wheelsets(dataset))
        named = labels if len(labels) > 1 else dict.fromkeys(labels, "")
        self.axles = [
            AxleSignals(axle if label else "", label, of_wheelset(dataset, axle), settings, rules)
            for axle, label in named.items()
        ]
        self.bogies = self._bogies() if rules.judging("bogie") else []
        self.climbing = Climbing(dataset, settings)
        climbs = [c for c in rules.clauses if c.quantity in ("Y_over_Q_nadal", "climb_distance")]
        if any(self.climbing.nadal(c.friction) is None for c in climbs):
            self.notes.append(f"Nadal: the result does not hold the {self.climbing.missing()}; [assessment] sets it")
        if (message := self.climbing.out_of_range()) and rules.about("climb_share"):
            self.notes.append(message)
        unstable = rules.about("instability")
        if unstable and not any(axle.hunting and axle.hunting.rms.size for axle in self.axles):
            self.notes.append(f"instability: the run is shorter than the window of {unstable.window_m:g} m")
        self.notes += [f"event at {place:.1f} m: {label}" for _, place, label in events(dataset)]
        self.track = track_quality(dataset, self.sections, self.notes)
        self.points = list(assessed_points(dataset, settings, rules))

    def _bogies(self) -> list[BogieSignals]:
        """The bogies, by the bodies that hold the wheelsets; a note where the result does not have them."""
        if "wheelset_bogie" not in self.dataset:
            self.notes.append("sides of bogies: the result does not hold which bogie holds a wheelset")
            return []
        groups: dict[str, list[AxleSignals]] = {}
        for axle, holder in zip(self.axles, np.atleast_1d(self.dataset["wheelset_bogie"].values), strict=True):
            groups.setdefault(str(holder), []).append(axle)
        return [BogieSignals(name, axles) for name, axles in groups.items() if name]

    def values(self) -> Iterator[Value]:
        """All but the quasi-static values, which go by classes."""
        for axle in self.axles:
            for section in self.sections:
                yield from axle.values(section, self.settings, self.rules, self.climbing)
        for bogie in self.bogies:
            for section in self.sections:
                yield from bogie.values(section, self.settings, self.rules)
        for point in self.points:
            for section in self.sections:
                yield from point.values(section, self.settings)
        yield from stop_values(self.dataset, self.sections, self.rules)

    def known(self) -> Iterator[tuple[str, float]]:
        """Numbers of this run that the assessment rests on."""
        ahead = f"run_{self.name}_" if self.name else ""
        parts: list[AxleSignals | AssessedPoint] = [*self.axles, *(point for point in self.points if point.is_frame)]
        for part in parts:
            if part.hunting is not None:
                yield f"{ahead}instability_frequency{f'_{part.name}' if part.name else ''}_Hz", part.hunting.frequency
        if (clause := self.rules.about("Y_over_Q_nadal")) and (nadal := self.climbing.nadal(clause.friction)):
            yield f"{ahead}nadal_limit", nadal[0]


def _checked(result: Result, history: HistorySection) -> xr.Dataset:
    """The dataset of a run that can be assessed. Raises InputError for any other."""
    dataset = result.dataset
    if "time" not in dataset.dims:
        raise InputError(f'a result of analysis = "{result.analysis}" has no history; only runs can be assessed')
    missing = [channel for channel in NEEDED if channel not in dataset.variables]
    if missing or dataset.sizes.get("wheel", 0) < 2:
        raise InputError(f"the result cannot be assessed: it has no {missing[0] if missing else 'second wheel'}")
    dataset = on_raster(dataset)
    sampling_rate(dataset["time"].values)  # enough of them, evenly spaced
    if np.any(np.diff(dataset["distance"].values) <= 0.0):
        raise InputError("the result cannot be assessed: the vehicle does not move forward all the time")
    passed = float(np.ptp(dataset["distance"].values))
    if passed < history.window_m:
        raise InputError(f"the run is {passed:.2f} m long; sliding means are taken over {history.window_m:g} m")
    return dataset


def _check_alike(runs: Sequence[_Run]) -> None:
    """Raises InputError for runs whose wheelsets or points are not the same."""
    for run in runs[1:]:
        for kind in ("axles", "points"):
            names, first = ([part.name for part in getattr(each, kind)] for each in (run, runs[0]))
            if names != first:
                raise InputError(
                    f"the runs {runs[0].name} and {run.name} are not of one vehicle: the first has the "
                    f"{kind.replace('axles', 'wheelsets')} {', '.join(first) or 'none'}, the other "
                    f"{', '.join(names) or 'none'}"
                )


def _title(results: Sequence[Result]) -> str:
    titles = list(dict.fromkeys(result.title for result in results))
    if len(results) == 1:
        return titles[0]
    return f"{len(results)} runs: {'; '.join(titles[:3])}{' and others' if len(titles) > 3 else ''}"


def _settings_of(dataset: xr.Dataset) -> AssessmentSettings:
    """[assessment] of the scenario that the result carries; the defaults where it has none."""
    try:
        text = str(dataset.attrs.get("scenario_text", ""))
        return load_text(text, shipped_models(), closed=True).table(AssessmentSection).settings()
    except InputError:  # a result without a scenario, or of an older wrsim
        return AssessmentSettings()


def _mean_radii(sections: Sequence[AssessedSection]) -> Mapping[str, float]:
    """Mean radius of the sections of every class of curves [m], of those that count where some do."""
    radii: dict[str, float] = {}
    for zone in dict.fromkeys(s.zone for s in sections if s.zone not in (STRAIGHT, TRANSITION)):
        members = [s for s in sections if s.zone == zone]
        radii[zone] = float(np.mean([abs(s.radius) for s in members if s.counts] or [abs(s.radius) for s in members]))
    return radii


def _signals(axles: Sequence[AxleSignals], shown: HistorySection) -> xr.Dataset:
    """Forces as they are shown, against distance: dimensions wheelset, place [m], wheel; not-a-number where none is."""
    signals: dict[str, Callable[[Forces, float | None], NDArray[np.float64]]] = {
        "sum_Y": Forces.sum_y,
        "Y_over_Q": Forces.quotient,
        "Y": lambda axle, low_pass: axle.forces(low_pass)[0],
        "Q": lambda axle, low_pass: axle.forces(low_pass)[1],
    }
    of_axles: dict[str, list[tuple[NDArray[np.float64], NDArray[np.float64]]]] = {}
    for name, signal in signals.items():
        raw = [(a.distance, signal(a, shown.low_pass_Hz)) for a in axles]
        if name in ("sum_Y", "Y_over_Q"):
            raw = [a.mean(values, shown.window_m, shown.step_m) for a, (_, values) in zip(axles, raw, strict=True)]
        of_axles[name] = raw
    first, last = (pick(middles[end] for middles, _ in of_axles["sum_Y"]) for pick, end in ((min, 0), (max, -1)))
    place = np.arange(first, last + 0.5 * shown.step_m, shown.step_m)

    def on_raster(distance: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
        columns = values.reshape(values.shape[0], -1).T
        rastered = [np.interp(place, distance, column, left=np.nan, right=np.nan) for column in columns]
        return np.stack(rastered, axis=-1).reshape(place.size, *values.shape[1:])

    dims = ("wheelset", "place", "wheel")
    stacked = {name: np.stack([on_raster(*each) for each in raw]) for name, raw in of_axles.items()}
    return xr.Dataset(
        {name: (dims[: values.ndim], values) for name, values in stacked.items()},
        coords={"place": place, "wheelset": [a.name for a in axles], "wheel": ["left", "right"]},
        attrs={"low_pass_Hz": shown.low_pass_Hz, "window_m": shown.window_m},
    )


def stop_values(dataset: xr.Dataset, sections: Sequence[AssessedSection], rules: RulesFile) -> Iterator[Value]:
    """Largest travel of every bump stop in every section, by the distance of the vehicle's reference body."""
    clause = rules.about("bump_stop")
    if clause is None or "suspension_stop_max" not in dataset:
        return
    for i, name in enumerate(dataset["suspension"].values):
        stop = dataset.isel(suspension=i)
        ends = [float(stop[f"suspension_stop_{end}"]) for end in ("min", "max")]
        if np.isnan(ends).any():
            continue
        # a stop works along one axis; its travel along the others is zero
        travel = np.sum([stop[f"suspension_d{axis}"].values for axis in "xyz"], axis=0)
        for section in sections:
            inside = section.holds(stop["distance"].values)
            if not inside.any():
                continue
            # travel to the other side of the design position is none; an end at infinity is never reached
            extremes = zip((travel[inside].min(), travel[inside].max()), ends, strict=True)
            used = [
                (t / end, abs(t), abs(end)) if t * end > 0.0 else (0.0, 0.0, abs(end))
                for t, end in extremes
                if end != 0.0 and np.isfinite(end)
            ]
            if used:
                _, value, end = max(used)
                limit = Limit(end, "vehicle file: end of the bump stop's table", "file")
                yield Value(clause.judged, section, "", "", float(value), limit, str(name))
