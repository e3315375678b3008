"""Small samples of the figures of robustness (docs/user/robustness.md): mutants, corrupted files, long runs.

Kills are sampled by tests/analysis/test_resume.py (a run) and tests/cli/test_users_files.py (tables, pictures)."""

import json
import random
import struct
import sys
from pathlib import Path

import pytest
from support.rows import rows_of
from support.runs import STEERING, setup_of, straight
from support.scripts import ROOT, script

from wrsim import InputError, load, run
from wrsim.analysis.motion import samples
from wrsim.analysis.motion.run import run_in_time
from wrsim.report.output_folder import read

table = rows_of(__file__)

hostile = script("campaigns/hostile.py")
accepted = script("campaigns/accepted.py")
corrupted = script("campaigns/corrupted.py")
crafted = sys.modules["crafted"]
long_run = script("campaigns/long_run.py")


def test_mutated_files_are_accepted_or_refused_with_file_and_place() -> None:
    answers, slowest = hostile.counted(8, random.Random(5))
    assert set(answers) <= {"valid", "refused"}, answers
    assert slowest < hostile.LONGEST


def test_accepted_mutants_keep_the_laws_of_contact() -> None:
    ends, _ = accepted.counted(1, random.Random(3))
    assert ends["broken"] == 0 and sum(ends.values()) == 1


def test_corrupted_files_are_refused_or_hold_the_same_numbers(tmp_path: Path) -> None:
    answers = corrupted.counted(10, random.Random(2), tmp_path)
    good = {"refused", "read, the same numbers", "right checksum: refused", "right checksum: numbers"}
    assert set(answers) <= good and answers["refused"] and answers["read, the same numbers"], answers


@pytest.fixture(scope="module")
def run_files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes]:
    """The result of a short run, and what its run file holds."""
    folder = tmp_path_factory.mktemp("run")
    record = folder / "run.nc.part"
    scenario = load(ROOT / "scenarios/curve_r300.toml").with_values(corrupted.VALUES)
    return run(scenario, record=record).save(folder / "run.nc"), record.read_bytes()


def refusal(path: Path) -> str:
    """The line with which a file is refused."""
    with pytest.raises(InputError) as problem:
        read(path)
    message = str(problem.value)
    assert "\n" not in message and str(path) in message
    return message


@pytest.mark.parametrize(("change", "message"), table("an_odd_header_of_a_run_file_is_refused_by_name"))
def test_an_odd_header_of_a_run_file_is_refused_by_name(change, message, run_files, tmp_path):
    (header, nothing), *rest = crafted.records(run_files[1])
    path = tmp_path / "result.nc.part"
    path.write_bytes(crafted.run_file([(json.dumps(json.loads(header) | change).encode(), nothing), *rest]))
    assert message in refusal(path)


@pytest.mark.parametrize("header", [b"", b"[]", b"\xff", b"[" * 100000, b"{}"])
def test_a_header_that_is_no_table_is_refused(header: bytes, run_files: tuple[Path, bytes], tmp_path: Path) -> None:
    path = tmp_path / "result.nc.part"
    path.write_bytes(crafted.run_file([(header, b""), *crafted.records(run_files[1])[1:]]))
    assert "its header" in refusal(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rows": 2**40}, "numbers has the head"),
        ({"step": 2**62}, "a record that no run writes"),
        ({"step": None}, "numbers has the head"),
    ],
)
def test_samples_that_a_record_declares_and_does_not_hold_are_refused(change, message, run_files, tmp_path):
    header, (about, numbers), *rest = crafted.records(run_files[1])
    path = tmp_path / "result.nc.part"
    path.write_bytes(crafted.run_file([header, (json.dumps(json.loads(about) | change).encode(), numbers), *rest]))
    assert message in refusal(path)


def test_a_record_with_numbers_that_no_run_leaves_is_refused(run_files: tuple[Path, bytes], tmp_path: Path) -> None:
    """Each number of the first record in turn becomes odd; what remains of it is refused or harmless."""
    header, (about, numbers), *rest = crafted.records(run_files[1])
    path = tmp_path / "result.nc.part"
    path.write_bytes(crafted.run_file([header, (about, struct.pack("<d", float("nan")) + numbers[8:]), *rest]))
    assert "samples that are not finite" in refusal(path)
    about, numbers = rest[-2]  # the last checkpoint: the counts of the integration begin its memory
    said, size = json.loads(about), json.loads(header[0])["size"]
    assert not said["goes_on"]
    place = 8 * (said["rows"] * (1 + 2 * size) + 2 * size)
    numbers = numbers[:place] + struct.pack("<d", 1e300) + numbers[place + 8 :]
    path.write_bytes(crafted.run_file([header, *crafted.records(run_files[1])[1:-2], (about, numbers), rest[-1]]))
    assert "its checkpoint does not fit its scenario" in refusal(path)


def test_zeros_without_end_in_a_small_file_are_refused_with_their_number(tmp_path: Path) -> None:
    path = crafted.declared(tmp_path / "result.nc", 10**7)
    assert path.stat().st_size < 1_000_000
    assert "declares 1600 MB of numbers in a file of" in refusal(path)


def test_crafted_files_get_one_line_or_numbers_from_commands(tmp_path: Path, run_files: tuple[Path, bytes]) -> None:
    rng, content = random.Random(4), run_files[0].read_bytes()
    for i, command in enumerate(corrupted.COMMANDS[name] for name in ("show", "diff", "resolve")):
        path = tmp_path / f"{i}.nc"
        path.write_bytes(crafted.numbers(content, rng))
        places = {"FILE": str(path), "WHOLE": str(run_files[0])}
        filled = [places.get(word, word.replace("OUT", str(tmp_path / "out_of_it"))) for word in command]
        answer = corrupted.answer_of(filled, path)
        assert answer in corrupted.GOOD, (command, answer)


def test_a_result_does_not_depend_on_how_many_samples_are_evaluated_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = setup_of([straight(4.0)], 20.0, STEERING)
    whole = run_in_time(setup).dataset
    monkeypatch.setattr(samples, "BLOCK", 7)
    assert run_in_time(setup).dataset.identical(whole)


def test_the_validation_report_is_that_of_its_data():
    """Make it anew with: python docs/figures/make_standing.py"""
    for path, text in script("docs/figures/make_standing.py").pages().items():
        assert path.read_text(encoding="utf-8") == text, path
