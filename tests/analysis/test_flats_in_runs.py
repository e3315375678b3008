"""Wheels out of round in vehicle files, scenarios, poses and runs."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.rows import rows_of

from wrsim import InputError, load, load_vehicle, run
from wrsim.geometry.profile.out_of_round import Flat, Harmonic
from wrsim.scenario.build import build

table = rows_of(__file__)

ROOT = Path(__file__).resolve().parents[2]
SCENARIO = ROOT / "scenarios/flat.toml"
WHEELSET = ROOT / "models/vehicles/wheelset_s1002.toml"
R, MM = 0.46, 1e-3


def with_table(**table):
    return load(SCENARIO).with_values({"vehicle.out_of_round": [table], "contact.normal": "kik-piotrowski"})


def vertical_forces(scenario):
    """Times [s] and Q of both wheels [N]."""
    data = run(scenario).dataset
    return data["time"].values, data["Q"].values.reshape(-1, 2)


def test_a_vehicle_file_gives_its_wheels_their_shape(tmp_path):
    own = tmp_path / "wheelset.toml"
    own.write_text(
        WHEELSET.read_text().replace("wheels/", f"{ROOT}/models/wheels/")
        + '\n[[wheelset.out_of_round]]\nkind = "flat"\nwheel = "right"\nlength_mm = 40\nat_deg = 90\n'
        + '[[wheelset.out_of_round]]\nkind = "harmonic"\norder = 3\namplitude_mm = 0.1\n'
    )
    wheelset = load_vehicle(own).wheelsets[0].wheelset
    wave = Harmonic(3, 0.1 * MM)
    assert wheelset.left.out_of_round == (wave,)
    flat, other = wheelset.right.out_of_round
    assert other == wave and isinstance(flat, Flat)
    assert_allclose([flat.length, flat.angle, flat.deepest], [0.04, np.pi / 2, 0.04**2 / (8 * R)], rtol=1e-3)
    assert wheelset.with_wheel("right", None, 0.45).right.out_of_round == (flat, wave)


@pytest.mark.parametrize("table, words", table("what_cannot_be_is_refused_with_its_key"))
def test_what_cannot_be_is_refused_with_its_key(table, words):
    with pytest.raises(InputError) as error:
        build(with_table(**table))
    assert words in str(error.value) and "vehicle.out_of_round[0]" in str(error.value)


@pytest.mark.parametrize("rows, words", table("a_file_of_radii_that_is_no_wheel_is_refused_with_its_line"))
def test_a_file_of_radii_that_is_no_wheel_is_refused_with_its_line(tmp_path, rows, words):
    file = tmp_path / "radii.csv"
    file.write_text(rows)
    with pytest.raises(InputError) as error:
        build(with_table(kind="radius", file=str(file)))
    assert f"{file}" in str(error.value) and words in str(error.value)


def test_measured_radii_and_sections_are_the_wave_that_they_were_made_of(tmp_path):
    angle = np.arange(0, 360, 2)
    file = tmp_path / "radii.csv"
    rows = [f"{a},{100.0 * np.cos(np.radians(3 * a)):.9f}" for a in angle]
    file.write_text("\n".join(["angle_deg,deviation_um", *rows]))
    (part,) = build(with_table(kind="radius", file=str(file))).wheelset.left.out_of_round
    angles = np.arange(720) * np.pi / 360
    found = part.depth(angles, np.zeros(0), R)[:, 0]
    # a wave of 3 around is 0.5^((3 / 289)^2) of itself behind a limit of 10 mm
    assert_allclose(found, -1e-4 * np.cos(3 * angles), atol=2e-8)
    for name, conicity in (("a", 0.025), ("b", 0.035)):
        (tmp_path / f"{name}.toml").write_text(
            f'name = "{name}"\nbody = "wheel"\nkind = "cone"\nconicity = {conicity}\nfrom_mm = -50\nto_mm = 60\n'
            'date = 2026-11-26\nsource = "a line"\n'
        )
    sections = tmp_path / "sections.csv"
    sections.write_text("angle_deg,profile\n0,a.toml\n120,b.toml\n240,a.toml\n")
    scenario = with_table(kind="sections", file=str(sections), cutoff_mm=0)
    scenario = scenario.with_values({"vehicle.wheel": str(tmp_path / "a.toml")})
    (part,) = build(scenario).wheelset.left.out_of_round
    depth = part.depth(np.radians([0.0, 120.0, 240.0]), np.array([-0.01, 0.02]), R)
    assert_allclose(depth, [[0.0, 0.0], [-1e-4, 2e-4], [0.0, 0.0]], atol=1e-9)


@pytest.mark.parametrize("order, speed", [(18, 60.0), (23, 90.0)])
def test_a_polygon_gives_its_frequency(order, speed):
    """f = n v / (2 pi R), within the 3 Hz that 0.3 s tell apart."""
    wave = with_table(kind="harmonic", order=order, amplitude_mm=0.02)
    values = {"vehicle.speed_kmh": speed, "run.time_s": 0.4, "run.step_us": 500, "run.output_interval_ms": 0.5}
    t, q = vertical_forces(wave.with_values(values))
    late = q[t > 0.1, 0] - q[t > 0.1, 0].mean()
    size = np.abs(np.fft.rfft(late * np.hanning(late.size), 8 * late.size))
    found = np.fft.rfftfreq(8 * late.size, t[1] - t[0])[np.argmax(size)]
    assert_allclose(found, order * speed / 3.6 / (2.0 * np.pi * R), atol=3.0)


def test_a_flat_strikes_when_it_is_below_and_a_half_step_changes_the_peak_by_less_than_two_per_cent():
    flat = load(SCENARIO).with_values({"contact.normal": "kik-piotrowski"})
    peaks = []
    for step in (50, 25):
        t, q = vertical_forces(flat.with_values({"run.step_us": step, "run.output_interval_ms": 0.1}))
        peaks.append(q[:, 0].max())
        place = 60.0 / 3.6 * t[np.argmax(q[:, 0])]
        assert np.radians(60.0) * R - 1e-3 < place < np.radians(60.0) * R + 0.02
        assert_allclose(q[:, 1], q[0, 1], rtol=0.2)
    assert peaks[0] > 4.0 * q[0, 0]
    assert_allclose(peaks[0], peaks[1], rtol=0.02)


def test_flats_on_either_side_strike_alike():
    found = []
    for side in (0, 1):
        wheel = ("left", "right")[side]
        table = with_table(kind="flat", wheel=wheel, shape="rounded", length_mm=70, depth_mm=0.3, at_deg=60)
        _, q = vertical_forces(table)
        found.append(q[:, side])
    assert_allclose(*found, rtol=1e-7)


def test_poses_turn_the_wheel():
    """A rounded flat lowers the wheel by its depth, less what the flatter wheel is pressed in less."""
    values = {
        "vehicle.out_of_round": [{"kind": "flat", "shape": "rounded", "length_mm": 120, "depth_mm": 0.4, "at_deg": 5}],
        "static.load_kN": 50,
        "static.lateral_mm": 0,
        "static.yaw_mrad": 0,
        "static.wheel_angle_deg": [-90, 5],
    }
    data = run(load(ROOT / "scenarios/static_s1002.toml").with_values(values)).dataset
    high, low = data["vertical_shift"].values
    assert_allclose(high - low, 0.4e-3, atol=2e-5)
    assert [str(name) for name in data["pose"].values] == ["y+0_angle-90", "y+0_angle+5"]
