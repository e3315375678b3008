"""The command line: what it prints, what it leaves on disk, how it ends."""

import errno
import json
import os
from pathlib import Path
from typing import Any

import pytest
from support.commands import call, forked, refusal
from support.scenario_texts import CURVE, edited
from support.synthetic_result import curve_run

import wrsim.analysis
from wrsim.errors import SimulationError
from wrsim.inputs.lookup import shipped_models
from wrsim.results import Result


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    file = tmp_path / "curve.toml"
    file.write_text(CURVE)
    return file


def analysis_that(monkeypatch: pytest.MonkeyPatch, does: Any) -> list[dict[str, Any]]:
    """Put ``does()`` in the place of the analyses; returns a record of its calls."""
    calls: list[dict[str, Any]] = []

    def run(scenario: Any, progress: Any = None, record: Any = None, resume: bool = False, **_: Any) -> Result:
        calls.append({"scenario": scenario, "progress": progress})
        return does()

    monkeypatch.setattr(wrsim.analysis, "run", run, raising=False)
    return calls


def completed() -> Result:
    return Result(curve_run(samples=40))


def stopped() -> Result:
    return Result(curve_run(samples=40, stopped=True))


def test_bad_input_is_one_message_on_stderr_and_exit_code_2(scenario: Path) -> None:
    scenario.write_text(edited(CURVE, "radius_m = 300", "radius_m = 0"))
    for command in (("check",), ("run", "-o", scenario.parent / "out")):
        result = call(*command, scenario)
        assert result.exit_code == 2
        assert result.stdout == ""
        assert result.stderr.startswith(f"{scenario}:18: track.segments[2].radius_m = 0: must be")
        assert result.stderr.count("\n") == 1
    assert not (scenario.parent / "out").exists(), "a run that cannot start leaves nothing"


def test_bad_input_is_a_json_object_for_machines(scenario: Path) -> None:
    scenario.write_text(edited(edited(CURVE, "radius_m = 300", "radius_m = 0"), "friction = 0.35", "mu = 1"))
    result = call("run", scenario, "--json")
    assert result.exit_code == 2
    error = json.loads(result.stdout)["error"]
    assert error["kind"] == "InputError"
    assert error["exit_code"] == 2
    assert len(error["messages"]) == 2
    assert result.stderr == ""


@pytest.mark.parametrize("name", ["nothing.toml", "."])
def test_a_file_that_cannot_be_read_is_bad_input(tmp_path: Path, name: str) -> None:
    for command in ("check", "run", "profile", "plot"):
        assert str(tmp_path) in refusal(command, tmp_path / name)


def test_models_of_the_user_are_found(scenario: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/rail.toml").write_text((shipped_models() / "rails/60E1.toml").read_text())
    scenario.write_text(edited(CURVE, "rails/60E1.toml", "rail.toml"))
    assert call("check", scenario).exit_code == 2
    assert call("check", scenario, "--models", tmp_path / "mine").exit_code == 0


def test_results_go_to_a_folder_named_after_the_scenario_unless_told(
    scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    analysis_that(monkeypatch, completed)
    call("run", scenario, "--no-pictures")
    assert (tmp_path / "results/curve/result.nc").is_file()


@pytest.mark.usefixtures("unpainted")
def test_a_run_that_stops_keeps_what_was_computed_and_says_why(
    scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    analysis_that(monkeypatch, stopped)
    result = call("run", scenario, "-o", tmp_path / "out", "--no-pictures")
    assert result.exit_code == 3
    assert "stopped: " + stopped().stop_reason in result.stderr
    assert f"wrsim plot {tmp_path / 'out'}" in result.stderr
    kept = Result.load(tmp_path / "out")
    assert kept.status == "stopped"
    assert call("plot", tmp_path / "out").exit_code == 0, "what was computed can be drawn"


def failing(error: BaseException) -> Any:
    def fail() -> Result:
        raise error

    return fail


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (SimulationError("no equilibrium at 0 m"), 3, "no equilibrium at 0 m"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (OSError(errno.ENOSPC, "No space left on device"), 1, "the disk is full; free some space"),
        (PermissionError(errno.EACCES, "Permission denied", "/place"), 1, "/place: Permission denied"),
        (MemoryError(), 1, "out of memory"),
        (ZeroDivisionError("float division"), 70, "internal error: ZeroDivisionError: float division"),
    ],
)
def test_no_error_ends_in_a_traceback(
    scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int, message: str
) -> None:
    analysis_that(monkeypatch, failing(error))
    result = call("run", scenario, "-o", tmp_path / "out")
    assert result.exit_code == code
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    for_machines = call("run", scenario, "-o", tmp_path / "out", "--json")
    assert json.loads(for_machines.stdout)["error"]["exit_code"] == for_machines.exit_code == code


def test_an_internal_error_shows_its_traceback_to_who_asks(
    scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    analysis_that(monkeypatch, failing(ZeroDivisionError("here")))
    monkeypatch.setenv("WRSIM_DEBUG", "1")
    assert isinstance(call("run", scenario, "-o", tmp_path / "out").exception, ZeroDivisionError)


def test_a_place_that_may_not_be_written_is_told_before_anything_is_computed(
    scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = analysis_that(monkeypatch, completed)
    (tmp_path / "taken").write_text("a file")
    result = call("run", scenario, "-o", tmp_path / "taken")
    assert result.exit_code == 1
    assert "cannot write" in result.stderr
    assert not calls


def test_the_command_ends_quietly_when_the_reader_of_its_output_goes(scenario: Path) -> None:
    def go() -> None:
        reading, writing = os.pipe()
        os.dup2(writing, 1)
        os.close(reading)

    done = forked("check", scenario, first=go)
    assert "Traceback" not in done.stderr
    assert "Error" not in done.stderr
