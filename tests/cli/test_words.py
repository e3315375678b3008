"""What commands say: peaks with their signs, medians, times, help that is whole, one meaning of every option."""

import inspect
import json
import re
import time
from itertools import combinations, product
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import xarray as xr
from support.commands import call, ok, refusal
from support.rows import rows_of
from support.scenario_texts import CURVE
from support.synthetic_result import curve_run, static_poses
from typer.main import get_command
from typer.testing import CliRunner

import wrsim.analysis
from wrsim.api.options import PARAMETERS, Option
from wrsim.cli import application
from wrsim.cli.commands import PANELS
from wrsim.jit.compiling import Kernel
from wrsim.plots.moments import moment_title
from wrsim.results import Result
from wrsim.results.differences import differences
from wrsim.results.table import Column, Table, on_terminal

app = application()

table = rows_of(__file__)

runner = CliRunner()
COMMANDS = get_command(application()).commands  # type: ignore[attr-defined]
FUNCTIONS = {
    "new": "new_file", "run": "run_scenario", "study": "run_study", "type-test": "run_type_test", "wear": "run_wear",
    "plot": "write_pictures", "report": "write_report", "view": "write_view", "vehicle": "stationary",
    "live": "write_live", "profile": "profiles", "track": "draw_track", "recording": "read_recording",
    "fmu": "write_unit",
}  # fmt: skip
"""Functions of commands that have another name."""


@pytest.fixture(scope="module")
def run() -> Result:
    return Result(curve_run(samples=60))


def test_the_track_shifting_force_and_the_balance_of_energy_are_told(run: Result) -> None:
    y = run.dataset["Y"].values
    assert run.dataset["sum_Y"].values == pytest.approx(y[:, :, 0] - y[:, :, 1])
    largest = run.summary()["wheelsets"]["wheelset"]["sum_Y_max_kN"]["value"]
    assert abs(largest) == pytest.approx(1e-3 * np.abs(y[:, 0, 0] - y[:, 0, 1]).max())
    # 1 MJ of pull, a quarter of it lost in creep, the rest in motion: nothing is left over, nothing else is told
    time = run.dataset["time"].values
    even = np.full_like(time, 1.0 / (time[-1] - time[0]))
    values = {"pull_power": 1e6 * even, "creep_power": 2.5e5 * even, "damper_power": 0.0 * even}
    values |= {"kinetic_energy": 7.5e5 * (time - time[0]) * even, "potential_energy": 0.0 * even}
    result = Result(run.dataset.assign({name: ("time", value) for name, value in values.items()}))
    (table,) = (table for table in result.numbers() if table.title == "Energy balance")
    rows = dict(table.rows)
    assert abs(rows.pop("stored elastically, rest")) < 1e-6
    balance = {"traction work": 1000.0, "lost in creep": 250.0, "change of kinetic energy": 750.0}
    assert rows == pytest.approx(balance, rel=1e-3)


@pytest.mark.parametrize("columns", [40, 78, 200])
def test_no_number_of_a_table_is_cut_however_narrow_the_terminal(columns: int, capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    rows = [["a long name of a wheel", "0.0769812", "-0.0079512 at 135.9 m"], ["right", "12", "7"]]
    on_terminal([Table("", tuple(map(Column, ("wheel", "derailment quotient", "difference %"))), rows)])
    told = capsys.readouterr().out
    assert all(cell in told for row in rows for cell in row) and "…" not in told
    heading = told.partition("a long")[0].split()
    assert sorted(heading) == sorted(["wheel", "derailment", "quotient", "difference", "%"])


def _one_more(x: int) -> int:
    return x + 1


def test_the_time_that_a_run_took_is_told_beside_the_time_on_the_track(run, tmp_path, monkeypatch):
    monkeypatch.setattr(wrsim.analysis, "run", lambda *_, **__: run, raising=False)
    (tmp_path / "curve.toml").write_text(CURVE)
    command = ("run", tmp_path / "curve.toml", "-o", tmp_path / "out", "--no-pictures")
    lasted = float(np.ptp(run.dataset["time"].values))
    told = call(*command).stdout
    assert f"{lasted:.4g} s on the track in " in told
    assert told.splitlines()[-1] == f"HTML report: wrsim report {tmp_path / 'out'}"
    summary = json.loads(call(*command, "--json").stdout)["summary"]
    assert summary["times_real_time"] == pytest.approx(summary["wall_time_s"] / lasted, abs=1e-3)
    assert summary["compiling_s"] == 0.0 and "compiling" not in told

    def compiles(*_: object, **__: object) -> Result:
        made = Kernel(_one_more, targetoptions={"nopython": True})
        assert made(1) == 2
        return run

    monkeypatch.setattr(wrsim.analysis, "run", compiles, raising=False)
    began = time.perf_counter()
    summary = json.loads(call(*command, "--json").stdout)["summary"]
    assert summary["compiling_s"] > 0.0
    assert 0.0 <= summary["wall_time_s"] <= time.perf_counter() - began - summary["compiling_s"] + 1e-3


def test_help_loses_no_word() -> None:
    """What stands in brackets is no markup of the terminal's."""
    for name, command in COMMANDS.items():
        texts = [command.help, *(p.help for p in command.params if getattr(p, "help", None))]
        told = " ".join(runner.invoke(app, [name, "-h"], env={"COLUMNS": "400", "NO_COLOR": "1"}).stdout.split())
        for bracketed in re.findall(r"\S*\[[^\]]+\]", " ".join(filter(None, texts)).replace("\\[", "[")):
            assert bracketed in told, (name, bracketed)


def test_a_parameter_is_described_alike_in_help_and_docstring() -> None:
    for panel in PANELS.values():
        for name in panel.keys() - {"warm"}:
            function = next(f for f in PARAMETERS if f.__name__ == FUNCTIONS.get(name, name))
            text = " ".join(inspect.cleandoc(function.__doc__ or "").split())
            assert " ".join(COMMANDS[name].help.split()) in text, name
            helps = {p.name: p.help.replace("\\[", "[") for p in COMMANDS[name].params}
            for parameter in PARAMETERS[function]:
                option = get_args(parameter.annotation)[1]
                described = option.help if isinstance(option, Option) else option
                assert f"{parameter.name} : " in text and described in text, (name, parameter.name)
                assert not isinstance(option, Option) or any(described in each for each in helps.values()), (
                    name,
                    option,
                )


def test_one_option_means_one_thing_in_all_commands() -> None:
    meanings: dict[str, set[str]] = {}
    for command in COMMANDS.values():
        for option in command.params:
            for name in getattr(option, "opts", ()):
                meanings.setdefault(name, set()).add(str(option.name))
    assert {name: targets for name, targets in meanings.items() if name.startswith("-") and len(targets) > 1} == {}
    assert (meanings["-o"], meanings["--models"]) == ({"output"}, {"models"})
    orders = ([o.name for o in c.params if o.opts[0].startswith("-")] for c in COMMANDS.values())
    pairs = {pair for order in orders for pair in combinations(order, 2)}
    assert not {(a, b) for a, b in pairs if (b, a) in pairs}, "the same order in the help of all commands"
    assert {o.metavar for c in COMMANDS.values() for o in c.params if "--models" in getattr(o, "opts", ())} == {"DIR"}


def test_the_same_place_means_the_same_to_plot_and_resolve(tmp_path: Path) -> None:
    """A place is where the vehicle is, as in patches_at_m, whatever the wheelset; pictures give both."""
    front = curve_run(samples=40).assign_coords(wheelset=["front"])
    rear = front.assign_coords(wheelset=["rear"])
    rear["wheelset_distance"] = rear["wheelset_distance"] - 17.5
    vehicle = xr.concat(
        [front, rear], "wheelset", data_vars="minimal", coords="minimal", compat="override", join="override"
    )
    Result(vehicle).save(tmp_path / "result.nc")
    place = float(front["snapshot_distance"].values[0])
    for name, command in product(("front", "2"), ("plot", "resolve")):
        told = call(command, tmp_path, "--wheelset", name, "--at", "9999")
        assert f"of that distance of the vehicle; there are {place:.1f}, " in told.stderr, (command, name)
    told = call("plot", tmp_path, "--wheelset", "2", "--at", f"{place:.1f}")
    assert (tmp_path / f"wheelset_2/patches_at_{place:.1f}.png").is_file(), told.output
    titles = [moment_title(Result(vehicle).wheelset(name), 0, 0) for name in ("front", "rear")]
    assert titles[0].startswith(f"(a) {place:.1f} m")
    assert titles[1].startswith(f"(a) vehicle {place:.1f} m, wheelset {place - 17.5:.1f} m")


@pytest.mark.parametrize("command", ["diff", "resolve", "ride"])
def test_a_result_that_cannot_be_used_is_named_in_one_line(command: str, run: Result, tmp_path: Path) -> None:
    """Of a scenario with several faults the first is told: its reader has not written it."""
    file, readable = tmp_path / "odd.nc", tmp_path / "other.nc"
    Result(static_poses() if command != "resolve" else run.dataset.assign_attrs(scenario_text="a = 1\nb = 2\n")).save(
        file
    )
    run.save(readable)
    told = call(command, file, *((readable,) if command == "diff" else ()))
    assert told.exit_code == 2 and str(file) in told.stderr and told.stderr.count("\n") == 1
    assert (" more lines)" in told.stderr) == (command == "resolve")


@pytest.mark.usefixtures("unpainted")
def test_a_result_does_not_keep_files_of_the_one_before(run: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Files of wrsim's go, also what later commands made of that result; the user's and changed ones stay."""
    monkeypatch.setattr(wrsim.analysis, "run", lambda *_, **__: run, raising=False)
    (tmp_path / "curve.toml").write_text(CURVE)
    out = tmp_path / "out"
    assert call("run", tmp_path / "curve.toml", "-o", out).exit_code == 0
    assert call("export", out, "--to", "mat").exit_code == 0
    assert call("new", "-o", out / "template.toml").exit_code == 0
    (out / "notes.txt").write_text("mine")
    (out / "forces.png").write_bytes((out / "forces.png").read_bytes() + b"edited")
    poses = Result(static_poses())
    monkeypatch.setattr(wrsim.analysis, "run", lambda *_, **__: poses, raising=False)
    told = json.loads(call("run", tmp_path / "curve.toml", "-o", out, "--no-pictures", "--json").stdout)
    names = {path.name for path in out.iterdir()}
    assert {"notes.txt", "forces.png", "template.toml", "patches.csv", "result.nc"} <= names
    assert not {"overview.png", "history.csv", "result.mat"} & names
    assert {Path(f).name for f in told["removed"]} >= {"overview.png", "history.csv", "result.mat"}


def test_a_shortened_run_leaves_out_the_patches_that_it_does_not_reach(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CURVE + "\n[output]\npatches_at_m = [40, 150]\n")
    told = ok("check", tmp_path / "case.toml", "--set", "run.distance_m=60")
    assert "150 m is not passed by the run" in told.stderr
    (tmp_path / "case.toml").write_text(CURVE + "\n[output]\npatches_at_m = [40, 5000]\n")
    told = call("check", tmp_path / "case.toml")
    assert (told.exit_code, "5000 m is not on the track" in told.stderr) == (2, True)


# Two results side by side, and keys that are set on the command line.


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """A run, and the same with Q of the right wheel 2 % larger."""
    folder = tmp_path_factory.mktemp("runs")
    run = curve_run()
    Result(run).save(folder / "a" / "result.nc")
    loaded = run.copy(deep=True)
    loaded["Q"].loc[{"wheel": "right"}] *= 1.02
    Result(loaded).save(folder / "b" / "result.nc")
    return str(folder / "a"), str(folder / "b")


def test_the_exit_code_says_whether_a_change_is_beyond_the_tolerance(runs: tuple[str, str]) -> None:
    beyond = call("diff", runs[0], runs[1], "--json")
    assert beyond.exit_code == 4
    answer = json.loads(beyond.output)
    changed = {(d["place"], d["quantity"]) for d in answer["differences"] if d["difference"]}
    assert all("right" in place and quantity.startswith("Q_") for place, quantity in changed)
    assert ("wheelset right", "Q_max_kN") in changed
    largest = max(d["relative"] for d in answer["differences"])
    assert largest == pytest.approx(0.02 / 1.02, rel=1e-6)  # of the larger one
    assert call("diff", runs[0], runs[1], "--tolerance", "0.03").exit_code == 0
    assert call("diff", runs[0], runs[1], "--only", "Y_over_Q_max").exit_code == 0
    assert call("diff", runs[0], runs[0], "--tolerance", "0").exit_code == 0


def test_a_number_that_cannot_be_told_from_zero_has_no_change_in_percent() -> None:
    """A part of a balance is measured against the largest of all."""
    run = curve_run()
    time = run["time"]
    height = 1e6 + 1e-3 * time / float(time[-1])  # round-off of a large energy
    energies = {"kinetic_energy": 5e5 + 0.0 * time, "potential_energy": height}
    run = run.assign(energies | {f"{of}_power": 1e3 + 0.0 * time for of in ("pull", "creep", "damper")})
    changed = run.copy(deep=True)
    changed["potential_energy"] = 1e6 - 2.0 * (height - 1e6)
    energies_diff = {d.quantity: d for d in differences(Result(run), Result(changed), (), 0.01) if d.place == "energy"}
    assert energies_diff["gained_in_height_kJ"].change is None and energies_diff["gained_in_height_kJ"].relative < 1e-4
    changed["creep_power"] *= 1.1
    energies_diff = {d.quantity: d for d in differences(Result(run), Result(changed), (), 0.01) if d.place == "energy"}
    assert energies_diff["lost_in_creep_kJ"].change == pytest.approx(10.0)


@pytest.mark.parametrize(("options", "message"), table("faults_of_a_comparison_are_one_sentence"))
def test_faults_of_a_comparison_are_one_sentence(options: list[str], message: str, runs: tuple[str, str]) -> None:
    assert message in refusal("diff", runs[0], runs[1], *options)
