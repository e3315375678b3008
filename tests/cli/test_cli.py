"""The command line: what it prints, what it leaves on disk, how it ends."""

import errno
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from support.commands import call, forked, on_a_terminal, refusal
from support.rows import rows_of
from support.runs import SCENARIOS
from support.scenario_texts import CURVE, edited
from support.synthetic_result import curve_run, static_poses

import wrsim.analysis
from wrsim import Result, SimulationError
from wrsim.cli import console
from wrsim.cli.console import plain
from wrsim.inputs.lookup import shipped_models

table = rows_of(__file__)


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


def test_bad_input_is_one_message_on_stderr_or_a_json_object_and_exit_code_2(scenario: Path) -> None:
    scenario.write_text(edited(CURVE, "radius_m = 300", "radius_m = 0"), encoding="utf-8")
    for command in (("check",), ("run", "-o", scenario.parent / "out")):
        result = call(*command, scenario)
        assert result.exit_code == 2
        assert result.stdout == ""
        assert result.stderr.startswith(f"{scenario}:18: track.segments[2].radius_m = 0: must be")
        assert result.stderr.count("\n") == 1
    assert not (scenario.parent / "out").exists(), "a run that cannot start leaves nothing"
    scenario.write_text(
        edited(edited(CURVE, "radius_m = 300", "radius_m = 0"), "friction = 0.35", "mu = 1"), encoding="utf-8"
    )
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
    scenario.write_text(edited(CURVE, "rails/60E1.toml", "rail.toml"), encoding="utf-8")
    assert call("check", scenario).exit_code == 2
    assert call("check", scenario, "--models", tmp_path / "mine").exit_code == 0


@pytest.mark.usefixtures("unpainted")
def test_a_run_that_stops_keeps_what_was_computed_and_says_why(scenario, tmp_path, monkeypatch):
    analysis_that(monkeypatch, stopped)
    result = call("run", scenario, "-o", tmp_path / "out", "--no-pictures")
    assert result.exit_code == 3
    assert "stopped: " + stopped().stop_reason in result.stderr
    assert f"wrsim plot {tmp_path / 'out'}" in result.stderr
    kept = Result.load(tmp_path / "out")
    assert kept.status == "stopped"


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
def test_no_error_ends_in_a_traceback(scenario, tmp_path, monkeypatch, error, code, message):
    analysis_that(monkeypatch, failing(error))
    result = call("run", scenario, "-o", tmp_path / "out")
    assert result.exit_code == code
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    for_machines = call("run", scenario, "-o", tmp_path / "out", "--json")
    assert json.loads(for_machines.stdout)["error"]["exit_code"] == for_machines.exit_code == code


def test_an_internal_error_shows_its_traceback_to_who_asks(scenario, tmp_path, monkeypatch):
    analysis_that(monkeypatch, failing(ZeroDivisionError("here")))
    monkeypatch.setenv("WRSIM_DEBUG", "1")
    assert isinstance(call("run", scenario, "-o", tmp_path / "out").exception, ZeroDivisionError)


def test_a_place_that_may_not_be_written_is_told_before_anything_is_computed(scenario, tmp_path, monkeypatch):
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


@pytest.mark.parametrize(
    ("settings", "threads"),
    [({}, ["1", "1"]), ({"OPENBLAS_NUM_THREADS": "2"}, ["2", "1"]), ({"OMP_NUM_THREADS": "2"}, ["None", "None"])],
)
def test_the_command_has_one_thread_of_blas_unless_the_user_says_how_many(settings, threads) -> None:
    names = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")} | settings
    code = f"""import os, sys, wrsim.cli
print(*(os.environ.get(name) for name in {names}), "numpy" in sys.modules)
import numpy
print(len(os.listdir("/proc/self/task")) if sys.platform == "linux" and not {settings} else 1)"""
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [*threads, "False", "1"]


# What reaches the terminal, whatever it is, and whoever wrote the text.


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result whose title would colour the terminal and rename its window."""
    folder = tmp_path_factory.mktemp("run")
    dataset = static_poses((5.0,), (0.0,), ("left",)).copy()  # it is kept for others
    dataset.attrs["title"] = "Kurve \u00e4 \u03b3 \x1b]0;owned\x07 \x1b[31mred\x9b5m"
    Result(dataset).save(folder / "result.nc")
    (folder / "curve.toml").write_text(edited(CURVE, 'title = "a curve"', 'title = "\u00e4 \\u001b[31m"'))
    return folder


def test_control_characters_do_not_reach_the_terminal_lines_and_tabs_do(folder: Path) -> None:
    for command in (("show", folder), ("check", folder / "curve.toml"), ("show", folder / "no\x1b[31m.nc")):
        done = forked(*command)
        text = done.stdout + done.stderr
        assert "\N{REPLACEMENT CHARACTER}" in text
        assert not set(text) & {"\x1b", "\x07", "\x9b"}
    assert plain("a\tb\n\u00e4\u03b3") == "a\tb\n\u00e4\u03b3"
    assert plain("\u202egnp.exe") == "\N{REPLACEMENT CHARACTER}gnp.exe"


def test_a_terminal_is_told_what_goes_on_before_a_run(tmp_path: Path) -> None:
    """Compiling stands in the bar of the run, too; its words come by the same way."""
    scenario = tmp_path / "curve.toml"
    scenario.write_text(edited(CURVE, "[run]\n", "[run]\nstart_distance_m = 20\ntime_s = 0.02\n"))
    done = on_a_terminal("run", scenario, "-o", tmp_path / "out", "--no-pictures")
    assert done.returncode == 0, done.stdout
    assert "steady motion at the start: wheelset S1002" in done.stdout
    assert "internal error" not in done.stdout


@pytest.mark.parametrize("quiet", [False, True])
def test_a_pipe_gets_a_line_of_progress_now_and_then(tmp_path: Path, quiet: bool) -> None:
    scenario = tmp_path / "curve.toml"
    scenario.write_text(edited(CURVE, "[run]\n", "[run]\nstart_distance_m = 20\ntime_s = 0.02\n"))
    command = ("run", scenario, "-o", tmp_path / "out", "--no-pictures", *["--quiet"] * quiet)
    done = forked(*command, first=lambda: setattr(console, "LINES_APART", 0.0))
    lines = done.stderr.splitlines()
    assert done.returncode == 0 and bool(done.stdout or lines) != quiet
    assert quiet or (lines[-1].startswith("100%") and any("steady motion" in line for line in lines))


def test_verbose_names_each_part_of_a_run_its_time_and_the_contacts_that_were_solved(tmp_path: Path) -> None:
    values = ("-s", "run.distance_m=0.3", "-s", "output.patches_at_m=[0.1]")
    done = forked("run", SCENARIOS / "curve_r300.toml", *values, "-v", "-o", tmp_path, "--no-pictures", "--json")
    parts = dict(re.findall(r"^ *\d+\.\d\d s  ([^,:\n]+)(.*)$", done.stderr, re.MULTILINE))
    order = ["scenario read and checked", "vehicle", "steady motion at the start", "time step chosen", "integration"]
    assert [part for part in parts if part in order] == order
    took = json.loads(done.stdout)["summary"]["integration"]["evaluations"]
    assert f"{took} evaluations of the forces" in parts["integration"]
    assert f"{2 * took} contacts of a wheel" in parts["integration"]


def test_a_terminal_that_cannot_take_every_letter_gets_what_it_can(folder: Path) -> None:
    done = forked("show", folder, encoding="ascii")
    assert done.returncode == 0, done.stderr
    assert "Kurve \\xe4" in done.stdout


@pytest.mark.parametrize(("arguments", "message"), table("wrong_usage_is_json_for_machines"))
def test_wrong_usage_is_json_for_machines(arguments: tuple[str, ...], message: str) -> None:
    done = forked(*arguments)
    error = json.loads(done.stdout)["error"]
    assert done.returncode == error["exit_code"] == 2
    assert error["kind"] == "UsageError"
    assert message in error["messages"][0]
    assert done.stderr == ""


@pytest.mark.parametrize(("left", "waited", "text"), [
    (90.0, 0.0, "1.5 min left"), (1.0, 0.0, "1 s left"), (10.0, 8.0, "2 s left"), (float("inf"), 50.0, ""),
    (1.0, 45.0, "45 s since the last step, longer than expected"),
])  # fmt: skip
def test_the_time_left_runs_down_and_is_withdrawn_when_it_is_over(left: float, waited: float, text: str) -> None:
    assert console.time_left(left, waited) == text
