"""The contact locus of a yawed wheel against the surface of revolution itself, found by brute force."""

import numpy as np
import pytest
from scipy.optimize import brentq
from support.contacts import RADIUS, round_wheel, wheel_at, wheel_profile

from wrsim.core.contact.profile import profile_point
from wrsim.core.contact.search.locus import LARGEST_SINE, locus_node, locus_point

WHEELS = {"S1002": wheel_profile("S1002"), "round": round_wheel(0.1, 0.05)}
YAWS = [0.0, 0.002, -0.012, 0.05]
ROLL = 0.02
ORIGIN = np.array([0.01, 0.02, 0.5])


def axle(yaw, roll=ROLL):
    """Unit vector of the axle, outward, in (t, o, b), of a wheel turned by yaw and roll."""
    return np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])


class Surface:
    """A wheel as a surface r(L, angle), angle about the axle from the lowest point, forward positive."""

    def __init__(self, profile, yaw):
        self.profile = profile
        self.axle = axle(yaw)
        down = -np.array([0.0, 0.0, 1.0]) + self.axle[2] * self.axle
        self.down = down / np.linalg.norm(down)
        self.ahead = np.cross(self.axle, -self.down)

    def radial(self, angle):
        return np.cos(angle) * self.down + np.sin(angle) * self.ahead

    def __call__(self, arc, angle):
        u, w = self.profile.at(arc)
        return ORIGIN + u * self.axle + (RADIUS - w) * self.radial(angle)

    def normal(self, arc, angle, h=1e-6):
        """Unit normal out of the wheel, by central differences."""
        along = self(arc + h, angle) - self(arc - h, angle)
        around = self(arc, angle + h) - self(arc, angle - h)
        n = np.cross(along, around)
        return n / np.linalg.norm(n)

    def outline_angle(self, arc):
        """Where the normal has no part along the rail."""
        return brentq(lambda angle: self.normal(arc, angle)[0], -0.8, 0.8, xtol=1e-13)


def kernel(profile, yaw, arc):
    """locus_point with the table of the model: (x, o, b), (normal), shrink, r_t, curvature of the profile."""
    table, step = profile.table(1e-4)
    x, o, b, no, nb, shrink, rt, _, curvature = locus_point(wheel_at(table, step, RADIUS, ORIGIN, axle(yaw)), arc)
    return np.array([x, o, b]), np.array([0.0, no, nb]), shrink, rt, curvature


def places(profile, yaw):
    """Arclengths on tread, root and flange where the yawed wheel has an outline."""
    table, step = profile.table(1e-4)
    steep = np.abs(table[:, 3] / np.maximum(table[:, 2], 1e-3) * np.sin(yaw))
    arcs = step * np.arange(len(table))
    return arcs[(steep < 0.6) & (table[:, 2] > 0.05) & (arcs > 1e-3) & (arcs < profile.length - 1e-3)][3::97]


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("profile", WHEELS.values(), ids=WHEELS)
def test_the_locus_is_where_the_wheels_normal_is_across_the_rail(profile, yaw):
    surface = Surface(profile, yaw)
    wheel = wheel_at(*profile.table(1e-4), RADIUS, ORIGIN, axle(yaw))
    for arc in places(profile, yaw):
        point, normal, _, _, _ = kernel(profile, yaw, arc)
        node = locus_node(wheel, profile_point(wheel.profile, arc), LARGEST_SINE)  # as the search has it
        np.testing.assert_allclose(node[:4], [*point[1:], *normal[1:]], atol=1e-14)
        angle = surface.outline_angle(arc)
        # 1e-8: the normal of the brute force comes from differences
        np.testing.assert_allclose(point, surface(arc, angle), atol=1e-8)
        np.testing.assert_allclose(normal, surface.normal(arc, angle), atol=1e-7)
        assert np.hypot(*normal[1:]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("profile", WHEELS.values(), ids=WHEELS)
def test_curvature_along_the_rail(profile, yaw):
    # the wheel cut by the plane through t and the normal: its depth at +-h along t
    surface = Surface(profile, yaw)
    h = 3e-4
    for arc in places(profile, yaw):
        if jumps_near(profile, arc, 2e-3):
            continue
        point, normal, _, r_t, _ = kernel(profile, yaw, arc)
        across = np.array([0.0, -normal[2], normal[1]])

        def depth(x, arc=arc, point=point, normal=normal, across=across):
            def beside(a):
                angle = on_section(surface, a, point, x)
                return float((surface(a, angle) - point) @ across)

            a = brentq(beside, arc - 1e-3, arc + 1e-3, xtol=1e-14)
            return -float((surface(a, on_section(surface, a, point, x)) - point) @ normal)

        curvature = (depth(h) + depth(-h)) / h**2
        # difference quotient over 0.3 mm: h^2 times the square of the profile's curvature
        assert 1.0 / r_t == pytest.approx(curvature, rel=2e-3)


def on_section(surface, arc, point, x):
    """Angle at which the circle at ``arc`` passes the section ``x`` ahead of the point."""
    return brentq(lambda angle: surface(arc, angle)[0] - point[0] - x, -0.8, 0.8, xtol=1e-15)


def jumps_near(profile, arc, reach):
    """Does the profile's curvature jump or change fast within reach?"""
    near = np.abs(profile.arclength - arc) < reach
    spread = profile.curvature_after[near]
    return np.ptp(np.concatenate([spread, profile.curvature_before[near]])) > 20.0


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("profile", WHEELS.values(), ids=WHEELS)
def test_shrink_is_profile_arclength_over_outline_arclength(profile, yaw):
    h = 1e-6
    for arc in places(profile, yaw):
        before, after = kernel(profile, yaw, arc - h), kernel(profile, yaw, arc + h)
        outline = np.hypot(*(after[0] - before[0])[1:])
        _, _, shrink, r_t, curvature = kernel(profile, yaw, arc)
        # on a steep convex flank shrink is 0.02 and the outline turns within the quotient
        assert shrink == pytest.approx(2.0 * h / outline, rel=1e-5)
        # the outline's own curvature, by its turning: its points move shrink times slower than the profile's
        turning = (before[1][1] * after[1][2] - before[1][2] * after[1][1]) / outline
        assert turning == pytest.approx(k1_k2_over_kt(profile, yaw, arc, r_t, curvature), rel=1e-4, abs=1e-3)


def k1_k2_over_kt(profile, yaw, arc, r_t, k2):
    """Curvature of the outline from the principal curvatures."""
    _, w = profile.at(arc)
    k1 = profile.tangent(arc)[0] / (RADIUS - w)
    return k1 * k2 * r_t


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("profile", WHEELS.values(), ids=WHEELS)
def test_the_normal_meets_the_axle(profile, yaw):
    table, step = profile.table(1e-4)
    e = axle(yaw)
    for arc in places(profile, yaw):
        at = locus_point(wheel_at(table, step, RADIUS, ORIGIN, e), arc)
        arm = np.array([at.x, at.o, at.b]) - at.to_axle * np.array([0.0, at.no, at.nb]) - ORIGIN
        assert np.linalg.norm(arm - (arm @ e) * e) < 1e-9
