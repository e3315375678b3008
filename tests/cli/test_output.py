"""What reaches the terminal, whatever it is, and whoever wrote the text."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.commands import forked, on_a_terminal
from support.rows import rows_of
from support.runs import SCENARIOS
from support.scenario_texts import CURVE, edited
from support.synthetic_result import static_poses

from wrsim.cli import console
from wrsim.cli.console import plain
from wrsim.results import Result

table = rows_of(__file__)


COMMAND = [sys.executable, "-c", "from wrsim.cli import main; main()"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result whose title would colour the terminal and rename its window."""
    folder = tmp_path_factory.mktemp("run")
    dataset = static_poses((5.0,), (0.0,), ("left",)).copy()  # it is kept for others
    dataset.attrs["title"] = "Kurve \u00e4 \u03b3 \x1b]0;owned\x07 \x1b[31mred\x9b5m"
    Result(dataset).save(folder / "result.nc")
    (folder / "curve.toml").write_text(edited(CURVE, 'title = "a curve"', 'title = "\u00e4 \\u001b[31m"'))
    return folder


def test_control_characters_of_others_do_not_reach_the_terminal(folder: Path) -> None:
    for command in (("show", folder), ("check", folder / "curve.toml"), ("show", folder / "no\x1b[31m.nc")):
        done = forked(*command)
        text = done.stdout + done.stderr
        assert "\N{REPLACEMENT CHARACTER}" in text
        assert not set(text) & {"\x1b", "\x07", "\x9b"}


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


def test_text_with_lines_and_tabs_stays_as_it_is() -> None:
    assert plain("a\tb\n\u00e4\u03b3") == "a\tb\n\u00e4\u03b3"
    assert plain("\u202egnp.exe") == "\N{REPLACEMENT CHARACTER}gnp.exe"


def test_a_terminal_that_cannot_take_every_letter_gets_what_it_can(folder: Path) -> None:
    done = forked("show", folder, encoding="ascii")
    assert done.returncode == 0, done.stderr
    assert "Kurve \\xe4" in done.stdout


@pytest.mark.campaign
def test_closed_outputs_do_not_spoil_the_work(folder: Path) -> None:
    command = ["sh", "-c", '"$@" >&- 2>&-', "sh", *COMMAND, "show", str(folder)]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize(("arguments", "words"), table("wrong_usage_is_json_for_machines"))
def test_wrong_usage_is_json_for_machines(arguments: tuple[str, ...], words: str) -> None:
    done = forked(*arguments)
    error = json.loads(done.stdout)["error"]
    assert done.returncode == error["exit_code"] == 2
    assert error["kind"] == "UsageError"
    assert words in error["messages"][0]
    assert done.stderr == ""
