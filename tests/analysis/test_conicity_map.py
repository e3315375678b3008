"""Maps of the equivalent conicity over gauge and profiles: cones, what gauge and spacing mean together, folders."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from support.commands import call
from support.runs import ROOT

from wrsim.analysis.conicity.pairs import conicity_map, profiles_of
from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.sections import cone

MODELS = ROOT / "models"
SCANS = ROOT / "scenarios" / "measured"
S1002 = {"S1002": load_profile(MODELS / "wheels/S1002.toml")}
RAILS = {"60E1": load_profile(MODELS / "rails/60E1.toml").inclined(1 / 40)}


def test_a_cone_has_its_conicity_at_any_gauge():
    cones = {f"{c}": cone(f"cone {c}", "wheel", c, -0.04, 0.06) for c in (0.05, 0.1)}
    found = conicity_map(cones, RAILS, [1.43, 1.435, 1.44], 1.5, 0.46)
    assert found.pairs == (("0.05", "60E1"), ("0.1", "60E1"))
    assert found.conicity == pytest.approx(np.tile([[0.05], [0.1]], 3), rel=0.02)  # a sixtieth of 1.5 m either way
    assert found.nonlinearity == pytest.approx(np.zeros((2, 3)), abs=1e-3)


def test_only_the_play_counts_not_gauge_and_spacing_by_themselves():
    wide = conicity_map(S1002, RAILS, [1.433, 1.436], 1.5, 0.46)
    moved = conicity_map(S1002, RAILS, [1.431, 1.434], 1.498, 0.46)
    assert moved.conicity == pytest.approx(wide.conicity, rel=1e-9)
    assert wide.conicity[0, 0] > 1.2 * wide.conicity[0, 1]  # S1002 on 60E1 falls with the gauge


def test_a_folder_gives_its_profiles_of_a_kind(tmp_path):
    assert list(profiles_of(SCANS, "wheel")) == ["wheel"]
    assert list(profiles_of(SCANS, "rail")) == ["rail"]  # rail.toml describes rail.csv
    with pytest.raises(InputError, match=r"has no wheel profiles \(files that end in \.toml or \.ban"):
        profiles_of(tmp_path, "wheel")
    (tmp_path / "broken.whl").write_text("no numbers\n")
    with pytest.raises(InputError, match=r"broken\.whl"):
        profiles_of(tmp_path, "wheel")


def command(*words: str) -> tuple[int, str]:
    found = call("conicity", *words)
    return found.exit_code, found.output


def test_the_command_leaves_a_table_and_a_picture_and_says_where_there_is_none(tmp_path):
    wheels = tmp_path / "wheels"
    wheels.mkdir()
    for name in ("S1002", "lrv_standin"):
        shutil.copy(MODELS / f"wheels/{name}.toml", wheels)
    where = tmp_path / "out"
    code, text = command(str(wheels), "rails/60E1.toml", "--gauges-mm", "1434", "1436", "1", "-o", str(where), "--json")
    assert code == 0
    found = json.loads(text)
    assert [Path(f).name for f in found["files"]] == ["conicity_map.csv", "conicity_map.png"]
    cells = {(c["wheel"], c["gauge_mm"]): c["equivalent_conicity_3_mm"] for c in found["map"]}
    own = json.loads(command("wheels/S1002.toml", "rails/60E1.toml", "--gauge-mm", "1436", "--json")[1])
    assert cells["S1002", 1436.0] == pytest.approx(own["equivalent_conicity"]["3_mm"], rel=1e-5)
    assert len(cells) == 6
    missing = sum(value is None for value in cells.values())
    assert len(found["gaps"]) <= missing <= 3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--gauges-mm", "1440", "1430", "1"), "must be FROM, a TO not below it"),
        (("--gauges-mm", "1430", "1440", "0.001"), "at most 200"),
        (("--gauges-mm", "1430", "1440", "1", "--diameters-mm", "920", "918"), "a map is of wheelsets with like"),
    ],
)
def test_bad_input_is_answered_with_one_clear_line(words, message):
    code, text = command("wheels/S1002.toml", "rails/60E1.toml", *words)
    assert code == 2
    assert message in text
