"""Estimated values by regression: known coefficients, bounds that hold as often as they say."""

import json

import numpy as np
import pytest
from scipy import stats
from support.commands import ok
from support.scenario_texts import CURVE, faults
from support.synthetic_run import run

from wrsim.analysis.assessment import assess_runs
from wrsim.analysis.assessment.estimates import regression
from wrsim.results.assessment import assessment_json
from wrsim.scenario.sections.assessment import AssessmentSettings

SEED = np.random.SeedSequence(20261123)
SLOPES = {"cant_deficiency": 2e5, "curvature": -3e6, "speed": 150.0}
"""Of a force [N] per [m], [1/m], [m/s]."""
AT = {"cant_deficiency": 0.165, "curvature": 1 / 400, "speed": 40.0}


def sections(n: int, generator: np.random.Generator) -> dict:
    """Influences of n sections of curves."""
    return {
        "cant_deficiency": generator.uniform(0.02, 0.16, n),
        "curvature": generator.uniform(1 / 600, 1 / 400, n),
        "speed": generator.uniform(20.0, 38.0, n),
    }


def force(known: dict) -> np.ndarray:
    """What the influences make of it [N]."""
    return 20e3 + sum(slope * known[name] for name, slope in SLOPES.items())


def test_values_without_scatter_give_back_their_coefficients():
    known = sections(30, np.random.default_rng(SEED))
    found = regression(force(known), known, tuple(SLOPES), AT, 2.2)
    assert dict(zip(found.over, found.slope, strict=True)) == pytest.approx(SLOPES, rel=1e-9)
    assert (found.fit, found.estimate) == pytest.approx((force(AT),) * 2, rel=1e-9)
    # without a place the largest of the sections
    assert regression(force(known), known, ("speed",), {}, 2.2).at == (known["speed"].max(),)


def test_one_influence_has_the_bound_of_textbooks():
    generator = np.random.default_rng(SEED)
    known = sections(25, generator)
    x = known["cant_deficiency"]
    y = 30e3 + 2e5 * x + generator.normal(0.0, 1.5e3, x.size)
    found = regression(y, known, ("cant_deficiency",), AT, 3.0)
    line = stats.linregress(x, y)
    residuals = y - line.intercept - line.slope * x
    s = np.sqrt(np.sum(residuals**2) / (x.size - 2))
    wide = np.sqrt(1.0 + 1.0 / x.size + (0.165 - x.mean()) ** 2 / np.sum((x - x.mean()) ** 2))
    fit = line.intercept + line.slope * 0.165
    assert (found.slope[0], found.deviation, found.fit) == pytest.approx((line.slope, s, fit), rel=1e-9)
    t = stats.t.ppf(stats.norm.cdf(3.0), x.size - 2)
    assert found.estimate == pytest.approx(fit + t * s * wide, rel=1e-9)
    assert regression(y, known, ("cant_deficiency",), AT, 0.0).estimate == pytest.approx(found.fit, rel=1e-12)


@pytest.mark.parametrize("k", [3.0, 2.2])
def test_without_influences_many_sections_give_the_one_dimensional_method(k):
    y = np.random.default_rng(SEED).normal(40e3, 2e3, 200_000)
    found = regression(y, sections(y.size, np.random.default_rng(1)), (), {}, k)
    assert found.over == ()
    assert found.fit == pytest.approx(y.mean()) and found.deviation == pytest.approx(y.std(ddof=1))
    assert found.estimate == pytest.approx(y.mean() + k * y.std(ddof=1), rel=1e-5)


def test_one_more_section_stays_below_its_bound_as_often_as_that_says():
    generator = np.random.default_rng(SEED)
    below, trials, scatter = 0, 4000, 2e3
    for _ in range(trials):
        known = sections(14, generator)
        y = force(known) + generator.normal(0.0, scatter, 14)
        bound = regression(y, known, tuple(SLOPES), AT, 2.2).estimate
        below += force(AT) + generator.normal(0.0, scatter) <= bound
    share = stats.norm.cdf(2.2)
    # three standard deviations of the count
    assert below / trials == pytest.approx(share, abs=3.0 * np.sqrt(share * (1.0 - share) / trials))


def test_influences_that_go_together_or_do_not_vary_are_told_apart():
    known = sections(20, np.random.default_rng(SEED))
    y = force(known)
    assert regression(y, known | {"speed": np.full(20, 30.0)}, ("curvature", "speed"), AT, 3.0).over == ("curvature",)
    tied = known | {"speed": 100.0 * known["cant_deficiency"] + 20.0}
    assert regression(y, tied, ("cant_deficiency", "speed"), AT, 3.0) is None
    few = {name: x[:6] for name, x in known.items()}
    assert regression(y[:6], few, tuple(SLOPES), AT, 3.0) is None


def missing(s: np.ndarray) -> np.ndarray:
    """Cant deficiency by sections of 250 m [m]."""
    return 0.02 * (np.floor(s / 250.0 + 1e-9) % 5)


CANTED = {"y": lambda s: (20e3 + 1e5 * missing(s), 0.0 * s), "cant": lambda s: -missing(s)}
SETTINGS = AssessmentSettings(estimate_over=("cant_deficiency", "speed"), estimate_at={"cant_deficiency": 0.15})


def test_an_assessment_estimates_at_a_cant_deficiency_beyond_that_of_the_run():
    found = assess_runs(run(3000.0, **CANTED), SETTINGS)
    (zone,) = [z for z in found.zones if z.worst.quantity.key == "sum_Y"]
    fitted = zone.regression
    assert fitted.over == ("cant_deficiency",)  # the speed stays
    # neighbours reach into a section by half a window and what the filter swings over
    assert fitted.slope[0] == pytest.approx(1e5, rel=0.05) and fitted.fit == pytest.approx(35e3, rel=0.02)
    assert zone.estimate == fitted.estimate > fitted.fit
    row = next(z for z in json.loads(assessment_json(found))["zones"] if z["worst"]["quantity"] == "sum_Y")
    (over,) = row["regression"]["over"]
    assert (over["influence"], over["unit"], over["at"]) == ("cant_deficiency", "mm", pytest.approx(150.0))
    assert over["slope"] == pytest.approx(0.1, rel=0.05)
    assert row["estimated_maximum"] == pytest.approx(1e-3 * zone.estimate)


@pytest.mark.usefixtures("sketched")
def test_the_command_tells_and_draws_what_values_depend_on(tmp_path):
    file = tmp_path / "settings.toml"
    over = 'estimate_over = ["cant_deficiency", "speed"]\nestimate_cant_deficiency_mm = 150\n'
    file.write_text(f"{CURVE}\n[assessment]\n{over}")
    result = run(3000.0, **CANTED).save(tmp_path / "result.nc")
    told = ok("assess", result, "--scenario", file)
    assert "estimated values by regression [mem]" in told.output and "at 150 mm" in told.output
    assert (tmp_path / "assessment_estimates.png").is_file()


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ('estimate_over = ["speed", "speed"]', "has a duplicate"),
        ("estimate_speed_kmh = 100", 'goes with "speed" in estimate_over'),
    ],
)
def test_bad_influences_are_refused_with_file_and_key(tmp_path, lines, said):
    (fault,) = faults(f"{CURVE}\n[assessment]\n{lines}\n", tmp_path)
    assert fault.startswith("case.toml:") and said in fault
