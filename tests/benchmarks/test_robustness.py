"""Small samples of the figures of robustness (docs/robustness.md): mutants, corrupted files, long runs.

Kills are sampled by tests/analysis/test_resume.py (a run) and tests/cli/test_users_files.py (tables, pictures).
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from benchmarks.test_scoreboard import ROOT, script
from support.runs import STEERING, setup_of, straight

from wrsim.analysis.motion import result as results
from wrsim.analysis.motion.run import run_in_time

hostile = script(ROOT / "benchmarks/hostile.py")
accepted = script(ROOT / "benchmarks/accepted.py")
corrupted = script(ROOT / "benchmarks/corrupted.py")
long_run = script(ROOT / "benchmarks/long_run.py")


def test_mutated_files_are_accepted_or_refused_with_file_and_place() -> None:
    answers, slowest = hostile.counted(16, random.Random(5))
    assert set(answers) <= {"valid", "refused"}, answers
    assert slowest < hostile.LONGEST


def test_a_message_without_file_or_place_would_be_seen() -> None:
    named = "a/case.toml:3: vehicle.speed_kmh = -1: must be a number from 0 to 600"
    assert hostile.NAMED.match(named) and hostile.PLACED.search(named)
    assert not hostile.NAMED.match("must be a number from 0 to 600")
    assert not hostile.PLACED.search("a/case.toml: must be a number")


def test_accepted_mutants_keep_the_laws_of_contact() -> None:
    ends, _ = accepted.counted(3, random.Random(3))
    assert ends["broken"] == 0 and sum(ends.values()) == 3


def test_corrupted_files_are_refused_or_hold_the_same_numbers(tmp_path: Path) -> None:
    answers = corrupted.counted(30, random.Random(2), tmp_path)
    assert set(answers) == {"refused", "read, the same numbers"}, answers


def test_samples_do_not_stay_in_memory(tmp_path: Path) -> None:
    figures = long_run.measured(tmp_path, 0.05)
    first, *_, last = figures["run_MB"].values()
    assert last < first + 5.0


def test_a_result_does_not_depend_on_how_many_samples_are_evaluated_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = setup_of([straight(4.0)], 20.0, STEERING)
    whole = run_in_time(setup).dataset
    monkeypatch.setattr(results, "BLOCK", 7)
    assert run_in_time(setup).dataset.identical(whole)
