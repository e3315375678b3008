"""Wear and fatigue of a run: what is gathered from its samples."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.rows import rows_of
from support.runs import LEADING, SCENARIOS, arc, setup_of, transition

from wrsim import InputError, Result, load
from wrsim.analysis.motion.run import run_in_time
from wrsim.plots.pictures import standard_figures
from wrsim.report.page import report_page
from wrsim.scenario.build import Setup, build

table = rows_of(__file__)

STRETCH = 5.0, 14.0
VALUES = {
    "wear.laws": ["usfd", "archard", "brr"], "wear.from_m": STRETCH[0], "wear.to_m": STRETCH[1], "run.distance_m": 15.0,
    "contact.cells": 6,
}  # fmt: skip


def curve(**values: Any) -> Setup:
    """A leading wheelset from a transition into an arc."""
    return setup_of([transition(10.0), arc(15.0, 300.0, 60.0)], 10.0, LEADING, values=VALUES | values)


@pytest.fixture(scope="module")
def left() -> xr.Dataset:
    return run_in_time(curve()).dataset


def test_what_is_gathered_is_the_wear_number_over_the_stretch(left: xr.Dataset) -> None:
    """By the trapezoidal rule between the samples, whose cells end at the stretch's ends."""
    x, wear = left["wheelset_distance"].values[:, 0], left["T_gamma"].values[:, 0]
    edges = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    cells = np.diff(np.clip(edges, *STRETCH))
    mean = (wear * cells[:, None]).sum(axis=0) / cells.sum()
    width = place_width(left)
    energy = np.nansum(left["wear_wheel_energy"].values[0], axis=-1) * width
    np.testing.assert_allclose(energy, mean, rtol=1e-9)


def place_width(dataset: xr.Dataset) -> float:
    """Width of the places on the wheels [m]."""
    setup = curve()
    profile = setup.wheelset.left.profile
    return profile.length / int(np.isfinite(dataset["wear_wheel_u"].values[0, 0]).sum())


def test_wear_numbers_of_patches_add_up_to_that_of_the_wheel(left: xr.Dataset) -> None:
    np.testing.assert_allclose(left["T_gamma_patch"].sum("patch").values, left["T_gamma"].values, rtol=1e-9, atol=1e-9)
    used = left["traction_coefficient"].values
    assert np.nanmax(used) < 0.35 * (1.0 + 1e-6) and np.nanmin(used) >= 0.0


def test_coarser_samples_give_the_same_mass(left: xr.Dataset) -> None:
    """Four times as far apart: 0.2 m instead of 0.05 m. Archard's coefficient jumps from field to field of its map."""
    coarse = run_in_time(curve(**{"run.output_interval_ms": 20})).dataset
    for law, tolerance in (("usfd", 1e-3), ("brr", 1e-3), ("archard", 0.02)):
        fine_mass, coarse_mass = (
            d["wear_wheel_mass"].sel(wear_law=law).sum("wear_zone").values for d in (left, coarse)
        )
        np.testing.assert_allclose(fine_mass, coarse_mass, rtol=tolerance)


def test_results_tell_wear_and_draw_it(left: xr.Dataset, tmp_path: Path) -> None:
    Result(left).save(tmp_path / "result.nc")
    told = Result.load(tmp_path / "result.nc").summary()["wear"]
    right = told["laws"]["usfd"]["wheelsets"]["wheelset"]["right"]
    mass = left["wear_wheel_mass"].sel(wear_law="usfd", wheel="right").values[0]
    assert right["tread_g_per_km"] + right["flange_g_per_km"] == pytest.approx(1e6 * mass.sum())
    assert right["wear_wheel_u_mm"] < 0.0 < right["wear_wheel_depth_max_um_per_km"]
    assert set(told["fatigue"]) == {"left", "right"}
    figures = standard_figures(left)
    assert {"wear", "fatigue"} <= set(figures)
    figures["wear"](), figures["fatigue"]()


FAULTS: list[tuple[dict[str, Any], str]] = table("faults")


@pytest.mark.parametrize(("values", "message"), FAULTS)
def test_wrong_input_is_one_clear_error(values: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        build(load(SCENARIOS / "curve_r300.toml").with_values(values))
    assert message in str(caught.value)


def test_rails_that_change_have_no_wear() -> None:
    with pytest.raises(InputError, match="rails of one profile only"):
        build(load(SCENARIOS / "rail_states.toml").with_values({"wear.laws": ["usfd"]}))


@pytest.mark.usefixtures("unpainted")
def test_the_report_has_the_wear_of_a_run(left: xr.Dataset) -> None:
    page = report_page([Result(left)], ["run"])
    wear_of_wheel = Result(left).summary()["wear"]["laws"]["archard"]["wheelsets"]["wheelset"]["right"]
    section = page[page.index('<section id="wear"') : page.index('<section id="again"')]
    assert f"<td>{wear_of_wheel['tread_g_per_km']:.4g}</td><td>{wear_of_wheel['flange_g_per_km']:.4g}</td>" in section
    assert section.count("<img ") == 2
