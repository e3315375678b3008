"""Forms of transitions: curvature, cant and plan against published numbers, definitions and symmetries."""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from support.rows import rows_of

from wrsim import Arc, InputError, Straight, Track, Transition
from wrsim.track.forms import FORMS, Form

table = rows_of(__file__)

ENDS = [(math.inf, 300.0, 100.0), (-500.0, 300.0, 100.0), (math.inf, -25.0, 20.0), (300.0, 900.0, 60.0)]
DEFINITIONS = {
    "clothoid": lambda xi: xi,
    "bloss": lambda xi: (3.0 - 2.0 * xi) * xi**2,
    "cosine": lambda xi: 0.5 * (1.0 - np.cos(np.pi * xi)),
    "sine": lambda xi: xi - np.sin(2.0 * np.pi * xi) / (2.0 * np.pi),
    "helmert": lambda xi: np.where(xi < 0.5, 2.0 * xi**2, 1.0 - 2.0 * (1.0 - xi) ** 2),
    "viennese": lambda xi: xi**4 * (35.0 + xi * (-84.0 + xi * (70.0 - 20.0 * xi))),
}
"""IFC 4.3.2, IfcAlignmentHorizontalSegmentTypeEnum."""
ORDER = {"clothoid": 0, "bloss": 1, "cosine": 1, "sine": 2, "helmert": 1, "viennese": 3}
"""Highest derivative of the ramp that is zero at both ends."""


def alone(form: Form, start: float, end: float, length: float, **more: Any) -> Track:
    """A transition between two radii."""
    return Track.build([Transition(length, form, radius_start=start, radius_end=end, **more)])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_plan_holds_the_published_points_within_a_nanometre(side: float) -> None:
    for form, start, end, s, x, y in table("plan"):
        track = alone(form, side * start, side * end, 100.0)
        assert np.abs(track.centre_line.position(s) - [x, side * y, 0.0]).max() < 1e-9, (form, start, end, s)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_cant_holds_the_published_values_within_a_nanometre(side: float) -> None:
    for form, start, end, cant_start, cant_end, s, cant in table("cant"):
        ends = {"cant_start": cant_start, "cant_end": cant_end, "cant_form": form}
        track = alone("clothoid", side * start, side * end, 100.0, **ends)
        assert abs(track.cant(s) - side * cant) < 1e-9, (form, start, end, s)  # linear: 1 m and more from the kinks


@pytest.mark.parametrize(("start", "end", "length"), ENDS)
@pytest.mark.parametrize("form", DEFINITIONS)
def test_curvature_and_plan_follow_the_definition(form: Form, start: float, end: float, length: float) -> None:
    def curvature(s: Any) -> Any:
        return 1.0 / start + (1.0 / end - 1.0 / start) * DEFINITIONS[form](np.asarray(s) / length)

    track = alone(form, start, end, length)
    s = np.linspace(0.0, length, 41)
    assert np.abs(track.curvature(s) - curvature(s)).max() < 1e-13 / min(abs(start), abs(end))

    node, weight = np.polynomial.legendre.leggauss(24)
    edges = np.linspace(0.0, length, 9)  # 8 parts, one of them ends where Helmert's parabolas meet
    place, heading, half = np.zeros(2), 0.0, length / 16.0
    for a in edges[:-1]:
        u = a + half * (1.0 + node)
        # heading at each node: a quadrature of the curvature from the part's beginning
        turn = heading + np.array([0.5 * (v - a) * weight @ curvature(a + 0.5 * (v - a) * (1.0 + node)) for v in u])
        place += half * np.array((weight @ np.cos(turn), weight @ np.sin(turn)))
        heading += half * weight @ curvature(u)
    assert np.abs(track.centre_line.position(length)[:2] - place).max() < 1e-11
    assert track.heading(length) == pytest.approx(heading, abs=1e-13)


@pytest.mark.parametrize("form", FORMS)
def test_a_transition_passed_the_other_way_is_the_same_line(form: Form) -> None:
    for start, end, length in ENDS:
        forward = alone(form, start, end, length)
        back = alone(form, -end, -start, length)
        s = np.linspace(0.0, length, 11)
        points = forward.centre_line.position(s) - forward.centre_line.position(length)
        turn = math.pi - float(forward.heading(length))
        c, sn = math.cos(turn), math.sin(turn)
        turned = np.stack((c * points[:, 0] - sn * points[:, 1], sn * points[:, 0] + c * points[:, 1]), axis=1)
        assert np.abs(turned - back.centre_line.position(length - s)[:, :2]).max() < 1e-10


@pytest.mark.parametrize("form", ORDER)
def test_ramps_begin_and_end_with_as_many_zero_derivatives_as_their_form_has(form: Form) -> None:
    length, order = 80.0, ORDER[form]
    law = alone(form, math.inf, 400.0, length).centre_line.curvature_law
    step = 1e-3 * length
    first = law.pieces.derivative(order + 1)(np.array([0.0, length])) * 400.0 * length ** (order + 1)
    assert np.abs(first).min() > 0.99
    for n in range(1, order + 1):
        ends = law.pieces.derivative(n)(np.array([0.0, length])) * 400.0 * length**n
        assert np.abs(ends).max() < 1e-10
    # to the order of the form: the deviation from the end value grows with the power order + 1
    near, far = (abs(float(law(x))) for x in (step, 2.0 * step))
    assert math.log2(far / near) == pytest.approx(order + 1, abs=0.02)


@pytest.mark.parametrize("form", FORMS)
def test_a_flat_transition_has_the_offset_of_the_doubly_integrated_ramp(form: Form) -> None:
    length, radius = 50.0, 50_000.0
    ramp = DEFINITIONS.get(form, DEFINITIONS["clothoid"])
    # integral of (1 - xi) f; Helmert's ramp has two parts
    offset = sum(quad(lambda xi: (1.0 - xi) * float(ramp(xi)), *part)[0] for part in ((0.0, 0.5), (0.5, 1.0)))
    _, y, _ = alone(form, math.inf, radius, length).centre_line.position(length)
    assert y == pytest.approx(offset * length**2 / radius, rel=1e-6)  # of the order of the angle squared, 2.5e-7


def test_a_cubic_parabola_is_a_cubic_parabola() -> None:
    for radius, length in ((300.0, 100.0), (-60.0, 40.0)):
        x, y, _ = alone("cubic parabola", math.inf, radius, length).centre_line.position(np.linspace(0.0, length, 21)).T
        assert np.abs(y - x**3 / (6.0 * radius * length)).max() < 1e-12
    # an S: both branches touch the tangent of the inflection with y = a x^3
    track = alone("cubic parabola", -200.0, 300.0, 100.0)
    middle = track.centre_line.position(60.0)
    turn = float(track.heading(60.0))
    x, y, _ = (track.centre_line.position(np.linspace(0.0, 100.0, 21)) - middle).T
    along, across = math.cos(turn) * x + math.sin(turn) * y, math.cos(turn) * y - math.sin(turn) * x
    assert np.abs(across - along**3 / 6.0 / 100.0 * (1.0 / 300.0 + 1.0 / 200.0)).max() < 1e-12


def test_a_viennese_bend_leads_its_centre_of_gravity_along_the_ramp() -> None:
    length, height, base, cant = 100.0, 1.8, 1.5, 0.1
    bend = [Transition(length, "viennese", centre_of_gravity_height=height), Arc(50.0, 300.0, cant)]
    for side in (1.0, -1.0):
        row = [bend[0], replace(bend[1], radius=side * 300.0)]
        law = Track.build(row, cant_base=base).centre_line.curvature_law
        terms = law.pieces.c[::-1, 0] * length ** np.arange(8.0) * length
        # the coefficients of IFC 4.3.2's curvature formula: cf = -420 h psi / L, f = L / R
        f, cf = side * length / 300.0, side * -420.0 * height / length * cant / base
        assert np.abs(terms - [0, 0, cf, -4 * cf, 5 * cf + 35 * f, -2 * cf - 84 * f, 70 * f, -20 * f]).max() < 1e-12
    # the path of the point at the height, h c / c0 towards the inside, is curved as the ramp
    track = Track.build(bend, cant_base=base)
    s = np.linspace(0.0, length, 41)
    path = track.curvature(s) + height / base * track.left_curve.cant(s, 2)
    assert np.abs(path - DEFINITIONS["viennese"](s / length) / 300.0).max() < 1e-15


def test_two_transitions_meet_where_one_of_them_says() -> None:
    arc = Arc(60.0, 200.0, 0.1)
    first, second = Transition(40.0, radius_end=500.0, cant_end=0.05), Transition(30.0, "bloss")
    track = Track.build([Straight(20.0), first, second, arc])
    second_named = Track.build(
        [Straight(20.0), Transition(40.0), replace(second, radius_start=500.0, cant_start=0.05), arc]
    )
    s = np.linspace(0.0, track.length, 301)
    assert np.array_equal(track.curvature(s), second_named.curvature(s))
    assert np.array_equal(track.cant(s), second_named.cant(s))
    assert float(track.curvature(60.0)) == pytest.approx(1.0 / 500.0)
    assert float(track.cant(62.0)) == pytest.approx(0.05 + 0.05 * DEFINITIONS["bloss"](2.0 / 30.0))
    for row in ([first, replace(second, radius_start=500.0)], [replace(first, radius_end=None, cant_end=0.0), second]):
        with pytest.raises(InputError, match=r"segment 2 \(transition\) follows another transition"):
            Track.build([*row, arc])


@pytest.mark.parametrize(("change", "message"), table("wrong_transitions_are_refused"))
def test_wrong_transitions_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as error:
        Track.build([Straight(30.0), replace(Transition(80.0), **change), Arc(50.0, 300.0, 0.1)])
    assert re.search(message, str(error.value)), str(error.value)
