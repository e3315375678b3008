"""Bad study files: one clear error each, with file, key, value, what is allowed and the nearest guess."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from support.commands import ok, refusal
from support.rows import rows_of
from support.studies import AXES, study_file
from support.synthetic_result import curve_run

from wrsim.errors import InputError
from wrsim.results import Result
from wrsim.study.outputs import case_outputs, reduced
from wrsim.study.plan import planned
from wrsim.study.spec import OutputsSection
from wrsim.study.task import COMPLETED, MARKER, Marker, read_marker, write_marker

table = rows_of(__file__)

GRID = '[[vary]]\nkind = "grid"\nkey = "{}"\nvalues = {}\n'
OVER = '[[vary]]\nkind = "sobol"\nsamples = {}\n[[vary.over]]\nkey = "contact.friction"\n{}\n'


@pytest.mark.parametrize(("axes", "message"), table("every_fault_of_a_study_file_is_one_clear_error"))  # fmt: skip
def test_every_fault_of_a_study_file_is_one_clear_error(axes: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text("contact.friction,vehicle.speed_kmh\n0.1,40\n0.2\n")
    (tmp_path / "head.csv").write_text("# keys\nvehicle.speed_kmh\n")
    (tmp_path / "key.csv").write_text("contact.frction\n0.2\n")
    (tmp_path / "bad.py").write_text("def f(:\n")
    (tmp_path / "h.py").write_text("def numbers(result):\n    return {}\n")
    with pytest.raises(InputError, match=message) as problem:
        planned(study_file(tmp_path, axes), tmp_path / "out")
    assert "Traceback" not in str(problem.value)


def test_a_study_of_too_many_cases_is_refused_before_they_are_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wrsim.study.plan.MOST_CASES", 5)
    with pytest.raises(InputError, match=r"study\.toml:4: vary: describes 6 cases; must be at most 5"):
        planned(study_file(tmp_path), tmp_path / "out")


def test_an_axis_that_is_refused_is_not_missing_as_well(tmp_path: Path) -> None:
    with pytest.raises(InputError) as problem:
        planned(study_file(tmp_path, '[[vary]]\nkey = "a"\n'), tmp_path / "out")
    assert len(str(problem.value).splitlines()) == 1


def test_a_base_that_is_not_there_names_the_nearest_file(tmp_path: Path) -> None:
    file = study_file(tmp_path)
    file.write_text(file.read_text().replace('"base.toml"', '"bsae.toml"'))
    with pytest.raises(InputError, match=r'toml:2: base = "bsae\.toml": not found in .*did you mean "base\.toml"'):
        planned(file, tmp_path / "out")


def test_files_of_the_user_are_not_written_over(tmp_path: Path) -> None:
    file = study_file(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "study.csv").write_text("mine")
    assert "wrsim did not write it" in refusal("study", file, "-o", tmp_path / "out")
    assert (tmp_path / "out" / "study.csv").read_text() == "mine"


def test_a_scheduler_without_certificates_is_refused_ahead_of_any_case(tmp_path: Path) -> None:
    told = refusal("study", study_file(tmp_path, AXES), "-o", tmp_path / "out", "--scheduler", "nowhere:1", "--dry-run")
    assert told.startswith("--scheduler tls://nowhere:1: needs certificates: give --tls DIR")


HOOKS = ("def numbers(result): pass", "from math import fsum as numbers", "numbers = print", "from math import *",
         "try:\n    import none\nexcept ImportError:\n    numbers = None")  # fmt: skip


def test_planning_executes_nothing_of_a_hook(tmp_path: Path) -> None:
    mine, file = tmp_path / "executed", study_file(tmp_path, AXES + "[outputs]\nhook = 'h.py:numbers'\n")
    for binding in HOOKS:
        (tmp_path / "h.py").write_text(f"open({str(mine)!r}, 'w')\n{binding}\nraise SystemExit\n")
        assert len(planned(file, tmp_path / "out")[0].cases) == 6
    answer = ok("study", file, "-o", tmp_path / "out", "--dry-run")
    assert "6 cases, 6 to run" in answer.output
    assert not mine.exists() and not (tmp_path / "out").exists()


@pytest.mark.parametrize("ending", ["raise SystemExit(3)", "raise KeyboardInterrupt", "import sys; sys.exit('enough')"])
@pytest.mark.parametrize("place", ["", "def numbers(result): "])
def test_a_hook_that_wants_to_end_the_process_is_a_fault_of_the_case(place: str, ending: str, tmp_path: Path) -> None:
    (tmp_path / "h.py").write_text(place + ending)
    found = case_outputs(Result(curve_run()), OutputsSection(hook="h.py:numbers"), tmp_path / "h.py")
    (fault,) = found.faults
    assert fault.startswith(f"outputs.hook: {tmp_path / 'h.py'}: numbers: ")
    assert "SystemExit" in fault or "KeyboardInterrupt" in fault


@pytest.mark.parametrize("odd", [
    b"", b"[]", b"\xff", b"[" * 100_000, b"{}", {"status": "x"}, {"status": 3}, {"numbers": []}, {"more": 1},
    {"numbers": {"Y_max": "x"}}, {"units": {"Y_max": 3}}, {"faults": [3]}, {"time_limit": "x"}, {"process": 1.5},
    {"message": None},
], ids=lambda odd: str(odd)[:20])  # fmt: skip
def test_a_case_whose_marker_has_odd_content_runs_again(odd: bytes | dict[str, object], tmp_path: Path) -> None:
    """There is no marker then."""
    marker = Marker("a", "a", COMPLETED, "", {"Y_max": 1.0}, {"Y_max": "kN"})
    write_marker(tmp_path, marker)
    assert read_marker(tmp_path) == marker
    content = odd if isinstance(odd, bytes) else json.dumps(vars(marker) | odd).encode()
    (tmp_path / MARKER).write_bytes(content)
    assert read_marker(tmp_path) is None


def test_a_pipe_in_place_of_a_marker_is_no_marker_and_stays(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / MARKER)
    assert read_marker(tmp_path) is None
    with pytest.raises(InputError, match="is a pipe"):
        write_marker(tmp_path, Marker("a", "a", COMPLETED, ""))


def test_of_several_wheels_the_worst_counts() -> None:
    """Either way for a peak, the smallest for the least value."""
    values = np.array([[1.0, -5.0], [2.0, 3.0]])
    assert [reduced(values, how) for how in ("peak", "max", "min")] == [-5.0, 3.0, -5.0]
    assert reduced(values, "percentile", 50.0) == 1.5
