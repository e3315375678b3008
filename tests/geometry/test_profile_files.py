"""Files of points: round trips, orientations, and files that are refused with the line of the fault."""

from pathlib import Path

import numpy as np
import pytest
from support.rows import rows_of
from support.scenario_texts import DATA

from wrsim.errors import InputError
from wrsim.geometry.profile.files import read_points
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.sections import circle, cone

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


@pytest.fixture
def write(tmp_path):
    """Write a text file; returns its path."""

    def writer(text: str, name: str = "points.csv") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return writer


# --- there and back -----------------------------------------------------------------------------------

SHAPES = [
    WHEEL,
    RAIL,
    RAIL.inclined(1 / 20),
    WHEEL.shifted(0.001, -0.002),
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
    back = read_points(write(text.format(profile, rows(profile, w=up, between=between), int(is_wheel)), name)).profile()
    assert (back.name, back.kind) == (profile.name, profile.kind)
    assert distance(back, profile) < 1e-9
    assert back.source == (profile.source if format == "columns" and profile.source else name)
    # direction too, which contact needs: away from joins curvature comes back
    L = np.linspace(0.0, profile.length, 2001)
    np.testing.assert_allclose(back.tangent(L * back.length / profile.length), profile.tangent(L), atol=1e-4)


# --- orientation, order, unit -------------------------------------------------------------------------
@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("heights", ["up", "down"])
@pytest.mark.parametrize("side", ["positive", "negative"])
def test_any_orientation_and_order_of_a_wheel_is_recognised_by_its_flange(write, order, heights, side):
    text = rows(WHEEL, 1e3 if side == "positive" else -1e3, 1e3 if heights == "up" else -1e3, order)
    path = write(text)
    assert distance(read_points(path, "wheel").profile(), WHEEL) < 1e-9
    assert distance(read_points(path, "wheel", heights=heights, field_side=side).profile(), WHEEL) < 1e-9


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("heights", ["up", "down"])
def test_a_rail_upside_down_is_recognised_by_its_head(write, order, heights):
    inclined = RAIL.inclined(1 / 20)
    path = write(rows(inclined, 1e3, 1e3 if heights == "up" else -1e3, order))
    assert distance(read_points(path, "rail").profile(), inclined) < 1e-9


def test_the_field_side_of_a_rail_must_be_told(write):
    inclined = RAIL.inclined(1 / 20)
    path = write(rows(inclined, -1e3))
    assert distance(read_points(path, "rail", field_side="negative").profile(), inclined) < 1e-9
    assert distance(read_points(path, "rail").profile(), inclined.mirrored()) < 1e-9


@pytest.mark.parametrize(("unit", "factor"), [("m", 1.0), ("mm", 1e3), ("in", 1 / 0.0254)])
def test_units_come_from_the_caller_or_the_header(write, unit, factor):
    text = rows(RAIL, factor, factor, between=",")
    assert distance(read_points(write(text), "rail", unit=unit).profile(), RAIL) < 1e-9
    assert distance(read_points(write(f"y_{unit},z_{unit}\n" + text), "rail").profile(), RAIL) < 1e-9


def test_columns_may_be_separated_as_spreadsheets_do(write):
    comma_decimals = rows(RAIL, between=";").replace(".", ",")
    for text in (rows(RAIL, between="\t"), rows(RAIL, between=", "), comma_decimals):
        assert distance(read_points(write("% a comment\n\n" + text), "rail").profile(), RAIL) < 1e-9


def test_points_closer_than_their_digits_allow_do_not_spoil_the_curvature(write):
    # Nodes as near as 5 um, written to 1e-6 mm: a spline through all of them would have curvatures off by 50 1/m.
    text = "".join(f"{1e3 * u:.6f} {1e3 * w:.6f}\n" for u, w in zip(RAIL.u, RAIL.w, strict=True))
    profile = read_points(write(text), "rail").profile()
    u = np.linspace(-0.009, 0.009, 501)  # the crown, 300 mm
    np.testing.assert_allclose(profile.curvature(profile.arclength_of(u)), -1 / 0.3, atol=1.0)


def test_turning_undoes_an_inclination(write):
    path = write(rows(RAIL.inclined(1 / 40)))
    assert distance(read_points(path, "rail", turn=-np.arctan(1 / 40)).profile(), RAIL) < 1e-9


# --- SIMPACK ------------------------------------------------------------------------------------------
def simpack(points: str, keys: str = "", kind: int = 1) -> str:
    """A SIMPACK profile with the comments and the alignment that such files have."""
    return (DATA / "simpack.txt.in").read_text().format(points=points, keys=keys, kind=kind)


def test_simpack_keys_do_what_their_comments_say(write):
    # Written mirrored, in inches, shifted, from the other end, with a weight column and a bound.
    y, z = -(WHEEL.u / 0.0254) - 2.0, -(WHEEL.w / 0.0254) + 1.0
    keep = slice(None, None, -1)
    points = "\n".join(f"{a:.15E} {b:.15E} 1.0" for a, b in zip(y[keep], z[keep], strict=True))
    keys = "\n".join(table("simpack_keys"))
    profile = read_points(write(simpack(points, keys), "w.prw")).profile()
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
        read_points(write(text.replace(*change), "w.prw"), "wheel").profile()


# --- MiniProf -----------------------------------------------------------------------------------------
def miniprof(points: str, keys: str = "") -> str:
    """A MiniProf measurement: head, an empty line, rows."""
    return f"ProgramName=MiniProf\nDate=31-01-2026\nFlangeWidth=32,5\n{keys}\n\n{points}"


def test_miniprof_measurements_are_smoothed_and_put_upright(write):
    noise = 2e-3 * np.random.default_rng(1).normal(size=(1500, 2))  # mm
    table, _ = WHEEL.table(WHEEL.length / 1499.5)
    points = np.column_stack([1e3 * table[:, 0] - 10.0, -1e3 * table[:, 1] + 5.0])[: len(noise)] + noise
    text = "".join(f"{x:.4f}\t{y:.4f}\t0.0\n" for x, y in points)
    keys = f"XYPoints={len(points)}\nColumnDef=X,Y,A\nXOffset=10.0\nYOffset=-5.0"
    profile = read_points(write(miniprof(text, keys), "left.whl")).profile()
    assert "smoothed, cut-off 5 mm" in profile.source
    u = np.linspace(-0.020, 0.050, 501)
    w, true = profile.at(profile.arclength_of(u))[1], WHEEL.at(WHEEL.arclength_of(u))[1]
    np.testing.assert_allclose(w, true, atol=3e-6)


def test_a_miniprof_rail_of_the_old_kind_is_read(write):
    points = rows(RAIL, 1e3, 1e3)
    profile = read_points(write("Rail\nLeft\n\n" + points, "r.ban"), measured=False).profile()
    assert distance(profile, RAIL) < 1e-9


@pytest.mark.parametrize(("keys", "message"), table("miniprof_files_with_faults_are_refused"))
def test_miniprof_files_with_faults_are_refused(write, keys, message):
    with pytest.raises(InputError, match=message):
        read_points(write(miniprof(rows(WHEEL), keys), "w.whl")).profile()


# --- bad points ---------------------------------------------------------------------------------------


BAD = table("bad")


@pytest.mark.parametrize(("text", "message"), BAD, ids=range(len(BAD)))
def test_points_that_are_no_profile_are_refused_with_their_line(write, text, message):
    with pytest.raises(InputError, match=message):
        read_points(write(text), "rail").profile()


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
        read_points(write(rows(WHEEL)), **{"kind": "wheel", **options}).profile()


def test_files_that_are_not_there_or_not_text_are_refused(tmp_path):
    (tmp_path / "wheel.csv").write_bytes(b"\x00\x01\x02")
    with pytest.raises(InputError, match=r"whele.csv: no such profile file; did you mean '.*wheel.csv'\?"):
        read_points(tmp_path / "whele.csv", "wheel").profile()
    with pytest.raises(InputError, match="not a text file"):
        read_points(tmp_path / "wheel.csv", "wheel").profile()
    with pytest.raises(InputError, match="is a directory, a profile file is needed"):
        read_points(tmp_path, "wheel", format="columns").profile()
    with pytest.raises(InputError, match=r"no profile format has the suffix '.stl'; allowed: .csv, .txt"):
        read_points(tmp_path / "wheel.stl", "wheel").profile()


def test_a_toml_file_that_names_points_of_no_format_names_its_line(tmp_path):
    place = tmp_path / "rail.toml"
    place.write_text('name = "r"\nbody = "rail"\nkind = "points"\ndate = 2026-01-01\nsource = "s"\nfile = "rail.c[v"\n')
    with pytest.raises(
        InputError, match=r"rail.toml:6: file = .*no profile format has the suffix '.c\[v'.*name the format"
    ):
        load_profile(place)


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


# --- S1002 -------------------------------------------------------------------------------------------

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


# --- rails -------------------------------------------------------------------------------------------
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


# --- the other kinds ---------------------------------------------------------------------------------
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


# --- slips -------------------------------------------------------------------------------------------

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
