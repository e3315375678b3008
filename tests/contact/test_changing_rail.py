"""A wheel on a rail that changes along the track: laws of inclined planes and steps, a potential."""

from itertools import pairwise
from math import atan, cos, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from support.contacts import PLAIN, RADIUS, contact_model, numbers, rail_profile, wheel_profile
from support.crossings import lifted, on, turning
from support.kernels import branches_that_cross

from wrsim.contact.model import Contact, ContactModel
from wrsim.contact.models import contact_model as model_of
from wrsim.core.contact.rail import unfold
from wrsim.errors import InputError
from wrsim.geometry.profile.sections import circle
from wrsim.geometry.track.rail_surface import RailSection, RailSurface, read_sections
from wrsim.geometry.track.rolled_rail import rolled_rail

CROWN = circle("crown", "rail", 0.3, 0.02)
WHEEL = circle("round", "wheel", -0.5, 0.02)
RISE = 0.1
EVEN = np.linspace(-1.0, 1.0, 21)
NORMAL = ("strips", "kik-piotrowski")


def on_60e1(normal: str, lateral: float, axle: tuple[float, float, float]) -> tuple[ContactModel, np.ndarray]:
    """S1002 on 60E1 without creep forces, and the wheel's origin where it is carried by 50 kN."""
    model = contact_model(wheel_profile("S1002"), rail_profile("60E1", 40), normal=normal, strips=20, **PLAIN)

    def lacking(z: float) -> float:
        return model.evaluate((0.0, lateral, z), axle).force[2] - 5e4

    # the flange may not be pressed deeper than an overlap: from above, in steps
    z = RADIUS + 0.04
    while lacking(z) < 0.0:
        z -= 1e-4
    return model, np.array([0.0, lateral, brentq(lacking, z, z + 1e-4, xtol=1e-10)])


def touching(model: ContactModel, lateral: float, axle, place: float = 0.0) -> np.ndarray:
    """The wheel's origin where it comes down on its rail."""
    origin = np.array([0.0, lateral, RADIUS + 5e-3])
    while (closest := model.evaluate(origin, axle, place=place).closest) > 1e-9:
        origin[2] -= closest
    return origin


@pytest.fixture(scope="module")
def ramp():
    """A crowned rail that rises 1:10."""
    return lifted(CROWN, EVEN, RISE * EVEN)


@pytest.mark.parametrize("normal", [*NORMAL, "half-space"])
def test_a_rising_rail_is_touched_ahead_and_pushes_back(ramp, normal: str) -> None:
    # the plane through the contact is inclined: the wheel's centre is R / cos above it
    angle, depth = atan(RISE), 5e-5
    level = contact_model(WHEEL, CROWN, normal=normal, **PLAIN).evaluate((0.0, 0.0, RADIUS - depth))
    own = on(ramp, normal, WHEEL).evaluate((0.0, 0.0, (RADIUS - depth) / cos(angle)))
    patch = own.patches[0]
    assert patch["x"] == pytest.approx(RADIUS * sin(angle), abs=2e-5)
    share = 1e-2 if normal == "kik-piotrowski" else 2e-3  # its approach is measured in the section
    assert patch["N"] == pytest.approx(level.normal_force, rel=share)
    assert patch["p0"] == pytest.approx(level.patches[0]["p0"], rel=share)
    assert own.force[0] == pytest.approx(-patch["N"] * sin(angle), rel=1e-4)
    assert own.force[2] == pytest.approx(patch["N"] * cos(angle), rel=1e-4)
    # no moment about the axle: the force passes through it
    assert abs(own.moment[1]) < 1e-4 * patch["N"] * RADIUS


@pytest.mark.parametrize(("normal", "share"), [("strips", 2e-3), ("kik-piotrowski", 2e-3), ("half-space", 5e-3)])
@pytest.mark.parametrize("bend", [2.0, -2.0])
def test_on_a_hump_a_wheel_is_pressed_as_a_smaller_one_and_in_a_hollow_as_a_larger_one(normal, share, bend) -> None:
    """Curvatures of wheel and rail along the track add up, and half of the square of their place is the gap."""
    places, depth = 0.3 * EVEN, 5e-5
    own = on(lifted(CROWN, places, -(places**2) / (2.0 * bend)), normal, WHEEL).evaluate((0.0, 0.0, RADIUS - depth))
    like = 1.0 / (1.0 / RADIUS + 1.0 / bend)
    plain = contact_model(WHEEL, CROWN, radius=like, normal=normal, **PLAIN).evaluate((0.0, 0.0, like - depth))
    assert own.patches["N"] == pytest.approx(plain.patches["N"], rel=share)
    assert own.patches["p0"] == pytest.approx(plain.patches["p0"], rel=share)


@pytest.mark.parametrize(("normal", "share"), [("strips", 1e-2), ("half-space", 5e-4)])
@pytest.mark.parametrize("angle", [0.05, 0.15])
def test_a_rail_whose_section_moves_sideways_is_a_yawed_cylinder(normal: str, share: float, angle: float) -> None:
    """The section in the track's plane of a cylinder that runs off at an angle is wider than the cylinder."""
    across = circle("across", "rail", 0.02, 8e-3)
    places = np.linspace(-0.3, 0.3, 13)
    oblique = RailSurface("oblique", tuple(RailSection(s, across.shifted(np.tan(angle) * s, 0.0)) for s in places))
    own = on(oblique, normal, WHEEL).evaluate((0.0, 0.0, RADIUS - 5e-5)).patches[0]
    cylinder = contact_model(WHEEL, circle("c", "rail", 0.02 * cos(angle) ** 2, 8e-3), normal=normal, **PLAIN)
    plain = cylinder.evaluate((0.0, 0.0, RADIUS - 5e-5), (-sin(angle), cos(angle), 0.0)).patches[0]
    assert own["N"] == pytest.approx(plain["N"], rel=share)
    assert own["p0"] == pytest.approx(plain["p0"], rel=share)


@pytest.mark.parametrize(
    ("rise", "yaw", "lateral", "share"),
    [(0.03, 0.01, 3e-3, 0.025), (0.03, -0.01, 3e-3, 0.025), (0.01, 0.02, 8e-3, 0.045), (0.01, -0.02, 8e-3, 0.045)],
)
def test_a_yawed_wheel_on_a_rising_rail_is_one_on_an_inclined_plane(
    rise: float, yaw: float, lateral: float, share: float
) -> None:
    # its outline runs ahead of the axle by another way at every row, and each is as high, and as steep across, as the
    # rail is there; at the flange, 65 degrees steep, p0 is half as large again if its tangents do not follow
    rail, angle = rail_profile("60E1", 40), atan(rise)
    to_ramp = np.array([[cos(angle), 0.0, sin(angle)], [0.0, 1.0, 0.0], [-sin(angle), 0.0, cos(angle)]])
    plain = contact_model(wheel_profile("S1002"), rail, normal="strips", strips=20, **PLAIN)
    own = on(lifted(rail, EVEN, rise * EVEN), "strips", wheel_profile("S1002"), strips=20)
    axle = np.array([-sin(yaw), cos(yaw), 0.0])

    def found(z: float) -> Contact:
        return plain.evaluate(to_ramp @ (0.0, lateral, z), to_ramp @ axle)

    z = RADIUS + 0.04
    while found(z).force[2] < 5e4:
        z -= 2e-5
    force, other = to_ramp.T @ found(z).force, own.evaluate((0.0, lateral, z), axle)
    # what is left grows with the square of the rise: the section is felt with the radius of the tape circle
    np.testing.assert_allclose(other.force, force, atol=share * np.linalg.norm(force))
    assert other.patches["p0"].max() == pytest.approx(found(z).patches["p0"].max(), rel=share)


def test_a_step_is_felt_before_and_behind_it() -> None:
    # a wheel that climbs a step h touches its edge from sqrt(2 R h) ahead of it on
    height = 5e-4
    places = np.array([-0.5, -0.3, -0.1, -0.0005, 0.0005, 0.1, 0.3, 0.5])
    felt = rolled_rail(lifted(CROWN, places, np.where(places > 0.0, height, 0.0)), RADIUS)
    top = [felt.section(s)[:, 1].max() for s in (-0.06, -sqrt(2.0 * RADIUS * height) - 2e-3, -0.01, 0.05)]
    assert top[0] == pytest.approx(0.0, abs=1e-6) and top[1] == pytest.approx(0.0, abs=5e-6)
    assert top[2] == pytest.approx(height - 0.01**2 / (2.0 * RADIUS), abs=1.5e-5)
    assert top[3] == pytest.approx(height, abs=1e-6)


def test_sections_that_are_alike_are_the_plain_rail() -> None:
    wheel, rail = wheel_profile("S1002"), rail_profile("60E1", 40)
    pose = ((0.0, 3e-3, RADIUS + 0.0296),)
    plain = model_of(wheel, rail, RADIUS).evaluate(*pose)
    alike = model_of(wheel, rail, RADIUS, surface=lifted(rail, EVEN, 0.0 * EVEN)).evaluate(*pose, place=0.2)
    np.testing.assert_allclose(numbers(alike), numbers(plain), rtol=1e-9)


def test_what_is_joined_between_sections_has_its_own_tangents_and_curvature() -> None:
    """A hump that moves along the profile from section to section and grows, at uneven distances."""
    places = np.array([-0.4, -0.2, -0.12, -0.05, 0.0, 0.03, 0.1, 0.2, 0.4])
    rail = rail_profile("60E1", 40)
    moved = (rail.rotated(0.05 * float(np.sin(9.0 * s))).shifted(2e-3 * s, 1e-3 * s * s) for s in places)
    surface = RailSurface("moved", tuple(RailSection(float(s), own) for s, own in zip(places, moved, strict=True)))
    for piece in surface.pieces:
        for s in (-0.15, -0.02, 0.014, 0.06):
            rows = piece.spline(s)
            along = CubicSpline(np.arange(len(rows)), rows[:, :2])(np.arange(len(rows)), 1)
            normal = np.column_stack((-rows[:, 3], rows[:, 2])) / np.hypot(rows[:, 2], rows[:, 3])[:, None]
            off = (along * normal).sum(axis=1) / np.hypot(*along.T)
            # what is left are the steps of the rows' distance at features and the profile's jumps of curvature
            assert np.median(np.abs(off)) < 1e-5 and np.percentile(np.abs(off), 95.0) < 3e-3
        jumps = piece.spline(places[1:-1] + 1e-9, 2) - piece.spline(places[1:-1] - 1e-9, 2)
        assert np.abs(jumps).max() < 1e-3


def test_what_is_joined_does_not_swing_beyond_level_stretches() -> None:
    places = np.array([0.0, 0.3, 0.6, 0.63, 0.65, 0.68, 1.0, 1.3])
    heights = 1e-3 * np.array([0.0, 0.0, 0.0, 0.2, 0.9, 1.0, 1.0, 1.0])
    piece = lifted(CROWN, places, heights).pieces[0].spline
    up = np.array([piece(s)[:, 1] for s in np.linspace(0.0, 1.3, 400)]) - piece(0.0)[:, 1]
    assert up.min() > -1e-9 and up.max() < 1e-3 + 1e-9


def test_sections_recorded_to_different_depths_are_the_same_rail(tmp_path: Path) -> None:
    """60E1, recorded to 12 to 30 mm below its top by turns; the only features lie on its gauge corner and its top."""
    rail = rail_profile("60E1", 40)
    arc = np.linspace(0.0, rail.length, round(rail.length / 0.2e-3))
    u, w = rail.at(arc)
    corner, top = int(np.argmin(np.abs(u + 0.027) + (u > 0.0))), int(w.argmax())
    lines = ["at_m,outward_mm,up_mm,feature"]
    for s, depth in zip((0.0, 0.03, 0.06, 0.065, 0.1, 0.13), (12.0, 30.0, 12.0, 25.0, 12.0, 30.0), strict=True):
        for i in np.flatnonzero((w > w.max() - 1e-3 * depth) | (u > u[top])):
            mark = {corner: "1", top: "2"}.get(int(i), "")
            lines.append(f"{s},{1e3 * u[i]:.9f},{1e3 * w[i]:.9f},{mark}")
    (tmp_path / "rail.csv").write_text("\n".join(lines))
    surface = RailSurface("recorded", tuple(read_sections(tmp_path / "rail.csv")))
    for s in np.linspace(0.0, 0.13, 14):
        rows = surface.pieces[0].spline(s)
        rows = rows[(rows[:, 1] > w.max() - 11e-3) & (np.abs(rows[:, 0]) < 0.034)]
        at = np.array([rail.arclength_of(each) for each in rows[:, 0]])
        assert np.abs(rows[:, 1] - rail.at(at)[1]).max() < 5e-6


@pytest.mark.parametrize("normal", NORMAL)
def test_the_normal_force_has_a_potential(normal: str) -> None:
    # what pushes back along the track is the gradient of the same energy that carries the wheel
    wave = lifted(CROWN, EVEN, 5e-4 * np.cos(6.0 * EVEN))
    model = on(wave, normal, WHEEL)

    def force(z: float, s: float) -> np.ndarray:
        return model.evaluate((0.0, 0.0, z), place=s).force

    for s in (0.13, 0.3):
        top = brentq(lambda z, s=s: force(z, s)[2] - 3e4, RADIUS - 2e-3, RADIUS + 1e-3, xtol=1e-12)
        h = 2e-6
        along = (force(top, s + 10.0 * h)[2] - force(top, s - 10.0 * h)[2]) / (20.0 * h)
        down = (force(top + h, s)[0] - force(top - h, s)[0]) / (2.0 * h)
        assert down == pytest.approx(along, rel=0.02)


@pytest.mark.parametrize("normal", NORMAL)
@pytest.mark.parametrize("turning", [(5e-3, 0.0, 0.0), (0.0, 0.01, 0.0), (2e-3, -0.04, 0.005)])
@pytest.mark.parametrize(("lateral", "yaw"), [(0.0, 0.0), (-8e-3, 0.0), (6e-3, 0.01), (6.4e-3, -0.01)])
def test_a_rail_that_turns_and_bends_pushes_back_by_its_moment(normal, turning, lateral, yaw) -> None:
    # virtual work: to go on by dx is to turn about the rail's origin the other way, with its twist and its bends
    twist, outward, up = turning
    axle = (-sin(yaw), cos(yaw), 0.0)
    model, origin = on_60e1(normal, lateral, axle)
    level, own = model.evaluate(origin, axle), model.evaluate(origin, axle, turning=turning)
    about_the_rail = own.moment + np.cross(origin, own.force)
    expected = -twist * about_the_rail[0] - outward * about_the_rail[2] + up * about_the_rail[1]
    assert own.force[0] == pytest.approx(expected, rel=1e-2, abs=1e-6 * own.normal_force)
    assert (abs(own.force[0]) > 5e-6 * own.normal_force) == (twist != 0.0 or yaw != 0.0)
    assert level.force[0] == pytest.approx(0.0, abs=1e-9 * level.normal_force)
    # it is touched where its normal meets the axle, and turns no wheel
    assert abs((own.moment - level.moment) @ axle) <= 0.02 * abs(own.force[0]) * RADIUS
    assert own.normal_force == pytest.approx(level.normal_force, rel=1e-2)


def test_a_rail_that_turns_is_one_of_turned_sections() -> None:
    twist = 5e-3
    model, origin = on_60e1("strips", 0.0, (0.0, 1.0, 0.0))
    turned = turning(rail_profile("60E1", 40), EVEN, twist)
    one = model.evaluate(origin, turning=(twist, 0.0, 0.0))
    other = on(turned, "strips", wheel_profile("S1002"), strips=20).evaluate(origin, place=0.0)
    assert other.force == pytest.approx(one.force, rel=2e-3)
    assert other.patches["x"] == pytest.approx(one.patches["x"], rel=0.05)


def test_a_rail_that_is_too_steep_is_refused_with_its_place() -> None:
    with pytest.raises(InputError, match=r"near .* m it is so steep along the track"):
        rolled_rail(lifted(CROWN, EVEN, 0.6 * EVEN), RADIUS)


@pytest.fixture(scope="module")
def wearing() -> ContactModel:
    """S1002 on a rail that goes from new to worn, and back, and on."""
    new, worn = (rail_profile(name, 40) for name in ("60E1", "60E1_worn"))
    places = zip((10.0, 40.0, 70.0, 90.0), (new, worn, new, worn), strict=True)
    surface = RailSurface("wears", tuple(RailSection(*at) for at in places))
    return on(surface, "strips", wheel_profile("S1002"))


def test_no_piece_of_a_rail_between_new_and_worn_is_pressed_twice(wearing: ContactModel) -> None:
    """Where the gauge corner of the rail lies nearly parallel to the wheel the samples of a search tell the
    slope of the distance with a wrong sign: lobes that are none were found there, over the ground of others."""
    for place, lateral, yaw, depth in (  # [m, mm, mrad, um]
        (73.369, 3.372, 5.0084, 96.746), (73.566, 3.3911, 4.9966, 98.671), (73.3564, 3.3769, 5.0196, 98.906),
        (73.3887, 3.3715, 4.9877, 92.056), (73.3374, 3.3702, 4.9825, 98.819),
    ):  # fmt: skip
        axle = np.array([-sin(1e-3 * yaw), cos(1e-3 * yaw), 7e-4])
        origin = touching(wearing, 1e-3 * lateral, axle, place) - [0.0, 0.0, 1e-6 * depth]
        contact = wearing.evaluate(origin, axle, place=place)
        patches = [patch for patch in contact.patches if patch["N"] > 0.0]
        pressed = sorted(tuple(patch["arc_rail"] + [patch["start"], patch["end"]]) for patch in patches)
        assert patches and all(one[1] < other[0] + 1e-9 for one, other in pairwise(pressed))


@pytest.mark.parametrize("anchor", [0, 60])
def test_what_runs_on_below_the_other_branch_is_left_out(anchor: int) -> None:
    keep = np.zeros(61, dtype=bool)
    unfold(branches_that_cross(61), anchor, -1.0, keep)
    assert (keep == (np.abs(np.linspace(-1.2, 1.2, 61)) > sqrt(0.75))).all()
