"""The yardstick: two codes beside figures of others, wrong factors that it notices, files that it refuses."""

import sys
from inspect import signature
from pathlib import Path

import pytest
from support.rows import rows_of
from support.scripts import ROOT

sys.path.insert(0, str(ROOT))

from campaigns.benchmark.__main__ import code_of, comparisons, main
from campaigns.benchmark.adapter import Code
from campaigns.benchmark.comparison import read_comparison, run_comparison
from campaigns.benchmark.hertz_fastsim import HertzFastsim
from campaigns.benchmark.wrsim_adapter import Wrsim
from wrsim.errors import InputError

table = rows_of(__file__)

CODES = pytest.mark.parametrize("code", [Wrsim, HertzFastsim])
REFERENCE = ROOT / "tests" / "data"  # no table of these comparisons is read
IN_PLACE = ["hertz", "hertz_closed"]
"""Comparisons whose cases stand in their files."""


@CODES
@pytest.mark.parametrize("name", IN_PLACE)
def test_both_codes_meet_hertz(code, name):
    verdict = run_comparison(name, comparisons([name])[name], code(REFERENCE))
    assert verdict.word == "green"
    assert all(0.0 <= o.errors[0] <= o.errors[2] < 0.01 and o.cases >= 3 for o in verdict.outcomes)


@CODES
def test_a_wrong_factor_turns_a_comparison_red(code):
    class Wrong(code):
        def hertz(self, **arguments):
            return super().hertz(**arguments | {"load_N": 0.9 * arguments["load_N"]})

    verdict = run_comparison("hertz", comparisons(["hertz"])["hertz"], Wrong(REFERENCE))
    assert verdict.word == "red"
    assert all(o.errors[2] == pytest.approx(1.0 - 0.9 ** (1 / 3), abs=0.01) for o in verdict.outcomes[:1])


def test_what_a_code_does_not_have_is_not_offered_and_no_solution_is_red():
    comparison = comparisons(["grooves"])["grooves"]
    assert run_comparison("grooves", comparison, HertzFastsim(REFERENCE)).word == "not offered"

    class Lost(HertzFastsim):
        def arcs(self, **arguments):
            return None

    assert run_comparison("grooves", comparison, Lost(REFERENCE)).word == "red"


@pytest.mark.parametrize(("old", "new", "expected"), table("a_comparison_that_cannot_be_is_refused_with_file_and_line"))
def test_a_comparison_that_cannot_be_is_refused_with_file_and_line(tmp_path: Path, old, new, expected):
    text = (ROOT / "campaigns/benchmark/comparisons/hertz.toml").read_text()
    path = tmp_path / "own.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as problem:
        read_comparison(path)
    message = str(problem.value)
    assert expected in message and message.startswith(f"{path}:") and "\n" not in message


def test_every_comparison_gives_the_arguments_of_its_function():
    for name, comparison in comparisons().items():
        taken = signature(getattr(Code, comparison.function)).parameters
        needed = {key for key, parameter in taken.items() if parameter.default is parameter.empty} - {"self"}
        assert needed <= comparison.inputs.keys() | comparison.given.keys() <= taken.keys(), name


def test_the_command_ends_with_what_it_found(tmp_path: Path, capsys):
    table = tmp_path / "errors.csv"
    assert main([str(REFERENCE), "--only", "hertz", "--jobs", "1", "--code", "hertz-fastsim", "-o", str(table)]) == 0
    assert len(table.read_text().splitlines()) == 3
    assert main([str(tmp_path), "--only", "kalker", "--jobs", "1"]) == 2
    assert f"{tmp_path}/kalker.csv: no such table" in capsys.readouterr().err
    assert main([str(REFERENCE), "--only", "nothing"]) == 2


def test_a_package_that_a_code_needs_and_that_is_missing_is_named_with_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "campaigns.benchmark.hertz_fastsim", None)  # the module itself
    with pytest.raises(InputError, match="--code hertz-fastsim: must be wrsim, hertz-fastsim or MODULE:CLASS"):
        code_of("hertz-fastsim", REFERENCE)
    monkeypatch.delitem(sys.modules, "campaigns.benchmark.wrsim_adapter", raising=False)
    monkeypatch.setitem(sys.modules, "support.boxes", None)
    with pytest.raises(InputError, match=r'^--code wrsim: needs support.boxes: pip install -e "\.\[dev\]"$'):
        code_of("wrsim", REFERENCE)
