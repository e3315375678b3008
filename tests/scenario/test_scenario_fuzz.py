"""Whatever is thrown at the readers, the answer is a scenario or an InputError."""

import math
import tempfile
import tomllib
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from support.examples import examples
from support.scenario_texts import CURVE, STATIC

from wrsim.errors import InputError
from wrsim.inputs.lines import key_lines
from wrsim.inputs.toml_files import parse_toml, read_text, write_toml
from wrsim.scenario.loading import load_text

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
