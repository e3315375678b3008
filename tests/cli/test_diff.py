"""Two results side by side, and keys that are set on the command line."""

import json
from pathlib import Path

import pytest
from support.commands import call, ok, refusal
from support.runs import SCENARIOS
from support.synthetic_result import curve_run, static_poses

from wrsim.results import Result

EQUILIBRIUM = str(SCENARIOS / "equilibrium_s1002.toml")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str, str]:
    """A run, the same with Q of the right wheel 2 % larger, and one that stopped."""
    folder = tmp_path_factory.mktemp("runs")
    run = curve_run()
    Result(run).save(folder / "a" / "result.nc")
    other = run.copy(deep=True)
    other["Q"].loc[{"wheel": "right"}] *= 1.02
    Result(other).save(folder / "b" / "result.nc")
    Result(curve_run(stopped=True)).save(folder / "c" / "result.nc")
    Result(static_poses()).save(folder / "d" / "result.nc")
    return tuple(str(folder / name) for name in "abc")  # type: ignore[return-value]


def test_a_result_is_like_itself(runs: tuple[str, str, str]) -> None:
    ok("diff", runs[0], runs[0], "--tolerance", "0")


def test_the_exit_code_says_whether_a_change_is_beyond_the_tolerance(runs: tuple[str, str, str]) -> None:
    beyond = call("diff", runs[0], runs[1], "--json")
    assert beyond.exit_code == 4
    found = json.loads(beyond.output)
    changed = {(d["place"], d["quantity"]) for d in found["differences"] if d["difference"]}
    assert all("right" in place and quantity.startswith("Q_") for place, quantity in changed)
    assert ("wheelset right", "Q_max_kN") in changed
    largest = max(d["relative"] for d in found["differences"])
    assert largest == pytest.approx(0.02 / 1.02, rel=1e-6)  # of the larger one
    assert call("diff", runs[0], runs[1], "--tolerance", "0.03").exit_code == 0
    assert call("diff", runs[0], runs[1], "--only", "Y_over_Q_max").exit_code == 0


def test_wheelsets_and_curves_are_matched_by_order_and_what_was_asked_differently_is_said_once(
    runs: tuple[str, str, str], tmp_path: Path
) -> None:
    other = Result.load(runs[0]).dataset.load()
    other.attrs["scenario_text"] += "\n[asked]\nradius_m = 150\n"
    named = "wheelset" in other.dims
    other = other.assign_coords(wheelset=["lead"] if named else "lead")
    Result(other).save(tmp_path / "result.nc")
    found = json.loads(call("diff", runs[0], tmp_path, "--json").output)
    assert found["alike"] and {d["place"] for d in found["differences"]} >= {"wheelset right"}
    assert sum("150 in B" in words for words in found["inputs"]) == 1
    assert "wheelsets are matched from the front: wheelset and lead" in found["inputs"]
    call("diff", runs[0], tmp_path, "-o", tmp_path / "d")
    assert (tmp_path / "d/diff.png").exists()


def test_what_only_one_result_has_is_named_once_beside_the_differences(
    runs: tuple[str, str, str], tmp_path: Path
) -> None:
    lone = Result.load(runs[1]).dataset.load()
    both = lone.isel(wheelset=[0, 0]).assign_coords(wheelset=["front", "rear"])
    Result(both).save(tmp_path / "result.nc")
    lines = call("diff", runs[0], tmp_path).output.splitlines()
    assert sum("rear" in line and "only in B" in line for line in lines) == 1
    assert any(line.startswith("wheelset right") and "Q_max_kN" in line for line in lines)


def test_a_run_that_stopped_is_not_like_one_that_came_to_its_end(runs: tuple[str, str, str]) -> None:
    answer = call("diff", runs[0], runs[2], "--tolerance", "1e9")
    assert answer.exit_code == 4 and "B: stopped" in answer.output


def test_a_table_and_an_overlay_are_left_on_demand(runs: tuple[str, str, str], tmp_path: Path) -> None:
    answer = call("diff", runs[0], runs[1], "-o", tmp_path / "d")
    assert answer.exit_code == 4
    assert {p.name for p in (tmp_path / "d").iterdir()} == {"diff.csv", "diff.png", ".wrsim"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--only", "Q_maxx"], "--only Q_maxx: neither result has it (did you mean 'Q_max_kN'?)"),
        (["--tolerance", "-1"], "--tolerance -1: must be a number not below 0"),
    ],
)
def test_faults_of_a_comparison_are_one_sentence(options: list[str], message: str, runs: tuple[str, str, str]) -> None:
    assert message in refusal("diff", runs[0], runs[1], *options)


def test_results_of_two_kinds_are_not_compared(runs: tuple[str, str, str]) -> None:
    assert "both must be of one kind" in refusal("diff", runs[0], str(Path(runs[0]).with_name("d")))


def test_a_key_is_set_on_the_command_line() -> None:
    values = ["--set", "track.gauge_mm=1440", "-s", "contact.normal=strips", "--set", 'title="mine"']
    answer = ok("check", EQUILIBRIUM, "--json", *values)
    found = json.loads(answer.output)
    assert (found["gauge_mm"], found["normal"], found["title"]) == (pytest.approx(1440.0), "strips", "mine")


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("track.gauge_mm", "--set track.gauge_mm: must be key=value, such as vehicle.speed_kmh=60"),
        ("track.gauge_mm=wide", '--set track.gauge_mm=wide: track.gauge_mm = "wide": must be a number from'),
        ("contact.nromal=strips", '--set contact.nromal=strips: contact.nromal = "strips": unknown key; '),
        ("track.segments[7].length_m=3", "track.segments"),
    ],
)
def test_a_wrong_key_on_the_command_line_is_one_sentence(value: str, message: str) -> None:
    assert message in refusal("check", EQUILIBRIUM, "--set", value)
