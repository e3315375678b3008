"""Model beside measurement: differences that are known, what was not measured is left out, the verdict and its page."""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from support import synthetic_run
from support.commands import call
from support.runs import SCENARIOS

from wrsim import InputError, Outcome, validate
from wrsim.results import Result

GAIN, SHIFT = 1.04, 250.0
FILE = """
title = "Curve of 300 m"
[[scenario]]
name = "curve"
result = "result.nc"
file = "measured.csv"
distance = "place [m]"
shift_m = -249
search_m = 4
"""
SERIES = """
[[measured]]
series = "{0}{1} [kN]"
channel = "{0}"
wheel = "{1}"
"""


def run() -> Result:
    return synthetic_run.run(
        600.0, 20.0, 5e-3, curvature=synthetic_run.curve(300.0),
        y=lambda s: (2e4 + 5e3 * np.sin(s / 3.0), -1e4 + 3e3 * np.cos(s / 5.0)),
        q=lambda s: (5e4 + 8e3 * np.sin(s**1.3 / 40.0), 5e4 - 4e3 * np.sin(s / 7.0)),
    )  # fmt: skip


@cache
def recorded(gain: float) -> dict[str, bytes]:
    """The files of a run and of its measurement, by names."""
    with TemporaryDirectory() as scratch:
        folder, result = Path(scratch), run()
        result.save(folder / "result.nc")
        dataset = result.dataset
        y, q = (1e-3 * dataset[name].values[:, 0] for name in "YQ")
        columns = np.column_stack([dataset["distance"].values + SHIFT, y, gain * q])
        header = "place [m],Yleft [kN],Yright [kN],Qleft [kN],Qright [kN]"
        np.savetxt(folder / "measured.csv", columns, fmt="%.9g", delimiter=",", header=header, comments="")
        return {path.name: path.read_bytes() for path in folder.iterdir()}


def files(folder: Path, series: str = "Yleft Yright Qleft Qright", more: str = "", gain: float = GAIN) -> Path:
    """A validation whose measured forces are those of the model, Q times a factor."""
    for name, content in recorded(gain).items():
        (folder / name).write_bytes(content)
    file = folder / "validation.toml"
    file.write_text(FILE + "".join(SERIES.format(name[0], name[1:]) for name in series.split()) + more)
    return file


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Outcome:
    folder = tmp_path_factory.mktemp("whole")
    return validate(files(folder), folder / "out", pictures=False)


def of(outcome: Outcome, quantity: str) -> dict:
    return next(row for row in outcome["differences"] if row["quantity"] == quantity)


def test_differences_are_those_that_were_put_in(whole):
    assert whole["shifts"]["curve"]["value"] == pytest.approx(-SHIFT, abs=0.01)
    assert of(whole, "Y")["mean"] == pytest.approx(0.0, abs=2e-3)
    q = next(row for row in whole.value if row.key == "Q")
    for difference_of_section in q.differences:  # the model has less by a part of what it has
        assert difference_of_section.difference == pytest.approx(difference_of_section.model * (1.0 - GAIN), abs=0.02)
    assert of(whole, "Q")["mean"] == pytest.approx((1.0 - GAIN) * np.mean([d.model for d in q.differences]), abs=0.02)


def test_quasi_static_values_are_of_full_curves_and_transitions_are_left_out(whole):
    zones = {row.key: {d.value.section.zone for d in row.differences} for row in whole.value}
    assert zones["Y"] == {"straight", "very small radius"}
    assert all(zones[key] == {"very small radius"} for key in ("Y_qst", "Q_qst", "sum_Y_qst", "Y_over_Q_qst"))


def test_the_series_of_a_factor_has_that_ratio_and_no_phase(whole):
    row = next(row for row in whole["series"] if row["series"].startswith("Q left"))
    assert row["ratio"] == pytest.approx(1.0 / GAIN, abs=1e-3)
    assert row["phase_deg"] == pytest.approx(0.0, abs=0.5)
    assert row["correlation"] == pytest.approx(1.0, abs=1e-3)


def test_what_was_not_measured_is_left_out(tmp_path):
    few = validate(files(tmp_path, "Yleft Qleft"), tmp_path / "out", pictures=False)
    wheels = {row.key: {d.value.wheel for d in row.differences} for row in few.value}
    assert wheels == {key: {"left"} for key in ("Y", "Q", "Y_over_Q", "Y_over_Q_qst")}  # the outer wheel is the right
    (lacking,) = [note for note in few["notes"] if note.startswith("not compared")]
    assert "ΣY" in lacking and "Y_qst" in lacking


def test_a_limit_that_is_exceeded_gives_code_4_and_is_named(tmp_path):
    red = validate(files(tmp_path, gain=1.3), tmp_path / "out", pictures=False)
    assert red.code == 4 and not red["passed"]
    assert red["verdict"].startswith("LIMITS EXCEEDED") and "Q" in red["verdict"]
    assert of(red, "Q")["verdict"] == "EXCEEDED" and of(red, "Y")["verdict"] == "ok"


def test_a_page_says_what_the_verdict_rests_on(tmp_path, sketched):
    answer = call("validate", files(tmp_path), "-o", tmp_path / "out", "--json")
    assert answer.exit_code == 0, answer.output
    page = (tmp_path / "out/validation.html").read_text()
    for text in ("measured.csv over distance, shift -250.00 m (found by cross-correlation)", "5 of 12* sections"):
        assert text in page
    numbers = json.loads(answer.output)
    assert numbers["passed"] and "too few sections" in numbers["verdict"]
    assert {p.name for p in map(Path, numbers["files"])} >= {"validation.html", "series.png", "sections.png"}


Change = Callable[[str], str]


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda t: t.replace('wheel = "left"', 'wheel = "left"\nwheelset = "third"'), 'wheelset = "third": there is'),
        (lambda t: t.replace('channel = "Y"\nwheel = "left"', 'channel = "Y"'), "name one wheel"),
        (lambda t: t.replace('channel = "Y"', 'channel = "point_ay"'), "has none: it belongs to (time, point)"),
        (lambda t: t.replace("search_m = 4", "search_s = 4"), "search_s = 4: goes with time"),
        (lambda t: t.replace('result = "result.nc"', ""), "(or give result)"),
        (lambda t: t.replace(t[t.index("file =") : t.index("[[measured]]")], ""), "no scenario has a measured file"),
    ],
)  # fmt: skip
def test_a_file_that_does_not_go_together_is_refused(change: Change, message: str, tmp_path):
    file = files(tmp_path)
    file.write_text(change(file.read_text()))
    with pytest.raises(InputError) as refused:
        validate(file, tmp_path / "out")
    assert message in str(refused.value)


def test_a_scenario_is_run_and_what_its_run_lacks_is_told_before(tmp_path):
    (tmp_path / "base.toml").write_text(
        f'base = "{SCENARIOS / "curve_r300.toml"}"\n[run]\ntime_s = 0.2\nstart_distance_m = 40\n'
        '[contact]\nnormal = "kik-piotrowski"\ntangential = "fastsim"\nstrips = 12\ncells = 6\n'
        "[output]\npatches_at_m = []\n"
    )
    file = files(tmp_path)
    text = file.read_text().replace('result = "result.nc"', 'base = "base.toml"')
    file.write_text(text.replace('channel = "Q"\nwheel = "left"', 'channel = "point_ay"\npoint = "floor"\nunit = "g"'))
    with pytest.raises(InputError, match="this analysis has no such channel"):
        validate(file, tmp_path / "out")
    assert not (tmp_path / "out").exists()
