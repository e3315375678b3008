"""Laws of a track: curvature, heading, place, cant and gauge; two rails with their own arclength."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import fresnel
from support.paths import locate
from support.rows import rows_of

from wrsim import Arc, InputError, Straight, Track, Transition, load_profile
from wrsim.contact.surfaces.rail_surface import RailSurface
from wrsim.track.crossing import read_crossing
from wrsim.track.segments import Segment

table = rows_of(__file__)

GAUGE = 1.435
SHAPES = ("clothoid", "bloss")


def mirrored(segments: Sequence[Segment]) -> tuple[Segment, ...]:
    """The same track with left and right exchanged."""
    if not any(isinstance(s, Arc) for s in segments):
        return tuple(
            replace(s, cant_start=-s.cant_start, cant_end=-s.cant_end) if isinstance(s, Straight) else s
            for s in segments
        )
    return tuple(replace(s, radius=-s.radius) if isinstance(s, Arc) else s for s in segments)


def curve(
    radius: float, shape: str = "clothoid", cant: float = 0.1, widening: float = 0.01, length: float = 40.0
) -> tuple[Segment, ...]:
    """Straight, transition, arc, transition, straight."""
    ramp = Transition(length, shape)  # type: ignore[arg-type]
    return (Straight(30.0), ramp, Arc(80.0, radius, cant, widening), ramp, Straight(30.0))


def s_curve(radius: float = 300.0, shape: str = "clothoid") -> tuple[Segment, ...]:
    """Left and right curve joined by one transition that runs through zero curvature."""
    ramp = Transition(40.0, shape)  # type: ignore[arg-type]
    return (
        Straight(20.0),
        ramp,
        Arc(60.0, radius, 0.1, 0.01),
        Transition(80.0, shape),  # type: ignore[arg-type]
        Arc(60.0, -radius, 0.08, 0.005),
        ramp,
        Straight(20.0),
    )


@pytest.mark.parametrize("radius", [25.0, 150.0, 300.0, -1000.0])
def test_a_full_circle_closes_within_a_nanometre(radius: float) -> None:
    track = Track.build([Arc(2.0 * math.pi * abs(radius), radius)])
    for path in (track.centre, track.left, track.right):
        first, last = path.frame(0.0), path.frame(path.length)
        # rounding of coordinates up to 2 R over some hundred pieces
        assert np.linalg.norm(last[0] - first[0]) < 1e-14 * abs(radius) + 1e-12 < 1e-9
        assert np.abs(last[1:] - first[1:]).max() < 1e-13
    assert track.heading(track.length) == pytest.approx(math.copysign(2.0 * math.pi, radius), rel=1e-15)


@pytest.mark.parametrize("radius, length", [(25.0, 15.0), (25.0, 150.0), (300.0, 40.0), (-5000.0, 150.0)])
def test_clothoid_ends_where_fresnels_integrals_say(radius: float, length: float) -> None:
    """x = a C(L / a), y = a S(L / a) with a = sqrt(pi R L). The second case turns by 172 degrees."""
    track = Track.build([Transition(length), Arc(10.0, radius)])
    scale = math.sqrt(math.pi * abs(radius) * length)
    sine, cosine = fresnel(length / scale)
    end = track.centre_line.position(length)
    assert np.abs(end - [scale * cosine, math.copysign(scale * sine, radius), 0.0]).max() < 1e-12


def test_bloss_transition_ends_where_adaptive_quadrature_says() -> None:
    radius, length = 60.0, 30.0
    track = Track.build([Transition(length, "bloss"), Arc(10.0, radius)])

    def heading(s: float) -> float:
        xi = s / length
        return length / radius * (xi**3 - 0.5 * xi**4)

    exact = [
        quad(lambda s, f=f: f(heading(s)), 0.0, length, epsabs=1e-13, epsrel=1e-13)[0] for f in (math.cos, math.sin)
    ]
    assert np.abs(track.centre_line.position(length)[:2] - exact).max() < 1e-12


def test_bloss_curvature_has_no_slope_at_either_end_and_a_clothoid_a_constant_one() -> None:
    for shape, at_ends, middle in (("bloss", 0.0, 1.5), ("clothoid", 1.0, 1.0)):
        track = Track.build(curve(300.0, shape))
        slope = track.centre_line.curvature(np.array([30.0, 50.0, 70.0 - 1e-9]), 1) * 300.0 * 40.0
        # tolerance: the last point is 1e-9 m before the end, where the slope changes by 6 / L per metre
        assert slope == pytest.approx([at_ends, middle, at_ends], abs=1e-9)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("segments", [curve, s_curve], ids=["curve", "s-curve"])
def test_curvature_and_frame_are_continuous_at_every_joint(segments: Callable, shape: str) -> None:
    track = Track.build(segments(300.0, shape=shape))
    joints = np.array([f.start for f in track.features()[1:]])
    tiny = 1e-7
    before, behind = joints - tiny, joints + tiny
    # slopes: curvature 1.5 / (R L) < 2e-4 / m2, roll and gauge below 0.01 / m
    assert np.abs(track.curvature(before) - track.curvature(behind)).max() < 2e-4 * 2.0 * tiny
    assert np.abs(track.heading(before) - track.heading(behind)).max() < 4e-3 * 2.0 * tiny
    assert np.abs(track.left_curve.roll(before)[0] - track.left_curve.roll(behind)[0]).max() < 0.01 * 2.0 * tiny
    assert np.abs(track.gauge(before) - track.gauge(behind)).max() < 0.01 * 2.0 * tiny
    for law in (track.left_curve, track.right_curve):
        (d0, dd0), (d1, dd1) = law.components(before), law.components(behind)
        assert np.abs(d0 - d1).max() < 0.02 * 2.0 * tiny  # curvature of the rail below 0.02 / m
        if shape == "clothoid":
            # the rounding makes the rail's curvature vector continuous as well; what is left is the jump of
            # kappa' d = 6e-5 / m2 seen at the angle of some mrad between rail and centre line
            bends = [
                dd - np.sum(dd * d, 1)[:, None] * d / np.sum(d * d, 1)[:, None] for d, dd in ((d0, dd0), (d1, dd1))
            ]
            assert np.abs(bends[0] - bends[1]).max() < 3e-7
    for side in ("left", "right"):
        path = getattr(track, side)
        s = track.rail_distance(side, joints)
        jump = np.abs(path.frame(s - tiny)[:, 1:] - path.frame(s + tiny)[:, 1:]).max()
        assert jump < 0.02 * 2.0 * tiny


def test_a_joint_without_transition_keeps_the_tangent_and_useless_ones_are_arcs() -> None:
    track = Track.build([Straight(10.0), Arc(20.0, 190.0), Transition(10.0), Straight(10.0)])
    assert (track.curvature([10.0 - 1e-9, 10.0 + 1e-9]) == [0.0, 1.0 / 190.0]).all()
    tangents = track.left.frame(10.0 + np.array([-1e-6, 1e-6]))[:, 1]
    assert np.abs(tangents[0] - tangents[1]).max() < 3e-6 / 190.0 * 2.0
    spread = np.abs(
        track.centre.position(np.linspace(9.0, 11.0, 200)) - track.centre_line.position(np.linspace(9.0, 11.0, 200))
    ).max()
    assert spread < 0.25**2 / 190.0 / 20.0  # the table blends the jump over one row distance
    with_ramp = Track.build([Arc(20.0, 200.0), Transition(30.0), Arc(20.0, 200.0)])
    arc = Track.build([Arc(70.0, 200.0)])
    assert np.abs(with_ramp.left.table - arc.left.table).max() < 1e-12
    track = Track.build([Transition(30.0), Arc(20.0, 200.0, 0.1), Transition(30.0)])
    ends = np.array([0.0, track.length])
    assert np.abs(track.curvature(ends)).max() == 0.0
    assert np.abs(track.cant(ends)).max() < 1e-15


def test_several_turns_are_followed_without_a_wrapped_angle() -> None:
    turns, radius = 3.25, 100.0
    track = Track.build(
        [Straight(20.0), Transition(30.0), Arc(2.0 * math.pi * radius * turns, radius), Straight(50.0)], heading=3.0
    )
    assert track.heading(track.length) == pytest.approx(3.0 + 30.0 / 200.0 + 2.0 * math.pi * turns, abs=1e-12)
    s = np.arange(0.5, track.left.length, 0.25)
    points = track.left.frame(s)
    wheel = points[:, 0] + 0.46 * points[:, 3] + 0.01 * points[:, 2]
    located = 0.0
    for k in range(len(s)):
        located = float(locate(track.left, wheel[k], located))
        assert abs(located - s[k]) < 1e-9
    steps = np.linalg.norm(np.diff(points[:, 1], axis=0), axis=1)
    # no tangent jumps anywhere, +-pi included; the blend of the arc's sudden end overshoots by 5 %
    assert steps.max() < 1.06 * 0.25 / (radius - 1.0)


def test_a_left_curve_has_its_right_rail_up_and_a_right_curve_its_left_rail() -> None:
    left, right = Track.build(curve(300.0)), Track.build(curve(-300.0))
    assert left.cant(110.0) == pytest.approx(0.1, abs=1e-15)
    assert right.cant(110.0) == pytest.approx(-0.1, abs=1e-15)
    assert left.left_curve.roll(110.0)[0] == pytest.approx(-math.asin(0.1 / 1.5), abs=1e-15)
    z = [t.right.position(110.0)[2] - t.left.position(110.0)[2] for t in (left, right)]
    # the rails are gauge + 10 mm apart; cant is measured over 1.5 m
    assert z == pytest.approx([0.1 * 1.445 / 1.5, -0.1 * 1.445 / 1.5], abs=1e-12)
    n = left.centre.frame(110.0)[2]
    assert n[2] < 0.0, "n points to the left and down into the curve"


@pytest.mark.parametrize("heading", [2.0, -40.0])
def test_a_turned_track_is_the_same_track(heading: float) -> None:
    start = (700.0, -300.0, 20.0)
    track, turned = Track.build(s_curve()), Track.build(s_curve(), heading=heading, start=start)
    c, d = math.cos(heading), math.sin(heading)
    turn = np.array([[c, -d, 0.0], [d, c, 0.0], [0.0, 0.0, 1.0]])
    for side in ("centre", "left", "right"):
        a, b = getattr(track, side).table, getattr(turned, side).table
        assert np.abs(a[:, 0:3] @ turn.T + start - b[:, 0:3]).max() < 2e-12  # coordinates up to 1000 m
        assert np.abs(a[:, 3:6] @ turn.T - b[:, 3:6]).max() < 1e-13
        assert np.abs(a[:, 8:11] @ turn.T - b[:, 8:11]).max() < 1e-13
        assert np.abs(a[:, 6:8] - b[:, 6:8]).max() < 1e-14


def test_cant_runs_as_the_curvature_of_its_transition() -> None:
    track = Track.build(curve(300.0, cant=0.12))
    s = np.linspace(28.0, 72.0, 2001)
    ramp = 0.12 * np.clip((s - 30.0) / 40.0, 0.0, 1.0)
    error = np.abs(track.cant(s) - ramp)
    near = (np.abs(s - 30.0) < 1.0) | (np.abs(s - 70.0) < 1.0)
    assert error[~near].max() < 1e-16
    assert error.max() == pytest.approx(3.0 / 16.0 * 0.12 / 40.0 * 1.0, rel=1e-2)  # at the joint: 0.56 mm
    assert np.abs(np.diff(track.left_curve.cant(s, 1))).max() < 0.75 * 0.12 / 40.0 * (s[1] - s[0]) * 1.01
    track = Track.build(curve(300.0, "bloss", cant=0.12))
    s = np.linspace(30.0, 70.0, 101)
    assert np.abs(track.cant(s) / 0.12 - track.curvature(s) * 300.0).max() < 1e-14


def test_the_cant_of_a_straight_belongs_to_the_curve_beside_it() -> None:
    track = Track.build(
        [Straight(40.0, cant_end=0.1), Arc(50.0, -400.0, 0.1), Straight(40.0, cant_start=0.1)], rounding=0.5
    )
    assert track.cant([20.0, 60.0, 110.0]) == pytest.approx([-0.05, -0.1, -0.05], abs=1e-15)
    between = [Arc(50.0, -400.0, 0.1), Straight(40.0, cant_start=0.1, cant_end=0.1), Arc(50.0, 400.0, 0.1)]
    assert Track.build(between).cant([60.0, 80.0]) == pytest.approx([-0.05, 0.05], abs=1e-15)
    bare = Track.build([Straight(40.0, 0.0, 0.1), Straight(10.0, 0.1, 0.1)])
    assert bare.cant(45.0) == pytest.approx(0.1)  # as in a left curve: right rail higher
    assert Track.build(mirrored(bare.segments)).cant(45.0) == pytest.approx(-0.1)


def test_gauge_widening_moves_each_rail_by_half() -> None:
    track = Track.build(curve(300.0, cant=0.0, widening=0.02), left_offset=(0.043, -0.001))
    assert track.gauge([0.0, 110.0]) == pytest.approx([GAUGE, GAUGE + 0.02], abs=1e-15)
    for s in (10.0, 50.0, 110.0):
        centre = track.centre.frame(s)
        left = track.left.position(track.rail_distance("left", s))
        right = track.right.position(track.rail_distance("right", s))
        offset_left, offset_right = (centre[1:] @ (p - centre[0]) for p in (left, right))
        half = 0.5 * track.gauge(s)
        assert offset_left == pytest.approx([0.0, half + 0.043, -0.001], abs=2e-9)
        assert offset_right == pytest.approx([0.0, -half, 0.0], abs=2e-9)  # table against the exact centre


@pytest.mark.parametrize("shape", SHAPES)
def test_level_rails_differ_in_length_by_spacing_times_heading(shape: str) -> None:
    """True for every level curve of constant gauge, whatever its transitions."""
    level = Track.build(curve(120.0, shape, cant=0.0, widening=0.0), gauge=1.0)
    turn = float(level.heading(level.length))
    assert level.right.length - level.left.length == pytest.approx(1.0 * turn, abs=1e-11)
    assert 0.5 * (level.right.length + level.left.length) == pytest.approx(level.length, abs=1e-11)
    canted = Track.build(curve(120.0, shape, cant=0.1, widening=0.0), gauge=1.0)
    assert 0.99 * turn < canted.right.length - canted.left.length < turn  # cos(roll): the rails are nearer


def test_rail_distance_and_centre_distance_are_inverse_and_table_rows_are_evenly_spaced() -> None:
    track = Track.build(s_curve(60.0))
    s = np.linspace(-5.0, track.length + 5.0, 500)
    for side in ("left", "right"):
        rail_distance = track.rail_distance(side, s)
        assert np.all(np.diff(rail_distance) > 0.0)
        assert np.abs(getattr(track, f"{side}_curve").distance(rail_distance) - s).max() < 1e-11
        path = getattr(track, side)
        assert path.length == pytest.approx(float(track.rail_distance(side, track.length)), abs=1e-12)
        assert np.abs(np.linalg.norm(path.table[:, 3:6], axis=1) - 1.0).max() < 1e-15
        chord = np.linalg.norm(np.diff(path.table[:, 0:3], axis=0), axis=1)
        # chord = h (1 - (kappa h)^2 / 24): the tightest place has a radius of 59 m
        assert chord.min() > path.step * (1.0 - (path.step / 59.0) ** 2 / 23.0)
        assert chord.max() < path.step * (1.0 + 1e-12)


@pytest.mark.parametrize("radius, length", [(25.0, 15.0), (60.0, 20.0), (300.0, 40.0), (5000.0, 120.0)])
@pytest.mark.parametrize("shape", SHAPES)
def test_quarter_metre_tables_follow_the_exact_rails_within_a_micrometre(radius: float, length: float, shape: str):
    """Largest errors sit in the rows beside joints, where the slope of curvature and roll jumps."""
    track = Track.build(curve(radius, shape, cant=min(0.1, 0.004 * length), length=length))
    for curve_, path in ((track.left_curve, track.left), (track.right_curve, track.right)):
        fine = curve_.path(path.step / 8.0)
        frame = path.frame(np.arange(fine.table.shape[0]) * fine.step)
        assert np.abs(frame[:, 0] - fine.table[:, 0:3]).max() < 1e-6
        assert np.abs(frame[:, 1] - fine.table[:, 3:6]).max() < 1.5e-5


@pytest.mark.parametrize("segments, messages", table("a_wrong_segment_is_named"))
def test_a_wrong_segment_is_named_with_its_number_key_value_and_what_is_allowed(segments: list, messages: list[str]):
    kinds = {"straight": Straight, "transition": Transition, "arc": Arc}
    with pytest.raises(InputError) as error:
        Track.build([kinds[entry[0]](*entry[1:]) if isinstance(entry, list) else entry for entry in segments])
    for word in messages:
        assert word in str(error.value)


@pytest.mark.parametrize("arguments, message", table("a_wrong_property_of_the_track_is_named"))
def test_a_wrong_property_of_the_track_is_named(arguments: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Track.build([Straight(10.0)], **arguments)


# A fixed crossing from a few numbers: its sections are wing and nose, and its nose grows to the plain rail.

FILE = Path(__file__).parents[2] / "models" / "crossings" / "60E1_1in9.toml"


def changed(folder, *pairs):
    text = FILE.read_text()
    for key, value in pairs:
        line = next(row for row in text.splitlines() if row.startswith(f"{key} ="))
        text = text.replace(line, f"{key} = {value}")
    path = folder / "crossing.toml"
    path.write_text(text)
    return path


def section_at(sections, distance):
    return min(sections, key=lambda section: abs(section.distance - distance))


def marks(section):
    """Places of the features (2, 7) [mm]."""
    return 1e3 * np.array(section.profile.at(np.array(section.features)))


@pytest.fixture(scope="module")
def sections():
    return read_crossing(FILE)


def test_before_and_behind_the_crossing_the_rail_is_plain():
    inclination = 1 / 40
    rail = load_profile("rails/60E1.toml").inclined(inclination)
    sections = read_crossing(FILE, inclination)
    for section in (sections[0], sections[-1]):
        arc = np.linspace(0.0, rail.length, 300)
        np.testing.assert_allclose(section.profile.at(arc), rail.at(arc), atol=2e-9)


def test_the_nose_is_as_wide_as_its_angle_says_and_the_flangeway_stays(sections):
    for section in sections:
        if not 0.13 < section.distance < 0.64:
            continue
        # flanks lie in the planes of the plain rail's: where its corner ends they are apart by the width
        (u, w), level = marks(section), marks(sections[-1])[1][0]
        lean = (w[[0, 2]] - level) / 20.0
        assert u[2] + lean[1] - u[0] + lean[0] == pytest.approx(1e3 * section.distance / 9.0, abs=1e-6)
        assert u[4] - u[2] - lean[1] == pytest.approx(44.0, abs=1e-6)
        assert u[0] - lean[0] == pytest.approx(marks(sections[-1])[0][0], abs=1e-6)


def test_a_nose_has_the_corners_the_crown_and_the_height_of_its_file(tmp_path):
    path = changed(tmp_path, ("crown_radius_mm", 30))
    for section in read_crossing(path):
        width = 1e3 * section.distance / 9.0
        if not 14.0 <= width < 71.0:
            continue
        profile, (corner, crown, *_) = section.profile, section.features
        share = min((width - 14.0) / 36.0, 1.0)
        lowered = (0.9 - share if share < 0.8 else 2.5 * (1.0 - share) ** 2) / 0.9
        assert 1e3 * profile.at(crown)[1] == pytest.approx(-3.5 * lowered, abs=1e-6)
        assert 1e3 / abs(float(profile.curvature(corner + 1e-6))) == pytest.approx(6.0 + 7.0 * share, rel=1e-6)
        radius = 1e3 / abs(float(profile.curvature(crown)))
        assert radius < 30.0 if width < 30.0 else radius <= 30.0 * (1.0 + 1e-9)
        if width > 40.0:
            assert radius == pytest.approx(30.0, rel=1e-9)


def test_the_nose_rises_without_steps_and_alike_for_a_trailing_wheel(sections):
    rows, starts = RailSurface("crossing", tuple(sections)).rows(np.arange(0.14, 0.7, 2e-3))
    nose = rows[:, : starts[1], 1].max(axis=1)
    slopes = np.diff(nose) / 2e-3
    assert slopes.min() > -1e-3
    assert slopes.max() < 1.05 * 3.5 / (36.0 * 9.0) / 0.9
    assert nose[-1] == pytest.approx(0.0, abs=1e-6)
    for facing, trailing in zip(sections, reversed(read_crossing(FILE, trailing=True)), strict=True):
        assert facing.distance == -trailing.distance
        assert facing.features == trailing.features


@pytest.mark.parametrize(("key", "value", "message"), table("wrong_crossings_are_refused"))  # fmt: skip
def test_wrong_crossings_are_refused(tmp_path, key, value, message):
    path = changed(tmp_path, (key, value))
    with pytest.raises(InputError) as error:
        read_crossing(path)
    assert message in str(error.value)
    assert str(path) in str(error.value)


def test_a_head_whose_arcs_do_not_meet_is_refused(tmp_path):
    head = (FILE.parents[1] / "rails" / "60E1.toml").read_text().replace("10.228, 26.0265", "10.228, 99.0")
    (tmp_path / "head.toml").write_text(head)
    with pytest.raises(InputError) as error:
        read_crossing(changed(tmp_path, ("rail", '"head.toml"')))
    assert "rail = \"head.toml\": profile '60E1': the arc of radius 80 mm has no room" in str(error.value)
