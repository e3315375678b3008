"""Losses on a profile, place by place: mass, smoothing, overlap; dimensions of the flange."""

from pathlib import Path

import numpy as np
import pytest

from wrsim.errors import InputError
from wrsim.geometry.profile.flange import flange_dimensions
from wrsim.geometry.profile.models import load_profile, write_depths
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.wear import area_off, bin_edges, depths_of, on_unworn, smoothed_table, worn

CUTOFF = 5e-3
Array = np.ndarray


def wheel() -> Profile:
    return load_profile("wheels/S1002.toml")


def losses(profile: Profile, depth: float = 1e-3) -> Array:
    """Tread and flange root, and one bin alone."""
    edges = bin_edges(profile, 0.25e-3)
    u = profile.at(0.5 * (edges[1:] + edges[:-1]))[0]
    areas = depth * np.exp(-(((u + 33e-3) / 3e-3) ** 2)) + 0.7 * depth * np.exp(-(((u - 5e-3) / 10e-3) ** 2))
    areas[np.searchsorted(u, -20e-3)] += depth
    return areas


def enclosed(a: Profile, b: Profile, points: int = 100_001) -> float:
    """Area between two profiles of the same ends, as a polygon [m2]."""
    share = np.linspace(0.0, 1.0, points)
    (x0, y0), (x1, y1) = (p.at(share * p.length) for p in (a, b))
    x, y = np.concatenate([x0, x1[::-1]]), np.concatenate([y0, y1[::-1]])
    return 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))


def test_a_new_s1002_has_the_dimensions_of_its_standard() -> None:
    """Flange 32.5 mm thick and 28 mm high (EN 13715); qR of the new profile is 10.8 mm."""
    found = flange_dimensions(wheel())
    assert found.thickness == pytest.approx(32.5e-3, abs=1e-6)
    assert found.height == pytest.approx(28.0e-3, abs=1e-6)
    assert found.steepness == pytest.approx(10.8e-3, abs=0.02e-3)


def test_a_tread_that_wears_makes_the_flange_higher_and_thicker() -> None:
    """A tread that loses 1 mm all over: Sh grows by that, and Sd is measured 1 mm nearer to the root."""
    new = wheel()
    edges = bin_edges(new, 0.25e-3)
    u = new.at(0.5 * (edges[1:] + edges[:-1]))[0]
    areas = 1e-3 / (1.0 + np.exp(-(u + 10e-3) / 1e-3))
    old, now = flange_dimensions(new), flange_dimensions(worn(new, [depths_of(new, areas, CUTOFF)], "hollow"))
    assert now.height - old.height == pytest.approx(1e-3, rel=2e-3)
    face = (new.u > -40e-3) & (new.u < -30e-3)
    assert now.thickness == pytest.approx(70e-3 + np.interp(-9e-3, new.w[face], new.u[face]), abs=1e-5)


def test_a_cone_has_no_flange() -> None:
    with pytest.raises(InputError, match="no flange"):
        flange_dimensions(load_profile("wheels/cone_1in20.toml"))


@pytest.mark.parametrize("name", ["wheels/S1002.toml", "rails/60E1.toml"])
def test_area_off_the_profile_is_area_lost(name: str) -> None:
    """By the depths to round-off, and between the two curves as a polygon."""
    profile = load_profile(name)
    areas = losses(profile)
    table = depths_of(profile, areas, CUTOFF)
    lost = areas.sum() * profile.length / areas.size
    assert sum(area_off(profile, table)) == pytest.approx(lost, rel=1e-13)
    assert enclosed(profile, worn(profile, [table], "worn")) == pytest.approx(lost, rel=1e-6)


def test_smoothing_keeps_the_sum_and_puts_nothing_back() -> None:
    areas = losses(wheel())
    smooth = smoothed_table(areas, 0.25e-3, CUTOFF)
    assert smooth.sum() == pytest.approx(areas.sum(), rel=1e-13)
    assert smooth.min() >= 0.0


def test_smoothing_halves_a_wave_of_the_cutoff() -> None:
    x = np.arange(4000) * 0.1e-3
    wave = np.sin(2.0 * np.pi * x / CUTOFF)
    middle = smoothed_table(wave, 0.1e-3, CUTOFF)[1000:3000]
    assert np.abs(middle).max() == pytest.approx(0.5, abs=1e-3)


def test_losses_on_the_worn_profile_come_back_to_the_unworn_one() -> None:
    """Their sum stays, and each stays at its place: on the profile that lost nothing they are the same."""
    new = wheel()
    areas = losses(new)
    np.testing.assert_allclose(on_unworn(new, None, new.length, areas, areas.size), areas, rtol=1e-9, atol=1e-15)
    table = depths_of(new, areas, CUTOFF)
    profile = worn(new, [table], "worn")
    count = int(np.ceil(profile.length / 0.25e-3))
    lost = np.random.default_rng(1).random(count)
    back = on_unworn(new, table, profile.length, lost, areas.size)
    assert back.sum() * new.length / areas.size == pytest.approx(lost.sum() * profile.length / count, rel=1e-12)


def test_a_table_of_depths_is_a_model_file(tmp_path: Path) -> None:
    new = wheel()
    table = depths_of(new, losses(new), CUTOFF)
    (tmp_path / "depths.csv").write_text(write_depths(table))
    head = 'name = "x"\nbody = "wheel"\nkind = "worn"\ndate = 2026-11-22\nsource = "test"\n'
    (tmp_path / "wheel.toml").write_text(head + 'base = "S1002.toml"\ndepths = "depths.csv"\n')
    read = load_profile(tmp_path / "wheel.toml")
    made = worn(new, [table], "x")
    np.testing.assert_allclose(read.w, made.w, rtol=0.0, atol=1e-15)
    (tmp_path / "depths.csv").write_text("place_mm,depth_mm\n0,0\n1,0\n1,0\n2,0\n")
    with pytest.raises(InputError, match=r"depths.csv:4: place_mm = .*: must rise from row to row"):
        load_profile(tmp_path / "wheel.toml")


def test_a_profile_that_would_overlap_itself_is_refused() -> None:
    """A groove deeper than the radius of the flange's tip."""
    new = wheel()
    edges = bin_edges(new, 0.25e-3)
    u = new.at(0.5 * (edges[1:] + edges[:-1]))[0]
    areas = 15e-3 * np.exp(-(((u + 55e-3) / 6e-3) ** 2))
    with pytest.raises(InputError, match="makes the profile overlap itself"):
        worn(new, [depths_of(new, areas, CUTOFF)], "x")
