"""Points of a space of keys become cases of several scenarios: the same numbers whatever stops them, told refusals."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from support.rows import rows_of
from support.runs import SCENARIOS
from support.studies import study_file

from wrsim.errors import InputError
from wrsim.results import write_atomically
from wrsim.results.files import digest_of
from wrsim.study.candidates import REFUSED, Candidate, Candidates, CandidatesFile, read_candidates
from wrsim.study.candidates import SCENARIOS as FOLDER
from wrsim.study.plan import PLAN, FileInput, Plan
from wrsim.study.spec import ChannelOutput, OutputsSection
from wrsim.study.task import COMPLETED, run_case

KEYS = """
[[scenario]]
name = "curve"
base = "base.toml"
[[scenario]]
name = "slippery"
base = "slippery.toml"
[[vary]]
key = "vehicle.speed_kmh"
low = 40
high = 600
[[vary]]
key = ["contact.cells", "contact.strips"]
low = 5
high = 9
whole = true
start = 6
"""
Y = OutputsSection(channels=(ChannelOutput(channel="Y", reduce="max", name="Y"),))


def candidates_in(folder: Path, text: str = KEYS, outputs: OutputsSection = Y) -> Candidates:
    """Candidates of a short run of a wheelset."""
    study_file(folder)
    (folder / "slippery.toml").write_text('base = "base.toml"\n[contact]\nfriction = 0.1\n')
    (folder / "file.toml").write_text(text)
    file_input = FileInput(folder / "file.toml", "file", CandidatesFile, ())
    names = [name for name, *_ in file_input.spec.named_bases()]
    return read_candidates(file_input, folder / "out", dict.fromkeys(names, outputs))


def work(plan: Plan, todo: Sequence[int]) -> None:
    """Run the cases here, one after the other, as a worker does."""
    write_atomically(Path(plan.folder) / PLAN, plan.dumped())
    for index in todo:
        run_case(plan.folder, digest_of(plan.dumped()), index)


POINTS = [(45.0, 5.2), (50.0, 5.0), (550.0, 5.0), (45.0, 4.9)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> list[Candidate]:
    folder = tmp_path_factory.mktemp("whole")
    return candidates_in(folder).evaluated(POINTS, work)


def numbers(candidates: Sequence[Candidate]) -> list[object]:
    return [
        (candidate.values, [(name, case.status, case.numbers) for name, case in candidate.cases.items()])
        for candidate in candidates
    ]


def test_points_of_the_same_values_are_one_case_and_scenarios_differ(whole):
    assert [candidate.values for candidate in whole] == [(45.0, 5), (50.0, 5), (550.0, 5), (45.0, 5)]
    assert whole[0].cases is whole[3].cases
    assert whole[0].completed and whole[0].status == COMPLETED and not whole[0].message
    curve, slippery = (whole[0].cases[name].numbers["Y"] for name in ("curve", "slippery"))
    assert curve != slippery and whole[1].cases["curve"].numbers["Y"] != curve
    assert whole[0].cases["curve"].dataset()["Y"].sizes["wheel"] == 2


def test_values_that_are_refused_are_told_and_run_nothing(whole):
    assert whole[2].status == REFUSED and not whole[2].completed
    assert "speed_kmh = 550" in whole[2].message and "500" in whole[2].message


def test_a_search_that_was_killed_meets_the_same_numbers(whole, tmp_path):
    class Killed(Exception):
        pass

    def killed(plan: Plan, todo: Sequence[int]) -> None:
        work(plan, todo[:1])
        raise Killed

    ran: list[tuple[str, int]] = []

    def rest(plan: Plan, todo: Sequence[int]) -> None:
        ran.append((Path(plan.folder).name, len(todo)))
        work(plan, todo)

    candidates = candidates_in(tmp_path)
    with pytest.raises(Killed):
        candidates.evaluated(POINTS, killed)
    assert len(list((tmp_path / "out" / FOLDER).rglob("case.json"))) == 1
    assert numbers(candidates.evaluated(POINTS, rest)) == numbers(whole)
    assert ran == [("curve", 1), ("slippery", 2)]
    assert numbers(candidates.evaluated(POINTS, killed)) == numbers(whole)  # nothing is left to run


def test_an_output_that_no_case_has_is_an_error(tmp_path):
    bad = OutputsSection(channels=(ChannelOutput(channel="Y", reduce="max", wheelset="second"),))
    with pytest.raises(InputError, match='wheelset = "second": there is wheelset'):
        candidates_in(tmp_path, outputs=bad).evaluated(POINTS[:1], work)


BASE = f'base = "{SCENARIOS / "curve_r300.toml"}"\n'


@pytest.mark.parametrize(("text", "message"), rows_of(__file__)("faults_of_the_keys"))
def test_a_fault_of_the_keys_is_one_error_before_anything_runs(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as error:
        candidates_in(tmp_path, BASE + text)
    assert "\n" not in str(error.value)
