"""What a name in a file may reach: plain files of a sensible size, and for the scenario of a result only its own."""

import os
import re
import socket
from pathlib import Path

import pytest
import xarray as xr
from support.commands import call, forked, refusal
from support.runs import SCENARIOS
from support.scenario_texts import edited

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.inputs.checking import check_section
from wrsim.inputs.lines import key_lines
from wrsim.inputs.section import MOST_FAULTS
from wrsim.inputs.toml_files import LARGEST, read_bytes, read_text, reading_within, shown_value
from wrsim.report.view_data import setup_of
from wrsim.results import Result
from wrsim.scenario.build import build
from wrsim.scenario.loading import load, load_text
from wrsim.scenario.merging import MOST_BASES
from wrsim.scenario.sections.static import read_cases
from wrsim.vehicle.element_tables import DamperTable
from wrsim.vehicle.vehicle_files import load_vehicle

CURVE = (SCENARIOS / "curve_r300.toml").read_text()
POSES = (SCENARIOS / "static_s1002.toml").read_text()


SECRET = "root:x:0:0 a line of somebody else's"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_a_pipe_and_a_socket_are_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(InputError, match=r"pipe\.toml: is a pipe, a scenario file is needed"):
        load(tmp_path / "pipe.toml")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "socket"))
        with pytest.raises(InputError, match="socket: cannot read this file: "):
            read_bytes(tmp_path / "socket", "file")


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="needs a device")
def test_a_device_is_refused_and_does_not_fill_the_memory():
    with pytest.raises(InputError, match="/dev/zero: is a device, a scenario file is needed"):
        load("/dev/zero")


def test_a_file_that_is_too_large_is_refused_with_its_size(tmp_path):
    with open(tmp_path / "large.toml", "wb") as stream:
        stream.truncate(LARGEST + 100_000)
    with pytest.raises(InputError, match=r"has 64\.1 MB; a scenario file of at most 64 MB is read"):
        load(tmp_path / "large.toml")


def test_files_start_from_each_other_so_often_and_no_further(tmp_path):
    (tmp_path / "0.toml").write_text(CURVE)
    for i in range(1, MOST_BASES + 2):
        (tmp_path / f"{i}.toml").write_text(f'base = "{i - 1}.toml"\n')
    assert len(load(tmp_path / f"{MOST_BASES}.toml").merged.files) == MOST_BASES + 1
    with pytest.raises(InputError, match=r'1\.toml:1: base = "0\.toml": is one file too many: at most 20 scenarios'):
        load(tmp_path / f"{MOST_BASES + 1}.toml")
    for i in range(500):
        base = "S1002.toml" if i == 0 else f"{i - 1}.toml"
        text = (SCENARIOS.parent / "models/wheels/S1002_worn.toml").read_text()
        (tmp_path / f"{i}.toml").write_text(re.sub(r'(?m)^base = ".*?"', f'base = "{base}"', text))
    with pytest.raises(InputError, match="at most 20 profiles may follow each other by base"):
        load_profile(tmp_path / "499.toml")


def named(name: str) -> dict[str, str]:
    """Scenarios that name a file, by the key that does so."""
    segments = re.search(r"(?s)\[\[track\.segments\]\].*?(?=\[contact\])", CURVE)[0]
    uneven = f'[[track.irregularities]]\nkind = "table"\nfile = "{name}"\n\n'
    sections = f'[[track.rail_sections]]\nside = "left"\nat_m = 50\ntable = "{name}"\n\n'
    return {
        "vehicle.model": edited(CURVE, 'model = "vehicles/wheelset_s1002_steering.toml"', f'model = "{name}"'),
        "vehicle.wheel": edited(CURVE, "speed_kmh = 54", f'speed_kmh = 54\nwheel = "{name}"'),
        "track.rail": edited(CURVE, 'rail = "rails/60E1.toml"', f'rail = "{name}"'),
        "track.file": edited(CURVE, segments, "").replace("gauge_mm = 1435", f'file = "{name}"'),
        "track.table": edited(CURVE, segments, "").replace("gauge_mm = 1435", f'gauge_mm = 1435\ntable = "{name}"'),
        "track.irregularities[0].file": edited(CURVE, "[contact] ", f"{uneven}[contact] "),
        "track.rail_sections[0].table": edited(CURVE, "[contact] ", f"{sections}[contact] "),
        "contact.friction_table": edited(CURVE, "friction = 0.35", f'friction_table = "{name}"'),
        "static.cases": re.sub(
            r"(?s)\[static\].*?(?=\n\[|\Z)", f'[static]\ntarget = "wheelset"\ncases = "{name}"\n', POSES
        ),
    }


def said_of(text: str, folder: Path) -> str:
    """What the viewer says of a result with this scenario."""
    setup, why = setup_of(Result(xr.Dataset(attrs={"scenario_text": text})), folder)
    assert setup is None
    return why


@pytest.mark.parametrize("key", named(""))
def test_the_scenario_of_a_result_opens_nothing_outside_of_its_folder(key, tmp_path):
    secret, own = tmp_path / "secret.toml", tmp_path / "result"
    secret.write_text(SECRET)
    own.mkdir()
    (own / "linked.toml").symlink_to(secret)
    for name in (str(secret), "../secret.toml", "linked.toml", str(tmp_path / "missing.toml")):
        text = named(name)[key]
        why = said_of(text, own)
        assert f"{key} = {shown_value(name)}: lies outside of {own}, " in why
        assert "root:" not in why
    with pytest.raises(InputError, match=r"root:|secret\.toml"):  # a scenario of the user's own reads what it names
        build(load_text(named("../secret.toml")[key], own))


def test_the_models_beside_a_result_lead_nowhere_else_either(tmp_path):
    secret, own = tmp_path / "secret.csv", tmp_path / "result"
    secret.write_text(SECRET)
    own.mkdir()
    worn = (SCENARIOS.parent / "models/wheels/S1002_worn.toml").read_text()
    points = 'body = "wheel"\nname = "x"\nsource = "x"\ndate = 2026-01-01\nkind = "points"\nfile = "../secret.csv"\n'
    for text in (re.sub(r'(?m)^base = ".*?"', 'base = "../secret.csv"', worn), points):
        (own / "wheel.toml").write_text(text)
        why = said_of(named("wheel.toml")["vehicle.wheel"], own)
        assert re.search(r"secret\.csv\"?: lies outside of", why)
        assert "root:" not in why


def test_the_folders_around_a_result_are_not_listed_and_models_in_it_are_shown(tmp_path):
    (tmp_path / "result").mkdir()
    (tmp_path / "private.toml").write_text("")
    with reading_within([tmp_path / "result"]), pytest.raises(InputError) as refused:
        read_text(tmp_path / "privat.toml")
    assert "private" not in str(refused.value)
    own = tmp_path / "result"
    (own / "rail.toml").write_text((SCENARIOS.parent / "models/rails/60E1.toml").read_text())
    text = named("rail.toml")["track.rail"]
    setup, why = setup_of(Result(xr.Dataset(attrs={"scenario_text": text})), own)
    assert setup is not None
    assert why == ""


def test_a_value_of_many_lines_leaves_the_keys_behind_it_their_lines():
    text = "a = [" + '\n"]", # [\n' * 500 + ']\n"b = 1".c = """\n[d]\n"""""\n[[e]]\nf = {x = [1,\n 2]}\n[[e]]\nf = 1\n'
    lines = key_lines(text)
    assert lines == {
        ("a",): 1,
        ("b = 1",): 1002,
        ("b = 1", "c"): 1002,
        ("e",): 1005,
        ("e", 0): 1005,
        ("e", 0, "f"): 1006,
        ("e", 1): 1008,
        ("e", 1, "f"): 1009,
    }


def test_of_many_faults_and_digits_the_first_are_told_and_the_rest_is_counted():
    with pytest.raises(InputError) as told:
        load_text(CURVE + "".join(f"\n[unknown_{i}]" for i in range(500)))
    lines = str(told.value).split("\n")
    assert len(lines) == MOST_FAULTS + 1
    assert lines[-1] == f"scenario: and {500 - MOST_FAULTS} more faults"
    with pytest.raises(InputError, match=r"^scenario:2: a whole number of 5000 digits; at most 4300 are read$"):
        load_text(f"title = 'x'\nnumber = {'1' * 5000}")


@pytest.mark.parametrize("key", [".".join("a" * 200_000), "[" + " . ".join(["'b'"] * 100_000) + "]"])
def test_a_key_of_very_many_parts_is_refused_without_a_wait(key):
    with pytest.raises(InputError, match="nested too deeply; at most 30 levels"):
        load_text(f"{CURVE}\n{key}" + ("" if key.startswith("[") else " = 1"))


def test_too_many_parts_or_pieces_and_too_wide_a_rail_are_refused(tmp_path):
    places = "".join(f'[[parts.p{{i}}.places]]\nname = "n{k}"\npart = "p{{j}}"\nat_mm = [0, 0, 0]\n' for k in range(9))
    parts = "".join(places.format(i=i, j=i + 1) for i in range(7)) + "[parts.p7]\n"
    head = 'name = "x"\nsource = "x"\ndate = 2026-01-01\n[[places]]\nname = "a"\npart = "p0"\nat_mm = [0, 0, 0]\n'
    (tmp_path / "car.toml").write_text(head + parts)
    with pytest.raises(InputError, match="is one too many: a vehicle has at most 1000 parts"):
        load_vehicle(tmp_path / "car.toml")
    text = 'name = "flat"\nsource = "x"\ndate = 2026-01-01\nbody = "rail"\nkind = "circle"\n'
    (tmp_path / "flat.toml").write_text(f"{text}radius_mm = 10000\nhalf_width_mm = 999\n")
    with pytest.raises(InputError) as told:
        build(load_text(named("flat.toml")["track.rail"].replace('"1:40"', '"none"'), tmp_path))
    assert 'track.rail = "flat.toml": its gauge point or its top lies 0.5' in str(told.value)
    assert str(told.value).endswith(f"m from the origin of {tmp_path / 'flat.toml'}; at most 0.5 m")
    text = (SCENARIOS.parent / "models/rails/grooved.toml").read_text()
    begin = text.index("[[pieces]]")
    (tmp_path / "rail.toml").write_text(text[:begin] + text[begin:] * 100)
    with pytest.raises(InputError, match=r"rail\.toml: sections: there are 900; allowed: 500"):
        load_profile(tmp_path / "rail.toml")


@pytest.mark.parametrize("end", ["\r", "\r\n"])
def test_lines_of_a_table_may_end_as_on_any_machine(tmp_path, end):
    (tmp_path / "poses.csv").write_bytes(f"id,lateral_mm,load_kN{end}a,0,70{end}b,x,70{end}".encode())
    with pytest.raises(InputError, match=r"poses\.csv:3: lateral_mm = \"x\": must be a number"):
        read_cases(tmp_path / "poses.csv")


def test_quotes_in_the_middle_of_a_cell_are_refused_in_words_of_ours(tmp_path):
    (tmp_path / "poses.csv").write_text('id,lateral_mm,load_kN\n"a"b,0,70\n')
    with pytest.raises(
        InputError, match=r"poses\.csv:2: no line of a CSV table: a cell has at most \d+ characters, and"
    ):
        read_cases(tmp_path / "poses.csv")


def test_a_folder_in_the_place_of_the_result_is_told_before_the_run(tmp_path):
    (tmp_path / "out/result.nc").mkdir(parents=True)
    for force in ((), ("--force",)):
        refused = refusal("run", SCENARIOS / "static_s1002.toml", "-o", tmp_path / "out", *force)
        assert "result.nc: is a directory; a file of that name is written: move it away" in refused
        assert not (tmp_path / "out/scenario.toml").exists()


def test_a_long_value_on_the_command_line_is_not_echoed_whole():
    refused = call("check", SCENARIOS / "curve_r300.toml", "--set", f"vehicle.speed_kmh={'a' * 6000}")
    assert refused.exit_code == 2
    assert len(refused.stderr) < 400


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_a_full_disk_behind_stdout_is_told_by_that_name():
    ended = forked("keys", "run", first=lambda: os.dup2(os.open("/dev/full", os.O_WRONLY), 1))
    assert ended.returncode == 1
    assert ended.stderr.startswith("standard output: the disk is full")


def test_a_rod_needs_a_length_that_has_a_direction(tmp_path):
    text = (SCENARIOS.parent / "models/vehicles/manchester_motor.toml").read_text()
    short = edited(text, "to_mm = [1000, 0, 600]", "to_mm = [5e-324, 0, 600]")
    (tmp_path / "car.toml").write_text(short)
    with pytest.raises(InputError, match="is the same point as body_mm: a rod needs a length"):
        load_vehicle(tmp_path / "car.toml")
    line = {"body_mm": [0.0, 0.0, 1.0], "to_mm": [0.0, 5e-324, 1.0], "damping_kNs_per_m": 1.0}
    damper = {"kind": "damper", "name": "d", "body": "a", "to": "b", **line}
    with pytest.raises(InputError, match="is the same point as body_mm: a damper along a line needs a length"):
        check_section(DamperTable, damper, str)
