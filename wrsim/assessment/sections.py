"""Sections of track: stretches of one class, cut into pieces of about equal length.

Classes go by the radius of the curve, see rule sets.

UIC 518 counts curves with little cant deficiency (up to 40 mm [mem]) as straight track: where chosen, those of the
second class are.

A full curve shorter than a section is one section, marked as short. What changes its curvature is a transition, also
between two curves.
"""

from collections.abc import Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np
import xarray as xr

from wrsim.assessment.outcome import TRANSITION, Array, AssessedSection
from wrsim.assessment.rules import ClassSection
from wrsim.track.cant import CANT_BASE
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

STRAIGHT = "straight"

CHANGING = 1e-6  # change of curvature [1/m2] from which track counts as a transition: 1/R = 1/3000 m over 330 m
LEAST = 5.0  # stretches shorter than this [m] are joined to the one before
NEARLY = 0.01  # part of its length that may be missing from a section, for samples seldom lie at its ends
CLOSE = 1e-3  # places nearer than this [m] are one


def counts(section: AssessedSection, admissible: float | None, tested: tuple[float, float]) -> bool:
    """Whether a section counts in the statistics of its class.

    admissible: cant deficiency [m]; tested: that of full curves in a test, from and to, over the admissible one.
    """
    if admissible is None or section.zone in (STRAIGHT, TRANSITION):
        return True
    least, most = (factor * admissible for factor in tested)
    return least - CLOSE <= section.cant_deficiency <= most + CLOSE


def cant_deficiency(speed: Any, curvature: Any, cant: Any) -> Any:
    """Lateral acceleration over gravity times the base, less the cant [m], positive to the outside of the curve.

    speed [m/s], curvature [1/m], cant [m]: numbers or arrays.
    """
    return CANT_BASE * speed**2 * curvature / STANDARD_GRAVITY - cant


def zone_of(curvature: float, classes: Sequence[ClassSection]) -> str:
    """Class of a curve or of straight track; the limit belongs to the curves for straight track."""
    radius = 1.0 / max(abs(curvature), 1e-12)
    if radius > classes[0].from_radius_m:
        return classes[0].name
    reach = (each.from_radius_m - 1e-6 * each.from_radius_m for each in classes[1:])
    return next((c.name for c, least in zip(classes[1:], reach, strict=True) if radius >= least), classes[0].name)


def section_length(zone: str, speed: float, classes: Sequence[ClassSection]) -> float:
    """Length of sections of a class [m] at a speed [m/s]; infinite for transitions."""
    if zone == TRANSITION:
        return np.inf
    lengths = next(each.lengths for each in classes if each.name == zone)
    return next((length for most, length in lengths if 3.6 * speed - 1e-6 <= most), lengths[-1][1])


def sections_of(
    dataset: xr.Dataset,
    classes: Sequence[ClassSection],
    length: float | None = None,
    straight_deficiency: float | None = None,
) -> tuple[AssessedSection, ...]:
    """Sections of the track that a run has passed; length [m]: of sections of every class, instead of theirs;
    straight_deficiency [m]: cant deficiency up to which curves of the second class are straight track, none if not
    given.
    """
    distance, curvature, cant, speed = _track_passed(dataset)
    missing = cant_deficiency(speed, curvature, cant)
    sections: list[AssessedSection] = []
    for zone, first, last in _stretches(distance, curvature, missing, classes, straight_deficiency):
        inside = slice(first, last + 1)
        start, end = float(distance[first]), float(distance[last])
        mean_speed = float(speed[inside].mean())
        wanted = length if length is not None and zone != TRANSITION else section_length(zone, mean_speed, classes)
        pieces = max(1, int((end - start) / wanted + NEARLY))
        edges = np.linspace(start, end, pieces + 1)
        for a, b in pairwise(edges):
            part = slice(*np.searchsorted(distance, [a, b]))
            sampled = part.stop > part.start
            bends = curvature[part] if sampled else curvature[first : first + 1]
            bend = float(bends[np.argmax(np.abs(bends))] if zone == TRANSITION else bends.mean())
            hand = np.sign(bend) if abs(bend) > 1e-9 else 1.0
            radius = np.inf if zone == STRAIGHT and abs(bend) < 1e-6 else 1.0 / bend
            own_speed = float(speed[part].mean()) if sampled else mean_speed
            deficiency = float(hand * missing[part].mean()) if sampled else 0.0
            short = zone != TRANSITION and bool(b - a < wanted * (1.0 - NEARLY))
            section = AssessedSection(len(sections) + 1, zone, float(a), float(b), radius, own_speed, deficiency, short)
            sections.append(section)
    return tuple(sections)


def _track_passed(dataset: xr.Dataset) -> tuple[Array, Array, Array, Array]:
    """Distance, curvature, cant and speed against distance, of all the track that any wheelset has passed."""
    passed = dataset["wheelset_distance"]
    distance = passed.values
    speed = np.gradient(dataset["distance"].values, dataset["time"].values)
    if "speed" in dataset:
        speed = dataset["speed"].values
    speed = np.broadcast_to(speed.reshape(-1, *(1,) * (distance.ndim - 1)), distance.shape)
    curvature, cant = (
        dataset[name].transpose(*passed.dims).values if name in dataset else np.zeros(distance.shape)
        for name in ("curvature", "cant")
    )
    flat = distance.ravel()
    order = np.argsort(flat, kind="stable")
    order = order[np.concatenate(([True], np.diff(flat[order]) > CLOSE))]
    return flat[order], curvature.ravel()[order], cant.ravel()[order], speed.ravel()[order]


def _stretches(
    distance: Array,
    curvature: Array,
    missing: Array,
    classes: Sequence[ClassSection],
    straight_deficiency: float | None,
) -> list[tuple[str, int, int]]:
    """Class, first and last sample of every stretch of one class."""
    slope = np.abs(np.diff(curvature)) / np.maximum(np.diff(distance), 1e-9)
    names = [
        TRANSITION if s > CHANGING else zone_of(0.5 * (a + b), classes)
        for s, a, b in zip(slope, curvature[:-1], curvature[1:], strict=True)
    ]
    if straight_deficiency is not None and len(classes) > 1:
        little = np.abs(missing) <= straight_deficiency
        names = [STRAIGHT if n == classes[1].name and small else n for n, small in zip(names, little[1:], strict=True)]
    joined: list[tuple[str, int, int]] = []
    for name, group in groupby(range(len(names)), key=names.__getitem__):
        first = joined[-1][2] if joined else 0
        last = first + len(list(group))
        if joined and (distance[last] - distance[first] < LEAST or joined[-1][0] == name):
            joined[-1] = (joined[-1][0], joined[-1][1], last)
        else:
            joined.append((name, first, last))
    return joined
