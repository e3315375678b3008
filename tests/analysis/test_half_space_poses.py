"""The exact solver chosen in a scenario: the same channels and strips as the strip models, and all bad input told."""

from functools import cache

import numpy as np
import pytest
from support.scenario_texts import STATIC, faults

from wrsim import SimulationError, load_text, run
from wrsim.report.document import contact_sentence

# The exact solver chosen in a scenario: the same channels and strips as the strip models, and all bad input told.
POSES = "lateral_mm = [0, 5.06, 6.5]\nyaw_mrad = 5\nload_kN = 60\n"


# off the rail, its end on it, two lobes, full overlap, flange; 1 N and 1 MN
HARD = "lateral_mm = [{shifts}]\nyaw_mrad = [{yaws}]\nload_kN = [{loads}]\n"


@cache
def solved(contact, poses=POSES, friction=0.3):
    text = STATIC.replace("lateral_mm = 0\nload_kN = 60\n", poses)
    return run(load_text(f"{text}[contact]\nfriction = {friction}\n{contact}\n")).wheelset()


CHOSEN = 'normal = "half-space"'


ON_EXACT = 'normal = "half-space"\ntangential = "fastsim"'


def patches(dataset, name):
    return dataset[name].values[np.isfinite(dataset["N"].values)]


@pytest.mark.parametrize("contact", [CHOSEN, ON_EXACT])
def test_strips_are_the_rows_of_the_elements(contact):
    d = solved(contact)
    assert (d["pose_message"] == "").all()
    for of_patch, of_strip in (("N", "strip_N"), ("Fx", "strip_Fx"), ("Fy", "strip_Fy")):
        assert np.nansum(d[of_strip].values, axis=-1) == pytest.approx(np.nan_to_num(d[of_patch].values), abs=1e-6)
    assert np.nanmax(d["strip_p"].values[0]) == pytest.approx(np.nanmax(d["p0"].values[0]))
    area = np.nansum(2.0 * d["strip_a"].values * d["strip_ds"].values, axis=-1)
    assert area[np.isfinite(d["N"].values)] == pytest.approx(patches(d, "area"), rel=0.02)
    # the wheel's forces are those of its strips along their normals and tangents
    angle = d["strip_angle"].values
    vertical = np.nansum(d["strip_N"] * np.cos(angle) + d["strip_Fy"] * np.sin(angle), axis=(-1, -2))
    assert vertical == pytest.approx(d["Q"].values, rel=1e-6)
    assert -np.nansum(d["Fx"].values, axis=-1) == pytest.approx(d["X"].values, rel=1e-6)
    assert d["Q"].values == pytest.approx(60e3, rel=1e-4)


# two flanges at -87 mrad have a reason only; with friction they come to it in 20 s
@pytest.mark.parametrize(("friction", "shifts", "yaws", "loads", "least"), [
    (0.3, "-72, 8", "0", "30", 1),
    pytest.param(0, "-72, -60, 5.06, 8, 9", "0, -87, 87", "0.001, 1000", 15, marks=pytest.mark.campaign),
    pytest.param(2, "-72, -60, 5.06, 8, 9", "0, 87", "0.001, 1000", 15, marks=pytest.mark.campaign),
])  # fmt: skip
def test_hard_poses_have_a_result_or_a_reason(friction, shifts, yaws, loads, least):
    hard = HARD.format(shifts=shifts, yaws=yaws, loads=loads)
    d = solved('normal = "half-space"\nhalf_space = {resolution = 8}', hard, friction)
    solved_ones = d["pose_message"].values == ""
    assert solved_ones.sum() >= least
    assert any("beside its rail" in message for message in d["pose_message"].values)
    assert d["Q"].values[solved_ones, 0] == pytest.approx(d["load"].values[solved_ones], rel=1e-3)
    for name in d.data_vars:
        if d[name].dims == ("pose", "wheel") and d[name].dtype.kind == "f" and name != "Y_over_Q":
            assert np.isfinite(d[name].values[solved_ones]).all()
    slid = np.hypot(patches(d, "Fx"), patches(d, "Fy"))
    assert (slid <= friction * patches(d, "N") * (1.0 + 1e-6)).all()


def test_turned_influence_that_is_left_out_is_said_with_what_it_would_change():
    poses = "lateral_mm = [0, 6.7]\nyaw_mrad = 3\nload_kN = 60\n"
    plain, turned = solved("", poses), solved("half_space = {influence = 'angle-corrected'}", poses)
    assert "contact_remark" not in turned
    none, said = plain["contact_remark"].values.ravel()
    assert none == ""
    p0 = [1e-6 * float(d["p0"][1].max()) for d in (plain, turned)]
    assert f"p0 = {p0[0]:.4g} MPa, and {p0[1]:.4g} MPa with" in said
    assert p0[1] == pytest.approx(p0[0], rel=0.042) and p0[1] != pytest.approx(p0[0], rel=0.02)
    assert "Normals turn by up to 42 degrees over a patch" in contact_sentence(plain)
    assert "Normals" not in contact_sentence(turned)


def test_too_many_elements_are_said():
    tiny = 'normal = "half-space"\nhalf_space = {element_x_mm = 0.001, element_s_mm = 0.001}'
    with pytest.raises(SimulationError, match="elements"):
        solved(tiny)


def test_wrong_keys_are_told(tmp_path):
    def said(contact):
        return faults(f"{STATIC}[contact]\n{contact}\n", tmp_path)

    assert said('tangential = "half-space"') == [
        'case.toml:13: contact.tangential = "half-space": "half-space" solves for tractions on exact pressures: '
        'it needs normal = "half-space"'
    ]
    assert 'did you mean "half-space"?' in said('normal = "halfspace"')[0]
    assert "goes with element_x_mm" in said("[contact.half_space]\nelement_x_mm = 0.2")[0]
    assert (
        "cannot be given with element_x_mm"
        in said("half_space = {element_x_mm=0.2, element_s_mm=0.2, resolution=30}")[0]
    )
    assert "did you mean 'element_x_mm'?" in said("half_space = {dx_mm = 0.2, element_s_mm = 0.2}")[0]
    assert said(CHOSEN + "\nhalf_space = {resolution = 20, influence = 'angle-corrected'}") == []
