"""Files of points: round trips, orientations, and files that are refused with the line of the fault."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.contacts import bench, contact_model, rail_profile, settle, wheel_profile
from support.examples import examples
from support.rows import DATA, rows_of

from wrsim import InputError, Profile, load_profile
from wrsim.contact.profiles.files import read_points
from wrsim.contact.profiles.points import CUTOFF, ProfilePoints, smoothed, smoothing_spline
from wrsim.contact.profiles.sections import circle, cone
from wrsim.inputs.file_kinds import resolved

table = rows_of(__file__)

MODELS = Path(__file__).parents[2] / "models"
WHEEL = load_profile(MODELS / "wheels/S1002.toml")
RAIL = load_profile(MODELS / "rails/60E1.toml")


def distance(a: Profile, b: Profile) -> float:
    """Largest distance of points at equal parts of the length, m."""
    parts = np.linspace(0.0, 1.0, 20_001)
    return float(np.hypot(*np.subtract(a.at(parts * a.length), b.at(parts * b.length))).max())


def rows(profile: Profile, u: float = 1e3, w: float = 1e3, order: int = 1, between: str = " ") -> str:
    """Text of the profile's nodes, scaled."""
    pairs = list(zip(u * profile.u, w * profile.w, strict=True))[::order]
    return "".join(f"{a:.12f}{between}{b:.12f}\n" for a, b in pairs)


SHAPES = [
    WHEEL,
    RAIL,
    RAIL.inclined(1 / 20),
    WHEEL.shifted(0.001, -float(WHEEL.at(WHEEL.arclength_of(-0.001))[1])),
    cone("cone", "wheel", 0.05, -0.04, 0.06),
    circle("crown", "rail", 0.3, 0.035),
]

WRITTEN = {
    "columns": ("# name: {0.name}\n# kind: {0.kind}\n# source: {0.source}\nu_mm,w_mm\n{1}", 1e3, ","),
    "simpack": (
        "header.begin\n  type = {2}  ! 0 = rail\nheader.end\nspline.begin\n  comment = '{0.name}'\n"
        "  units.len.f = 1000.0\n  point.begin\n{1}  point.end\nspline.end\n", -1e3, "  ",
    ),
    "miniprof": ("ProgramName=wrsim\nID={0.name}\nColumnDef=X,Y\nXOffset=0.0\n\n{1}", 1e3, "\t"),
}  # fmt: skip
SUFFIXES = {"columns": (".csv", ".csv"), "simpack": (".prr", ".prw"), "miniprof": (".ban", ".whl")}


@pytest.mark.parametrize("format", WRITTEN)
@pytest.mark.parametrize("profile", SHAPES, ids=lambda p: p.name)
def test_a_profile_that_is_read_is_the_one_written_to_a_nanometre(profile, format, write):
    text, up, between = WRITTEN[format]
    is_wheel = profile.kind == "wheel"
    name = "profile" + SUFFIXES[format][is_wheel]
    back = read_points(write(text.format(profile, rows(profile, w=up, between=between), int(is_wheel)), name)).profile
    named = Path(name).stem if format == "simpack" else profile.name  # a comment is no name: the file's is
    assert (back.name, back.kind) == (named, profile.kind)
    assert distance(back, profile) < 1e-9
    source = {"columns": profile.source or name, "simpack": profile.name, "miniprof": name}[format]
    assert back.source == source
    # direction too, which contact needs: away from joins curvature comes back
    L = np.linspace(0.0, profile.length, 2001)
    np.testing.assert_allclose(back.tangent(L * back.length / profile.length), profile.tangent(L), atol=1e-4)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("heights", ["up", "down"])
@pytest.mark.parametrize("side", ["positive", "negative"])
def test_any_orientation_and_order_of_a_wheel_is_recognised_by_its_flange(write, order, heights, side):
    text = rows(WHEEL, 1e3 if side == "positive" else -1e3, 1e3 if heights == "up" else -1e3, order)
    path = write(text)
    assert distance(read_points(path, "wheel").profile, WHEEL) < 1e-9
    assert distance(read_points(path, "wheel", heights=heights, field_side=side).profile, WHEEL) < 1e-9


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("heights", ["up", "down"])
def test_a_rail_upside_down_is_recognised_by_its_head(write, order, heights):
    inclined = RAIL.inclined(1 / 20)
    path = write(rows(inclined, 1e3, 1e3 if heights == "up" else -1e3, order))
    assert distance(read_points(path, "rail").profile, inclined) < 1e-9


def test_an_inclination_shows_the_field_side_of_a_rail_and_turning_undoes_an_inclination(write):
    inclined = RAIL.inclined(1 / 20)
    path = write(rows(inclined, -1e3))
    assert distance(read_points(path, "rail", field_side="negative").profile, inclined) < 1e-9
    assert distance(read_points(path, "rail", field_side="positive").profile, inclined.mirrored()) < 1e-9
    told = read_points(path, "rail").profile
    assert distance(told, inclined) < 1e-9 and "gauge side by its inclination of 1:20" in told.notes[0]
    path = write(rows(RAIL.inclined(1 / 40)))
    assert distance(read_points(path, "rail", turn=-np.arctan(1 / 40)).profile, RAIL) < 1e-9


@pytest.mark.parametrize(("unit", "factor"), [("m", 1.0), ("mm", 1e3), ("in", 1 / 0.0254)])
def test_units_come_from_the_caller_or_the_header(write, unit, factor):
    text = rows(RAIL, factor, factor, between=",")
    assert distance(read_points(write(text), "rail", unit=unit).profile, RAIL) < 1e-9
    assert distance(read_points(write(f"y_{unit},z_{unit}\n" + text), "rail").profile, RAIL) < 1e-9


def test_columns_may_be_separated_as_spreadsheets_do_and_digits_spoil_no_curvature(write):
    comma_decimals = rows(RAIL, between=";").replace(".", ",")
    for text in (rows(RAIL, between="\t"), rows(RAIL, between=", "), comma_decimals):
        assert distance(read_points(write("% a comment\n\n" + text), "rail").profile, RAIL) < 1e-9
    # Nodes as near as 5 um, written to 1e-6 mm: a spline through all of them would have curvatures off by 50 1/m.
    text = "".join(f"{1e3 * u:.6f} {1e3 * w:.6f}\n" for u, w in zip(RAIL.u, RAIL.w, strict=True))
    profile = read_points(write(text), "rail").profile
    u = np.linspace(-0.009, 0.009, 501)  # the crown, 300 mm
    np.testing.assert_allclose(profile.curvature(profile.arclength_of(u)), -1 / 0.3, atol=1.0)


def simpack(points: str, keys: str = "", kind: int = 1) -> str:
    """A SIMPACK profile with the comments and the alignment that such files have."""
    return (DATA / "simpack.txt.in").read_text().format(points=points, keys=keys, kind=kind)


def test_simpack_keys_do_what_their_comments_say(write):
    # Written mirrored, in inches, shifted, from the other end, with a weight column and a bound.
    y, z = -(WHEEL.u / 0.0254) - 2.0, -(WHEEL.w / 0.0254) + 1.0
    keep = slice(None, None, -1)
    points = "\n".join(f"{a:.15E} {b:.15E} 1.0" for a, b in zip(y[keep], z[keep], strict=True))
    keys = "\n".join(table("simpack_keys"))
    profile = read_points(write(simpack(points, keys), "w.prw")).profile
    # 2.75 inches = 69.85 mm: the bound takes the last 0.15 mm of the flange's back
    assert profile.u[0] == pytest.approx(-0.06985, abs=1e-4)
    u = np.linspace(-0.05, 0.055, 501)
    w, true = profile.at(profile.arclength_of(u))[1], WHEEL.at(WHEEL.arclength_of(u))[1]
    np.testing.assert_allclose(w, true, atol=1e-9)


@pytest.mark.parametrize(("change", "message"), table("simpack_files_with_faults_are_refused"))
def test_simpack_files_with_faults_are_refused(write, change, message):
    text = simpack(rows(WHEEL, 1e3, -1e3), "    units.len.f = 1000")
    assert change[0] in text
    with pytest.raises(InputError, match=message):
        read_points(write(text.replace(*change), "w.prw"), "wheel")


def miniprof(points: str, keys: str = "") -> str:
    """A MiniProf measurement: head, an empty line, rows."""
    return f"ProgramName=MiniProf\nDate=31-01-2026\nFlangeWidth=32,5\n{keys}\n\n{points}"


def test_miniprof_measurements_are_smoothed_and_put_upright(write):
    noise = 2e-3 * np.random.default_rng(1).normal(size=(1500, 2))  # mm
    table, _ = WHEEL.table(WHEEL.length / 1499.5)
    points = np.column_stack([1e3 * table[:, 0] - 10.0, -1e3 * table[:, 1] + 5.0])[: len(noise)] + noise
    text = "".join(f"{x:.4f}\t{y:.4f}\t0.0\n" for x, y in points)
    keys = f"XYPoints={len(points)}\nColumnDef=X,Y,A\nXOffset=10.0\nYOffset=-5.0"
    profile = read_points(write(miniprof(text, keys), "left.whl")).profile
    assert "smoothed, cut-off 5 mm" in profile.source
    u = np.linspace(-0.020, 0.050, 501)
    w, true = profile.at(profile.arclength_of(u))[1], WHEEL.at(WHEEL.arclength_of(u))[1]
    np.testing.assert_allclose(w, true, atol=3e-6)


def test_a_miniprof_rail_of_the_old_kind_is_read(write):
    points = rows(RAIL, 1e3, 1e3)
    profile = read_points(write("Rail\nLeft\n\n" + points, "r.ban"), measured=False).profile
    assert distance(profile, RAIL) < 1e-9


@pytest.mark.parametrize(("keys", "message"), table("miniprof_files_with_faults_are_refused"))
def test_miniprof_files_with_faults_are_refused(write, keys, message):
    with pytest.raises(InputError, match=message):
        read_points(write(miniprof(rows(WHEEL), keys), "w.whl"))


BAD = table("bad")


@pytest.mark.parametrize(("text", "message"), BAD, ids=range(len(BAD)))
def test_points_that_are_no_profile_are_refused_with_their_line(write, text, message):
    with pytest.raises(InputError, match=message):
        read_points(write(text), "rail", measured=False if "scatter" in message else None)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": None}, r"unknown whether this is a wheel or a rail"),
        ({"kind": "weel"}, r"kind = 'weel'; allowed: wheel, rail \(did you mean 'wheel'\?\)"),
        ({"heights": "down"}, r"the flange points the wrong way up with heights 'down'"),
        ({"field_side": "negative"}, r"the flange is on the field side with field_side 'negative'"),
        ({"clip": (0.1, 0.2)}, r"clip from 100 to 200 mm leaves no point; the points go from -70 to 60 mm"),
    ],
)  # fmt: skip
def test_options_that_cannot_be_are_answered_with_what_is_allowed(write, options, message):
    with pytest.raises(InputError, match=message):
        read_points(write(rows(WHEEL)), **{"kind": "wheel", **options})


def test_files_and_points_that_cannot_be_read_or_smoothed_are_refused(tmp_path):
    (tmp_path / "wheel.csv").write_bytes(b"\x00\x01\x02")
    with pytest.raises(InputError, match=r"whele.csv: no such profile file; did you mean '.*wheel.csv'\?"):
        read_points(tmp_path / "whele.csv", "wheel")
    with pytest.raises(InputError, match="not a text file"):
        read_points(tmp_path / "wheel.csv", "wheel")
    with pytest.raises(InputError, match="is a directory, a profile file is needed"):
        read_points(tmp_path, "wheel", format="columns")
    with pytest.raises(InputError, match=r"no profile format has the suffix '.stl'; allowed: .csv, .txt"):
        read_points(tmp_path / "wheel.stl", "wheel")
    place = tmp_path / "rail.toml"
    place.write_text('name = "r"\nbody = "rail"\nkind = "points"\ndate = 2026-01-01\nsource = "s"\nfile = "rail.c[v"\n')
    with pytest.raises(
        InputError, match=r"rail.toml:6: file = .*no profile format has the suffix '.c\[v'.*name the format"
    ):
        load_profile(place)
    u = np.linspace(-0.03, 0.03, 21)
    with pytest.raises(InputError, match=r"measured.csv:2: 3.005 mm from .* line 1; .*at most 2.5 mm apart"):
        smoothed(points(u, -(u**2)), "coarse", "rail")


# Profile files in TOML: the standard profiles against published numbers, the kinds, and slips of the pen.

ALL = sorted(p for folder in ("wheels", "rails") for p in (MODELS / folder).glob("*.toml"))


@pytest.fixture
def toml(tmp_path):
    """Write a TOML profile file with the usual head; returns its path."""

    def write(text: str, head: str = "") -> Path:
        path = tmp_path / "profile.toml"
        head = head or 'name = "test"\nbody = "wheel"\ndate = 2026-01-31\nsource = "made up"\n'
        path.write_text(head + text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("path", ALL, ids=lambda p: p.stem)
def test_every_shipped_profile_loads_and_names_its_source(path):
    profile = load_profile(path)
    assert profile.source and profile.name
    assert profile.kind == path.parent.name.removesuffix("s")


S1002_FORMULAS = table("s1002_formulas")


@pytest.mark.parametrize(("first", "last", "formula"), S1002_FORMULAS, ids="ABCDEFGH")
def test_s1002_follows_the_formulas_of_its_standard(first, last, formula):
    wheel = load_profile(MODELS / "wheels/S1002.toml")
    u = np.linspace(first, last, 501)
    L = wheel.arclength_of(1e-3 * u)
    down = eval(formula, {"u": u})
    across = (-down - 1e3 * wheel.at(L)[1]) * wheel.tangent(L)[0]  # mm, at right angles to the curve
    # The rounded formulas disagree by 1.2e-4 mm at u = -35; half of that goes to either side, faded over 2 mm.
    assert np.abs(across).max() < 6e-5
    assert np.abs(across[(u > first + 2.1) & (u < last - 2.1)]).max(initial=0.0) < 1e-9


@pytest.mark.parametrize(
    ("rail", "half_width", "depth"), [("60E1", 36.0, 14.3), ("54E1", 35.0, 14.1)], ids=["60E1", "54E1"]
)
def test_rail_heads_are_as_wide_as_the_standard_says(rail, half_width, depth):
    # EN 13674-1 rounds to 0.1 mm, the tangent arcs meet it within 1e-3 mm.
    profile = load_profile(MODELS / f"rails/{rail}.toml")
    assert 1e3 * profile.gauge_point(1e-3 * depth)[0] == pytest.approx(-half_width, abs=1e-3)
    assert profile.top == pytest.approx((0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize(("rail", "slope", "distance"), table("top_and_gauge_point_are_as_far_apart_as_published"))
def test_top_and_gauge_point_are_as_far_apart_as_published(rail, slope, distance):
    # The published numbers take the highest of points 0.1 mm apart for the top: good to 4 um.
    profile = load_profile(MODELS / f"rails/{rail}.toml").inclined(slope)
    assert 1e3 * (profile.top[0] - profile.gauge_point()[0]) == pytest.approx(distance, abs=5e-3)


@pytest.mark.parametrize(
    ("rail", "slope", "lateral", "vertical"),
    [
        ("60E1", 1 / 40, 753.034723, 0.093706),
        ("60E1", 1 / 20, 752.512325, 0.346635),
        ("54E1", 1 / 20, 751.569140, 0.344065),
    ],
)
def test_rail_origins_on_standard_gauge_agree_with_contact(rail, slope, lateral, vertical):
    # Origins that CONTACT 25.2 found for these profiles on 1435 mm gauge (heights down); it takes the highest
    # sampled point as the top, which is good to 1e-4 mm.
    profile = load_profile(MODELS / f"rails/{rail}.toml").inclined(slope)
    assert 1435.0 / 2 - 1e3 * profile.gauge_point()[0] == pytest.approx(lateral, abs=1e-4)
    assert -1e3 * profile.top[1] == pytest.approx(-vertical, abs=1e-4)


@pytest.mark.parametrize(
    ("rail", "points"),
    [
        ("60E1", [(10.228, 0.174404, 300, 80), (26.0265, 2.302524, 80, 13), (35.9998, 14.29996, 13, np.inf)]),
        ("54E1", [(10.012, 0.167113, 300, 80), (24.8635, 2.064868, 80, 13), (35.0001, 14.1001, 13, np.inf)]),
    ],
)
def test_rail_arcs_meet_where_published(rail, points):
    profile = load_profile(MODELS / f"rails/{rail}.toml")
    for u, down, inner, outer in points:
        i = int(np.argmin(np.hypot(1e3 * profile.u - u, 1e3 * profile.w + down)))
        # 1e-3 mm across, but the end of the 13 mm arc is nearly vertical and known to 1e-4 mm in u
        assert (1e3 * profile.u[i], -1e3 * profile.w[i]) == pytest.approx((u, down), abs=1.5e-3)
        assert -1e-3 * profile.curvature_before[i] == pytest.approx(1 / inner, rel=1e-9)
        assert -1e-3 * profile.curvature_after[i] == pytest.approx(1 / outer, rel=1e-9, abs=1e-12)


def test_a_chain_of_tangent_pieces_passes_the_tape_circle(toml):
    profile = load_profile(
        toml("""
kind = "chain"
start_mm = -45.0
start_angle_deg = 70.0
pieces = [
    {shape = "line", length_mm = 5.0},
    {shape = "arc", radius_mm = 14.0, to_angle_deg = 2.862405226},
    {shape = "line", length_mm = 80.0},
]
""")
    )
    assert float(profile.at(profile.arclength_of(0.0))[1]) == pytest.approx(0.0, abs=1e-15)
    assert profile.length == pytest.approx(0.085 + 0.014 * np.radians(70.0 - 2.862405226), rel=1e-12)
    assert profile.curvature(0.010) == pytest.approx(-1 / 0.014, rel=1e-6)
    assert np.tan(profile.angle[-1]) == pytest.approx(0.05, abs=1e-8)


def test_sections_may_be_lines_too(toml):
    profile = load_profile(
        toml("""
kind = "sections"
[[sections]]
shape = "line"
start_mm = [40.0, 2.0]
end_mm = [0.0, 0.0]
[[sections]]
shape = "polynomial"
from_mm = -10.0
to_mm = 0.0
coefficients_mm = [0.0, 0.05, -0.001]
""")
    )
    assert profile.at(profile.arclength_of([-0.01, 0.04]))[1] == pytest.approx([-0.6e-3, 2e-3], abs=1e-12)


def test_points_beside_a_file_are_read_as_it_says(toml, tmp_path):
    rail = load_profile(MODELS / "rails/60E1.toml")
    rows = "".join(f"{-1e3 * u:.9f};{1e3 * w + 3.0:.9f}\n" for u, w in zip(rail.u, rail.w, strict=True))
    (tmp_path / "points.txt").write_text(rows.replace(".", ","), encoding="utf-8")
    head = 'name = "r"\nbody = "rail"\ndate = 2026-01-31\nsource = "made up"\n'
    profile = load_profile(
        toml(
            'kind = "points"\nfile = "points.txt"\nfield_side = "negative"\nclip_mm = [-30.0, 30.0]\n'
            "shift_mm = [0.0, -3.0]\n",
            head,
        )
    )
    L = np.linspace(0.0, profile.length, 2001)
    u, w = profile.at(L)
    np.testing.assert_allclose(w, rail.at(rail.arclength_of(u))[1], atol=1e-9)
    assert -0.03 <= u[0] < -0.0299 and 0.0299 < u[-1] <= 0.03


SLIPS = table("slips")  # fmt: skip


@pytest.mark.parametrize(("text", "message"), SLIPS)
def test_slips_are_answered_with_file_key_and_what_is_allowed(toml, text, message):
    with pytest.raises(InputError, match=message) as caught:
        load_profile(toml(text))
    assert "profile.toml" in str(caught.value) or "none.csv" in str(caught.value)


def test_all_faults_of_a_file_are_told_at_once(toml):
    with pytest.raises(InputError) as caught:
        load_profile(toml('kind = "cone"\nconicity = 7\nfrom_mm = true\n', 'name = ""\nbody = "axle"\n'))
    text = str(caught.value)
    for key in ("name", "body", "date", "source", "conicity", "from_mm", "to_mm"):
        assert key in text


@pytest.mark.parametrize("half_width", ["0.001", "2.4"])
def test_a_profile_that_is_too_short_for_any_contact_is_refused(toml, half_width):
    path = toml(f'kind = "circle"\nradius_mm = 10\nhalf_width_mm = {half_width}\n')
    with pytest.raises(InputError, match="mm long; needs at least 5 mm"):
        load_profile(path)


# Measured profiles from the file to the contact: noise, smoothing, what the report says of it, and garbage.
NOISE = 10e-6  # of every coordinate, standard deviation [m]
SCANS = Path(__file__).parents[2] / "scenarios/measured"


def measured(profile: Profile, step: float, seed: int) -> np.ndarray:
    """Points (n, 2) [mm] of a profile, resampled and with noise, as a device writes them: to 0.1 um."""
    rows, _ = profile.table(step)
    return 1e3 * (rows[:, :2] + NOISE * np.random.default_rng(seed).normal(size=(len(rows), 2)))


@pytest.fixture(scope="module")
def files():
    """The shipped scans: the worn wheel as a MiniProf file, the worn rail in two columns, points 0.11 mm apart."""
    return SCANS / "wheel.whl", SCANS / "rail.csv"


# y [mm] of: field side of the hollow, its gauge side, worn root in the worn corner, flank, and beyond
SHIFTS = (-5.0, -4.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0)


def contacts(wheel: Profile, rail: Profile) -> np.ndarray:
    """p0, area, N and contact angle at 60 kN over the shifts."""
    stand = bench(contact_model(wheel, rail))
    rows = []
    for shift in SHIFTS:
        solved, contact = settle(stand, 1e-3 * shift, 0.0, 60e3)
        assert not solved.message
        p = contact.patches
        rows.append((p["p0"].max(), p["area"].sum(), p["N"].sum(), p["angle"][0]))
    return np.array(rows)


def test_a_noisy_worn_pair_gives_the_contact_of_the_exact_one_within_a_few_per_cent(files):
    exact = contacts(wheel_profile("worn"), rail_profile("worn", 40))
    wheel = read_points(files[0]).profile
    rail = read_points(files[1], "rail", measured=True).profile.inclined(1 / 40)
    smoothed = contacts(wheel, rail)
    p0, area, force = np.abs(smoothed / exact - 1.0)[:, :3].T
    # curvature is what noise spoils: pressures follow it. Measured over 6 seeds: median 3.5 %, 95 % 9.6 %
    assert np.median(p0) < 0.05 and p0.max() < 0.13
    assert np.median(area) < 0.045 and area.max() < 0.13
    assert force.max() < 0.01
    assert np.abs(smoothed[:, 3] - exact[:, 3]).max() < np.radians(1.0)


SCAN = "".join(f"{u:.4f} {w:.4f}\n" for u, w in measured(load_profile(MODELS / "rails/60E1.toml"), 5e-4, 3))
LINES = SCAN.splitlines(keepends=True)

cuts = st.tuples(st.just("cut"), st.integers(0, len(SCAN)), st.integers(0, len(SCAN)))
swaps = st.tuples(st.just("swap"), st.integers(0, len(LINES) - 1), st.integers(0, len(LINES) - 1))
insertions = st.tuples(st.just("word"), st.integers(0, len(LINES)), st.text(max_size=12))
values = st.tuples(st.just("value"), st.integers(0, len(LINES) - 1), st.floats(allow_nan=True))


@settings(max_examples=examples(50), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(slips=st.lists(cuts | swaps | insertions | values, min_size=1, max_size=3), measure=st.booleans())
def test_a_spoiled_scan_is_read_or_refused_with_its_file(tmp_path, slips, measure):
    text = SCAN
    for slip, a, b in slips:
        rows = text.splitlines(keepends=True)
        if slip == "cut":
            text = text[: min(a, b)] + text[max(a, b) :]
        elif slip == "swap" and max(a, b) < len(rows):
            rows[a], rows[b] = rows[b], rows[a]
            text = "".join(rows)
        elif slip == "word":
            rows.insert(min(a, len(rows)), f"{b}\n")
            text = "".join(rows)
        elif slip == "value" and a < len(rows):
            rows[a] = f"{b} {rows[a].split()[0] if rows[a].split() else 0}\n"
            text = "".join(rows)
    path = tmp_path / "scan.csv"
    path.write_text(text, encoding="utf-8", errors="replace")
    try:
        profile = read_points(path, "rail", measured=measure).profile
    except InputError as error:
        assert str(path) in str(error)
        return
    assert np.isfinite(profile.curvature_after).all()
    assert 0.005 <= profile.length <= 1.0


@settings(max_examples=examples(40), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=300), suffix=st.sampled_from([".csv", ".prr", ".prw", ".ban", ".whl", ".toml"]))
def test_any_bytes_are_refused_with_their_file(tmp_path, data, suffix):
    path = tmp_path / f"garbage{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError, match="garbage"):
        load_profile(path, "wheel" if suffix in (".csv", ".prw", ".whl", ".toml") else "rail")


# Laws of smoothing: its frequency response, what it keeps, what it removes.
S1002 = load_profile(Path(__file__).parents[2] / "models/wheels/S1002.toml")


def points(u: np.ndarray, w: np.ndarray) -> ProfilePoints:
    """Points as if read from a file, one a line."""
    return ProfilePoints("measured.csv", u, w, np.arange(1, u.size + 1))


def scanned(profile: Profile, noise: float, step: float = 1e-4, seed: int = 1) -> ProfilePoints:
    """Points of a profile with independent noise across and along it."""
    rows, _ = profile.table(step)
    shift = noise * np.random.default_rng(seed).normal(size=(len(rows), 2))
    return points(rows[:, 0] + shift[:, 0], rows[:, 1] + shift[:, 1])


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0, 4.0])
def test_a_wave_passes_with_the_stated_amplitude(ratio):
    # Steel ruler of 150 mm with a wave of 2 um; far from the ends the response is the docstring's.
    wave = ratio * CUTOFF
    u = np.arange(0.0, 0.15, 1e-4)
    profile = smoothed(points(u, 2e-6 * np.sin(2 * np.pi * u / wave)), "ruler", "rail")
    inner = np.linspace(0.04, 0.11, 3001)
    w = profile.at(profile.arclength_of(inner))[1]
    basis = np.column_stack([np.sin(2 * np.pi * inner / wave), np.cos(2 * np.pi * inner / wave)])
    (amplitude, shift), *_ = np.linalg.lstsq(basis, w, rcond=None)
    assert amplitude / 2e-6 == pytest.approx(1.0 / (1.0 + (1.0 / ratio) ** 6), abs=2e-3)
    assert shift / 2e-6 == pytest.approx(0.0, abs=2e-3)  # nothing moves sideways


@settings(max_examples=examples(20), deadline=None)
@given(coefficients=st.tuples(*[st.floats(-1.0, 1.0)] * 3), cutoff=st.floats(1e-3, 0.1), seed=st.integers(0, 100))
def test_parabolas_pass_unchanged_to_their_very_ends(coefficients, cutoff, seed):
    s = np.sort(np.random.default_rng(seed).uniform(0.0, 0.1, 400))
    p = np.polynomial.polynomial.polyval(s, coefficients)
    np.testing.assert_allclose(smoothing_spline(s, p[:, None], cutoff)(s)[:, 0], p, atol=1e-9)


def test_curvature_of_a_noisy_wheel_is_that_of_its_shape():
    profile = smoothed(scanned(S1002, 5e-6), "S1002", "wheel")
    tread = np.linspace(-0.015, 0.050, 1001)
    true = S1002.curvature(S1002.arclength_of(tread))
    error = np.std(profile.curvature(profile.arclength_of(tread)) - true)
    assert error < 1.5  # 1/m; a spline through all points is a thousand times as far off


def test_smoothing_keeps_the_shape():
    profile = smoothed(scanned(S1002, 5e-6), "S1002", "wheel")
    for u, most in ((np.linspace(-0.020, 0.055, 501), 4e-6), (np.linspace(-0.060, 0.055, 501), 10e-6)):
        L = profile.arclength_of(u)
        (mu, mw), (tu, tw) = profile.at(L), S1002.normal(S1002.arclength_of(u))
        across = (mu - u) * tu + (mw - S1002.at(S1002.arclength_of(u))[1]) * tw
        # 4 um on the tread: what is left of 5 um of noise. 10 um at the flange, whose arcs of 13 and 20 mm are
        # separated by a straight of 4 mm only: jumps of curvature are spread over the cut-off of 5 mm.
        assert np.abs(across).max() < most


def test_a_file_of_another_kind_is_refused_where_the_contact_is_alone(write, monkeypatch):
    """Rooms whose packages are not installed know no keys: the error is one, and still about the file."""

    def absent(name):
        if "wrsim.contact." not in name:
            raise ModuleNotFoundError(name)
        return resolved(name)

    monkeypatch.setattr("wrsim.inputs.checking.resolved", absent)
    with pytest.raises(InputError, match=r"scenario.toml: kind is missing: must be \"sections\""):
        load_profile(write('analysis = "curving"\n[vehicle]\n[track]\n[run]\n', "scenario.toml"))
