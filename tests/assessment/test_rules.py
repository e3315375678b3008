"""Rule sets: what clauses of laws make of known forces, and what is said of a rule set with mistakes."""

from math import pi, radians, sqrt, tan

import numpy as np
import pytest
from support.commands import ok, refusal
from support.rows import rows_of
from support.scenario_texts import CURVE, DATA
from support.synthetic_run import Q0, curve, run, with_points, with_wheelsets

from wrsim import InputError, Result, load_text
from wrsim.assessment.assess import assess_runs
from wrsim.assessment.limits import QUANTITIES, LimitContext
from wrsim.assessment.nadal import distance_to_climb
from wrsim.assessment.outcome import Assessment
from wrsim.assessment.rules import FOLDER, NAMES, rule_set
from wrsim.assessment.settings import AssessmentSettings
from wrsim.study.outputs import case_outputs
from wrsim.study.spec import OutputsSection

table = rows_of(__file__)

FLANGE = AssessmentSettings(axle_load=2.0 * Q0, friction=0.3, flange_angle=radians(70.0))
FEET_5 = 1.524


def tent(height: float, base: float, middle: float = 150.0):
    """A force that rises to its height and falls again, over that base [m]; slow for a filter of 25 Hz at 5 m/s."""
    return lambda s: height * np.clip(1.0 - np.abs(s - middle) / (0.5 * base), 0.0, None)


def assessed(rules: str, results: Result, settings: AssessmentSettings = FLANGE) -> Assessment:
    return assess_runs(results, settings, rules=rules)


def worst(assessment: Assessment, quantity: str) -> float:
    values = [v.value for v in assessment.of(quantity)]
    return min(values) if QUANTITIES[quantity].lowest else max(values)


def of_bogie(results: list[Result], apart: float = 2.5) -> Result:
    whole = with_wheelsets(results, apart).dataset
    return Result(whole.assign(wheelset_bogie=("wheelset", ["frame"] * len(results))))


def test_a_value_counts_as_far_as_it_is_held_over_5_ft():
    # over a window w a tent of base b holds h (1 - w/b)
    base, height = 12.0, 0.9 * Q0
    assessment = assessed("49cfr238", run(300.0, 5.0, y=lambda s: (0.0 * s, tent(height, base)(s))))
    held = height * (1.0 - FEET_5 / base)
    assert worst(assessment, "Y_over_Q_nadal") == pytest.approx(held / Q0, rel=5e-3)
    assert worst(assessment, "sum_Y_share") == pytest.approx(held / (2.0 * Q0), rel=5e-3)
    # one that is shorter than the window counts for nothing
    short = assessed("49cfr238", run(300.0, 5.0, y=lambda s: (0.0 * s, tent(height, 1.4)(s))))
    assert worst(short, "Y_over_Q_nadal") < 0.02 and short.passed


def test_a_wheel_load_counts_as_far_as_it_is_missing_over_5_ft():
    base = 12.0
    unloaded = of_bogie([run(300.0, 5.0, q=lambda s: (Q0 - tent(0.99 * Q0, base)(s), Q0 + 0.0 * s))] * 2, 0.0)
    assessment = assessed("49cfr238", unloaded)
    left = 1.0 - 0.99 * (1.0 - FEET_5 / base)
    assert worst(assessment, "Q_share") == pytest.approx(left, abs=5e-3)
    # two wheels of a side over the load of a wheelset
    assert worst(assessment, "side_Q_share") == pytest.approx(left, abs=5e-3)
    (share,) = [z for z in assessment.zones if z.worst.quantity.key == "side_Q_share"]
    assert (share.worst.wheel, share.worst.point, share.passed) == ("left", "frame", False)
    assert share.margin == pytest.approx((left - 0.2) / 0.8, abs=5e-3)


def test_the_side_of_a_bogie_has_the_quotient_of_the_sums():
    first = run(300.0, y=lambda s: (0.0 * s, 0.8 * Q0 + 0.0 * s))
    second = run(300.0, y=lambda s: (0.0 * s, 0.2 * Q0 + 0.0 * s), q=lambda s: (Q0 + 0.0 * s, 1.5 * Q0 + 0.0 * s))
    assessment = assessed("49cfr238", of_bogie([first, second]))
    assert worst(assessment, "side_Y_over_Q") == pytest.approx(1.0 / 2.5, rel=1e-6)
    without = assessed("49cfr238", with_wheelsets([first, second], 2.5))
    assert not without.of("side_Y_over_Q") and any("which bogie" in note for note in without.notes)


def test_limits_of_the_track_safety_standards_are_those_of_the_law():
    slope = tan(radians(70.0))
    (limit,) = {v.limit.value for v in assessed("49cfr238", run(300.0)).of("Y_over_Q_nadal")}
    assert limit == pytest.approx((slope - 0.5) / (1.0 + 0.5 * slope))
    (limit,) = {v.limit.value for v in assessed("en14363", run(300.0)).of("Y_over_Q_nadal")}
    assert limit == pytest.approx((slope - 0.3) / (1.0 + 0.3 * slope))
    clause = rule_set("49cfr213").about("sum_Y_share")
    assert clause.limit_at(LimitContext(axle_load=200e3)).value * 200e3 == pytest.approx(
        0.4 * 200e3 + 5e3 * 4.44822, rel=1e-4
    )


def frames(amplitude: float, seconds: float, step: float) -> Result:
    """A bogie frame that hunts at 3 Hz about a constant acceleration for some seconds."""
    base = run(600.0, 20.0, step)
    t = base.dataset["time"].values
    wave = 1.5 + amplitude * np.sin(2.0 * pi * 3.0 * t) * (np.abs(t - 15.0) < 0.5 * seconds)
    return with_points(base, {"frame": ("bogie frame", 6e3, wave, wave)})


def test_hunting_is_an_rms_about_the_mean_and_the_distance_to_climb_that_of_tcrp_71():
    g = 9.80665
    long = assessed("49cfr213", frames(0.6 * g, 8.0, 2e-3))
    assert worst(long, "frame_hunting") == pytest.approx(0.6 * g / sqrt(2.0), rel=5e-3)  # 0.424 g
    assert [z.passed for z in long.zones if z.worst.quantity.key == "frame_hunting"] == [False]
    short = assessed("49cfr213", frames(0.6 * g, 1.0, 2e-3))
    assert worst(short, "frame_hunting") == pytest.approx(0.6 * g / 2.0, rel=3e-2)  # half the window
    with pytest.raises(InputError, match=r"truck hunting: needs 250 samples a second; the result has 200: .* = 4 or"):
        assessed("49cfr213", frames(0.6 * g, 8.0, 5e-3))
    # 75 degrees and 0.7 in: 26 / (AOA + 1.1) ft
    attack = np.array([0.0, 2.5, 5.0, 10.0, 20.0])
    feet = distance_to_climb(1e-3 * attack, radians(75.0), 0.7 * 0.0254) / 0.3048
    assert feet == pytest.approx(26.0 / (attack + 1.12), rel=0.01)
    assert distance_to_climb(np.array([-5e-3]), radians(75.0), 0.0178) == pytest.approx(
        distance_to_climb(np.array([0.0]), radians(75.0), 0.0178)
    )


@pytest.mark.parametrize(("yaw", "attacks"), [(-8e-3, True), (8e-3, False)])
def test_the_way_beyond_nadals_limit_counts_by_the_distance_to_climb(yaw, attacks):
    settings = AssessmentSettings(friction=0.5, flange_angle=radians(72.0), flange_length=0.018)
    limit = (tan(radians(72.0)) - 0.5) / (1.0 + 0.5 * tan(radians(72.0)))

    def y(s):  # 3 m beyond the limit, with steep ends
        return 0.0 * s, Q0 * (limit + np.interp(s, [99.9, 100.1, 102.9, 103.1], [-0.5, 0.5, 0.5, -0.5]))

    climbing = run(300.0, 5.0, y=y, yaw=lambda s: yaw + 0.0 * s)
    assessment = assessed("en14363", climbing, settings)
    need = distance_to_climb(np.array([-yaw]), radians(72.0), 0.018)[
        0
    ]  # the right flange attacks with a yaw to the right
    assert worst(assessment, "climb_share") == pytest.approx(worst(assessment, "climb_distance") / need, rel=1e-6)
    assert worst(assessment, "climb_distance") == pytest.approx(3.0, abs=0.05)
    assert (worst(assessment, "climb_share") > 1.0) == attacks
    assert not assessed("en14363", climbing, FLANGE).of("climb_share")  # the flange's length is not given


def test_a_flange_that_tcrp_71_does_not_know_has_no_distance_to_climb_and_a_note_says_so():
    assert np.isnan(distance_to_climb(np.zeros(2), radians(76.5), 0.018)).all()
    assert np.isfinite(distance_to_climb(np.array([-1e-3, 1e-3]), radians(60.0), 0.018)).all()
    settings = AssessmentSettings(friction=0.5, flange_angle=radians(76.5), flange_length=0.018)
    assessment = assessed("en14363", run(300.0, 5.0), settings)
    assert not assessment.of("climb_share")
    assert "distance to climb: TCRP 71 has it for 60 to 76°, not for 76.5°" in assessment.notes


def test_every_set_that_is_shipped_has_a_source_for_every_limit():
    assert NAMES == ("49cfr213", "49cfr238", "en14363", "en14363-stationary", "uic518")
    for name in NAMES:
        for clause in rule_set(name).clauses:
            assert clause.limit is None or (clause.limit.source and clause.limit.mark in ("read", "pub", "mem"))


OWN = (DATA / "rules.toml").read_text()


@pytest.mark.usefixtures("unpainted")
def test_a_set_of_the_users_own_judges(tmp_path):
    rules_file = tmp_path / "own.toml"
    rules_file.write_text(OWN)
    assessment = assess_runs(run(900.0, curvature=curve(300.0)), FLANGE, rules=rules_file)
    assert {(v.section.zone, v.passed) for v in assessment.values} == {
        ("straight", None), ("transition", None), ("bends", False),
    }  # fmt: skip
    run(400.0, curvature=curve(300.0, 100.0, 50.0, 100.0)).save(tmp_path / "result.nc")
    ok("assess", tmp_path, "--rules", rules_file)
    ok("assess", tmp_path, "--rules", "49CFR238", "--force")


@pytest.mark.parametrize(("right", "wrong", "message"), table("a_mistake_in_a_set_is_one_line"))
def test_a_mistake_in_a_set_is_one_line(tmp_path, right, wrong, message):
    rules_file = tmp_path / "own.toml"
    rules_file.write_text(OWN.replace(right, wrong))
    with pytest.raises(InputError, match=message) as caught:
        rule_set(rules_file)
    assert len(str(caught.value).splitlines()) == 1


def test_two_clauses_about_one_quantity_and_an_unknown_set_are_refused(tmp_path):
    rules_file = tmp_path / "own.toml"
    text = (FOLDER / "49cfr238.toml").read_text()
    rules_file.write_text(text.replace('"sum_Y_share"', '"Q_share"'))
    with pytest.raises(InputError, match=r"clauses\[2\].quantity: .Q_share.: is that of clauses\[1\]"):
        rule_set(rules_file)
    run(300.0).save(tmp_path / "result.nc")
    assert 'did you mean "49cfr238"' in refusal("assess", tmp_path, "--rules", "49cfr328")
    assert "no such rule set" in refusal("assess", tmp_path, "--rules", tmp_path / "none.toml")
    assert "has no clause about runs" in refusal("assess", tmp_path, "--rules", "en14363-stationary")


def test_the_scenario_names_its_rule_set_and_studies_go_by_it():
    named = CURVE + '\n[assessment]\nrules = "49cfr238"\n'
    force = run(300.0, y=lambda s: (0.2 * Q0 + 0.0 * s, 0.0 * s), attributes={"scenario_text": named})
    assert assess_runs(force).rules.name == "49 CFR 238"
    assert assess_runs(force, rules="uic518").rules.name == "UIC 518"
    outputs = case_outputs(force, OutputsSection(assessment=("sum_Y_share", "Q_share", "sum_Y")), None)
    assert outputs.numbers["assessment_sum_Y_share"] == pytest.approx(0.1)
    assert outputs.numbers["assessment_Q_share_margin"] == pytest.approx(1.0)
    assert [fault.partition(" has ")[0] for fault in outputs.faults] == [
        'outputs.assessment: "sum_Y": 49 CFR 238 Appendix C, suspension system safety'
    ]
    with pytest.raises(InputError, match=r'assessment.rules = "49cfr283": must be .*did you mean "49cfr238"'):
        load_text(named.replace("238", "283"))
