"""Wheels out of round: laws, and a rounded flat beside CONTACT."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from support.contacts import RADIUS, rail_profile, round_wheel, wheel_at, wheel_profile
from support.rows import data_rows, rows_of
from support.scripts import script

from wrsim import ContactSettings, Flat, Harmonic, InputError, RadiusTable, contact_model
from wrsim.contact.left_out import share_left_out
from wrsim.contact.profiles.sections import circle, cone
from wrsim.contact.records import STATUS_LEFT_OUT
from wrsim.contact.search.locus import LARGEST_SINE, locus_node, locus_point
from wrsim.contact.surfaces.out_of_round import shape_tables
from wrsim.contact.surfaces.profile_table import profile_point
from wrsim.contact.surfaces.wheel_shape import depth_at
from wrsim.contact.wheel_rail import place_bodies

table = rows_of(__file__)

R = 0.46
TURN = 2.0 * np.pi
NO_PLACES = np.zeros(0)
MODELS = ("kik-piotrowski", "strips")
WHEEL, RAIL = wheel_profile("S1002"), rail_profile("60E1", 40)


def model(*parts, normal="kik-piotrowski", radius=R):
    settings = ContactSettings(normal=normal, tangential="none", damping=0.0)
    return contact_model(WHEEL, RAIL, radius, settings, 0.3, out_of_round=parts)


def touched(of, *, lateral=-0.002, height=0.4599, yaw=0.0, along=0.0, wheel_angle=0.0):
    axle = (-np.sin(yaw), np.cos(yaw), 0.0)
    return of.evaluate((along, lateral, height), axle, (20.0, 0.0, 0.0), (0.0, 20.0 / R, 0.0), wheel_angle=wheel_angle)


def place(contact):
    """Centre of the strips' forces along the rail [m]."""
    strips = np.concatenate(contact.strips)
    return float(strips["N"] @ strips["x"] / strips["N"].sum())


def uniform(deviation):
    return RadiusTable(np.arange(8) * TURN / 8, NO_PLACES, np.full((8, 1), deviation))


def test_a_wheel_without_depth_is_round_to_the_bit():
    parts = Harmonic(3, 0.0), uniform(0.0)
    assert model(*parts).out_of_round == ()
    assert_allclose(touched(model(*parts), yaw=0.004).force, touched(model(), yaw=0.004).force, rtol=0.0)


@pytest.mark.parametrize("normal", MODELS)
@pytest.mark.parametrize("lateral, yaw", [(-0.002, 0.0), (-0.002, 0.006), (0.0012, -0.008)])
def test_an_even_depth_is_a_smaller_round_wheel(normal, lateral, yaw):
    depth = 1e-4
    worn, turned = model(uniform(-depth), normal=normal), model(normal=normal, radius=R - depth)
    out_of_round, round_wheel = (
        touched(m, lateral=lateral, yaw=yaw, wheel_angle=1.0, height=R - 1.6e-4) for m in (worn, turned)
    )
    assert round_wheel.patches.size > 0 and out_of_round.patches.size == round_wheel.patches.size
    for name in ("arc_wheel", "arc_rail", "o", "b"):
        assert_allclose(out_of_round.patches[name], round_wheel.patches[name], atol=1e-8)
    # the mean over the length of contact knows that the gap of a yawed wheel is not even: a^2 sin(theta) / R
    assert_allclose(out_of_round.patches["x"], round_wheel.patches["x"], atol=2e-6)
    assert_allclose(out_of_round.patches["approach"], round_wheel.patches["approach"], atol=1e-11)
    # a circle's gap is (a/R)^2/4 more than the parabola's at the end of the contact: 1e-4 of the curvature
    assert_allclose(out_of_round.patches["N"], round_wheel.patches["N"], rtol=3e-4)
    assert_allclose(out_of_round.patches["p0"], round_wheel.patches["p0"], rtol=3e-4)


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
def test_an_eccentric_wheel_is_a_round_one_with_a_displaced_centre(angle):
    a = 1e-4
    height = R - 1e-4 + a * np.cos(angle)
    eccentric = touched(model(Harmonic(1, a)), wheel_angle=angle, yaw=0.003, height=height)
    displaced = touched(model(), along=-a * np.sin(angle), height=height - a * np.cos(angle), yaw=0.003)
    assert eccentric.patches["N"].sum() > 0.0
    second_order = a * a / (2.0 * R)
    assert_allclose(eccentric.patches["approach"], displaced.patches["approach"], atol=1.1 * second_order)
    most = 1.6 * second_order / displaced.patches["approach"].min()
    assert_allclose(eccentric.patches["N"], displaced.patches["N"], rtol=most + 1e-3)
    assert_allclose(eccentric.patches["x"], displaced.patches["x"], atol=4.0 * second_order)


def test_a_wave_turned_by_its_length_is_the_same():
    polygon = model(Harmonic(18, 5e-5, 0.4))
    forces = [touched(polygon, wheel_angle=0.02 + k * TURN / 18, yaw=0.002).patches["N"] for k in (0, 1, 7)]
    assert_allclose(forces[1:], [forces[0]] * 2, rtol=1e-6)


@pytest.mark.parametrize("order", [1, 3, 18])
@pytest.mark.parametrize("crest", [1.0, -1.0])
def test_the_curvature_of_a_wave_is_that_of_its_second_derivative(order, crest):
    """k = (P^2 + 2 P'^2 - P P'')/(P^2 + P'^2)^(3/2): at crests 1/R + a (n^2 - 1)/R^2 to first order."""
    a, wheel = 1e-5, cone("cylinder", "wheel", 0.0, -0.03, 0.03)
    settings = ContactSettings(normal="kik-piotrowski", tangential="none")
    rail = circle("crown", "rail", 0.3, 0.04)
    waved = contact_model(wheel, rail, R, settings, out_of_round=[Harmonic(order, a)])
    angle = 0.0 if crest > 0.0 else np.pi / order
    waved.evaluate((0.0, 0.0, R - 1e-5 + crest * a), wheel_angle=angle)
    seen = place_bodies(waved.arrays.rows)[0]
    seen = seen._replace(shape=seen.shape._replace(averaged=0.0))
    if crest > 0.0 or order == 1:  # a trough of a polygon does not touch: its neighbours do
        locus = locus_point(seen, 0.03)
        first = 1.0 / R + crest * a * (order**2 - 1.0) / R**2
        assert_allclose(1.0 / locus.r_t, first, rtol=3.0 * (a * order**2 / R) ** 2 + 1e-6)
        assert_allclose(locus.x, 0.0, atol=1e-9)
    else:
        locus = locus_point(seen, 0.03)
        t = np.linspace(-0.4, 0.4, 400_001)
        height = (R + a * np.cos(order * (t + angle))) * np.cos(t)
        assert_allclose(-locus.b + R - 1e-5 + crest * a, height.max(), atol=1e-10)


@pytest.mark.parametrize("normal", MODELS)
def test_a_wheel_seen_in_a_mirror_touches_at_the_mirrored_place(normal):
    dented = model(Flat.rounded(R, 0.06, 0.5e-3, width=0.05), normal=normal)
    height = R - 2.2e-4
    contact = touched(dented, wheel_angle=0.04, yaw=0.004, height=height)
    mirror_image = touched(dented, wheel_angle=-0.04, yaw=-0.004, height=height)
    assert contact.patches["N"].sum() > 1e4 and abs(place(contact)) > 2e-3
    assert_allclose(contact.patches["N"], mirror_image.patches["N"], rtol=1e-6)
    assert_allclose(place(contact), -place(mirror_image), atol=1e-6)


@pytest.mark.parametrize("length", [0.03, 0.06])
def test_a_fresh_flat_lowers_the_wheel_by_its_depth_and_rests_on_its_edges(length):
    """depth = length^2/(8 R); turned by beta the edge carries, R (1 - cos(half - beta)) below the round wheel. Rounded
    over e it lies kink e/8 lower at most, kink = length/(2 R), and the mean of the chord's depth is e^2/(24 R) less."""
    edge = 0.002
    flat = Flat.fresh(R, length, None, edge)
    assert_allclose(flat.deepest, length**2 / (8.0 * R), rtol=(length / R) ** 2)
    assert Flat.fresh(R, None, flat.deepest, edge).length == pytest.approx(length, rel=1e-9)
    flattened = model(flat)
    half = np.arcsin(0.5 * length / R)
    for beta in (0.0, 0.3 * half, 0.8 * half):
        drop = lowest(flattened, beta) - lowest(flattened, np.pi)
        wanted = -R * (1.0 - np.cos(half - beta))
        assert -length / (2.0 * R) * edge / 8.0 < drop - wanted < edge**2 / (12.0 * R)


def lowest(of, angle):
    """Height at which a wheel begins to touch at this angle [m]."""
    height = 0.461
    for _ in range(6):
        height -= touched(of, height=height, wheel_angle=angle).closest
    return height


def test_the_search_finds_what_the_exact_gap_shows():
    """Depth of a search of the outline and the largest interpenetration of the true surfaces on a fine grid."""
    parts = Flat.rounded(R, 0.06, 0.5e-3, width=0.05, centre=0.005), Harmonic(7, 3e-5, 1.0)
    settings = ContactSettings(normal="half-space", tangential="none")
    exact = contact_model(WHEEL, RAIL, R, settings, out_of_round=parts)
    for angle, yaw in ((0.03, 0.008),):
        contact = touched(exact, wheel_angle=angle, yaw=yaw, height=R - 2.5e-4)
        deepest = exact.arrays.contacts["depth"].max()
        assert_allclose(contact.patches["approach"].max(), deepest, rtol=2e-3)
        assert contact.status == 0


# Both edges of a flat on the rail

HOLLOW = Flat.rounded(R, 0.04, 2.0 * 0.04**2 / (2.0 * np.pi**2 * R))
FRESH = Flat.fresh(R, 0.04, None, 0.012)
PARTS = {
    "polygon": Harmonic(18, 5e-5),
    "rolled flat": Flat.rounded(R, 0.09, 5e-4),
    "fresh flat": FRESH,
    "hollow flat": HOLLOW,
    "sharp flat": Flat.fresh(R, 0.03, None, 0.002),
}


@pytest.mark.parametrize("part", [FRESH, HOLLOW], ids=["fresh", "hollow"])
@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_a_flat_on_both_edges_rests_on_both_after_the_least_turn(part, damping):
    """A turn by beta brings an edge down by at most beta length/2: of N ~ approach^3/2 not more than 3/2 of that share.
    The approach at the edges closes by beta' length/2, down on the one and up on the other edge."""
    settings = ContactSettings(normal="half-space", tangential="none", damping=damping)
    exact = contact_model(WHEEL, RAIL, R, settings, out_of_round=[part])
    beta, height = 2e-4, lowest(exact, 0.0) - 8e-5
    level, turned = (touched(exact, height=height, wheel_angle=angle) for angle in (0.0, beta))
    assert level.status == turned.status == 0
    assert_allclose(turned.normal_force, level.normal_force, rtol=1.5 * beta * 0.5 * part.length / 8e-5)


def seeded(seed, part, count=40):
    """Poses (height, lateral, yaw, angle) of a wheel under 20 to 150 kN by strips."""
    rng, strips = np.random.default_rng(seed), model(part, normal="strips")
    for _ in range(count):
        lateral, yaw, load = rng.uniform(-4e-3, 1e-3), rng.uniform(-4e-3, 4e-3), rng.uniform(2e4, 1.5e5)
        angle = rng.uniform(0.0, 6.0) if isinstance(part, Harmonic) else 0.02 * rng.uniform(-1.0, 1.0) ** 3
        start = [[0.0, lateral, 0.461, -np.sin(yaw), np.cos(yaw), *np.zeros(7)]]
        pose = strips.solve_many(start, load, threads=1, wheel_angle=angle).poses[0]
        yield {"height": pose[2], "lateral": lateral, "yaw": yaw, "wheel_angle": angle}


@pytest.mark.parametrize("name", PARTS)
def test_a_place_that_strips_leave_out_is_told_and_no_other(name):
    """Against the normal force of the exact solver at the same pose; Kik-Piotrowski's alone is 5 to 20 % above it."""
    part = PARTS[name]
    strips, kik, exact = (model(part, normal=normal) for normal in ("strips", "kik-piotrowski", "half-space"))
    told, missing = [], []
    for pose in seeded(5, part):
        whole, contact = touched(exact, **pose), touched(strips, **pose)
        told.append(bool(contact.status & STATUS_LEFT_OUT))
        missing.append(1.0 - contact.normal_force / whole.normal_force)
        assert whole.status == 0
        if not 0.01 < missing[-1] < 0.08:
            assert told[-1] == (missing[-1] > 0.05)
        if missing[-1] > 0.15:
            assert touched(kik, **pose).status & STATUS_LEFT_OUT
    assert any(told) == (name in ("fresh flat", "hollow flat", "sharp flat")) and not all(told)


def test_the_share_left_out_is_what_the_exact_solver_has_more():
    """Where a hollow flat rests on both edges with nothing between them: the normal force of the exact solver over that
    of the strips. The estimate has the curvature of the first edge."""
    strips, exact, shares = model(HOLLOW, normal="strips"), model(HOLLOW, normal="half-space"), []
    for pose in seeded(7, HOLLOW):
        whole, contact = touched(exact, **pose), touched(strips, **pose)
        forces = np.sort(whole.patches["N"])[::-1]
        a = strips.arrays.rows
        share = share_left_out(*place_bodies(a)[:2], a.model[0], a.patches, a.strips, contact.patches.size)
        if forces.size > 1 and forces[1] > 0.05 * forces[0]:
            shares.append(share / (whole.normal_force / contact.normal_force - 1.0))
    assert len(shares) > 10
    assert_allclose(np.percentile(shares, [10.0, 50.0, 80.0]), 1.0, atol=0.15)


def test_a_table_is_the_surface_that_it_was_made_of():
    angle, across = np.arange(0, 360, 0.5) * np.pi / 180, np.linspace(-0.03, 0.03, 13)
    surface = lambda a, u: 2e-4 * np.cos(2 * a) * (1 + 10 * u) + 1e-4 * np.sin(5 * a)  # noqa: E731
    table = RadiusTable(angle, across, surface(angle[:, None], across))
    model_of_table = contact_model(
        cone("c", "wheel", 0.0, -0.03, 0.03), circle("r", "rail", 0.3, 0.05), R, out_of_round=[table]
    )
    model_of_table.evaluate((0.0, 0.0, R))
    shape = place_bodies(model_of_table.arrays.rows)[0].shape
    for a, u in ((0.1, 0.0), (3.3, 0.012), (6.28, -0.02), (-40.0, 0.0299)):
        depth = depth_at(shape, u, a)
        assert_allclose(depth.d, -surface(a, u), atol=1e-9)
        h = 1e-4
        assert_allclose(depth.a, -(surface(a + h, u) - surface(a - h, u)) / (2 * h), atol=1e-7)
        assert_allclose(depth.u, -(surface(a, u + h) - surface(a, u - h)) / (2 * h), atol=1e-5)


def test_waves_shorter_than_the_limit_are_taken_out_of_a_table():
    angle = np.arange(0, 360, 0.25) * np.pi / 180
    deviation = 1e-4 * np.cos(3 * angle) + 1e-5 * np.cos(360 * angle)
    table = RadiusTable(angle, NO_PLACES, deviation[:, None], shortest=0.05)
    depth = table.depth(angle, NO_PLACES, R)[:, 0]
    assert_allclose(depth, -1e-4 * 0.5 ** ((3 * 0.05 / (TURN * R)) ** 2) * np.cos(3 * angle), atol=1e-10)


@pytest.mark.parametrize("angles, deviations, message", table("a_table_that_is_no_wheel_is_refused"))
def test_a_table_that_is_no_wheel_is_refused(angles, deviations, message):
    with pytest.raises(InputError, match=message):
        RadiusTable(np.radians(np.array(angles, float)), NO_PLACES, np.array(deviations, float)[:, None])


def test_a_depth_that_the_search_cannot_follow_is_refused():
    with pytest.raises(InputError, match=r"allowed: 20\.7 mm"):
        shape_tables((Harmonic(1, 0.02),), WHEEL, R)


# CONTACT

CAMPAIGN = script("campaigns/out_of_round.py")


def rows_of_contact():
    return {int(row["case"]): {k: float(v) for k, v in row.items()} for row in data_rows("rounded_flat_d09.csv")}


def test_the_closed_form_is_the_flat_of_the_table():
    angle, across, depth = CAMPAIGN.slices().T
    width = 2.0 * np.sqrt(2.0 * CAMPAIGN.CROWN * CAMPAIGN.DEPTH)
    flat = Flat.rounded(CAMPAIGN.RADIUS, CAMPAIGN.LENGTH, CAMPAIGN.DEPTH, width=width)
    depth_of_flat = flat.depth(np.unique(angle), 1e-3 * np.unique(across), CAMPAIGN.RADIUS)
    assert_allclose(depth_of_flat.ravel(), 1e-3 * depth, atol=3e-8)


def on_crown(normal, places):
    """The reference's wheel, at all places across of its slices or at those of the table, on its rail."""
    settings = ContactSettings(normal=normal, tangential="none", wheel=CAMPAIGN.STEEL, rail=CAMPAIGN.STEEL, damping=0.0)
    wheel, rail = cone("cylinder", "wheel", 0.0, -0.0302, 0.0302), circle("crown", "rail", CAMPAIGN.CROWN, 0.05)
    part = CAMPAIGN.table(places)
    return contact_model(wheel, rail, CAMPAIGN.RADIUS, settings, out_of_round=[part])


@pytest.mark.parametrize("normal, places, cases", table("a_rounded_flat_beside_contact"))
def test_a_rounded_flat_beside_contact(normal, places, cases):
    """Height, place, and but for Kik-Piotrowski's model and places lost across the approach."""
    model, rows = on_crown(normal, places), rows_of_contact()
    for case in cases:
        row = rows[case]
        z, contact = CAMPAIGN.carrying(model, 1e-3 * row["z_ws"], -row["pitch"])
        assert_allclose(1e3 * z, row["z_ws"], atol=0.002)
        assert_allclose(1e3 * place(contact), row["xcp"], atol=0.1)
        if places == "all places" and normal != "kik-piotrowski":
            strips = np.concatenate(contact.strips)
            across = strips[np.argmin(np.abs(strips["o"]))]
            assert_allclose(1e3 * across["penetration"], row["approach"], rtol=0.02)


# The contact locus of a yawed wheel against the surface of revolution itself, found by brute force.
WHEELS = {"S1002": wheel_profile("S1002"), "round": round_wheel(0.1, 0.05)}
YAWS = [0.0, -0.012, 0.05]
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
