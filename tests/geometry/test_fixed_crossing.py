"""A fixed crossing from a few numbers: its sections are wing and nose, and its nose grows to the plain rail."""

from pathlib import Path

import numpy as np
import pytest
from support.rows import rows_of

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.track.crossing import read_crossing
from wrsim.geometry.track.rail_surface import RailSurface

table = rows_of(__file__)

FILE = Path(__file__).parents[2] / "models" / "crossings" / "60E1_1in9.toml"


def changed(folder, *pairs):
    text = FILE.read_text()
    for key, value in pairs:
        line = next(one for one in text.splitlines() if one.startswith(f"{key} ="))
        text = text.replace(line, f"{key} = {value}")
    path = folder / "crossing.toml"
    path.write_text(text)
    return path


def at(sections, distance):
    return min(sections, key=lambda own: abs(own.distance - distance))


def marks(own):
    """Places of the features (2, 7) [mm]."""
    return 1e3 * np.array(own.profile.at(np.array(own.features)))


@pytest.fixture(scope="module")
def sections():
    return read_crossing(FILE)


@pytest.mark.parametrize("inclination", [0.0, 1 / 40])
def test_before_and_behind_the_crossing_the_rail_is_plain(inclination):
    rail = load_profile("rails/60E1.toml").inclined(inclination)
    found = read_crossing(FILE, inclination)
    for own in (found[0], found[-1]):
        arc = np.linspace(0.0, rail.length, 300)
        np.testing.assert_allclose(own.profile.at(arc), rail.at(arc), atol=2e-9)


def test_the_nose_is_as_wide_as_its_angle_says_and_the_flangeway_stays(sections):
    for own in sections:
        if not 0.13 < own.distance < 0.64:
            continue
        # flanks lie in the planes of the plain rail's: where its corner ends they are apart by the width
        (u, w), level = marks(own), marks(sections[-1])[1][0]
        lean = (w[[0, 2]] - level) / 20.0
        assert u[2] + lean[1] - u[0] + lean[0] == pytest.approx(1e3 * own.distance / 9.0, abs=1e-6)
        assert u[4] - u[2] - lean[1] == pytest.approx(44.0, abs=1e-6)
        assert u[0] - lean[0] == pytest.approx(marks(sections[-1])[0][0], abs=1e-6)


def test_a_nose_has_the_corners_the_crown_and_the_height_of_its_file(tmp_path):
    path = changed(tmp_path, ("crown_radius_mm", 30))
    for own in read_crossing(path):
        width = 1e3 * own.distance / 9.0
        if not 14.0 <= width < 71.0:
            continue
        profile, (corner, crown, *_) = own.profile, own.features
        share = min((width - 14.0) / 36.0, 1.0)
        lowered = (0.9 - share if share < 0.8 else 2.5 * (1.0 - share) ** 2) / 0.9
        assert 1e3 * profile.at(crown)[1] == pytest.approx(-3.5 * lowered, abs=1e-6)
        assert 1e3 / abs(float(profile.curvature(corner + 1e-6))) == pytest.approx(6.0 + 7.0 * share, rel=1e-6)
        found = 1e3 / abs(float(profile.curvature(crown)))
        assert found < 30.0 if width < 30.0 else found <= 30.0 * (1.0 + 1e-9)
        if width > 40.0:
            assert found == pytest.approx(30.0, rel=1e-9)


def test_the_nose_rises_all_along_and_nowhere_in_steps(sections):
    rows, starts = RailSurface("crossing", tuple(sections)).rows(np.arange(0.14, 0.7, 2e-3))
    nose = rows[:, : starts[1], 1].max(axis=1)
    slopes = np.diff(nose) / 2e-3
    assert slopes.min() > -1e-3
    assert slopes.max() < 1.05 * 3.5 / (36.0 * 9.0) / 0.9
    assert nose[-1] == pytest.approx(0.0, abs=1e-6)


def test_a_trailing_wheel_passes_the_same_sections_the_other_way(sections):
    for one, other in zip(sections, reversed(read_crossing(FILE, trailing=True)), strict=True):
        assert one.distance == -other.distance
        assert one.features == other.features


@pytest.mark.parametrize(("key", "value", "words"), table("wrong_crossings_are_refused"))  # fmt: skip
def test_wrong_crossings_are_refused(tmp_path, key, value, words):
    path = changed(tmp_path, (key, value))
    with pytest.raises(InputError) as error:
        read_crossing(path)
    assert words in str(error.value)
    assert str(path) in str(error.value)


def test_a_head_whose_arcs_do_not_meet_is_refused(tmp_path):
    head = (FILE.parents[1] / "rails" / "60E1.toml").read_text().replace("10.228, 26.0265", "10.228, 99.0")
    (tmp_path / "head.toml").write_text(head)
    with pytest.raises(InputError) as error:
        read_crossing(changed(tmp_path, ("rail", '"head.toml"')))
    assert "rail = \"head.toml\": profile '60E1': the arc of radius 80 mm has no room" in str(error.value)
