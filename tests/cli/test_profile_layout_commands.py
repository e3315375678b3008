"""Files of points as programs write them, through commands and scenarios: what is stated, assumed, refused."""

import json

import numpy as np
import pytest
from support.commands import call, ok
from support.profile_texts import BACK, S1002, lines, measures, miniprof, moved, nodes

from wrsim import InputError, Profile, load, load_profile
from wrsim.contact.profiles.files import read_points
from wrsim.contact.profiles.flange import flange_dimensions
from wrsim.contact.profiles.wear import Removal, worn
from wrsim.scenario.build import build

WHEEL, RAIL = load_profile("wheels/S1002.toml"), load_profile("rails/60E1.toml")
POINTS = nodes(WHEEL)


@pytest.mark.usefixtures("sketched")
def test_the_tape_circle_comes_from_the_file_the_wheelset_or_is_assumed(write, tmp_path):
    """77.79 mm from the flange back: a wheel of North America."""
    points = moved(POINTS, BACK)
    stated = write(miniprof(points, "WheelDiameterTaperline=77.7900\nXYPoints={count}\nColumnDef=X,Y\n"), "us.whl")
    assert measures(load_profile(stated))[1] == pytest.approx(_thickness(WHEEL, 7.79e-3), abs=0.02)
    bare = write(miniprof(moved(POINTS, BACK)), "bare.whl")
    assert "tape circle at 70 mm assumed" in load_profile(bare).notes[0]
    assert "tape circle at 77.79 mm as of the wheelset" in load_profile(bare, back=77.79e-3).notes[0]
    table = ok("profile", bare, "--back-to-tape-circle-mm", 75, "-o", tmp_path / "o.png", "--json").stdout
    (wheel,) = json.loads(table)["wheels"]
    assert wheel["Sd_mm"] == pytest.approx(_thickness(WHEEL, 5e-3), abs=0.02)
    refused = call("conicity", stated, "rails/60E1.toml", "--origin", "tape circle")
    assert (
        refused.exit_code == 2 and "with its tape circle at u = 0: the flange back lies at u = 0.0 mm" in refused.stderr
    )


def _thickness(wheel: Profile, outward: float) -> float:
    """Sd [mm] where the tape circle lies farther out: 10 mm below the tread there."""
    level = float(wheel.at(wheel.arclength_of(outward))[1])
    return 1e3 * flange_dimensions(wheel.shifted(-outward, -level), 70e-3 + outward).thickness


def test_a_wheel_of_another_tape_circle_does_not_go_on_a_wheelset_in_silence(write):
    path = write(miniprof(moved(POINTS, BACK), "WheelDiameterTaperline=68.0000\nColumnDef=X,Y\n"), "w.whl")
    with pytest.raises(
        InputError, match=r"68 mm from its flange back, that of the wheelset 70 mm: set back_to_tape_circle"
    ):
        build(load("scenarios/curve_r300.toml").with_values({"vehicle.wheel": str(path)}))


def test_the_scenario_says_how_points_are_read_and_the_result_what_was_assumed(write):
    path = write(lines(nodes(RAIL.inclined(1 / 20)), "in"), "rail.csv")
    scenario = load("scenarios/curve_r300.toml").with_values({"track.rail": str(path)})
    with pytest.raises(InputError, match="Is the unit right"):
        build(scenario)
    setup = build(scenario.with_set(["profiles.rail.unit=in"]))
    assert "rail.csv: x to the field side by its inclination of 1:20" in str(setup.attributes()["profile_notes"])
    told = build(scenario.with_set(["profiles.rail.unit=in", "profiles.rail.field_side=positive"]))
    assert "profile_notes" not in told.attributes()


@pytest.mark.usefixtures("sketched")
def test_what_a_workshop_measures_follows_the_points_and_the_head_is_compared(write, tmp_path):
    """A long cut-off rounds the flange; an instrument takes its points."""
    sharp = worn(WHEEL, [Removal("normal", 0.6e-3, -48e-3, 3e-3)], "sharp")
    expected = measures(sharp)
    path = write(
        miniprof(moved(nodes(sharp, 0.2e-3), BACK), "Sd=33.00\nSh=28.00\nqR=1,0\nColumnDef=X,Y\n"), "sharp.whl"
    )
    reading = read_points(path, cutoff=15e-3)
    assert measures(reading.close) == pytest.approx(expected, abs=0.01)
    assert max(np.abs(np.subtract(measures(reading.profile), expected))) > 0.01
    notes = json.loads(ok("profile", path, "-o", tmp_path / "o.png", "--json").stdout)["notes"]
    (head,) = [note for note in notes if "in its head" in note]
    assert "Sd" in head and "Sh" not in head and "qR" in head


@pytest.mark.usefixtures("sketched")
def test_the_key_of_a_points_file_aligns_too_and_a_scan_without_these_parts_is_refused(write, tmp_path):
    write(miniprof(moved(POINTS, 12.0, 3.0)), "scan.whl")
    head = 'name = "scan"\nbody = "wheel"\nkind = "points"\ndate = 2026-11-28\nsource = "test"\n'
    path = write(head + 'file = "scan.whl"\nalign = "wheels/S1002.toml"\n', "scan.toml")
    assert measures(load_profile(path)) == pytest.approx(S1002, abs=0.06)
    answer = json.loads(
        ok(
            "profile", path.with_suffix(".whl"), "--align", "wheels/S1002.toml", "-o", tmp_path / "o.png", "--json"
        ).stdout
    )
    assert any("aligned on S1002: moved by -12" in note for note in answer["notes"])
    middle = POINTS[(POINTS[:, 0] > -54.0) & (POINTS[:, 0] < 44.0)]
    with pytest.raises(InputError, match=r"cannot be aligned: .* points on the parts of S1002 that do not wear"):
        read_points(write(miniprof(middle), "scan.whl"), align=WHEEL)
