"""Friction of a scenario: a number, a law, a table along the track; what is refused."""

from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.rows import rows_of
from support.scenario_texts import CURVE, edited, faults

from wrsim import ContactSettings, Friction, InputError, load, load_text
from wrsim.assessment import nadal
from wrsim.contact import Layer
from wrsim.report.document import contact_sentence
from wrsim.scenario.build import build

table = rows_of(__file__)

GREASED = Friction(0.4, gauge_corner=0.1, ramp=(radians(10.0), radians(30.0)))
FALLING = Friction(0.4, falling_ratio=0.5, falling_decay=0.6)


def friction_of(text):
    return build(load_text(edited(CURVE, "friction = 0.35", text), "case.toml")).contact.friction


def test_scenarios_take_a_number_or_a_table_for_both_rails_or_for_each():
    table = "{static = 0.4, gauge_corner = 0.1, gauge_corner_from_deg = 10, gauge_corner_full_deg = 30}"
    assert friction_of(f"friction = {table}") == (GREASED, GREASED)
    assert friction_of(f"friction_left = 0.3\nfriction_right = {table}") == (0.3, GREASED)
    falling = "[contact.friction]\nstatic = 0.4\nfalling_ratio = 0.5"
    assert friction_of(falling) == (FALLING, FALLING)
    assert ContactSettings().friction == (0.35, 0.35)


@pytest.mark.parametrize(("text", "message"), table("bad_friction_is_refused"))
def test_bad_friction_is_refused(text, message, tmp_path):
    assert any(message in line for line in faults(edited(CURVE, "friction = 0.35", text), tmp_path))


@pytest.mark.parametrize(("text", "message"), table("bad_layers_are_refused"))
def test_bad_layers_are_refused(text, message, tmp_path):
    assert any(message in line for line in faults(edited(CURVE, "friction = 0.35", text), tmp_path))


@pytest.mark.parametrize(("text", "message"), table("bad_temperatures_are_refused"))
def test_bad_temperatures_are_refused(text, message, tmp_path):
    assert any(message in line for line in faults(edited(CURVE, "friction = 0.35", text), tmp_path))


def test_layers_are_in_si_units():
    layer = "{thickness_mm = 0.02, shear_modulus_GPa = 1, yield_stress_MPa = 150, hardening_MPa_per_mm = 828}"
    text = edited(CURVE, "friction = 0.35", f"normal = 'half-space'\nlayer = {layer}")
    assert build(load_text(text, "case.toml")).contact.layer == Layer(2e-5, 1e9, 150e6, 828e9)


def test_the_report_and_nadal_s_limit_know_the_heat() -> None:
    contact = "[contact]\nfriction = 0.12\nlayer = {yield_stress_MPa = 150}\n[contact.temperature]\n"
    sentences, friction = [], []
    for change in (0.15, -0.05):
        text = f"{contact}friction_change = {change}\nfriction_over_K = 80\n"
        dataset = xr.Dataset(attrs={"scenario_text": text, "analysis": "curving"})
        sentences.append(contact_sentence(dataset))
        friction.append(nadal._friction_of(dataset))
    assert "0.12, which changes by +0.15 over 80 K from 20 °C on; a layer between them that yields" in sentences[0]
    # the largest there may be
    assert friction == pytest.approx([0.27, 0.12])


def friction_along(text: str, more: str, folder: Path | None = None) -> Any:
    return build(load_text(edited(text, "friction = 0.35", more), folder or ".")).contact.friction


def test_a_table_and_sections_say_the_same_and_standing_wheels_feel_one_place(tmp_path: Path) -> None:
    (tmp_path / "mu.csv").write_text("at_m,left,right\n0,0.35,0.35\n60,0.35,0.35\n62,0.35,0.1\n")
    table = friction_along(CURVE, 'friction = 0.35\nfriction_table = "mu.csv"', tmp_path)
    row = 'friction_sections = [{from_m = 60, friction = 0.1, side = "right", transition_m = 2}]'
    sections = friction_along(CURVE, f"friction = 0.35\n{row}")
    s = np.linspace(0.0, 100.0, 1001)
    for ours, theirs in zip(table, sections, strict=True):
        np.testing.assert_allclose(ours.numbers(s), theirs.numbers(s), rtol=1e-12)
    rows = "friction_sections = [{from_m = 60, friction = 0.1, transition_m = 2}]\nfriction_at_m = "
    steady = CURVE.replace('"curving"', '"steady"').split("[[track.segments]]")[0]
    for place, mu in ((0.0, 0.35), (61.0, 0.225), (70.0, 0.1)):
        more = f"[contact]\nfriction = 0.35\n{rows}{place}\n[steady]\nradius_m = 300\n"
        left, right = build(load_text(steady + more, "case.toml")).contact.friction
        assert left.numbers == pytest.approx(Friction(mu).numbers)
        assert left == right


@pytest.mark.parametrize(("more", "message"), table("bad_friction_along_the_track_is_refused"))
def test_bad_friction_along_the_track_is_refused(more: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "mu.csv").write_text("at_m,left,right\n5,0.3,0.3\n4,0.3,0.3\n")
    (tmp_path / "high.csv").write_text("at_m,left,right\n5,7,0.3\n")
    messages = faults(edited(CURVE, "friction = 0.35", f"friction = 0.35\n{more}"), tmp_path)
    assert any(message in line for line in messages), messages


def test_slope_reduction_belongs_to_two_models() -> None:
    scenario = load(Path(__file__).resolve().parents[2] / "scenarios/traction.toml")
    settings = scenario.spec.contact.settings()
    assert (settings.slope_k0, settings.slope_alpha_inf, settings.slope_beta) == (0.54, 0.02, 0.62)
    with pytest.raises(InputError, match=r'slope_k0 = 0\.54: goes with tangential = "fastsim" or "fastrip" only'):
        scenario.with_values({"contact.tangential": "polach"})
