"""One fault in a scenario file is one sentence that its author understands; files merge and are found in order."""

import math
import os
import re
import socket
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from support.commands import call, forked, refusal
from support.examples import examples
from support.files import LINKS
from support.rows import rows_of
from support.scenario_texts import CURVE, STATIC, edited, faults

from wrsim import InputError, Result, load, load_profile, load_text, load_vehicle
from wrsim.inputs.checking import check_section
from wrsim.inputs.lines import key_lines
from wrsim.inputs.lookup import VARIABLE, shipped_models
from wrsim.inputs.section import MOST_FAULTS
from wrsim.inputs.toml_files import LARGEST, parse_toml, read_bytes, read_text, reading_within, shown_value, write_toml
from wrsim.report.view_data import setup_of
from wrsim.scenario.build import build
from wrsim.scenario.merging import MOST_BASES
from wrsim.scenario.sections.static import read_cases
from wrsim.vehicle.element_tables import DamperTable

table = rows_of(__file__)

SCENARIOS = shipped_models().parent / "scenarios"

ONE_FAULT = table("one_fault")  # fmt: skip
"""What the file has, what is written instead, what the message is."""


@pytest.mark.parametrize(
    ("old", "new", "message"), ONE_FAULT, ids=[f"{i}-{n[:30]!r}" for i, (_, n, _) in enumerate(ONE_FAULT)]
)
def test_one_fault_in_a_file_is_one_line_that_names_file_key_value_and_what_is_allowed(tmp_path, old, new, message):
    lines = faults(edited(CURVE, old, new), tmp_path)
    assert len(lines) == 1, lines
    assert message in lines[0]
    assert "toml" in lines[0]


OTHER_KINDS = {
    "history.csv": ("time_s,distance_m\n0,0\n", "a table (wrsim recording, wrsim profile)"),
    "forces.png": ("PNG", "a picture"),
    "friction.toml": ('title = "s"\nbase = "curve.toml"\n[[vary]]\nkey = "x"\nvalues = [1]\n', "a study (wrsim study)"),
    "line.toml": ('name = "t"\nsource = "s"\ndate = 2026-01-01\n[track]\n', "a track file (wrsim track)"),
}


READERS = {name: [load, Result.load, load_vehicle] for name in OTHER_KINDS}
READERS["friction.toml"] += [load_profile]  # a profile may be a table
READERS["line.toml"] += [load_profile]


@pytest.mark.parametrize(("name", "read"), [(name, read) for name, readers in READERS.items() for read in readers])
def test_a_file_of_another_kind_is_named_in_one_line_with_the_command_that_takes_it(tmp_path, name, read):
    text, message = OTHER_KINDS[name]
    (tmp_path / "curve.toml").write_text(CURVE)
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as problem:
        read(tmp_path / name)
    assert message in str(problem.value)
    assert "\n" not in str(problem.value)


def test_a_misspelt_table_makes_no_other_kind_of_file(tmp_path):
    (tmp_path / "base.toml").write_text(CURVE)
    (tmp_path / "case.toml").write_text('base = "base.toml"\n[outputs]\n')
    with pytest.raises(InputError, match=r"outputs: unknown key.*did you mean"):
        load(tmp_path / "case.toml")


def test_a_track_without_a_segment_is_shown_as_it_is_given(tmp_path):
    (tmp_path / "case.toml").write_text(CURVE)
    with pytest.raises(InputError, match=r"track\.segments = \[\]: .* needs a track of at least one of") as problem:
        load(tmp_path / "case.toml").with_set(["track.segments=[]"])
    assert "missing" not in str(problem.value)


STATIC_FAULTS = table("static_faults")


@pytest.mark.parametrize(("old", "new", "message"), STATIC_FAULTS)
def test_one_fault_in_static_poses_is_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    lines = faults(edited(STATIC, old, new), tmp_path)
    assert len(lines) == 1, lines
    assert message in lines[0]


def test_all_faults_of_a_file_are_told_at_once_in_the_order_of_its_lines(tmp_path: Path) -> None:
    text = CURVE
    for old, new in (
        ("speed_kmh = 54", "speed = 54"),
        ("gauge_mm = 1435", "gauge_mm = nan"),
        ("radius_m = 300", "radius_m = 0"),
        ("friction = 0.35", "friction = 3\nstrip = 5"),
    ):
        text = edited(text, old, new)
    lines = faults(text, tmp_path)
    assert [line.split(":")[1] for line in lines] == ["5", "7", "18", "22", "23"]


def test_a_fault_of_the_base_file_is_told_with_the_name_of_the_base_file(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text(edited(CURVE, "radius_m = 300", "radius_m = 0"))
    lines = faults('base = "base.toml"\n[contact]\nfriction = 9\n', tmp_path)
    assert len(lines) == 2
    assert lines[0].startswith("base.toml:18: track.segments[2].radius_m")
    assert lines[1].startswith("case.toml:3: contact.friction")


@pytest.mark.parametrize(("line", "place", "hint"), table("a_slip_of_toml_syntax_is_told_with_line_column_and_help"))
def test_a_slip_of_toml_syntax_is_told_with_line_column_and_help(tmp_path: Path, line: str, place: str, hint: str):
    (message,) = [" ".join(faults(line + "\n", tmp_path))]
    assert message.startswith("case.toml" + place)
    assert "not valid TOML" in message
    assert hint in message


@pytest.mark.parametrize("text", ['title = "{}"', "{} = 1", '[vehicle.changes]\n"{}" = 1', 'list = [["{}"]]'])
def test_names_and_texts_have_a_length_that_people_read(tmp_path: Path, text: str) -> None:
    (message,) = faults(text.format("n" * 100_000), tmp_path)
    assert "nnn" in message and "has 100000 characters; at most 4096 are read" in message
    assert len(message) < 200


def test_a_missing_file_names_its_neighbours_and_a_directory_what_is_in_it(tmp_path: Path) -> None:
    (tmp_path / "curve_r300.toml").write_text(CURVE)
    with pytest.raises(InputError, match=r"no such scenario file; did you mean '.*curve_r300\.toml'\?"):
        load(tmp_path / "curve_300.toml")
    with pytest.raises(InputError, match="there is no folder"):
        load(tmp_path / "nowhere" / "curve_300.toml")
    (tmp_path / "curve.toml").write_text(CURVE)
    with pytest.raises(InputError, match=r"is a directory, a scenario file is needed; there are curve\.toml"):
        load(tmp_path)


def test_bytes_that_are_not_utf8_are_told_and_marks_and_line_ends_do_no_harm(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_bytes("# Weiche\ntitle = 'Gleisbogen für alle'\n".encode("latin-1"))
    with pytest.raises(InputError, match=r"case\.toml:2: byte 0xfc is not UTF-8"):
        load(tmp_path / "case.toml")
    (tmp_path / "case.toml").write_bytes(CURVE.encode("utf-16"))
    with pytest.raises(InputError, match=r"case\.toml:1: byte 0xff is not UTF-8"):
        load(tmp_path / "case.toml")
    (tmp_path / "picture").write_bytes(b"\x89PNG\r\n\0\0")
    with pytest.raises(InputError, match=r"picture: is no text file; a scenario file is needed here"):
        load(tmp_path / "picture")
    (tmp_path / "case.toml").write_bytes(b"\xef\xbb\xbf" + CURVE.replace("\n", "\r\n").encode())
    assert load(tmp_path / "case.toml").title == "a curve"


def test_an_empty_file_is_told_what_it_needs_and_a_very_deep_nest_is_no_crash(tmp_path: Path) -> None:
    (line,) = faults("", tmp_path)
    assert line.endswith("case.toml: is empty; a scenario file is needed here")
    assert "nested too deeply" in faults("a = " + "[" * 100_000, tmp_path)[0]


def test_keys_override_those_of_the_base_and_lists_are_replaced(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text(CURVE)
    (tmp_path / "case.toml").write_text(
        'base = "base.toml"\n[vehicle]\nspeed_kmh = 36\n[[track.segments]]\nkind = "straight"\nlength_m = 9\n'
    )
    scenario = load(tmp_path / "case.toml")
    assert scenario.spec.vehicle.speed_kmh == 36.0
    assert scenario.spec.vehicle.model == "vehicles/wheelset_s1002.toml"
    assert [s.kind for s in scenario.spec.track.segments] == ["straight"]
    assert load_text(scenario.text).spec == scenario.spec, "the merged text stands for the whole"


def test_a_base_that_is_missing_or_starts_from_its_own_child_is_refused(tmp_path: Path) -> None:
    (tmp_path / "other.toml").write_text('base = "case.toml"\n')
    (line,) = faults('base = "other.toml"\n', tmp_path)
    assert "scenarios start from each other" in line
    assert "case.toml" in line and "other.toml" in line
    (line,) = faults('base = "case.toml"\n', tmp_path)
    assert "scenarios start from each other" in line
    (tmp_path / "curve.toml").write_text(CURVE)
    (line,) = faults('base = "curv.toml"\n', tmp_path)
    assert line.startswith('case.toml:1: base = "curv.toml": ')
    assert "curve.toml" in line
    (line,) = faults("base = 3\n", tmp_path)
    assert "base = 3: must be the name of a scenario file" in line


def test_a_section_of_the_base_that_the_analysis_does_not_use_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CURVE)
    (tmp_path / "rest.toml").write_text(
        'base = "case.toml"\nanalysis = "static"\n[static]\ntarget = "wheelset"\nload_kN = 100\n'
    )
    scenario = load(tmp_path / "rest.toml")
    assert scenario.analysis == "static"
    assert "output_interval_ms" not in scenario.text


def test_models_are_looked_up_beside_the_scenario_then_with_the_user_then_among_the_shipped(tmp_path, monkeypatch):
    rail = (shipped_models() / "rails/60E1.toml").read_text()
    for name in ("here", "argument", "environment"):
        (tmp_path / name / "rails").mkdir(parents=True)
    (tmp_path / "here/case.toml").write_text(CURVE)
    monkeypatch.setenv(VARIABLE, str(tmp_path / "environment"))

    def rail_file() -> Path:
        scenario = load(tmp_path / "here/case.toml", [tmp_path / "argument"])
        return scenario.find(("track", "rail"), "rails/60E1.toml")

    assert rail_file() == shipped_models() / "rails/60E1.toml"
    for name in ("environment", "argument", "here"):  # each comes before the one before
        (tmp_path / name / "rails/60E1.toml").write_text(rail)
        assert rail_file() == tmp_path / name / "rails/60E1.toml"


def test_a_missing_model_or_folder_of_models_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (line,) = faults(edited(CURVE, "rails/60E1.toml", "rails/unknown_rail.toml"), tmp_path)
    assert str(tmp_path) in line
    assert str(shipped_models()) in line
    (tmp_path / "case.toml").write_text(CURVE)
    with pytest.raises(InputError, match=r'models = ".*nowhere": must be a folder'):
        load(tmp_path / "case.toml", [tmp_path / "nowhere"])
    monkeypatch.setenv(VARIABLE, str(tmp_path / "elsewhere"))
    with pytest.raises(InputError, match=r'WRSIM_MODELS = ".*elsewhere": must be a folder'):
        load(tmp_path / "case.toml")


@pytest.mark.parametrize(
    ("value", "converted"),
    [(np.float64(60.0), 60.0), (np.int64(60), 60), (np.array(60.0), 60.0), (np.float32(60.0), 60.0)],
)
def test_numbers_of_numpy_are_numbers(value, converted):
    base = load(SCENARIOS / "curve_r300.toml")
    changed = base.with_values({"vehicle.speed_kmh": value, "output.patches_at_m": np.array([20.0, 50.0])})
    assert changed.spec.vehicle.speed_kmh == converted
    assert changed.text == base.with_values({"vehicle.speed_kmh": converted, "output.patches_at_m": [20.0, 50.0]}).text


def test_tables_that_a_change_leaves_are_those_of_its_whole_text() -> None:
    """Only tables with new values are checked again; what one of them asks of the others still holds."""
    base = load(SCENARIOS / "curve_r300.toml")
    changed = base.with_values({"contact.friction": 0.2})
    assert changed.spec == load_text(changed.text).spec
    assert changed.spec.track is base.spec.track and changed.spec.contact is not base.spec.contact
    with pytest.raises(InputError, match="needs a speed"):
        base.with_values({"vehicle": {"model": base.spec.vehicle.model}})
    with pytest.raises(InputError, match="friction"):
        changed.with_values({"contact.friction": "wet"})


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("vehicle.speed_kmh", None, "vehicle.speed_kmh = None: must be a number, a text"),
        ("contact", {"friction": None}, "contact.friction = None: must be"),
        ("contact.friction", object(), "contact.friction = <object"),
        (3, 4, "key 3: must be a text like track.segments[2].radius_m"),
        (("vehicle", "speed_kmh"), 4, "must be a text like"),
        ("a." * 3000 + "b", 1, "must be a text like"),
    ],
)
def test_values_and_keys_that_no_file_can_hold_are_refused(key, value, message):
    with pytest.raises(InputError, match=re.escape(message)):
        load(SCENARIOS / "curve_r300.toml").with_values({key: value})


# Whatever is thrown at the readers, the answer is a scenario or an InputError.
scalars = st.one_of(
    st.none().map(lambda _: math.nan),
    st.booleans(),
    st.integers(-(10**6), 10**6),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["straight", "arc", "transition", "1:40", "static", "rails/60E1.toml", "wheel", "wheelset"]),
)
values = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.sampled_from(["from", "to", "step", "kind", "radius_m", "x", "poisson"]), inner, max_size=3),
    ),
    max_leaves=6,
)
KEYS = """
title analysis vehicle track contact static run output base speed_kmh speed model segments rail gauge_mm kind x
length_m radius_m radius_mm cant_mm friction strips material wheel load_kN lateral_mm target cases
loads payloads on at_mm axes force_kN mass_kg time_s_force_kN distance_m_force_kN name
"""
keys = st.sampled_from(KEYS.split()) | st.text(min_size=1, max_size=6)


def canonical(tree: Any) -> str:
    """Text that is equal for equal trees, whatever the order of keys; not-a-number equals itself."""
    if isinstance(tree, dict):
        return "{" + ", ".join(sorted(f"{k!r}: {canonical(v)}" for k, v in tree.items())) + "}"
    if isinstance(tree, list):
        return "[" + ", ".join(canonical(v) for v in tree) + "]"
    return repr(tree)


def places(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    return [path, *(p for k, v in items for p in places(v, (*path, k)))]


@st.composite
def mutated_scenarios(draw: st.DrawFn) -> dict[str, Any]:
    """A valid scenario with one to four keys changed, added, renamed or taken away, anywhere."""
    tree: Any = tomllib.loads(draw(st.sampled_from([CURVE, STATIC])))
    for _ in range(draw(st.integers(1, 4))):
        *way, last = draw(st.sampled_from([p for p in places(tree) if p] or [("x",)]))
        holder = tree
        for step in way:
            holder = holder[step]
        action = draw(st.sampled_from(["change", "add", "rename", "drop"]))
        if action == "change" or isinstance(holder, list):
            holder[last] = draw(values)
        elif action == "add":
            holder[draw(keys)] = draw(values)
        else:
            value = holder.pop(last, 0)
            if action == "rename":
                holder[draw(keys)] = value
    return tree


@settings(max_examples=examples(120))
@given(mutated_scenarios())
def test_no_mutation_of_a_scenario_gives_anything_but_a_scenario_or_an_input_error(tree: dict[str, Any]) -> None:
    try:
        scenario = load_text(write_toml(tree))
    except InputError as error:
        lines = str(error).split("\n")
        assert all(line.strip() for line in lines)
        assert lines[0].startswith("scenario")
        assert all(len(line) < 500 for line in lines)
    else:
        assert load_text(scenario.text).spec == scenario.spec


@settings(max_examples=examples(80))
@given(st.dictionaries(st.text(), values, max_size=5))
def test_what_is_written_as_toml_reads_back_the_same(tree: dict[str, Any]) -> None:
    assert canonical(parse_toml(write_toml(tree), "x")) == canonical(tree)


@settings(max_examples=examples(80))
@given(mutated_scenarios())
def test_the_line_of_a_key_is_the_line_where_it_stands(tree: dict[str, Any]) -> None:
    text = write_toml(tree)
    lines = text.split("\n")
    for path, number in key_lines(text).items():
        name = next(str(part) for part in reversed(path) if isinstance(part, str))
        if name.isascii() and name.isidentifier():
            assert name in lines[number - 1]


@settings(max_examples=examples(80))
@given(st.text() | st.text(alphabet="[]{}=.\"'#\n ab1,:-"))
def test_no_text_gives_anything_but_tables_or_an_input_error(text: str) -> None:
    try:
        parse_toml(text, "x.toml")
    except InputError as error:
        assert str(error).startswith("x.toml")
    key_lines(text)


@settings(max_examples=examples(100))
@given(st.binary(max_size=60))
def test_no_bytes_give_anything_but_text_or_an_input_error(content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.toml"
        path.write_bytes(content)
        try:
            read_text(path)
        except InputError as error:
            assert (
                "no text file" if b"\0" in content and content[:2] not in (b"\xff\xfe", b"\xfe\xff") else "not UTF-8"
            ) in str(error)


# What a name in a file may reach: plain files of a sensible size, and for the scenario of a result only its own.
SHIPPED_CURVE = (SCENARIOS / "curve_r300.toml").read_text()
POSES = (SCENARIOS / "static_s1002.toml").read_text()

SECRET = "root:x:0:0 a line of somebody else's"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pipes in folders")
def test_a_pipe_and_a_socket_are_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(InputError, match=r"pipe\.toml: is a pipe, a scenario file is needed"):
        load(tmp_path / "pipe.toml")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "socket"))
        with pytest.raises(InputError, match="socket: cannot read this file: "):
            read_bytes(tmp_path / "socket", "file")


@pytest.mark.skipif(sys.platform == "win32", reason="needs a device")
def test_a_device_is_refused_and_does_not_fill_the_memory():
    with pytest.raises(InputError, match="/dev/zero: is a device, a scenario file is needed"):
        load("/dev/zero")


def test_a_file_that_is_too_large_is_refused_with_its_size(tmp_path):
    with open(tmp_path / "large.toml", "wb") as stream:
        stream.truncate(LARGEST + 100_000)
    with pytest.raises(InputError, match=r"has 64\.1 MB; a scenario file of at most 64 MB is read"):
        load(tmp_path / "large.toml")


def test_files_start_from_each_other_so_often_and_no_further(tmp_path):
    (tmp_path / "0.toml").write_text(SHIPPED_CURVE)
    for i in range(1, MOST_BASES + 2):
        (tmp_path / f"{i}.toml").write_text(f'base = "{i - 1}.toml"\n')
    assert len(load(tmp_path / f"{MOST_BASES}.toml").merged.files) == MOST_BASES + 1
    with pytest.raises(
        InputError, match=r'1\.toml:1: base = "0\.toml": follows 20 others: a scenario has no more than 20 base files'
    ):
        load(tmp_path / f"{MOST_BASES + 1}.toml")
    for i in range(500):
        base = "S1002.toml" if i == 0 else f"{i - 1}.toml"
        text = (SCENARIOS.parent / "models/wheels/S1002_worn.toml").read_text()
        (tmp_path / f"{i}.toml").write_text(re.sub(r'(?m)^base = ".*?"', f'base = "{base}"', text))
    with pytest.raises(InputError, match="at most 20 profiles may follow each other by base"):
        load_profile(tmp_path / "499.toml")


def named(name: str) -> dict[str, str]:
    """Scenarios that name a file, by the key that does so."""
    segments = re.search(r"(?s)\[\[track\.segments\]\].*?(?=\[contact\])", SHIPPED_CURVE)[0]
    uneven = f'[[track.irregularities]]\nkind = "table"\nfile = "{name}"\n\n'
    sections = f'[[track.rail_sections]]\nside = "left"\nat_m = 50\ntable = "{name}"\n\n'
    return {
        "vehicle.model": edited(SHIPPED_CURVE, 'model = "vehicles/wheelset_s1002_steering.toml"', f'model = "{name}"'),
        "vehicle.wheel": edited(SHIPPED_CURVE, "speed_kmh = 54", f'speed_kmh = 54\nwheel = "{name}"'),
        "track.rail": edited(SHIPPED_CURVE, 'rail = "rails/60E1.toml"', f'rail = "{name}"'),
        "track.file": edited(SHIPPED_CURVE, segments, "").replace("gauge_mm = 1435", f'file = "{name}"'),
        "track.table": edited(SHIPPED_CURVE, segments, "").replace(
            "gauge_mm = 1435", f'gauge_mm = 1435\ntable = "{name}"'
        ),
        "track.irregularities[0].file": edited(SHIPPED_CURVE, "[contact] ", f"{uneven}[contact] "),
        "track.rail_sections[0].table": edited(SHIPPED_CURVE, "[contact] ", f"{sections}[contact] "),
        "contact.friction_table": edited(SHIPPED_CURVE, "friction = 0.35", f'friction_table = "{name}"'),
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
    secret, result_folder = tmp_path / "secret.toml", tmp_path / "result"
    secret.write_text(SECRET)
    result_folder.mkdir()
    if LINKS:
        (result_folder / "linked.toml").symlink_to(secret)
    links = ["linked.toml"] * LINKS
    for name in (secret.as_posix(), "../secret.toml", *links, (tmp_path / "missing.toml").as_posix()):
        text = named(name)[key]
        why = said_of(text, result_folder)
        assert f"{key} = {shown_value(name)}: lies outside of {result_folder}, " in why
        assert "root:" not in why
    with pytest.raises(InputError, match=r"root:|secret\.toml"):  # a scenario of the user's own reads what it names
        build(load_text(named("../secret.toml")[key], result_folder))


def test_the_models_beside_a_result_lead_nowhere_else_either(tmp_path):
    secret, result_folder = tmp_path / "secret.csv", tmp_path / "result"
    secret.write_text(SECRET)
    result_folder.mkdir()
    worn = (SCENARIOS.parent / "models/wheels/S1002_worn.toml").read_text()
    points = 'body = "wheel"\nname = "x"\nsource = "x"\ndate = 2026-01-01\nkind = "points"\nfile = "../secret.csv"\n'
    for text in (re.sub(r'(?m)^base = ".*?"', 'base = "../secret.csv"', worn), points):
        (result_folder / "wheel.toml").write_text(text)
        why = said_of(named("wheel.toml")["vehicle.wheel"], result_folder)
        assert re.search(r"secret\.csv\"?: lies outside of", why)
        assert "root:" not in why


def test_the_folders_around_a_result_are_not_listed_and_models_in_it_are_shown(tmp_path):
    (tmp_path / "result").mkdir()
    (tmp_path / "private.toml").write_text("")
    with reading_within([tmp_path / "result"]), pytest.raises(InputError) as refused:
        read_text(tmp_path / "privat.toml")
    assert "private" not in str(refused.value)
    result_folder = tmp_path / "result"
    (result_folder / "rail.toml").write_text((SCENARIOS.parent / "models/rails/60E1.toml").read_text())
    text = named("rail.toml")["track.rail"]
    setup, why = setup_of(Result(xr.Dataset(attrs={"scenario_text": text})), result_folder)
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
        load_text(SHIPPED_CURVE + "".join(f"\n[unknown_{i}]" for i in range(500)))
    lines = str(told.value).split("\n")
    assert len(lines) == MOST_FAULTS + 1
    assert lines[-1] == f"scenario: and {500 - MOST_FAULTS} more faults"
    with pytest.raises(InputError, match=r"^scenario:2: a whole number of 5000 digits; at most 4300 are read$"):
        load_text(f"title = 'x'\nnumber = {'1' * 5000}")


@pytest.mark.parametrize("key", [".".join("a" * 200_000), "[" + " . ".join(["'b'"] * 100_000) + "]"])
def test_a_key_of_very_many_parts_is_refused_without_a_wait(key):
    with pytest.raises(InputError, match="nested too deeply; at most 30 levels"):
        load_text(f"{SHIPPED_CURVE}\n{key}" + ("" if key.startswith("[") else " = 1"))


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


def test_quotes_within_a_cell_and_a_folder_in_place_of_the_result_are_refused(tmp_path):
    (tmp_path / "poses.csv").write_text('id,lateral_mm,load_kN\n"a"b,0,70\n')
    with pytest.raises(
        InputError, match=r"poses\.csv:2: no line of a CSV table: a cell has at most \d+ characters, and"
    ):
        read_cases(tmp_path / "poses.csv")
    (tmp_path / "out/result.nc").mkdir(parents=True)
    for force in ((), ("--force",)):
        refused = refusal("run", SCENARIOS / "static_s1002.toml", "-o", tmp_path / "out", *force)
        assert "result.nc: is a directory; a file of that name is written: move it away" in refused
        assert not (tmp_path / "out/scenario.toml").exists()


def test_a_long_value_on_the_command_line_is_not_echoed_whole():
    refused = call("check", SCENARIOS / "curve_r300.toml", "--set", f"vehicle.speed_kmh={'a' * 6000}")
    assert refused.exit_code == 2
    assert len(refused.stderr) < 400


@pytest.mark.skipif(sys.platform == "win32", reason="needs a device that is always full")
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
