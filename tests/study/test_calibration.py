"""Least squares beside measurements: closed forms, intervals that hold the truth, what is not told, refusals."""

import json
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.special import stdtrit
from support.studies import study_file

from wrsim import InputError, calibrate, load, run
from wrsim.results import Result, write_atomically
from wrsim.results.files import digest_of
from wrsim.study.calibration.fit import Fit, autocorrelation_time
from wrsim.study.calibration.intervals import Knowledge, knowledge
from wrsim.study.calibration.outcome import Calibrated
from wrsim.study.calibration.reading import Target, mode_numbers
from wrsim.study.calibration.sections import CalibratedKey, ValueSection
from wrsim.study.candidates import Candidate, Varied
from wrsim.study.plan import PLAN, Plan
from wrsim.study.task import COMPLETED, FAILED, run_case

Model = Callable[[np.ndarray], np.ndarray]


class Formula:
    """A calibration whose model is a formula of the keys, in the place of runs."""

    def __init__(
        self,
        model: Model,
        measured: np.ndarray,
        noise: float | None,
        keys: Sequence[CalibratedKey],
        more: dict | None = None,
    ) -> None:
        self.from_fit, self.records, self.shifted = model, {}, 0
        self.spec = SimpleNamespace(
            vary=keys, confidence_percent=90.0, intervals="linear", iterations=30, **(more or {})
        )
        varied = [Varied(k.key, k.key[0], k.low, k.high, k.start, k.spacing == "log") for k in keys]
        self.candidates = SimpleNamespace(
            varied=varied, evaluated=self.evaluated, values=lambda point: tuple(map(float, point)), title="formula"
        )
        place = np.arange(measured.size, dtype=float)
        self.target = Target("series", "run", 0, place, measured, noise, True)

    def evaluated(self, points, work) -> list[Candidate]:
        return [self.candidate(tuple(map(float, point))) for point in points]

    def candidate(self, values: tuple[float, ...]) -> Candidate:
        status = COMPLETED if np.isfinite(self.from_fit(np.array(values))).all() else FAILED
        dataset = xr.Dataset({"keys": ("key", np.array(values))}, attrs={"analysis": "curving"})
        return Candidate(values, {"run": SimpleNamespace(status=status, message="", dataset=lambda: dataset)})

    def shifts(self, results) -> dict:
        return {}

    def targets(self, results, shifts) -> list[Target]:
        return [self.target]

    def model(self, results, targets) -> list[np.ndarray]:
        return [self.from_fit(results["run"].dataset["keys"].values)]


def key(name: str, start: float, **more) -> CalibratedKey:
    return CalibratedKey.model_validate({"key": name, "low": 0.2 * start, "high": 5.0 * start, "start": start} | more)


def fitted(calibration: Formula) -> tuple[Fit, Knowledge]:
    fit = Fit(calibration, lambda plan, todo: None, lambda message: None)  # type: ignore[arg-type]
    fit.begin()
    fit.run()
    return fit, knowledge(fit)


RNG = np.random.default_rng(58)
BASIS = RNG.normal(size=(400, 3))


def test_a_linear_model_comes_to_the_closed_form_with_its_priors():
    noise = 0.3
    measured = BASIS @ [1.2, 0.8, 1.1] + noise * RNG.normal(size=400)
    keys = [key("a", 1.0), key("b", 1.0, prior=0.9, tolerance=0.02), key("c", 1.0)]
    fit, known = fitted(Formula(lambda x: BASIS @ x, measured, noise, keys))
    weighted = np.vstack([BASIS / noise / fit.weights[0].neighbours ** 0.5, [0.0, 100.0, 0.0]])
    right = np.append(measured / noise / fit.weights[0].neighbours ** 0.5, 100.0 * 0.9)
    expected = np.linalg.lstsq(weighted, right, rcond=None)[0]
    assert fit.values(fit.optimum) == pytest.approx(expected, abs=1e-3 * noise)
    half = stdtrit(known.freedom, 0.95) * np.sqrt(
        np.diag(np.linalg.inv(weighted.T @ weighted)) * max(known.misfit, 1.0)
    )
    assert [0.5 * (interval.high - interval.low) for interval in known.intervals] == pytest.approx(half, rel=1e-6)
    assert fit.converged and known.misfit == pytest.approx(1.0, abs=0.15)


def twin(seed: int) -> tuple[list[bool], Knowledge]:
    """Six hidden parameters of a sum of swings with noise of 5 %, not given: which intervals hold the true value."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 3.0, 250)

    def model(x: np.ndarray) -> np.ndarray:
        swings = [a * np.exp(-c * t) * np.cos(w * t) for a, c, w in zip(x[:2], x[2:4], x[4:], strict=True)]
        return np.sum(swings, axis=0)

    nominal = np.array([1.0, 0.6, 0.8, 1.5, 6.0, 14.0])
    truth = nominal * (1.0 + 0.05 * rng.normal(size=6))
    clean = model(truth)
    keys = [key(f"p{i}", v, prior=v, tolerance=0.1 * v) for i, v in enumerate(nominal)]
    measured = clean + 0.05 * clean.std() * rng.normal(size=t.size)
    fit, known = fitted(Formula(model, measured, None, keys))
    assert fit.converged
    return [interval.low <= true <= interval.high for interval, true in zip(known.intervals, truth, strict=True)], known


def test_intervals_of_90_percent_hold_the_truth_of_85_to_95_percent_of_120():
    held = [inside for seed in range(20) for inside in twin(seed)[0]]
    assert len(held) == 120 and 0.85 <= np.mean(held) <= 0.95


def test_what_the_channels_cannot_tell_is_told_by_name():
    """a and b act by their product alone, c not at all."""
    t = np.linspace(0.0, 1.0, 200)
    measured = 1.1 * t + 0.01 * RNG.normal(size=200)
    keys = [key(name, 1.0, prior=1.0, tolerance=0.4) for name in "abc"]
    fit, known = fitted(Formula(lambda x: x[0] * x[1] * t + 0.0 * x[2], measured, None, keys))
    assert not known.intervals[2].told
    assert known.intervals[2].high - known.intervals[2].low == pytest.approx(2.0 * 1.645 * 0.2, rel=0.02)
    assert known.groups == (("a", "b"),) and known.correlation[0, 1] < -0.95
    assert {frozenset(d) for d in known.directions} == {frozenset("ab"), frozenset("c")}
    notes = Calibrated.from_fit(fit, known).notes()
    assert any(n.startswith("not told by these channels: c") for n in notes)
    assert any(n.startswith("told together only: a, b: correlation -1.00") for n in notes)


def test_a_profile_ends_where_chi2_has_risen_by_the_square_of_the_quantile():
    t = np.linspace(0.0, 1.0, 100)
    measured = np.exp(-2.0 * t) + 0.2 * np.random.default_rng(4).normal(size=100)

    def chi2(a: float, fit: Fit) -> float:
        """The least over the amplitude, of which the model is a linear function."""
        shape, sigma = np.exp(-a * t), fit.weights[0].noise * fit.weights[0].neighbours ** 0.5
        return float(np.sum((measured - shape * (shape @ measured) / (shape @ shape)) ** 2)) / sigma**2

    calibration = Formula(lambda x: x[1] * np.exp(-x[0] * t), measured, 0.2, [key("rate", 2.0), key("amplitude", 1.0)])
    calibration.spec.intervals = "profile"
    fit, known = fitted(calibration)
    rate = known.intervals[0]
    rise = stdtrit(known.freedom, 0.95) ** 2 * max(known.misfit, 1.0)
    for end in (rate.low, rate.high):
        assert chi2(end, fit) - chi2(rate.value, fit) == pytest.approx(rise, rel=0.12)
    assert rate.high - rate.value > 1.05 * (rate.value - rate.low)


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.9])
def test_neighbours_that_go_together_count_less(rho):
    rng, n = np.random.default_rng(7), 20000
    values = np.zeros(n)
    for i, step in enumerate(rng.normal(size=n - 1)):
        values[i + 1] = rho * values[i] + step
    assert autocorrelation_time(values) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.12)


def test_candidates_without_a_result_turn_the_search_back():
    t = np.linspace(0.0, 1.0, 50)
    calibration = Formula(lambda x: x[0] * t if x[0] < 2.1 else np.full(50, np.nan), 2.0 * t, None, [key("a", 1.0)])
    assert fitted(calibration)[1].intervals[0].value == pytest.approx(2.0, abs=1e-3)


def test_a_series_that_jumps_beside_the_optimum_is_told():
    """One step of the derivatives is 0.25 of a quarter of the bounds: 0.3."""
    t = np.linspace(0.0, 1.0, 50)
    rng = np.random.default_rng(6)
    measured = 2.0 * t + 0.02 * rng.normal(size=50)

    def notes(jump: float) -> list[str]:
        model = lambda x: x[0] * t + jump * (x[0] > 2.2)  # noqa: E731
        return Calibrated.from_fit(*fitted(Formula(model, measured, 0.02, [key("a", 1.0)]))).notes()

    assert not any("jumps" in note for note in notes(0.0))
    assert any(note.startswith("series jumps or bends over a near its value") for note in notes(0.5))


MODES = Result(
    xr.Dataset(
        {
            "mode_frequency": (("pose", "mode"), [[0.8, 1.1, np.nan, 1.2, 8.2]]),
            "mode_name": (("pose", "mode"), [["yaw", "roll", "", "yaw", "pitch"]]),
        }
    )
)


@pytest.mark.parametrize(
    "keys, expected",
    [
        ({"frequencies_Hz": [8.0, 1.15]}, [8.2, 1.2]),  # 1.2 is nearer in the logarithm
        ({"frequencies_Hz": [1.15, 1.12]}, [1.2, 1.1]),  # each mode once
        ({"frequencies_Hz": [1.15], "modes": ["roll"]}, [1.1]),
        ({"frequencies_Hz": [0.9, 1.0], "modes": ["yaw", "yaw"]}, [0.8, 1.2]),
    ],
)
def test_a_natural_frequency_stands_beside_the_mode_of_its_name_or_the_nearest(keys, expected):
    value = ValueSection.model_validate({"noise": 0.1} | keys)
    assert mode_numbers(value, MODES) == pytest.approx(expected)


def test_a_mode_that_the_model_has_not_is_refused():
    value = ValueSection.model_validate({"noise": 0.1, "frequencies_Hz": [1.0], "modes": ["bounce"]})
    with pytest.raises(InputError, match='"bounce" is none; there is yaw, roll, pitch'):
        mode_numbers(value, MODES)


FILE = """
[[scenario]]
name = "curve"
base = "base.toml"
file = "measured.csv"
time = "t_s"
[[vary]]
key = "contact.friction"
low = 0.1
high = 0.5
start = 0.2
[[measured]]
series = "Y_kN"
channel = "Y"
wheel = "left"
"""


def files(folder: Path, text: str = FILE, friction: float = 0.32) -> Path:
    study_file(folder)
    dataset = run(load(folder / "base.toml").with_values({"contact.friction": friction})).dataset
    force = 1e-3 * dataset["Y"].values[:, 0, 0]
    np.savetxt(
        folder / "measured.csv",
        np.column_stack([dataset["time"].values, force]),
        "%.9g",
        ",",
        header="t_s,Y_kN",
        comments="",
    )
    file = folder / "calibration.toml"
    file.write_text(text)
    return file


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cases run here, one after the other, as workers run them."""

    def work(plan: Plan, todo: Sequence[int]) -> None:
        write_atomically(Path(plan.folder) / PLAN, plan.dumped())
        for index in todo:
            run_case(plan.folder, digest_of(plan.dumped()), index)

    monkeypatch.setattr("wrsim.study.engine.worker_pool", lambda *options, **more: nullcontext(work))


def test_a_planted_friction_is_found_and_found_again_to_the_same_bits(tmp_path, in_process):
    file = files(tmp_path)
    first = calibrate(file, tmp_path / "out", pictures=False)
    (row,) = first["keys"]
    assert row["value"] == pytest.approx(0.32, rel=2e-3) and row["told"]
    bytes_before = (tmp_path / "out/calibration.json").read_bytes()
    cases = sorted((tmp_path / "out/scenarios/curve/cases").glob("*/*/case.json"))
    times = [case.stat().st_mtime_ns for case in cases]
    for lost in cases[3].parent.iterdir():  # as after a kill: one case has no marker and no result
        lost.unlink()
    again = calibrate(file, tmp_path / "out", pictures=False)
    assert (tmp_path / "out/calibration.json").read_bytes() == bytes_before
    assert sum(case.stat().st_mtime_ns != old for case, old in zip(cases, times, strict=True)) == 1
    assert again["keys"] == first["keys"]
    changed = load(tmp_path / "out/calibrated_curve.toml")
    assert changed.spec.contact.friction == pytest.approx(row["value"])
    assert f"0.2 -> {row['value']:.5g}" in (tmp_path / "out/calibrated_curve.toml").read_text()
    report = json.loads(bytes_before)
    assert report["converged"] and report["series"][0]["after"] < 1e-2 * report["series"][0]["before"]


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("start = 0.2", "start = 0.6", "vary[0].start = 0.6: is outside of the bounds 0.1 to 0.5"),
        ('series = "Y_kN"', 'series = "Q_kN"', "(did you mean 'Y_kN'?); it has t_s, Y_kN"),
        ('channel = "Y"\nwheel = "left"', 'channel = "point_ay"\npoint = "floor"\nunit = "g"', "no such channel"),
        ('wheel = "left"', 'wheel = "left"\nband_Hz = [4, 8]', "is 0.2 s long; a filter at 4 Hz needs 0.75 s"),
        ('wheel = "left"', 'wheel = "left"\nreduce = "rms"', "a number needs its standard deviation"),
        ("start = 0.2", "start = 0.2\nprior = 0.3", "tolerance is missing: goes with prior"),
        ("start = 0.2", "whole = true", "a calibration varies numbers alone"),
        ("[[measured]]", '[cases]\nkeep = "numbers"\n[[measured]]', 'must be "results"'),
        ("[[measured]]", "[[value]]\nfrequencies_Hz = [1.0]\nnoise = 0.1\n[[measured]]", 'must be "stability"'),
    ],
)
def test_what_cannot_be_calibrated_is_refused_before_anything_runs(old, new, message, tmp_path):
    with pytest.raises(InputError) as refused:
        calibrate(files(tmp_path, FILE.replace(old, new, 1)), tmp_path / "out")
    assert message in str(refused.value)
    assert not (tmp_path / "out").exists()


def test_a_dry_run_tells_the_cost(tmp_path):
    told = calibrate(files(tmp_path), tmp_path / "out", dry_run=True)
    assert told["candidates"] > 5 and told["of_all_s"] > 0.0 and not (tmp_path / "out/scenarios").exists()
