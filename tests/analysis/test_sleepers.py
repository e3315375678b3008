"""Runs on sleepers: impacts of a flat, and scenarios that cannot be."""

from functools import cache
from typing import Any

import pytest
from support.rows import rows_of
from support.runs import SCENARIOS

from wrsim.analysis import run
from wrsim.errors import InputError
from wrsim.scenario.build import build
from wrsim.scenario.loading import load

table = rows_of(__file__)

FLAT = load(SCENARIOS / "flat_on_sleepers.toml")


@cache
def peak(speed: float, step_us: int = 50, **changed: Any) -> float:
    """Largest force under the wheel with the flat [N], which strikes two sleepers earlier than as shipped."""
    values = {"vehicle.speed_kmh": speed, "contact.normal": "kik-piotrowski", "run.step_us": step_us}
    values |= {"run.output_interval_ms": 0.05, "run.distance_m": 0.6, "vehicle.out_of_round[0].at_deg": 46.5}
    values |= {"contact.strips": 8, "contact.cells": 4, "contact.tangential": "polach"}
    values |= {f"track.structure.{key}": value for key, value in changed.items()}
    result = run(FLAT.with_values(values))
    assert result.status == "completed"
    return float(result.wheelset()["Q"].values[:, 0].max())


def test_the_force_of_a_flat_has_a_hump_at_low_speed_and_grows_again() -> None:
    # at low speed the wheel falls into the flat and strikes its end; faster it leaves the rail and strikes harder
    slow, hump, valley, fast = (peak(v) for v in (20.0, 35.0, 50.0, 100.0))
    assert slow < hump > valley
    assert fast > 1.4 * valley


@pytest.mark.parametrize("speed", [100.0, pytest.param(35.0, marks=pytest.mark.campaign)])
@pytest.mark.parametrize("change", [{"step_us": 25}, {"margin_m": 20.0}, {"elements": 8}], ids=str)
def test_the_force_of_a_flat_depends_neither_on_step_nor_window_nor_elements(speed: float, change: dict) -> None:
    assert peak(speed, **change) == pytest.approx(peak(speed), rel=0.02)


@pytest.mark.parametrize(
    ("values", "words"),
    table("what_does_not_go_with_sleepers_is_one_clear_error"),
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_what_does_not_go_with_sleepers_is_one_clear_error(values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        build(FLAT.with_values(values))
    assert str(caught.value).count("\n") <= 1


def test_linear_stability_takes_no_sleepers() -> None:
    structure = FLAT.spec.track.structure
    assert structure is not None
    scenario = load(SCENARIOS / "stability_manchester.toml")
    with pytest.raises(InputError, match='may be "sleepers" with analysis'):
        scenario.with_values({"track.structure": structure.model_dump(exclude_unset=True)})
