"""Profile files in TOML: the standard profiles against published numbers, the kinds, and slips of the pen."""

from pathlib import Path

import numpy as np
import pytest
from support.rows import rows_of

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.plots.profile import profile_figure

table = rows_of(__file__)

MODELS = Path(__file__).parents[2] / "models"
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

# The table of EN 13715 / UIC 510-2 once more, as plain formulas: u from .. to, depth below the tape circle, mm.
TREAD = (
    "-3.358537058e-2*u + 1.565681624e-3*u**2 - 2.810427944e-5*u**3 + 5.844240864e-8*u**4 - 1.562379023e-8*u**5"
    " + 5.309217349e-15*u**6 - 5.957839843e-12*u**7 + 2.646656573e-13*u**8"
)
ROOT = (
    "-4.320221063e3 - 1.038384026e3*u - 1.065501873e2*u**2 - 6.051367875*u**3 - 2.054332446e-1*u**4"
    " - 4.169739389e-3*u**5 - 4.687195829e-5*u**6 - 2.252755540e-7*u**7"
)
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


@pytest.mark.parametrize(
    ("rail", "slope", "distance"),
    table("top_and_gauge_point_are_as_far_apart_as_published"),
)
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


def test_a_measured_file_is_smoothed_and_says_so(toml, tmp_path):
    wheel = load_profile(MODELS / "wheels/S1002.toml")
    np.savetxt(tmp_path / "w.csv", 1e3 * np.column_stack((wheel.u, wheel.w)), "%.12f")
    profile = load_profile(toml('kind = "points"\nfile = "w.csv"\nmeasured = true\ncutoff_mm = 3.0\n'))
    assert profile.source == "made up; smoothed, cut-off 3 mm"
    assert profile.length == pytest.approx(0.15338, abs=1e-5)


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


# The picture of a profile says what it shows, in units, at equal scales.
@pytest.mark.parametrize("name", ["wheels/S1002.toml", "rails/60E1.toml"])
def test_the_figure_shows_the_whole_profile_at_equal_scales(name):
    profile = load_profile(MODELS / name)
    figure = profile_figure(profile)
    shape = figure.axes[0]
    low, high = shape.get_xlim()
    assert low < 1e3 * profile.u.min() and high > 1e3 * profile.u.max()
    # One millimetre is as long upward as it is across.
    box = shape.get_position()
    across, up = figure.get_size_inches()
    per_mm = box.width * across / (high - low), box.height * up / np.diff(shape.get_ylim())[0]
    assert per_mm[0] == pytest.approx(per_mm[1], rel=1e-9)
