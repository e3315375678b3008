"""A bridge below the track: modes of its beam, moving loads, a coach over it beside a published program."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.pushed_rails import TRACK
from support.rows import rows_of
from support.runs import FAST, SCENARIOS
from support.vehicles import ROOT, coaches, manchester, on_track, shipped

from wrsim import InputError, load, run
from wrsim.scenario.build import build
from wrsim.simulation.steady_state import steady_state
from wrsim.track.bridge import Bridge, read_bridge
from wrsim.vehicle.dynamics.deck import DECK, deck_motion
from wrsim.vehicle.dynamics.flexible import MODE

table = rows_of(__file__)

SPAN, BENDING, MASS = 20.0, 35e9 * 0.52, 16587.0


def bridge(count: int = 10, spans: tuple[float, ...] = (SPAN,), damping: float = 0.02) -> Bridge:
    return Bridge.of_spans(50.0, spans, BENDING, MASS, damping, count)


def test_a_span_vibrates_in_sines() -> None:
    deck = bridge(5)
    n = np.arange(1, 6)
    theory = (n * np.pi / SPAN) ** 2 * np.sqrt(BENDING / MASS) / (2.0 * np.pi)
    assert deck.frequencies == pytest.approx(theory, rel=1e-5)
    assert deck.masses == pytest.approx(np.full(5, 0.5 * MASS * SPAN), rel=1e-5)
    x = np.linspace(0.0, SPAN, len(deck.shapes))
    for k in n:
        value, slope = deck.shapes[:, k - 1].T
        sign = np.sign(slope[0])
        assert sign * value == pytest.approx(np.sin(k * np.pi * x / SPAN), abs=1e-6)
        assert sign * slope == pytest.approx(k * np.pi / SPAN * np.cos(k * np.pi * x / SPAN), abs=1e-6)
    moment = -BENDING * (np.pi / SPAN) ** 2 * deck.values[0, 0]
    assert deck.moments is not None
    assert deck.moments[0, 0] == pytest.approx(moment, rel=1e-4)


def test_two_equal_spans_vibrate_as_one_pinned_and_one_clamped() -> None:
    """A continuous beam of two spans: odd modes those of a span, even ones of a span clamped at the middle pier."""
    frequencies = bridge(4, (SPAN, SPAN)).frequencies
    roots = np.array([np.pi, 3.926602, 2.0 * np.pi, 7.068583])  # tan x = tanh x
    theory = (roots / SPAN) ** 2 * np.sqrt(BENDING / MASS) / (2.0 * np.pi)
    assert frequencies == pytest.approx(theory, rel=1e-5)


def test_the_slope_under_a_wheel_is_that_of_the_deck_between_its_rows() -> None:
    deck, rows, modes = np.zeros(1, DECK), np.array([[0.1, 1.0], [0.4, -2.0], [0.2, 0.7]]), np.zeros(1, MODE)
    deck["step"], deck["count"] = 0.5, 1

    def motion_at(s: float) -> tuple[float, float, float]:
        return deck_motion(s, 0.0, deck[0], rows, modes, np.ones(1), np.zeros(1))

    for s in (0.1, 0.63):
        assert motion_at(s)[2] == pytest.approx((motion_at(s + 1e-6)[0] - motion_at(s - 1e-6)[0]) / 2e-6, rel=1e-6)


def test_spread_loads_leave_the_static_deflection_and_smooth_the_ends() -> None:
    """The weights of a beam on its foundation have no second moment: a sine of wavelength l is met with 1/(1 +
    (2 pi L/l)^4/4) of it."""
    plain, length = bridge(1), 2.0
    beneath = plain.beneath(length)
    middle = len(beneath.shapes) // 2
    part = beneath.shapes[middle, 0, 0] / plain.shapes[len(plain.shapes) // 2, 0, 0]
    k = np.pi / SPAN * length
    assert part == pytest.approx(1.0 / (1.0 + 0.25 * k**4), rel=2e-3)
    assert np.abs(beneath.shapes[0]).max() < 1e-3
    assert beneath.start < plain.start


def test_stiffness_of_deck_and_wheels_have_one_potential() -> None:
    """At rest what a mode does to a wheelset is what the wheelset does to the mode (Maxwell and Betti)."""
    law = on_track(shipped("wheelset_s1002"), 0.0, structure=bridge(2), start=57.0).law
    rest = steady_state(law)
    q, q_t, h = rest.q, rest.q_t, 1e-6

    def forces(change: np.ndarray) -> np.ndarray:
        law(0.0, q + change, q_t, out := np.zeros(law.size))
        out[law.of_deck] *= bridge(2).masses
        return out

    by_height, by_mode = np.zeros((2, law.size))
    by_height[0], by_mode[law.of_deck[0]] = h, h
    of_height, of_mode = (forces(c) - forces(-c) for c in (by_height, by_mode))
    assert of_height[law.of_deck[0]] == pytest.approx(of_mode[0], rel=1e-4)


def test_a_coach_behind_does_not_bend_the_bridge_that_it_has_not_reached() -> None:
    laws = [on_track(vehicle, 20.0, structure=bridge(2), start=56.0).law for vehicle in (manchester(), coaches(2))]
    alone, followed = (steady_state(law).q[law.of_deck[0]] for law in laws)
    assert followed == pytest.approx(alone, rel=1e-3)


@pytest.mark.parametrize(("structure",), table("a_coach_bends_a_bridge_as_in_a_published_program"))
def test_a_coach_bends_a_bridge_as_in_a_published_program(structure: dict[str, Any]) -> None:
    """TTB-2D (D. Cantero, SoftwareX 20 (2022) 101253); its span of 20 m has 67 elements of 0.3 m. Its acceleration is
    0.171 to 0.188 by the elements of its rail, which has no shear: with shear sleepers strike the deck."""
    values = {"track.structure": structure, "run.distance_m": 62.0}
    dataset = run(load(ROOT / "scenarios/bridge.toml").with_values(FAST | values)).dataset
    assert float(dataset["deck_deflection"].max()) == pytest.approx(2.0576e-3, rel=0.005)
    assert float(dataset["deck_moment"].max()) == pytest.approx(989771.0, rel=0.005)
    if structure["kind"] == "bridge":
        assert float(np.abs(dataset["deck_acceleration"]).max()) == pytest.approx(0.1807, rel=0.1)


def test_wrong_files_of_a_bridge_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "deck.csv"
    head = "mode,frequency_Hz,damping,modal_mass_kg,at_m,uz\n"
    x = np.linspace(0.0, SPAN, 11)
    rows = [f"1,4.1,0.02,165870,{a},{np.sin(np.pi * a / SPAN)}" for a in x]
    path.write_text(head + "\n".join(rows))
    deck = read_bridge(path, 50.0)
    assert deck.frequencies == pytest.approx([4.1])
    assert deck.shapes[:, 0, 0] == pytest.approx(np.sin(np.pi * np.linspace(0.0, 1.0, len(deck.shapes))), abs=1e-4)
    for some, message in ((rows[:3], "at least four"), (rows[1:], "rising from 0")):
        path.write_text(head + "\n".join(some))
        with pytest.raises(InputError, match=message):
            read_bridge(path, 50.0)


def test_a_run_on_sleepers_begins_beside_the_bridge() -> None:
    with pytest.raises(InputError, match="begins with no wheel on the bridge"):
        on_track(shipped("wheelset_s1002"), structure=replace(TRACK, bridge=bridge()), start=57.0)


# Runs on sleepers: impacts of a flat, and scenarios that cannot be.
FLAT = load(SCENARIOS / "flat_on_sleepers.toml")


@pytest.mark.parametrize(
    ("values", "message"),
    table("what_does_not_go_with_sleepers_is_one_clear_error"),
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_what_does_not_go_with_sleepers_is_one_clear_error(values: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        build(FLAT.with_values(values))
    assert str(caught.value).count("\n") <= 1


def test_the_largest_force_of_a_flat_converges_over_the_step() -> None:
    """The wheel leaves the rail; where it strikes, creep forces reverse within 10 us."""
    keys = {"contact.normal": "kik-piotrowski", "vehicle.speed_kmh": 100, "vehicle.out_of_round[0].at_deg": 30.0}
    keys |= {"run.distance_m": 0.35, "run.output_interval_ms": 0.04}
    datasets = [run(FLAT.with_values(keys | {"run.step_us": step})).dataset for step in (40, 20, 10)]
    assert [data.attrs["cut_steps"] for data in datasets] == [0, 0, 0]
    assert np.abs(np.diff(np.log([float(data["Q"].max()) for data in datasets]))).max() < 0.015


def test_linear_stability_takes_no_sleepers() -> None:
    structure = FLAT.spec.track.structure
    assert structure is not None
    scenario = load(SCENARIOS / "stability_manchester.toml")
    with pytest.raises(InputError, match='may be "sleepers" with analysis'):
        scenario.with_values({"track.structure": structure.model_dump(exclude_unset=True)})
