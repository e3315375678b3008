"""Which keys decide on an output: indices of functions whose indices are known, and of a study."""

import json
import sys
from math import pi
from pathlib import Path

import numpy as np
import pytest
from support.rows import rows_of
from support.studies import study_file

from wrsim.errors import InputError
from wrsim.report.study import study_page
from wrsim.results.sensitivity import by_output, sensitivity_in, sensitivity_tables
from wrsim.study.collect import read_study, write_study
from wrsim.study.plan import planned
from wrsim.study.sensitivity import axis_of, design, sensitivities, sensitivity
from wrsim.study.spec import SampledKey, SensitivitySection
from wrsim.study.task import COMPLETED, Marker

table = rows_of(__file__)

X = [{"key": f"x{i}", "low": -pi, "high": pi} for i in (1, 2, 3)]


def section(method: str, samples: int, over: list[dict] = X, **more) -> SensitivitySection:
    keys = [SampledKey.model_validate(keys_of_sample) for keys_of_sample in over]
    return SensitivitySection(method=method, samples=samples, seed=1, over=keys, **more)


def ishigami(spec: SensitivitySection) -> np.ndarray:
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 of the cases of a design."""
    x1, x2, x3 = np.array(axis_of(spec, "").values).T
    return np.sin(x1) + 7.0 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)


def test_sobols_indices_of_ishigamis_function_are_those_of_its_closed_form():
    spec = section("sobol", 4096)
    values = ishigami(spec)
    assert values.size == 4096 * 5
    result = sensitivity(spec, "y", values)
    # V1 = (1 + 0.1 pi^4/5)^2/2, V2 = 49/8, V13 = 0.1^2 pi^8 (1/18 - 1/50), V = their sum
    v1, v2, v13 = (1.0 + 0.02 * pi**4) ** 2 / 2.0, 49.0 / 8.0, 0.01 * pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = v1 + v2 + v13
    assert result.indices["first"][:, 0] == pytest.approx(np.array([v1, v2, 0.0]) / whole, abs=0.02)
    assert result.indices["total"][:, 0] == pytest.approx(np.array([v1 + v13, v2, v13]) / whole, abs=0.02)
    for each in result.indices.values():
        value, low, high = each.T
        assert np.all((low <= value) & (value <= high)) and np.all(high - low < 0.15)
    again = sensitivity(spec, "y", values).indices["total"]
    assert np.array_equal(again, result.indices["total"])


def test_the_effects_of_morris_are_the_slopes_over_the_ranges():
    pytest.importorskip("SALib")
    spec = section("morris", 20, [{"key": "a", "low": 0, "high": 10}, {"key": "b", "low": 1, "high": 2}])
    a, b = np.array(axis_of(spec, "").values).T
    assert a.size == 20 * 3
    indices = sensitivity(spec, "y", 3.0 * a - 5.0 * b).indices
    assert indices["mu_star"][:, 0] == pytest.approx([30.0, 5.0]) and indices["sigma"][:, 0] == pytest.approx(
        [0.0, 0.0]
    )


def test_a_regression_gives_standardised_coefficients_and_what_they_explain():
    spec = section("regression", 200, X[:2])
    x1, x2 = design(spec).T
    scatter = np.random.default_rng(5).normal(0.0, 1.0, 200)
    result = sensitivity(spec, "y", 4.0 * x1 - 3.0 * x2 + scatter)
    part = 12.0**-0.5  # deviation of a number spread evenly from 0 to 1
    whole = np.sqrt(25.0 * part**2 + 1.0)
    low, high = result.indices["coefficient"][:, 1], result.indices["coefficient"][:, 2]
    expected = np.array([4.0, -3.0]) * part / whole
    assert np.all((low < expected) & (expected < high))
    assert high - low == pytest.approx(2.0 * 1.96 * np.array([1.0, 1.0]) / whole / np.sqrt(200.0), rel=0.15)
    assert float(result.note.split()[4]) == pytest.approx(100.0 * 25.0 * part**2 / whole**2, abs=6.0)


def test_an_output_that_does_not_vary_or_has_gaps_gets_a_reason():
    spec = section("sobol", 8)
    values = ishigami(spec)
    assert "does not vary: 3 in every case" in sensitivity(spec, "y", np.full(values.size, 3.0)).note
    values[7] = np.nan
    report = sensitivities(section("sobol", 8, outputs=["y", "yy"]), {"y": values})
    assert report["notes"] == {
        "y": "1 of 40 cases have no value",
        "yy": "is no output (did you mean 'y'?); there are y",
    }
    assert not by_output(report) and len(sensitivity_tables(report)) == 1
    fit = section("regression", 40)
    gaps = ishigami(fit)
    gaps[3] = np.nan
    assert sensitivity(fit, "y", gaps).indices["coefficient"].shape == (3, 3)


OVER = '[[sensitivity.over]]\nkey = "contact.friction"\n'
RANGE = OVER + "low = 0.1\nhigh = 0.4\n"


@pytest.mark.parametrize(("text", "message"), table("a_design_that_cannot_be_is_one_clear_error"))
def test_a_design_that_cannot_be_is_one_clear_error(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message) as problem:
        planned(study_file(tmp_path, text), tmp_path / "out")
    assert len(str(problem.value).splitlines()) == 1


def test_without_salib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "SALib.sample", None)
    monkeypatch.setitem(sys.modules, "SALib.analyze", None)
    text = '[sensitivity]\nmethod = "morris"\nsamples = 8\n' + RANGE
    with pytest.raises(
        InputError, match=r'study.toml:\d+: sensitivity: method = "morris" needs SALib: .*\[type-test\]'
    ):
        planned(study_file(tmp_path, text), tmp_path / "out")


@pytest.mark.usefixtures("sketched")
def test_a_study_stores_its_indices_and_shows_them(tmp_path: Path) -> None:
    speed = '[[sensitivity.over]]\nkey = "vehicle.speed_kmh"\nlow = 40\nhigh = 60\n'
    text = '[sensitivity]\nmethod = "regression"\nsamples = 16\noutputs = ["y"]\n' + RANGE + speed
    text += '[[outputs.channels]]\nchannel = "Y"\nreduce = "max"\nname = "y"\n'
    plan, _ = planned(study_file(tmp_path, text), tmp_path / "out")
    made = []
    for i, case in enumerate(plan.cases):
        y = 10.0 * case.values["contact.friction"] - 0.01 * case.values["vehicle.speed_kmh"]
        numbers = {"y": y, "other": float(i)}
        made.append(Marker(case.name, case.label, COMPLETED, "", numbers=numbers, units={"y": "kN", "other": ""}))
    report, files = write_study(plan, made, pictures=True)
    assert {"sensitivity.csv", "sensitivity.png"} <= {file.name for file in files}
    stored = json.loads((tmp_path / "out" / "study.json").read_text())["sensitivity"]
    # ranges 3 and 0.2 kN, no scatter: parts of their root of the sum of squares
    ((output, keys),) = by_output(stored).items()
    whole = np.hypot(3.0, 0.2)
    assert output == "y" and [key for key, _ in keys] == ["contact.friction", "vehicle.speed_kmh"]
    values = [indices["coefficient"]["value"] for _, indices in keys]
    assert values == pytest.approx([3.0 / whole, -0.2 / whole], abs=0.02)
    assert sensitivity_in(read_study(tmp_path / "out")) == stored
    assert report["sensitivity"] == stored
    page = study_page(read_study(tmp_path / "out"), "out/study.nc")
    assert 'id="sensitivity"' in page and "a linear fit explains 100 % of the variance" in page
