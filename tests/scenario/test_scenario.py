"""One fault in a scenario file is one sentence that its author understands; files merge and are found in order."""

import math
import re
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.examples import examples
from support.rows import rows_of
from support.scenario_texts import CURVE, STATIC, edited, faults

from wrsim.errors import InputError
from wrsim.inputs.lines import key_lines
from wrsim.inputs.lookup import VARIABLE, shipped_models
from wrsim.inputs.toml_files import parse_toml, read_text, write_toml
from wrsim.scenario.loading import load, load_text

table = rows_of(__file__)

SCENARIOS = shipped_models().parent / "scenarios"

# --- one fault, one sentence ---------------------------------------------------------------------------

ONE_FAULT = table("one_fault")  # fmt: skip
"""What the file has, what is written instead, what the message is."""


@pytest.mark.parametrize(
    ("old", "new", "message"), ONE_FAULT, ids=[f"{i}-{n[:30]!r}" for i, (_, n, _) in enumerate(ONE_FAULT)]
)
def test_one_fault_in_a_file_is_one_line_that_names_file_key_value_and_what_is_allowed(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    lines = faults(edited(CURVE, old, new), tmp_path)
    assert len(lines) == 1, lines
    assert message in lines[0]
    assert "toml" in lines[0]


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


# --- files that cannot be read -------------------------------------------------------------------------
@pytest.mark.parametrize(("line", "place", "hint"), table("a_slip_of_toml_syntax_is_told_with_line_column_and_help"))
def test_a_slip_of_toml_syntax_is_told_with_line_column_and_help(
    tmp_path: Path, line: str, place: str, hint: str
) -> None:
    (message,) = [" ".join(faults(line + "\n", tmp_path))]
    assert message.startswith("case.toml" + place)
    assert "not valid TOML" in message
    assert hint in message


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
    (tmp_path / "case.toml").write_bytes(b"\xef\xbb\xbf" + CURVE.replace("\n", "\r\n").encode())
    assert load(tmp_path / "case.toml").title == "a curve"


def test_an_empty_file_is_told_what_it_needs_and_a_very_deep_nest_is_no_crash(tmp_path: Path) -> None:
    lines = faults("", tmp_path)
    assert [line.split(" ")[1] for line in lines] == ["analysis", "vehicle", "track"]
    assert "nested too deeply" in faults("a = " + "[" * 100_000, tmp_path)[0]


# --- base files ----------------------------------------------------------------------------------------
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


# --- where models are looked up ------------------------------------------------------------------------
def test_models_are_looked_up_beside_the_scenario_then_with_the_user_then_among_the_shipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rail = (shipped_models() / "rails/60E1.toml").read_text()
    for name in ("here", "argument", "environment"):
        (tmp_path / name / "rails").mkdir(parents=True)
    (tmp_path / "here/case.toml").write_text(CURVE)
    monkeypatch.setenv(VARIABLE, str(tmp_path / "environment"))

    def found() -> Path:
        scenario = load(tmp_path / "here/case.toml", [tmp_path / "argument"])
        return scenario.find(("track", "rail"), "rails/60E1.toml")

    assert found() == shipped_models() / "rails/60E1.toml"
    for name in ("environment", "argument", "here"):  # each comes before the one before
        (tmp_path / name / "rails/60E1.toml").write_text(rail)
        assert found() == tmp_path / name / "rails/60E1.toml"


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


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("vehicle.speed_kmh", None, "vehicle.speed_kmh = None: must be a number, a text"),
        ("contact", {"friction": None}, "contact.friction = None: must be"),
        ("contact.friction", object(), "contact.friction = <object"),
        (3, 4, "key 3: must be a text like track.segments[2].radius_m"),
        (("vehicle", "speed_kmh"), 4, "must be a text like"),
        ("a." * 3000 + "b", 1, "must be a text like"),
    ],
)
def test_values_and_keys_that_no_file_can_hold_are_refused(key, value, words):
    with pytest.raises(InputError, match=re.escape(words)):
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
            assert "not UTF-8" in str(error)
