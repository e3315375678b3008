"""Tracks from separate lists of plan, cant of the rails and vertical profile."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.rows import rows_of

from wrsim import Arc, InputError, Straight, Track, Transition
from wrsim.track.alignment import Cant, Plan, Profile, alignment_laws

table = rows_of(__file__)

PLAN = [
    Plan(100.0),
    Plan(80.0, 0.0, 1 / 300, "sine"),
    Plan(120.0, 1 / 300, 1 / 300),
    Plan(90.0, 1 / 300, -1 / 500, "helmert"),
    Plan(60.0, -1 / 500, -1 / 500),
]
CANT = [
    Cant(0.0, 90.0, (0.0, 0.0), (0.0, 0.0)),
    Cant(90.0, 90.0, (0.0, 0.0), (0.0, 0.1), "bloss"),
    Cant(180.0, 130.0, (0.0, 0.1), (0.0, 0.1)),
    Cant(310.0, 80.0, (0.0, 0.1), (0.05, 0.0)),
    Cant(390.0, 60.0, (0.05, 0.0), (0.05, 0.0)),
]
PROFILE = [
    Profile(-50.0, 130.0, 0.005, 0.005),
    Profile(80.0, 100.0, 0.005, -0.02, "circle"),
    Profile(180.0, 150.0, -0.02, -0.02),
    Profile(330.0, 90.0, -0.02, 0.01),
    Profile(420.0, 100.0, 0.01, 0.01),
]
END = 450.0


def track_of(plan: Any = PLAN, cant: Any = (), profile: Any = (), **options: Any) -> Track:
    law, segments = alignment_laws(plan, cant, profile)
    return Track.from_laws(law, segments=segments, **options)


def over_plan(track: Track, x: np.ndarray) -> np.ndarray:
    """Distances along the centre line of places of the plan [m]: inverse of the quadrature of cos(slope)."""
    s = x.copy()
    for _ in range(20):
        place = np.array([_quadrature(lambda u: np.cos(track.centre_line.pitch_law(u)), track, b) for b in s])
        s += x - place
    return s


def _quadrature(function: Any, track: Track, end: float) -> float:
    node, weight = np.polynomial.legendre.leggauss(12)
    breaks = track.centre_line.pitch_law.breaks
    edges = np.append(breaks[breaks < end], end)
    half = 0.5 * np.diff(edges)
    return float(half @ (function(edges[:-1, None] + half[:, None] * (1.0 + node)) @ weight))


def test_the_plan_does_not_depend_on_profile_and_cant() -> None:
    x = np.linspace(0.0, END, 16)
    level, steep = track_of(), track_of(cant=CANT, profile=PROFILE)
    assert steep.length > level.length + 0.03
    s = over_plan(steep, x)
    assert np.abs(steep.centre_line.position(s)[:, :2] - level.centre_line.position(x)[:, :2]).max() < 1e-10


def test_heights_follow_grades_arcs_and_parabolas() -> None:
    x = np.array([0.0, 60.0, 95.0, 130.0, 170.0, 250.0, 340.0, 380.0, 419.0, 440.0])
    track = track_of(profile=PROFILE, start=(0.0, 0.0, 7.0))
    first, last = np.sin(np.arctan(0.005)), np.sin(np.arctan(-0.02))
    radius = 100.0 / (last - first)
    centre = 0.4 + radius * np.cos(np.arcsin(first))  # height of the circle's centre; it begins at 80 m with 0.4 m
    arc = centre - radius * np.sqrt(1.0 - (first + (x - 80.0) / radius) ** 2)
    low = centre - radius * np.sqrt(1.0 - last**2)
    falls = low - 0.02 * (x - 180.0)
    bowl = low - 3.0 - 0.02 * (x - 330.0) + 0.5 * 0.03 / 90.0 * (x - 330.0) ** 2
    end = low - 3.0 - 0.005 * 90.0 + 0.01 * (x - 420.0)
    exact = np.select([x < 80.0, x < 180.0, x < 330.0, x < 420.0], [0.005 * x, arc, falls, bowl], end)
    assert np.abs(track.centre_line.position(over_plan(track, x))[:, 2] - 7.0 - exact).max() < 1e-10


def test_each_rail_lies_as_high_as_its_list_says() -> None:
    x = np.array([0.0, 50.0, 120.0, 150.0, 200.0, 308.0, 335.0, 350.0, 370.0, 420.0])  # 1 m and more from the kinks
    level, canted = track_of(), track_of(cant=CANT)
    s = over_plan(canted, x)
    share = (x - 90.0) / 90.0
    ramp = 0.1 * (3.0 - 2.0 * share) * share**2
    right = np.select([x < 90.0, x < 180.0, x < 310.0, x < 390.0], [0 * x, ramp, 0.1 + 0 * x, 0.1 * (390.0 - x) / 80.0])
    left = np.select([x < 310.0, x < 390.0], [0 * x, 0.05 * (x - 310.0) / 80.0], 0.05)
    middle = canted.centre_line.position(s)[:, 2]
    assert np.abs(canted.cant(s) - (right - left)).max() < 1e-10
    assert np.abs(middle - 0.5 * canted.cant(s) - left).max() < 1e-10
    assert np.abs(middle + 0.5 * canted.cant(s) - right).max() < 1e-10
    assert np.abs(level.centre_line.position(x)[:, 2]).max() == 0.0


def test_a_level_alignment_is_the_track_of_its_segments() -> None:
    row = [
        Straight(40.0),
        Transition(60.0, "bloss"),
        Arc(80.0, -400.0, 0.08),
        Transition(50.0, "cosine"),
        Straight(30.0),
    ]
    plan = [
        Plan(40.0), Plan(60.0, 0.0, -1 / 400, "bloss"), Plan(80.0, -1 / 400, -1 / 400),
        Plan(50.0, -1 / 400, 0.0, "cosine"), Plan(30.0),
    ]  # fmt: skip
    half = (0.04, -0.04)  # the left rail is the outer one
    cant = [
        Cant(0.0, 40.0, (0.0, 0.0), (0.0, 0.0)), Cant(40.0, 60.0, (0.0, 0.0), half, "bloss"),
        Cant(100.0, 80.0, half, half), Cant(180.0, 50.0, half, (0.0, 0.0), "cosine"),
        Cant(230.0, 30.0, (0.0, 0.0), (0.0, 0.0)),
    ]  # fmt: skip
    from_segments, from_lists = Track.build(row), track_of(plan, cant)
    s = np.linspace(0.0, 260.0, 131)
    assert np.abs(from_segments.curvature(s) - from_lists.curvature(s)).max() < 1e-15
    assert np.abs(from_segments.cant(s) - from_lists.cant(s)).max() < 1e-15
    assert [f.label for f in from_segments.features()] == [f.label for f in from_lists.features()]
    assert from_segments.segments == tuple(row)  # no length is summed and parted again


def test_a_viennese_bend_takes_the_cant_of_the_other_list() -> None:
    plan = [Plan(100.0, 0.0, 1 / 300, "viennese", 1.8), Plan(50.0, 1 / 300, 1 / 300)]
    cant = [
        Cant(0.0, 100.0, (0.0, 0.0), (-0.05, 0.05), "viennese"),
        Cant(100.0, 50.0, (-0.05, 0.05), (-0.05, 0.05)),
    ]
    from_segments = Track.build([Transition(100.0, "viennese", centre_of_gravity_height=1.8), Arc(50.0, 300.0, 0.1)])
    s = np.linspace(0.0, 150.0, 101)
    assert np.abs(from_segments.curvature(s) - track_of(plan, cant).curvature(s)).max() < 1e-15
    with pytest.raises(InputError, match=r"plan\[0\]: centre_of_gravity_height_m is missing"):
        track_of([replace(plan[0], centre_of_gravity_height=None), plan[1]], cant)


@pytest.mark.parametrize(("list_name", "number", "change", "message"), table("wrong_elements_are_refused"))
def test_wrong_elements_are_refused(list_name: str, number: int, change: dict[str, Any], message: str) -> None:
    lists: dict[str, list[Any]] = {"plan": list(PLAN), "cant": list(CANT), "profile": list(PROFILE)}
    lists[list_name][number] = replace(lists[list_name][number], **change)
    with pytest.raises(InputError, match=message):
        alignment_laws(**lists)
    with pytest.raises(InputError, match="plan of the alignment is empty"):
        alignment_laws([])
