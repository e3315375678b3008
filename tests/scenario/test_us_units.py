"""Keys in US units beside the metric ones."""

from pathlib import Path

import pytest
from support.rows import rows_of

from wrsim import InputError, load, load_text
from wrsim.inputs.us_units import chord_curvature, metric, us_keys
from wrsim.scenario.reference import keys_text

table = rows_of(__file__)

CURVE = """analysis = "curving"
[vehicle]
model = "vehicles/wheelset_s1002.toml"
speed_kmh = 60
[track]
rail = "rails/60E1.toml"
gauge_mm = 1435
inclination = "1:40"
[[track.segments]]
kind = "arc"
length_m = 100
radius_m = 300
cant_mm = 60
"""


def test_degrees_of_curve_are_those_of_a_chord_of_100_feet() -> None:
    assert 1.0 / chord_curvature(1.0) / 0.3048 == pytest.approx(5729.65, abs=0.01)  # the figure of US handbooks
    assert 1.0 / chord_curvature(2.49502) == pytest.approx(700.0, abs=0.01)


@pytest.mark.parametrize(("key", "value", "metric_key", "expected"), table("conversions"))
def test_the_ending_of_a_key_gives_its_unit(key: str, value: float, metric_key: str, expected: float) -> None:
    conversion = metric(key)
    assert conversion is not None and conversion.key == metric_key and key in us_keys(metric_key)
    assert conversion.convert(value) == pytest.approx(expected, rel=1e-9)


def test_a_scenario_in_us_units_is_the_metric_one_and_follows_set_base_and_studies(tmp_path: Path) -> None:
    text = CURVE.replace("speed_kmh = 60", "speed_mph = 37").replace("radius_m = 300", "radius_deg = 5")
    text = text.replace("cant_mm = 60", "superelevation_in = 3").replace("length_m = 100", "length_ft = 500")
    (tmp_path / "curve.toml").write_text(text)
    spec = load(tmp_path / "curve.toml").spec
    arc = spec.track.segments[0]
    assert spec.vehicle.speed_kmh == pytest.approx(59.545728)
    assert (arc.length_m, arc.cant_mm) == (152.4, 76.2) and arc.radius_m == pytest.approx(349.3859249)
    (tmp_path / "fast.toml").write_text('base = "curve.toml"\n[vehicle]\nspeed_kmh = 80\n')
    fast = load(tmp_path / "fast.toml")
    assert fast.spec.vehicle.speed_kmh == 80.0
    changed = fast.with_set(["vehicle.speed_mph=50", "track.segments[0].cant_mm=10", "vehicle.wheelset.mass_lb=2000"])
    assert changed.spec.vehicle.speed_kmh == pytest.approx(80.4672) and changed.spec.track.segments[0].cant_mm == 10.0
    assert "in US units: speed_mph" in keys_text("scenario", "vehicle.speed_mph")


@pytest.mark.parametrize(("old", "new", "message"), table("one_error"))
def test_both_or_none_is_one_clear_error(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        load_text(CURVE.replace(old, new))
    assert message in str(error.value) and "\n" not in str(error.value), str(error.value)
