"""The reference of keys, the schemas and the templates follow the code."""

import json
import re
import runpy
import tomllib
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from jsonschema.validators import Draft7Validator, validator_for
from support.commands import call, ok, refusal
from support.rows import rows_of

from wrsim import InputError, Vehicle, load, load_profile, load_text, load_vehicle
from wrsim.inputs.file_kinds import FILES
from wrsim.inputs.reference import entries
from wrsim.inputs.section import ALIASES
from wrsim.inputs.toml_files import shown_value
from wrsim.register import ANALYSES
from wrsim.scenario.build import build
from wrsim.scenario.plausibility import vehicle_warnings
from wrsim.scenario.reference import schema_text, tables_of_file
from wrsim.scenario.templates import TEMPLATES, scenario_template
from wrsim.scenario.track_build import track_model
from wrsim.study.evolution.reading import read_evolution
from wrsim.study.plan import planned
from wrsim.vehicle.vehicle_sections import WheelsetTable

table = rows_of(__file__)

ROOT = Path(__file__).parents[2]


def test_schemas_and_pages_are_not_stale_and_schemas_need_the_tables_that_a_scenario_needs() -> None:
    """Make them anew with: python docs/make_keys.py"""
    make = runpy.run_path(str(ROOT / "docs" / "make_keys.py"))
    for path, text in (make["schemas"]() | make["pages"]()).items():
        assert path.read_text(encoding="utf-8") == text, path
    data = tomllib.loads((ROOT / "scenarios/curve_r300.toml").read_text())
    del data["track"]
    assert faults(schema_of("scenario"), data) == ["'track' is a required property"]


@cache
def schema_of(file: str) -> Draft7Validator:
    """The schema of a kind of file, itself checked, in the draft that it says it is written in."""
    schema = json.loads(schema_text(file))
    assert validator_for(schema, default=None) is Draft7Validator
    # Taplo refuses a schema whose address is not whole
    assert "$id" not in schema
    Draft7Validator.check_schema(schema)
    return Draft7Validator(schema)


def faults(schema: Draft7Validator, data: dict[str, Any]) -> list[str]:
    """What an editor says of a file; dates are texts to it."""
    return [error.message for error in schema.iter_errors(json.loads(json.dumps(data, default=str)))]


@pytest.mark.parametrize(("kind", "file", "slip"), table("a_schema_finds_a_slip"))
def test_a_schema_finds_a_slip(kind: str, file: str, slip: dict[str, Any]) -> None:
    schema, data = schema_of(kind), tomllib.loads((ROOT / file).read_text())
    assert faults(schema, data) == []
    assert faults(schema, data | slip)


def test_editors_find_a_schema_for_every_shipped_file_and_it_accepts_them() -> None:
    rules = tomllib.loads((ROOT / ".taplo.toml").read_text())["rule"]
    accepted = set()
    for rule in rules:
        schema = Draft7Validator(json.loads((ROOT / rule["schema"]["path"]).read_text()))
        for file in (file for pattern in rule["include"] for file in ROOT.glob(pattern)):
            assert faults(schema, tomllib.loads(file.read_text())) == [], file
            accepted.add(file)
    shipped = {*(ROOT / "models").rglob("*.toml"), *(ROOT / "scenarios").rglob("*.toml")}
    assert shipped - accepted == set()


@pytest.mark.parametrize("file", FILES)
def test_every_key_says_what_it_is_and_may_be_with_an_example(file: str) -> None:
    for table in tables_of_file(file):
        for entry in entries(table):
            assert entry.meaning.endswith("."), f"{table.header} {entry.key}: write a sentence beneath the field"
            assert entry.allowed, f"{table.header} {entry.key}"
            assert entry.example or entry.allowed.startswith(("a table", "a list of tables", "tables")), (
                f"{table.header} {entry.key}"
            )


@pytest.mark.parametrize("kind", ANALYSES)
def test_a_new_scenario_can_be_run(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    ok("new", kind, "-o", file)
    setup = build(load(file))
    assert setup.analysis == kind
    text = file.read_text()
    assert max(map(len, text.splitlines())) <= 120
    ok("new", kind, "-o", file)
    file.write_text(text + "# mine\n")
    assert "has changed since" in refusal("new", kind, "-o", file)


@pytest.mark.parametrize("kind", ANALYSES)
def test_values_in_the_comments_of_a_new_scenario_are_the_defaults(kind: str) -> None:
    text = scenario_template(kind)
    plain = load_text(text).spec
    lines = re.findall(r"^# \w+ = [^#\s].*$", text, re.MULTILINE)
    assert len(lines) > 5
    for line in lines:
        try:
            assert load_text(text.replace(line, line[2:])).spec == plain
        except InputError as fault:
            assert re.search("goes with|is for", str(fault)), line


USE: dict[str, Callable[[Path], object]] = {
    "vehicle": load_vehicle,
    "train": load_vehicle,
    "track": track_model,
    "profile": load_profile,
    "study": lambda path: planned(path, path.parent / "out"),
    "wear": read_evolution,
}


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, names in TEMPLATES.items() for name in names])
def test_a_template_can_be_used_as_it_is(kind: str, name: str, tmp_path: Path) -> None:
    ok("new", kind, name, "-o", tmp_path / "mine.toml")
    used = USE[kind](tmp_path / "mine.toml")
    assert not isinstance(used, Vehicle) or vehicle_warnings(used) == []


def test_an_unknown_template_or_key_names_what_there_is() -> None:
    assert "did you mean 'vehicle'?" in refusal("new", "vehcile")
    assert "must be coach, metro, freight" in refusal("new", "vehicle", "cargo")
    answer = ok("keys", "contact")
    assert "tangential" in answer.output and "half-space" in answer.output
    # one sentence for the terminal, the schema of editors and new scenarios
    meaning = "Number of cells of a strip along the rolling direction"
    assert meaning in answer.output and meaning in schema_text("scenario")
    answer = ok("keys", "rail-head", "--file", "profile")
    assert "half_widths_mm" in answer.output and "conicity" not in answer.output
    assert "did you mean 'contact'?" in refusal("keys", "contcat")
    assert "did you mean 'study'?" in refusal("keys", "--file", "stduy")
    assert ok("keys", "--file", "service").output == ok("keys", "--file", "evolution").output
    listing = json.loads(call("keys", "run", "--json").output)
    assert {e["key"] for e in listing["[run]"]} >= {"step_us", "output_interval_ms"}
    alone = call("keys", "contact.normal").output
    assert "normal" in alone and "friction" not in alone
    assert call("keys", "contact.normal_model").output == alone
    assert "contact has no key 'nrmal' (did you mean 'normal'?)" in refusal("keys", "contact.nrmal")


def test_examples_of_keys_are_values_that_they_take() -> None:
    tables = {table for file in FILES for table in tables_of_file(file)}
    numbers = tomllib.loads(files("wrsim.inputs").joinpath("examples.toml").read_text())
    used = set()
    for table in tables:
        for entry in entries(table):
            assert '"..."' not in entry.example, f"{entry.table} {entry.key} has no example"
            example = numbers.get(table.header, {}).get(entry.key, numbers.get(entry.key))
            if (
                example is not None
                and entry.default in ("needed", "none", "")
                and entry.example == shown_value(example)
            ):
                used |= {(table.header, entry.key), entry.key}
    for key, value in numbers.items():
        keys = [(key, inner) for inner in value] if isinstance(value, dict) else [key]
        assert used.issuperset(keys), f"no table takes the example of {keys}"
    (flange_back,) = (e for e in entries(WheelsetTable) if e.key == "flange_back_mm")
    assert flange_back.example == "1360"


def test_other_names_are_those_of_keys() -> None:
    fields: dict[str, set[str]] = {}
    for table in {table for file in FILES for table in tables_of_file(file)}:
        for base in table.__mro__:  # a base has names of keys that not all of its kinds have
            fields[base.__name__] = fields.get(base.__name__, set()) | {*table.model_fields}
    assert ALIASES.keys() <= fields.keys()
    for name, names in ALIASES.items():
        assert names.keys() <= fields[name], f"{name} has no keys {names.keys() - fields[name]}"


@pytest.mark.parametrize(("command", "file", "message"), table("a_file_of_another_kind_is_named_as_what_it_is"))
def test_a_file_of_another_kind_is_named_as_what_it_is(command: str, file: str, message: str) -> None:
    assert refusal(command, ROOT / file).strip() == f"{ROOT / file}: {message}"
