"""The command for profiles: what smoothing takes away, cut-offs side by side, what is refused."""

import json
from pathlib import Path

import pytest
from support.commands import call, ok

from wrsim.contact.profiles.files import read_points
from wrsim.results.smoothing import report_smoothing

ROOT = Path(__file__).parents[2]
MODELS, SCANS = ROOT / "models", ROOT / "scenarios/measured"
NOISE = 10e-6  # of every coordinate of the scans, standard deviation [m]


@pytest.fixture(scope="module")
def files():
    """The shipped scans: the worn wheel as a MiniProf file, the worn rail in two columns, points 0.11 mm apart."""
    return SCANS / "wheel.whl", SCANS / "rail.csv"


def test_the_report_tells_noise_from_shape(files):
    reading = read_points(files[1], "rail", measured=True)
    numbers = report_smoothing(reading).numbers()
    assert 1e-6 * numbers["scatter_um"] == pytest.approx(NOISE, rel=0.1)
    # what was taken away is the noise, and no more
    assert 1e-6 * numbers["rms_change_um"] == pytest.approx(NOISE, rel=0.1)
    assert numbers["largest_curvature_before_1_per_m"] > 5e3  # a radius of 0.2 mm
    # the sharpest of the worn corner, R 13 and the wear on it
    assert numbers["largest_curvature_after_1_per_m"] == pytest.approx(90.0, rel=0.1)
    assert numbers["at_u_mm"] == pytest.approx(-28.0, abs=2.0)
    assert 2.5 * NOISE < 1e-6 * numbers["largest_change_um"] < 6.0 * NOISE
    u = float(files[1].read_text().splitlines()[int(numbers["largest_change_at_line"]) - 1].split()[0])
    assert numbers["largest_change_at_u_mm"] == pytest.approx(u, abs=1e-9)
    # a cut-off that is too long takes shape away: the change exceeds the scatter
    blunt = report_smoothing(read_points(files[1], "rail", measured=True, cutoff=15e-3)).numbers()
    assert blunt["rms_change_um"] > 1.5 * blunt["scatter_um"]


@pytest.mark.usefixtures("sketched")
def test_the_command_compares_cutoffs(files, tmp_path):
    result = ok(
        "profile", files[1], "--kind", "rail", "--cutoff", 3.5, "--cutoff", 10, "-o", tmp_path / "rail.png", "--json"
    )
    answer = json.loads(result.stdout)
    assert Path(answer["files"][0]).read_bytes().startswith(b"\x89PNG")
    fine, coarse = answer["smoothing"]
    assert (fine["cutoff_mm"], coarse["cutoff_mm"]) == (3.5, 10.0)
    assert fine["rms_change_um"] < coarse["rms_change_um"]
    assert fine["largest_curvature_before_1_per_m"] == coarse["largest_curvature_before_1_per_m"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((MODELS / "rails/60E1.toml", "--cutoff", 5), "is a shape by formula, with no points to smooth"),
        (("rail", "--cutoff", 0), "--cutoff 0: must be a number above 0 and at most 100"),
        (("rail", "--cutoff", "nan"), "--cutoff nan: must be"),
        (("rail", "--cutoff", 0.15), "smoothing with a cut-off of 0.15 mm needs points at most 0.075 mm apart"),
        (("rail", *["--cutoff", 5] * 5), "5 of them; must be at most 4"),
        (("rail", "--exact"), "measured = true (--measured)"),
    ],
)
def test_what_cannot_be_smoothed_is_answered(files, tmp_path, arguments, message):
    arguments = [files[1] if word == "rail" else word for word in arguments]
    result = call("profile", *arguments, "--kind", "rail", "-o", tmp_path / "out.png")
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())
    assert not (tmp_path / "out.png").exists()
