"""Runs on two contacts at high friction: elastic rails are calm at any step, on rigid ones the oscillation is told.

The eight cases are those of people at work: hollow and worn wheels, grooved rails, freight, 80 to 400 m, twists.
"""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt
from support.runs import FAST, ROOT, arc, straight, transition

from wrsim import Result, load_text, run
from wrsim.inputs.toml_files import write_toml

HOLLOW = (ROOT / "tests/data/wheel_hollow.whl").as_posix()
COACH, WAGON = "vehicles/manchester_1.toml", "vehicles/freight_y25.toml"
STEPS = (5000, 2000, 1000, 500)
NEAR = 0.05  # asked of Y/Q behind the filter of 20 Hz


@dataclass(frozen=True)
class Case:
    """A vehicle into a curve and out of it again; twist: amplitude [mm] of one over 12 m in the middle of the curve."""

    radius: float
    friction: float
    speed: float
    model: str = COACH
    wheel: str = ""
    cant: float = 0.0
    twist: float = 0.0
    ramp: float = 30.0
    rail: str = "rails/60E1.toml"

    def run(self, step_us: int, rails: str = "", **more: Any) -> Result:
        """rails: kind of structure, by default none; more: keys of [run] of a short form with fast contacts."""
        curve = [transition(self.ramp), arc(60.0, self.radius, self.cant), transition(self.ramp), straight(30.0)]
        track: dict[str, Any] = {
            "rail": self.rail, "inclination": "none" if "grooved" in self.rail else "1:40", "gauge_mm": 1435,
            "segments": [straight(30.0), *curve],
        }  # fmt: skip
        if self.twist:
            middle = 30.0 + self.ramp + 25.0
            track["irregularities"] = [{"kind": "twist", "at_m": middle, "length_m": 12, "amplitude_mm": self.twist}]
        track |= {"structure": {"kind": rails}} if rails else {}
        wheel = {"wheel": self.wheel} if self.wheel else {}
        contact = {key.split(".")[1]: value for key, value in FAST.items()} if more else {}
        keys: dict[str, Any] = {
            "analysis": "curving", "vehicle": {"model": self.model, "speed_kmh": self.speed} | wheel, "track": track,
            "contact": {"friction": self.friction} | contact,
            "run": {"step_us": step_us, "output_interval_ms": 5} | more,
        }  # fmt: skip
        return run(load_text(write_toml(keys)))


CASES = {
    "twist": Case(250.0, 0.45, 20.0, wheel=HOLLOW, cant=100.0, twist=25.0),
    "sharp": Case(90.0, 0.5, 15.0, wheel=HOLLOW, ramp=15.0),
    "metro": Case(150.0, 0.5, 20.0, "templates/metro.toml", HOLLOW, cant=50.0),
    "sharp-S1002": Case(80.0, 0.45, 15.0),
    "tram": Case(-80.0, 0.4, 15.0, "vehicles/tram.toml", rail="rails/grooved.toml"),
    "freight": Case(190.0, 0.6, 25.0, WAGON, cant=60.0, twist=20.0),
    "worn": Case(150.0, 0.3, 30.0, wheel="wheels/S1002_worn.toml", cant=60.0),
    "wide": Case(400.0, 0.6, 40.0, wheel=HOLLOW, cant=60.0, twist=20.0),
}


def quotient(result: Result) -> float:
    """Largest Y/Q of all wheels behind a low-pass filter of fourth order at 20 Hz."""
    dataset = result.dataset
    low = butter(4, 20.0, fs=1.0 / float(np.diff(dataset["time"].values[:2])[0]), output="sos")
    values = np.nan_to_num(dataset["Y_over_Q"].values.reshape(dataset.sizes["time"], -1))
    return float(sosfiltfilt(low, values, axis=0).max())


def swings(result: Result) -> list[float]:
    """Frequencies that events of wheelsets that excite themselves name [Hz]."""
    labels = [event["event"] for event in result.summary().get("events", [])]
    return [float(f) for label in labels if "excites itself" in label for f in re.findall(r"([\d.]+) Hz", label)]


@pytest.mark.campaign
@pytest.mark.parametrize("name", CASES)
def test_the_step_decides_nothing_on_the_rails_of_the_default(name):
    results = [CASES[name].run(step) for step in STEPS]
    assert {result.status for result in results} == {"completed"}
    quotients = [quotient(result) for result in results]
    assert quotients == pytest.approx([quotients[-1]] * len(quotients), rel=NEAR)
    assert not any(map(swings, results))


@pytest.mark.campaign
@pytest.mark.parametrize("name", ["twist", "sharp", "metro"])
def test_rigid_rails_have_one_verdict_and_tell_the_frequency(name):
    results = [CASES[name].run(step, "rigid") for step in STEPS]
    assert len({result.stop_reason.split(":")[0] for result in results}) == 1
    for result in results:
        assert all(70.0 < frequency < 170.0 for frequency in swings(result)) and swings(result)


SHORT = {"start_distance_m": 74, "distance_m": 4}  # from the steady curve into the twist


def test_the_longest_step_does_on_the_rails_of_the_default():
    coarse, fine = (CASES["twist"].run(step, **SHORT) for step in (5000, 1000))
    assert quotient(coarse) == pytest.approx(quotient(fine), rel=0.002)
    assert not swings(coarse) and "events" not in coarse.summary()
    assert "default" in coarse.summary()["structure"] and "energy" not in coarse.summary().get("remarks", {})


def test_an_oscillation_on_rigid_rails_is_told_with_its_frequency_and_resolved():
    result = CASES["twist"].run(5000, "rigid", **SHORT | {"distance_m": 7})  # it has to grow
    assert result.status == "completed"
    assert all(90.0 < frequency < 140.0 for frequency in swings(result)) and swings(result)
    (event,) = (e["event"] for e in result.summary()["events"] if "excites itself" in e["event"])
    assert 'kind = "moving mass"' in event and "damping_s_per_m" in event
    assert not any(
        "impact" in event["event"] or "run.step_us" in event["event"] for event in result.summary()["events"]
    )
