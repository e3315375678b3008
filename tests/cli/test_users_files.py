"""Nothing of the user's is written over, no command gets in another one's way, a run is whole when its files are."""

import os
import shutil
import sys
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pytest
from support.commands import call, ok, refusal
from support.files import LINKS
from support.scenario_texts import CURVE
from support.synthetic_result import curve_run, static_poses

import wrsim.analysis
from wrsim.errors import InputError
from wrsim.inputs.lookup import shipped_models
from wrsim.report.output_folder import OUTPUTS
from wrsim.results import Result, write_atomically, write_run
from wrsim.results.files import MANIFEST, Keeper, Manifest, keeping
from wrsim.results.run_file import RunFile


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    file = tmp_path / "curve.toml"
    file.write_text(CURVE)
    return file


@pytest.fixture(autouse=True)
def analysed(monkeypatch: pytest.MonkeyPatch, unpainted: None) -> list[str]:
    """A synthetic run in the place of the real ones; the list gains a title for every run."""
    runs: list[str] = []

    def run(scenario: Any, progress: Any = None, record: Any = None, resume: bool = False, **_: Any) -> Result:
        runs.append(scenario.title)
        dataset = curve_run(samples=40)
        dataset.attrs["scenario_text"] = scenario.text
        return Result(dataset)

    monkeypatch.setattr(wrsim.analysis, "run", run, raising=False)
    return runs


def contents(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.name != MANIFEST}


def test_a_run_does_not_write_over_a_file_of_the_users(scenario: Path, tmp_path: Path, analysed: list[str]):
    out, name = tmp_path / "out", "wheelset_1/patches.csv"
    (out / name).parent.mkdir(parents=True)
    (out / name).write_text("mine")
    refused = refusal("run", scenario, "-o", out)
    assert f"{out / name}: would be written over, but wrsim did not write it" in refused
    assert "--force" in refused
    assert (out / name).read_text() == "mine"
    assert len([path for path in out.rglob("*") if path.is_file() and path.name != ".wrsim"]) == 1
    assert not analysed, "refused before anything is computed"
    assert call("run", scenario, "-o", out, "--no-pictures", "--force").exit_code == 0
    assert (out / "scenario.toml").read_text() == CURVE


def test_what_wrsim_wrote_it_may_write_again_but_not_what_was_changed_since(scenario: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for _ in range(2):
        assert call("run", scenario, "-o", out, "--no-pictures").exit_code == 0
    with open(out / "history.csv", "a", encoding="utf-8") as table:
        table.write("a note of mine\n")
    refused = refusal("run", scenario, "-o", out, "--no-pictures")
    assert f"{out / 'history.csv'}: would be written over" in refused
    assert "or it has changed since" in refused


def test_the_base_of_a_scenario_is_not_replaced_by_the_record_of_its_run(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call("run", _written(tmp_path / "first.toml", CURVE), "-o", out, "--no-pictures").exit_code == 0
    child = _written(tmp_path / "child.toml", 'base = "out/scenario.toml"\ntitle = "child"\n')
    refused = refusal("run", child, "-o", out, "--no-pictures")
    assert f"{out / 'scenario.toml'}: would be written over, but the input is read from it" in refused
    assert (out / "scenario.toml").read_text() == CURVE


def _written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("command", "name"),
    [("report", "report.html"), ("view", "view.html"), ("plot", "contact.png"), ("export --to mat", "result.mat")],
)
def test_no_command_writes_over_a_file_of_the_users(command: str, name: str, tmp_path: Path) -> None:
    Result(static_poses((0.0, 5.0), (0.0,))).save(tmp_path / "result.nc")
    (tmp_path / name).write_text("mine")
    assert f"{tmp_path / name}: would be written over" in refusal(*command.split(), tmp_path)
    assert (tmp_path / name).read_text() == "mine"
    if command == "view":
        ok(command, tmp_path, "--force")
        ok(command, tmp_path)


NO_PIPES = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pipes in folders")
NO_LINKS = pytest.mark.skipif(not LINKS, reason="symbolic links are a right on Windows")


@NO_PIPES
@pytest.mark.parametrize("kind", ["a pipe", pytest.param("a device", marks=pytest.mark.campaign)])
def test_force_does_not_replace_what_is_no_plain_file(kind: str, tmp_path: Path) -> None:
    picture = tmp_path / "wheel.png"
    if kind == "a pipe":
        os.mkfifo(picture)
    else:
        picture.symlink_to("/dev/null")
    refused = refusal("profile", shipped_models() / "wheels/S1002.toml", "-o", picture, "--force")
    assert f"{picture}: is {kind}; a file of that name is written" in refused
    with pytest.raises(InputError, match=f"is {kind}"):  # from Python as well, where nobody keeps the folder
        write_atomically(picture, b"x")
    assert picture.is_fifo() or picture.is_symlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["wheel.png"]


@NO_LINKS
@pytest.mark.parametrize("kind", [pytest.param("a pipe", marks=pytest.mark.campaign), "a symbolic link"])
def test_a_manifest_that_is_no_plain_file_is_refused_and_not_written_through(kind: str, tmp_path: Path) -> None:
    target = _written(tmp_path / "letter.txt", "mine")
    out = tmp_path / "out"
    out.mkdir()
    if kind == "a pipe":
        os.mkfifo(out / MANIFEST)
    else:
        (out / MANIFEST).symlink_to(target)
    assert f"is {kind}" in refusal("profile", "wheels/S1002.toml", "-o", out / "wheel.png")
    assert target.read_text() == "mine"


def test_every_name_that_write_run_uses_is_looked_at_beforehand(tmp_path: Path) -> None:
    """The patterns of the early look cover all tables of runs."""
    written = write_run(Result(curve_run(samples=40)), tmp_path)
    assert all(any(fnmatch(f.name, pattern) for pattern in OUTPUTS) for f in written)


@NO_LINKS
@pytest.mark.parametrize("content", [b"a letter of mine" * 10, b""])
def test_the_target_of_a_link_in_the_place_of_a_run_file_is_left_alone(tmp_path: Path, content: bytes) -> None:
    target, link = tmp_path / "letter.txt", tmp_path / "result.nc.part"
    target.write_bytes(content)
    link.symlink_to(target)
    with pytest.raises(InputError, match="is a symbolic link"):
        RunFile(link)
    assert target.read_bytes() == content


def test_only_what_carries_our_signature_is_cut(tmp_path: Path) -> None:
    path = tmp_path / "result.nc.part"
    path.write_bytes(b"a letter of mine")
    with pytest.raises(InputError, match="not the file of a run of wrsim"):
        RunFile(path)
    assert path.read_bytes() == b"a letter of mine"
    path.write_bytes(b"wrsim r")  # a run that was killed at its start
    RunFile(path).close()


def test_a_second_run_into_a_folder_in_use_changes_nothing_there(scenario: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call("run", scenario, "-o", out, "--no-pictures").exit_code == 0
    before = contents(out)
    second_scenario = _written(tmp_path / "other.toml", CURVE.replace("a curve", "another"))
    with Manifest(out).locked():
        refused = call("run", second_scenario, "-o", out, "--no-pictures")
    assert refused.exit_code == 2
    assert "another run is writing into it" in refused.stderr
    assert contents(out) == before
    assert call("run", second_scenario, "-o", out, "--no-pictures").exit_code == 0, "the lock is gone with its holder"


def test_tables_and_pictures_belong_to_the_run_until_they_are_there(scenario, tmp_path, monkeypatch, analysed):
    """Killed while they are written, a run that is gone on with makes them."""
    whole, out = tmp_path / "whole", tmp_path / "out"
    assert call("run", scenario, "-o", whole).exit_code == 0

    def killed(*arguments: Any) -> Any:
        raise KeyboardInterrupt  # as good as any end half-way

    with monkeypatch.context() as patch:
        patch.setattr("wrsim.plots.standard_figures", killed)
        assert call("run", scenario, "-o", out).exit_code == 130
    assert set(contents(out)) < set(contents(whole))
    ok("run", scenario, "-o", out, "--resume")
    assert Result.load(out).dataset.identical(Result.load(whole).dataset)
    made, wanted = contents(out), contents(whole)
    del made["result.nc"], wanted["result.nc"]  # netCDF-C writes the time of the clock into it
    assert made == wanted
    before = len(analysed)
    told = call("run", scenario, "-o", out, "--resume")
    assert "holds the whole result of this scenario already" in told.stderr
    assert len(analysed) == before
    (out / "overview.png").unlink()
    assert call("run", scenario, "-o", out, "--resume").exit_code == 0
    assert (out / "overview.png").exists(), "what was deleted is drawn again from the result"
    assert len(analysed) == before


def test_what_a_killed_run_had_not_finished_goes_and_nothing_else(scenario: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    unfinished = [".history.csv.0a1b2c3d.part", ".result.nc.k2_x9abc.part"]
    users_files = [".notes.part", "history.csv.0a1b2c3d.part", ".history.csv.0a1b2c3d.parts"]
    for name in (*unfinished, *users_files):
        (out / name).write_text("begun")
    if LINKS:
        users_files.append(".link.csv.0a1b2c3d.part")
        (out / users_files[-1]).symlink_to(out / users_files[0])
    ok("run", scenario, "-o", out)
    left = {path.name for path in out.iterdir()}
    assert not left & set(unfinished)
    assert left >= {*users_files}


def test_a_folder_deleted_during_a_run_is_made_anew(scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    out = tmp_path / "out"
    analysis = wrsim.analysis.run

    def deleting(*arguments: Any, **options: Any) -> Result:
        shutil.rmtree(out)
        return analysis(*arguments, **options)

    monkeypatch.setattr(wrsim.analysis, "run", deleting)
    assert call("run", scenario, "-o", out).exit_code == 0
    assert {"scenario.toml", "result.nc", "history.csv", "overview.png"} <= set(contents(out))


def test_a_torn_line_of_the_manifest_hides_no_other(tmp_path: Path) -> None:
    with keeping(Keeper()):
        write_atomically(tmp_path / "a.csv", b"1")
    with open(tmp_path / MANIFEST, "ab") as stream:
        stream.write(b'{"file": "b.csv", "sha')
    with keeping(Keeper()):
        write_atomically(tmp_path / "c.csv", b"2")
        write_atomically(tmp_path / "a.csv", b"3")
        write_atomically(tmp_path / "c.csv", b"4")
    assert (tmp_path / "a.csv").read_bytes() == b"3"


def test_a_file_noted_but_not_written_before_a_kill_is_still_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The line stands before the file does, so both the old and the new file are known."""
    with keeping(Keeper()):
        write_atomically(tmp_path / "a.csv", b"old")
        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            patch.setattr(os, "replace", lambda *a: (_ for _ in ()).throw(KeyboardInterrupt))
            write_atomically(tmp_path / "a.csv", b"new")
        write_atomically(tmp_path / "a.csv", b"newer")
    assert (tmp_path / "a.csv").read_bytes() == b"newer"


def test_python_writes_where_it_is_told(tmp_path: Path) -> None:
    """Only commands keep a manifest: who names a file in a program of their own means it."""
    (tmp_path / "a.csv").write_bytes(b"mine")
    write_atomically(tmp_path / "a.csv", b"new")
    assert not (tmp_path / MANIFEST).exists()
