"""Sections of track: stretches of one class, cut into pieces of about equal length.

Classes, by the radius of the curve (the test zones of EN 14363 [mem]; below 250 m the standard stops, CEN/TS 17843
calls it zone 5 [pub]):

============  ==================  ================================================
class         radius              length of a section [mem]
============  ==================  ================================================
straight      above 2500 m        250 m, above 220 km/h 500 m
large radius  600 to 2500 m       100 m up to 140 km/h, 200 m up to 220, then 500 m
small radius  400 to 600 m        100 m
very small    250 to 400 m        70 m
tight         below 250 m         70 m
transition    changing            as long as it is
============  ==================  ================================================

UIC 518 counts curves with little cant deficiency (up to 40 mm [mem]) as straight track: where chosen, those of large
radius are.

A full curve shorter than that is one section, marked as short. What changes its curvature is a transition, also
between two curves.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby, pairwise

import numpy as np
import xarray as xr

from wrsim.results.assessment import TRANSITION, Array, AssessedSection
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

STRAIGHT = "straight"
LARGE = "large radius"
CLASSES: dict[str, tuple[float, Mapping[float, float]]] = {
    STRAIGHT: (2500.0, {220.0: 250.0, np.inf: 500.0}),
    LARGE: (600.0, {140.0: 100.0, 220.0: 200.0, np.inf: 500.0}),
    "small radius": (400.0, {np.inf: 100.0}),
    "very small radius": (250.0, {np.inf: 70.0}),
    "tight": (0.0, {np.inf: 70.0}),
}
"""The radius [m] down to which each class reaches (the limit belongs to the class of smaller radii for straight track
and of larger radii else), and the length of its sections [m] up to speeds [km/h]."""

CHANGING = 1e-6  # change of curvature [1/m2] from which track counts as a transition: 1/R = 1/3000 m over 330 m
LEAST = 5.0  # stretches shorter than this [m] are joined to the one before
NEARLY = 0.01  # part of its length that may be missing from a section, for samples seldom lie at its ends
CLOSE = 1e-3  # places nearer than this [m] are one
CANT_BASE = 1.5  # distance over which cant, cant deficiency and twist are counted, whatever the gauge [m]


TESTED = (0.75, 1.10)  # cant deficiency of full curves that count in a test, over the admissible one (UIC 518 [mem])


def counts(section: AssessedSection, admissible: float | None) -> bool:
    """Whether a section counts in the statistics of its class; admissible: cant deficiency [m]."""
    if admissible is None or section.zone in (STRAIGHT, TRANSITION):
        return True
    least, most = (factor * admissible for factor in TESTED)
    return least - CLOSE <= section.cant_deficiency <= most + CLOSE


def zone_of(curvature: float) -> str:
    """Class of a curve or of straight track."""
    radius = 1.0 / max(abs(curvature), 1e-12)
    if radius > CLASSES[STRAIGHT][0]:
        return STRAIGHT
    return next(n for n, (least, _) in CLASSES.items() if n != STRAIGHT and radius >= least - 1e-6 * least)


def section_length(zone: str, speed: float) -> float:
    """Length of sections of a class [m] at a speed [m/s]; infinite for transitions."""
    lengths = {np.inf: np.inf} if zone == TRANSITION else CLASSES[zone][1]
    return next(length for most, length in lengths.items() if 3.6 * speed - 1e-6 <= most)


def sections_of(
    dataset: xr.Dataset, length: float | None = None, straight_deficiency: float | None = None
) -> tuple[AssessedSection, ...]:
    """Sections of the track that a run has passed; length [m]: of sections of every class, instead of the above;
    straight_deficiency [m]: cant deficiency up to which curves of large radius are straight track, none if not given.
    """
    distance, curvature, cant, speed = _track_passed(dataset)
    # positive to the outside of the curve, as a cant: lateral acceleration over gravity times the base
    missing = CANT_BASE * speed**2 * curvature / STANDARD_GRAVITY - cant
    found: list[AssessedSection] = []
    for zone, first, last in _stretches(distance, curvature, missing, straight_deficiency):
        inside = slice(first, last + 1)
        start, end = float(distance[first]), float(distance[last])
        mean_speed = float(speed[inside].mean())
        wanted = length if length is not None and zone != TRANSITION else section_length(zone, mean_speed)
        pieces = max(1, int((end - start) / wanted + NEARLY))
        edges = np.linspace(start, end, pieces + 1)
        for a, b in pairwise(edges):
            part = slice(*np.searchsorted(distance, [a, b]))
            sampled = part.stop > part.start
            own = curvature[part] if sampled else curvature[first : first + 1]
            bend = float(own[np.argmax(np.abs(own))] if zone == TRANSITION else own.mean())
            hand = np.sign(bend) if abs(bend) > 1e-9 else 1.0
            radius = np.inf if zone == STRAIGHT and abs(bend) < 1e-6 else 1.0 / bend
            own_speed = float(speed[part].mean()) if sampled else mean_speed
            deficiency = float(hand * missing[part].mean()) if sampled else 0.0
            short = zone != TRANSITION and bool(b - a < wanted * (1.0 - NEARLY))
            section = AssessedSection(len(found) + 1, zone, float(a), float(b), radius, own_speed, deficiency, short)
            found.append(section)
    return tuple(found)


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
    distance: Array, curvature: Array, missing: Array, straight_deficiency: float | None
) -> list[tuple[str, int, int]]:
    """Class, first and last sample of every stretch of one class."""
    slope = np.abs(np.diff(curvature)) / np.maximum(np.diff(distance), 1e-9)
    names = [
        TRANSITION if s > CHANGING else zone_of(0.5 * (a + b))
        for s, a, b in zip(slope, curvature[:-1], curvature[1:], strict=True)
    ]
    if straight_deficiency is not None:
        little = np.abs(missing) <= straight_deficiency
        names = [STRAIGHT if n == LARGE and small else n for n, small in zip(names, little[1:], strict=True)]
    joined: list[tuple[str, int, int]] = []
    for name, group in groupby(range(len(names)), key=names.__getitem__):
        first = joined[-1][2] if joined else 0
        last = first + len(list(group))
        if joined and (distance[last] - distance[first] < LEAST or joined[-1][0] == name):
            joined[-1] = (joined[-1][0], joined[-1][1], last)
        else:
            joined.append((name, first, last))
    return joined
