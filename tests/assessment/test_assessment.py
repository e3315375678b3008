"""EN 14363 quantities from runs with known forces: filters, sliding values, percentiles, sections, limits."""

import json
from math import pi, sqrt, tan

import numpy as np
import pytest
from scipy.special import ndtr, stdtrit
from support.rows import rows_of
from support.scenario_texts import CURVE, faults
from support.synthetic_run import Q0, curve, run, with_points, with_wheelsets

from wrsim import InputError, Result
from wrsim.analysis.ride import ride_section_of
from wrsim.assessment.assess import assess_runs
from wrsim.assessment.estimates import regression
from wrsim.assessment.limits import LimitContext
from wrsim.assessment.nadal import Climbing, longest_stretch, nadal_limit
from wrsim.assessment.outcome import Assessment, assessment_json
from wrsim.assessment.rules import rule_set
from wrsim.assessment.sections import sections_of, zone_of
from wrsim.assessment.settings import AssessmentSettings
from wrsim.results.filters import band_pass, low_pass, sliding_mean, sliding_rms, windows
from wrsim.scenario.sections.run import RideSection

table = rows_of(__file__)

EN = rule_set("en14363")
RATE = 500.0
TIME = np.arange(0.0, 20.0, 1.0 / RATE)
NADAL = AssessmentSettings(friction=0.35, flange_angle=np.radians(70.0))


def gain(filtered, frequency: float) -> float:
    """Amplitude of a filtered sine of amplitude 1, away from the ends."""
    waves = np.column_stack((np.sin(2.0 * pi * frequency * TIME), np.cos(2.0 * pi * frequency * TIME)))
    inside = slice(2000, -2000)
    return float(np.hypot(*np.linalg.lstsq(waves[inside], filtered(waves[:, 0])[inside], rcond=None)[0]))


@pytest.mark.parametrize("cut_off", [6.0, 20.0, 100.0])
def test_a_low_pass_is_down_3_dB_at_its_cut_off_and_falls_24_dB_an_octave(cut_off):
    def filtered(signal):
        return low_pass(signal, RATE, cut_off)

    assert gain(filtered, cut_off) == pytest.approx(1.0 / sqrt(2.0), rel=1e-6)
    assert gain(filtered, cut_off / 10.0) == pytest.approx(1.0, rel=1e-4)
    # beyond the cut-off |H| = 1/(1 + (sqrt 2 - 1) w^4), w after the bilinear transform
    warped = tan(pi * 2.0 * cut_off / RATE) / tan(pi * cut_off / RATE)
    assert gain(filtered, 2.0 * cut_off) == pytest.approx(1.0 / (1.0 + (sqrt(2.0) - 1.0) * warped**4), rel=1e-6)


def test_a_low_pass_shifts_nothing():
    bump = np.exp(-(((TIME[1:] - 10.0) / 0.02) ** 2))
    filtered = low_pass(bump, RATE, 20.0)
    assert filtered == pytest.approx(filtered[::-1], abs=1e-12)
    assert filtered.sum() == pytest.approx(bump.sum(), rel=1e-6)


def test_a_band_pass_is_down_3_dB_at_both_ends_and_stops_what_is_constant():
    def filtered(signal):
        return band_pass(signal, RATE, 0.5, 10.0)

    assert gain(filtered, 0.5) == pytest.approx(1.0 / sqrt(2.0), rel=1e-3)
    assert gain(filtered, 10.0) == pytest.approx(1.0 / sqrt(2.0), rel=1e-3)
    assert gain(filtered, 2.2) == pytest.approx(1.0, rel=1e-3)
    assert np.abs(filtered(np.ones(TIME.size))).max() < 1e-9


def test_what_cannot_be_assessed_says_why_and_too_slow_samples_how_fast():
    whole = run(250.0).dataset
    with pytest.raises(InputError, match="it has no Q"):
        assess_runs(Result(whole.drop_vars("Q")))
    with pytest.raises(InputError, match="it has no second wheel"):
        assess_runs(Result(whole.isel(wheel=[0])))
    with pytest.raises(InputError, match="20 samples; filters need at least 30"):
        assess_runs(Result(whole.isel(time=slice(0, 20))))
    for few in (0, 1, 2, 29):
        with pytest.raises(InputError, match=f"{few} samples; filters need at least 30"):
            assess_runs(Result(whole.isel(time=slice(0, few))))
    with pytest.raises(InputError, match="m long; sliding means are taken over 2 m"):
        assess_runs(Result(whole.isel(time=slice(0, 30))))
    with pytest.raises(InputError, match="does not move forward"):
        assess_runs(Result(whole.assign_coords(distance=("time", 0.0 * whole["distance"].values))))
    broken = whole.copy(deep=True)
    broken["Q"].values[7, 0] = np.nan
    with pytest.raises(InputError, match="wheel forces are not numbers"):
        assess_runs(Result(broken))
    with pytest.raises(
        InputError, match=r"more than 44.4 samples a second; .* 40: run it with output_interval_ms = 20"
    ):
        assess_runs(run(step=0.025))


def test_a_sliding_mean_is_the_integral_of_the_line_through_the_samples():
    distance = np.cumsum(np.linspace(0.01, 0.05, 2000))  # not uniform
    middles = windows(distance, 2.0, 0.5)
    assert np.diff(middles) == pytest.approx(0.5)
    assert middles[0] == pytest.approx(distance[0] + 1.0)
    assert middles[-1] + 1.0 <= distance[-1] + 1e-9 < middles[-1] + 1.5
    assert sliding_mean(distance, 3.0 * distance - 1.0, middles, 2.0) == pytest.approx(3.0 * middles - 1.0, rel=1e-12)
    sine = np.sin(2.0 * pi * distance / 5.0)
    expected = np.sin(2.0 * pi * middles / 5.0) * np.sin(2.0 * pi / 5.0) / (2.0 * pi / 5.0)
    assert sliding_mean(distance, sine, middles, 2.0) == pytest.approx(expected, abs=3e-4)


def test_the_rms_of_a_sine_over_whole_waves_is_its_amplitude_over_root_2():
    distance = np.arange(0.0, 300.0, 0.05)
    middles = windows(distance, 100.0, 10.0)
    rms = sliding_rms(distance, 7.0 * np.sin(2.0 * pi * distance / 4.0), middles, 100.0)
    assert rms == pytest.approx(7.0 / sqrt(2.0), rel=1e-3)
    assert windows(distance, 301.0, 1.0).size == 0


def test_track_is_cut_into_sections_of_its_classes():
    sections = sections_of(run(900.0, curvature=curve(-500.0)).dataset, EN.classes)
    assert [s.zone for s in sections] == [
        "straight", "transition", "small radius", "small radius", "small radius", "transition", "straight",
    ]  # fmt: skip
    assert [s.number for s in sections] == list(range(1, 8))
    assert [s.start for s in sections[1:]] == pytest.approx([200, 250, 350, 450, 550, 600], abs=0.2)
    assert sections[3].radius == pytest.approx(-500.0)
    assert sections[1].radius == pytest.approx(-500.0, rel=1e-2)  # the sharpest of the transition
    # 20 m/s without cant: 1.5 m v^2/(g R)
    assert sections[3].cant_deficiency == pytest.approx(1.5 * 400.0 / (9.80665 * 500.0))
    assert [s.short for s in sections] == [True, False, False, False, False, False, False]  # 200 m of 250


@pytest.mark.parametrize(("radius", "zone"), table("classes_of_curves"))
def test_classes_of_curves(radius, zone):
    assert zone_of(1.0 / radius, EN.classes) == zone_of(-1.0 / radius, EN.classes) == zone


def only(assessment: Assessment, key: str, wheel: str = "") -> float:
    """The value of a quantity that there is once."""
    (value,) = [v for v in assessment.of(key) if v.wheel == wheel]
    return value.value


def test_constant_forces_are_their_own_percentiles_and_medians():
    forces = run(
        900.0,
        curvature=curve(500.0),
        y=lambda s: (0.0 * s - 2e3, 0.0 * s + 31e3),
        q=lambda s: (0.0 * s + 40e3, 0.0 * s + 62e3),
        T_gamma=lambda s: np.column_stack((0.0 * s + 5.0, 0.0 * s + 80.0)),
        yaw=lambda s: 0.0 * s - 3e-3,
        lateral_shift=lambda s: 0.0 * s - 6e-3,
    )
    assessment = assess_runs(forces)
    assert [v.value for v in assessment.of("sum_Y")] == pytest.approx([33e3] * 7)
    assert [v.value for v in assessment.of("Y_over_Q") if v.wheel == "right"] == pytest.approx([0.5] * 7)
    assert [v.value for v in assessment.of("Q") if v.wheel == "right"] == pytest.approx([62e3] * 7)
    outer = assessment.of("Y_qst")  # the right wheel in a left curve; three sections of the full curve, no others
    assert [(v.wheel, v.section.zone) for v in outer] == [("right", "small radius")] * 3
    assert [v.value for v in outer] == pytest.approx([31e3] * 3)
    assert [v.value for v in assessment.of("Q_qst")] == pytest.approx([62e3] * 3)
    assert assessment.of("T_gamma")[1].value == pytest.approx(80.0)
    assert assessment.of("angle_of_attack")[0].value == pytest.approx(3e-3)
    assert assessment.of("lateral_shift")[0].value == pytest.approx(6e-3)
    assert assessment.of("unloading")[0].value == pytest.approx(1.0 - 40.0 / 51.0)
    assert max(v.value for v in assessment.of("instability")) < 1e-6


def two_curves(first: float, second: float):
    """Curvature of full curves of two radii, 400 m each, with straight track and transitions between."""
    places = np.cumsum([0.0, 50.0, 50.0, 400.0, 50.0, 50.0, 50.0, 400.0, 50.0])
    bends = np.array([0.0, 0.0, 1.0 / first, 1.0 / first, 0.0, 0.0, 1.0 / second, 1.0 / second, 0.0])
    return lambda s: np.interp(s, places, bends)


def test_the_limit_of_the_guiding_force_takes_the_mean_radius_of_its_class():
    # five sections of each radius
    assessment = assess_runs(run(1150.0, curvature=two_curves(260.0, -390.0)))
    radii = [abs(v.section.radius) for v in assessment.of("Y_qst")]
    assert sorted({round(r) for r in radii}) == [260, 390] and len(radii) == 10
    assert {round(v.limit.value) for v in assessment.of("Y_qst") if v.limit} == {round(30e3 + 10500e3 / np.mean(radii))}
    # a class for itself: its own radius, and no step where the next one begins
    alone = assess_runs(run(1150.0, curvature=two_curves(399.9, 500.0)))
    at_399, at_500 = (
        [v.limit.value for v in alone.of("Y_qst") if v.section.zone == f"{z} radius"] for z in ("very small", "small")
    )
    assert at_399 == pytest.approx([30e3 + 10500e3 / 399.9] * len(at_399))
    assert at_500 == pytest.approx([60e3] * len(at_500))


def test_a_large_quotient_of_the_inner_wheel_lowers_the_guiding_force_that_counts():
    def forces(inner: float) -> Assessment:
        pushes = lambda s: (inner * Q0 + 0.0 * s, 70e3 + 0.0 * s)  # noqa: E731
        return assess_runs(run(900.0, curvature=curve(300.0), y=pushes))

    free = forces(0.39)
    assert not free.of("Y_qst_reduced") and not free.passed
    assert all(v.passed is False for v in free.of("Y_qst"))
    loaded = forces(0.52)
    assert [v.value for v in loaded.of("Y_qst_reduced")] == pytest.approx(
        [70e3 - 50e3 * 0.12] * len(loaded.of("Y_qst"))
    )
    assert all(v.passed for v in loaded.of("Y_qst_reduced")) and all(v.limit is None for v in loaded.of("Y_qst"))


def test_the_combined_load_of_the_outer_rail():
    y, q = (lambda s: (0.0 * s, 55e3 + 0.0 * s)), (lambda s: (Q0 + 0.0 * s, 150e3 + 0.0 * s))
    assessment = assess_runs(run(900.0, curvature=curve(300.0), y=y, q=q))
    assert {round(v.value) for v in assessment.of("B_qst")} == {round(55e3 + 0.83 * 150e3)}
    assert {v.passed for v in assessment.of("B_qst")} == {True}  # 179.5 of 180 kN
    assert all(v.limit is None for v in assess_runs(run(900.0, curvature=curve(200.0))).of("B_qst"))


def test_curves_of_little_cant_deficiency_may_count_as_straight_track():
    # 20 m/s without cant: 68 mm are missing in R 900, 38 in R 1600, 122 in R 500
    for radius, limit, zone in (
        (1600.0, 0.04, "straight"),
        (900.0, 0.04, "large radius"),
        (500.0, 0.2, "small radius"),
    ):
        sections = sections_of(run(900.0, curvature=curve(radius)).dataset, EN.classes, None, limit)
        assert zone in {s.zone for s in sections if s.start < 400.0 < s.end}
        assert "large radius" in {s.zone for s in sections_of(run(900.0, curvature=curve(1600.0)).dataset, EN.classes)}


def uneven(amplitude: float, wave: float, speed: float = 30.0, length: float = 1080.0) -> Assessment:
    """A run on a sine of one wavelength [m], ten times as large on the right rail laterally as on the left one."""

    def rails(s, share):
        return np.column_stack(
            (share * amplitude * np.sin(2.0 * pi * s / wave), amplitude * np.cos(2.0 * pi * s / wave))
        )

    return assess_runs(run(length, speed, rail_lateral=lambda s: rails(s, 0.1), rail_vertical=lambda s: rails(s, 1.0)))


def test_the_quality_of_track_is_the_deviation_of_its_waves_of_3_to_25_m():
    assessment = uneven(2e-3, 9.0)
    inner = [t for t in assessment.track if t.section.number == 2]
    assert [t.direction for t in inner] == ["lateral", "vertical"]
    assert [t.deviation for t in inner] == pytest.approx([2e-3 / sqrt(2.0)] * 2, rel=2e-3)
    assert [t.largest for t in inner] == pytest.approx([2e-3] * 2, rel=5e-3)
    # 108 km/h: lateral 1.41 mm between QN1 1.2 and QN2 1.5 and within TL90 1.05 to 1.45; vertical below 1.8, 1.8
    assert [(t.by_deviation, t.by_largest, t.tl90) for t in inner] == [
        ("QN2", "QN1", "within"), ("QN1", "QN1", "below"),
    ]  # fmt: skip
    outside = [t.deviation for t in uneven(2e-3, 60.0).track if t.section.number == 2]
    assert max(outside) < 0.05 * 2e-3
    faster = [t for t in uneven(2e-3, 9.0, 60.0).track if t.section.number == 2]  # 216 km/h
    assert [(t.by_deviation, t.tl90) for t in faster] == [("above QN2", "above"), ("above QN2", "within")]
    assert not assess_runs(run()).track
    still = dict.fromkeys(("rail_lateral", "rail_vertical"), lambda s: np.zeros((s.size, 2)))
    coarse = assess_runs(run(900.0, 60.0, 2e-2, **still))
    assert not coarse.track and any("1.20 m apart" in note for note in coarse.notes)


def test_percentiles_are_those_of_the_distribution_of_means_over_two_metres():
    # a force that rises evenly over the section: its 99.85 % percentile is known
    assessment = assess_runs(run(250.0, q=lambda s: (40e3 + 100.0 * s, Q0 + 0.0 * s)), NADAL)
    assert only(assessment, "Q", "left") == pytest.approx(40e3 + 100.0 * 0.9985 * 250.0, rel=1e-4)

    def y(s):  # 1 m long, 40 kN, at 10 m/s: slow for the filter
        return np.where(np.abs(s - 100.0) < 0.5, 40e3, 0.0), 0.0 * s

    assessment = assess_runs(run(110.0, speed=5.0, y=y), NADAL)
    assert assessment.signals[""]["sum_Y"].values.max() == pytest.approx(20e3, rel=0.01)


def test_a_hunting_wheelset_is_found_with_its_frequency_and_rms():
    amplitude, frequency, speed = 30e3, 4.0, 40.0
    assessment = assess_runs(
        run(900.0, speed=speed, y=lambda s: (amplitude * np.sin(2.0 * pi * frequency * s / speed) + 3e3, 0.0 * s))
    )
    assert assessment.settings["instability_frequency_Hz"] == pytest.approx(frequency, abs=0.2)
    assert max(v.value for v in assessment.of("instability")) == pytest.approx(amplitude / sqrt(2.0), rel=0.03)
    limit = assessment.of("instability")[0].limit
    assert limit is not None and limit.value == pytest.approx(0.5 * (10e3 + 2.0 * Q0 / 3.0))
    assert any(v.passed is False for v in assessment.of("sum_Y")) is False
    assert assessment.passed is True
    faster = assess_runs(run(900.0, speed=speed, y=lambda s: (2.0 * amplitude * np.sin(2.0 * pi * 0.1 * s), 0.0 * s)))
    assert faster.passed is False
    assert all(v.passed is False for v in faster.of("instability"))


def test_wheelsets_are_assessed_where_they_are_themselves():
    # a force that belongs to one place of the track, under two wheelsets 10 m apart
    def y(s):
        return np.where(np.abs(s - 300.0) < 5.0, 40e3, 0.0), 0.0 * s

    shape = curve(500.0, 200.0, 50.0, 200.0)
    first = run(700.0, curvature=shape, y=y)
    second = run(700.0, curvature=lambda s: shape(s - 10.0), y=lambda s: y(s - 10.0))
    assessment = assess_runs(with_wheelsets([first, second], apart=10.0), NADAL)
    assert assessment.sections[0].start == pytest.approx(-10.0)
    assert [s.start for s in assessment.sections[1:3]] == pytest.approx([200.0, 250.0], abs=0.2)
    hit = {(v.wheelset, v.section.number) for v in assessment.of("sum_Y") if v.value > 30e3}
    assert hit == {("1", 3), ("2", 3)}
    signals = assessment.signals[""]["sum_Y"].values
    inside = np.isfinite(signals).all(axis=0)
    assert signals[0, inside] == pytest.approx(signals[1, inside], abs=50.0)


def test_accelerations_of_a_car_body_and_of_a_bogie_frame():
    base = run(900.0, speed=30.0, curvature=curve(500.0, 300.0, 50.0, 300.0))
    t = base.dataset["time"].values
    sway = 0.8 * np.sin(2.0 * pi * 1.5 * t) + 1.1  # a constant is not in the band
    heave = 0.6 * np.sin(2.0 * pi * 3.0 * t) + 5.0 * np.sin(2.0 * pi * 60.0 * t)  # 60 Hz: not in the band
    hunting = 6.0 * np.sin(2.0 * pi * 5.0 * t)
    assessment = assess_runs(with_points(base, {
        "floor": ("car body", np.nan, sway, heave),
        "frame": ("bogie frame", 6e3, hunting, hunting),
        "axle box": ("wheelset", np.nan, 100.0 * hunting, 100.0 * hunting),
    }), NADAL)  # fmt: skip
    assert {v.point for v in assessment.values} == {"", "floor", "frame"}
    inner = [s.number for s in assessment.sections if s.zone == "small radius"]

    def of(key: str) -> list[float]:
        return [v.value for v in assessment.of(key) if v.section.number in inner]

    assert of("body_ay") == pytest.approx([0.8] * 3, rel=0.02)
    assert of("body_ay_rms") == pytest.approx([0.8 / sqrt(2.0)] * 3, rel=0.02)
    assert of("body_az") == pytest.approx([0.6] * 3, rel=0.02)
    assert of("body_az_rms") == pytest.approx([0.6 / sqrt(2.0)] * 3, rel=0.02)
    assert of("body_ay_qst") == pytest.approx([1.1] * 3, rel=0.02)
    assert [z.passed for z in assessment.zones if z.worst.quantity.key == "body_ay_rms"] == [False] * 3  # 0.57 > 0.5
    (limit,) = {v.limit for v in assessment.of("frame_instability")}
    assert limit is not None and limit.value == pytest.approx(0.5 * (12.0 - 6.0 / 5.0))
    band = (1.0 + (sqrt(2.0) - 1.0) * (5.0 / 7.0) ** 8) * (1.0 + (sqrt(2.0) - 1.0) * (3.0 / 5.0) ** 8)  # 3 to 7 Hz at 5
    assert of("frame_instability") == pytest.approx([6.0 / sqrt(2.0) / band] * 3, rel=5e-3)
    assert assessment.settings["instability_frequency_frame_Hz"] == pytest.approx(5.0, abs=0.2)


def test_nadals_limit_is_its_closed_form_and_the_longest_stretch_beyond_ends_between_samples():
    assert nadal_limit(np.radians(70.0), 0.0) == pytest.approx(tan(np.radians(70.0)))
    assert nadal_limit(np.radians(70.0), 0.36) == pytest.approx(tan(np.radians(70.0) - np.arctan(0.36)))
    assert nadal_limit(np.radians(60.0), tan(np.radians(60.0))) == pytest.approx(0.0, abs=1e-15)
    s = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert longest_stretch(s, np.array([-1.0, 1.0, -1.0, -1.0, 3.0, 1.0, -1.0])) == pytest.approx(0.75 + 1.0 + 0.5)
    assert longest_stretch(s, -np.ones(7)) == 0.0
    assert longest_stretch(s, np.ones(7)) == 6.0
    assert longest_stretch(s, np.array([-1.0, np.inf, np.inf, -1.0, -1.0, -1.0, -1.0])) >= 1.0


@pytest.mark.parametrize(
    "text", table("a_result_whose_scenario_has_no_friction_gives_no_nadal_limit"), ids=lambda text: text[:40]
)
def test_a_result_whose_scenario_has_no_friction_gives_no_nadal_limit(text):
    dataset = run(250.0).dataset.assign_attrs(scenario_text=text)
    assert Climbing(dataset, AssessmentSettings(flange_angle=np.radians(70.0))).nadal(None) is None
    assert ride_section_of(Result(dataset)) == RideSection()


def test_a_constructed_derailment_exceeds_every_limit_that_it_should():
    limit = nadal_limit(np.radians(70.0), 0.35)

    def y(s):  # Y/Q 1.3 on the right wheel over 10 m, a ramp of 2 m before and behind
        return 0.0 * s, 1.3 * Q0 * np.interp(s, [398, 400, 410, 412], [0, 1, 1, 0])

    assessment = assess_runs(run(900.0, curvature=curve(300.0), y=y), NADAL)
    assert assessment.passed is False
    beyond = {v.quantity.key: v for v in assessment.values if v.passed is False}
    assert set(beyond) == {"sum_Y", "Y_over_Q", "Y_over_Q_nadal", "climb_distance"}
    assert all(v.wheel in ("", "right") for v in beyond.values())
    assert beyond["Y_over_Q"].value == pytest.approx(1.3, rel=0.01)
    # 10 m on top and the upper parts of both ramps
    assert beyond["climb_distance"].value == pytest.approx(10.0 + 2.0 * 2.0 * (1.0 - limit / 1.3), abs=0.4)


def limit_of(quantity: str, **about) -> float | None:
    limit = EN.about(quantity).limit_at(LimitContext(**about))
    return limit and limit.value


def test_limits_are_those_of_the_standards():
    assert limit_of("sum_Y", axle_load=120e3) == pytest.approx(50e3)
    assert limit_of("sum_Y", axle_load=120e3, kind="freight") == pytest.approx(42.5e3)
    for load, speed, most in ((60e3, 160.0, 150e3), (112.5e3, 160.0, 200e3), (112.5e3, 250.0, 180e3)):
        assert limit_of("Q", axle_load=2.0 * load, speed=speed / 3.6) == pytest.approx(most)
    for radius, most in ((600.0, 60e3), (350.0, 60e3), (250.0, 72e3)):
        assert limit_of("Y_qst", radius=radius) == pytest.approx(most)
    assert limit_of("Y_qst", radius=150.0) is None and limit_of("Y_over_Q", radius=150.0) is None


def of_radius(radius: float, guiding: float, scenario: str = "") -> Result:
    """A run through a full curve of 140 m with that guiding force of the outer wheel [N]."""
    return run(
        400.0,
        curvature=curve(radius, 80.0, 40.0, 140.0),
        y=lambda s: (0.0 * s, guiding * curve(1.0, 80.0, 40.0, 140.0)(s)),
        attributes={"scenario_text": scenario},
    )


def test_sections_of_several_runs_count_together():
    several = [of_radius(300.0, 30e3), of_radius(390.0, 40e3), of_radius(330.0, 20e3)]
    together, alone = assess_runs(several), [assess_runs(run_result) for run_result in several]
    assert [s.number for s in together.sections] == list(range(1, sum(len(a.sections) for a in alone) + 1))
    assert [s.run for s in together.sections] == [
        name for name, a in zip("123", alone, strict=True) for _ in a.sections
    ]
    assert [v.value for v in together.of("Q")] == [v.value for a in alone for v in a.of("Q")]
    (zone,) = [z for z in together.zones if z.worst.quantity.key == "Y_qst"]
    assert zone.sections == 6
    # the limit goes by the mean radius of all sections of the class, not by that of each run
    assert [v.limit.value for v in together.of("Y_qst")] == pytest.approx([30e3 + 10500e3 / 340.0] * 6, rel=1e-3)
    assert zone.worst.section.run == "2" and zone.worst.value == pytest.approx(40e3, rel=1e-3)


def test_curves_count_at_cant_deficiencies_of_a_test_only():
    # 72 km/h without cant: 1.5 v^2 / (g R) = 204, 185 and 157 mm in R 300, 331 and 390 m
    several = [of_radius(300.0, 30e3), of_radius(331.0, 40e3), of_radius(390.0, 20e3)]
    assessment = assess_runs(several, AssessmentSettings(admissible_deficiency=0.17))  # 127.5 to 187 mm
    curves = [s for s in assessment.sections if s.zone == "very small radius"]
    assert [s.counts for s in curves] == [False, False, True, True, True, True]
    assert all(s.counts for s in assessment.sections if s.zone != "very small radius")
    (zone,) = [z for z in assessment.zones if z.worst.quantity.key == "Y_qst"]
    assert (zone.sections, zone.counted, zone.zone.partition(" (")[2]) == (6, 4, "4 of 6)")
    assert zone.mean == pytest.approx(30e3, rel=1e-3)  # of 40 and 20 kN
    assert zone.worst.limit.value == pytest.approx(30e3 + 10500e3 / 360.5, rel=1e-3)
    none = assess_runs(several[:1], AssessmentSettings(admissible_deficiency=0.1))
    (zone,) = [z for z in none.zones if z.worst.quantity.key == "Y_qst"]
    assert (zone.counted, zone.estimate) == (0, None) and zone.worst.value == pytest.approx(30e3, rel=1e-3)
    assert json.loads(assessment_json(none))["zones"]


def test_runs_of_different_vehicles_or_settings_are_no_test():
    passenger = run(300.0)
    with pytest.raises(InputError, match="the runs a and b are not of one vehicle: the first has the wheelsets"):
        assess_runs([passenger, with_wheelsets([passenger, passenger])], names=("a", "b"))
    freight = of_radius(300.0, 30e3, CURVE + '\n[assessment]\nvehicle_kind = "freight"\n')
    with pytest.raises(InputError, match=r"the runs a and b have different \[assessment\]"):
        assess_runs([passenger, freight], names=("a", "b"))
    assert assess_runs([passenger, freight], AssessmentSettings()).settings["vehicle_kind"] == "passenger"
    with pytest.raises(InputError, match="run b: the result cannot be assessed: it has no Q"):
        assess_runs([passenger, Result(passenger.dataset.drop_vars("Q"))], names=("a", "b"))


def test_a_run_that_was_stopped_is_assessed_without_its_last_odd_sample():
    whole = run(250.0).dataset
    n = whole.sizes["time"]
    odd = whole.isel(time=[*range(0, n - 100, 5), n - 98])
    assert assess_runs(Result(odd), NADAL).sections[-1].end == pytest.approx(float(odd["distance"].values[-2]))


def test_the_travel_of_bump_stops_is_compared_with_the_ends_of_their_tables():
    base = run(250.0, speed=20.0)
    t = base.dataset["time"].values
    travel = np.column_stack((0.02 * np.sin(t), 0.01 + 0.03 * np.sin(t), 0.5 * np.sin(t)))
    zero = np.zeros_like(travel)
    dims = ("time", "suspension")
    moved = base.dataset.assign(
        suspension_dx=(dims, zero),
        suspension_dy=(dims, travel),
        suspension_dz=(dims, zero),
        suspension_stop_min=("suspension", [-0.065, -0.065, np.nan]),
        suspension_stop_max=("suspension", [0.010, 0.065, np.nan]),
    ).assign_coords(suspension=["one-sided", "even", "spring"])
    travels = {v.point: v for v in assess_runs(Result(moved), NADAL).of("bump_stop")}
    assert set(travels) == {"one-sided", "even"}
    assert travels["one-sided"].value == pytest.approx(0.02, rel=1e-3)  # towards the end at 10 mm, though -20 is as far
    assert travels["one-sided"].limit.value == pytest.approx(0.010)
    assert travels["one-sided"].passed is False
    assert travels["even"].value == pytest.approx(0.04, rel=1e-3)
    assert travels["even"].margin == pytest.approx(1.0 - 40.0 / 65.0, rel=1e-3)


# Estimated values by regression: known coefficients, bounds that hold as often as they say.
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
    fitted = regression(force(known), known, tuple(SLOPES), AT, 2.2)
    assert dict(zip(fitted.over, fitted.slope, strict=True)) == pytest.approx(SLOPES, rel=1e-9)
    assert (fitted.fit, fitted.estimate) == pytest.approx((force(AT),) * 2, rel=1e-9)
    # without a place the largest of the sections
    assert regression(force(known), known, ("speed",), {}, 2.2).point == (known["speed"].max(),)


def test_one_influence_has_the_bound_of_textbooks():
    generator = np.random.default_rng(SEED)
    known = sections(25, generator)
    x = known["cant_deficiency"]
    y = 30e3 + 2e5 * x + generator.normal(0.0, 1.5e3, x.size)
    fitted = regression(y, known, ("cant_deficiency",), AT, 3.0)
    slope, intercept = np.polyfit(x, y, 1)
    residuals = y - intercept - slope * x
    s = np.sqrt(np.sum(residuals**2) / (x.size - 2))
    wide = np.sqrt(1.0 + 1.0 / x.size + (0.165 - x.mean()) ** 2 / np.sum((x - x.mean()) ** 2))
    fit = intercept + slope * 0.165
    assert (fitted.slope[0], fitted.deviation, fitted.fit) == pytest.approx((slope, s, fit), rel=1e-9)
    t = stdtrit(x.size - 2, ndtr(3.0))
    assert fitted.estimate == pytest.approx(fit + t * s * wide, rel=1e-9)
    assert regression(y, known, ("cant_deficiency",), AT, 0.0).estimate == pytest.approx(fitted.fit, rel=1e-12)


@pytest.mark.parametrize("k", [3.0, 2.2])
def test_without_influences_many_sections_give_the_one_dimensional_method(k):
    y = np.random.default_rng(SEED).normal(40e3, 2e3, 200_000)
    fitted = regression(y, sections(y.size, np.random.default_rng(1)), (), {}, k)
    assert fitted.over == ()
    assert fitted.fit == pytest.approx(y.mean()) and fitted.deviation == pytest.approx(y.std(ddof=1))
    assert fitted.estimate == pytest.approx(y.mean() + k * y.std(ddof=1), rel=1e-5)


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
    assessment = assess_runs(run(3000.0, **CANTED), SETTINGS)
    (zone,) = [z for z in assessment.zones if z.worst.quantity.key == "sum_Y"]
    fitted = zone.regression
    assert fitted.over == ("cant_deficiency",)  # the speed stays
    # neighbours reach into a section by half a window and what the filter swings over
    assert fitted.slope[0] == pytest.approx(1e5, rel=0.05) and fitted.fit == pytest.approx(35e3, rel=0.02)
    assert zone.estimate == fitted.estimate > fitted.fit
    row = next(z for z in json.loads(assessment_json(assessment))["zones"] if z["worst"]["quantity"] == "sum_Y")
    (over,) = row["regression"]["over"]
    assert (over["influence"], over["unit"], over["at"]) == ("cant_deficiency", "mm", pytest.approx(150.0))
    assert over["slope"] == pytest.approx(0.1, rel=0.05)
    assert row["estimated_maximum"] == pytest.approx(1e-3 * zone.estimate)


@pytest.mark.parametrize(("lines", "said"), table("bad_influences_are_refused_with_file_and_key"))
def test_bad_influences_are_refused_with_file_and_key(tmp_path, lines, said):
    (fault,) = faults(f"{CURVE}\n[assessment]\n{lines}\n", tmp_path)
    assert fault.startswith("case.toml:") and said in fault
