"""The reference of keys, the schemas and the templates follow the code."""

from __future__ import annotations

import json
import runpy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from wrsim.cli import app
from wrsim.cli.keys import FILES, schema_text, tables_of
from wrsim.inputs.reference import entries
from wrsim.register import ANALYSES
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.scenario.merging import BASE, read_merged

ROOT = Path(__file__).parents[2]
SCENARIOS = sorted((ROOT / "scenarios").glob("*.toml"))
runner = CliRunner()


def test_the_generated_pages_are_not_stale() -> None:
    """Make them anew with: python docs/make_keys.py"""
    for path, text in runpy.run_path(str(ROOT / "docs" / "make_keys.py"))["pages"]().items():
        assert path.read_text(encoding="utf-8") == text, path


def accepts(schema: dict[str, Any], value: Any, root: dict[str, Any]) -> bool:
    """True if a value fits a schema: as much of draft 7 as ours use."""
    if "$ref" in schema:
        schema = root["definitions"][schema["$ref"].rpartition("/")[2]] | {
            k: v for k, v in schema.items() if k != "$ref"
        }
    for name, least, most in (("anyOf", 1, 99), ("oneOf", 1, 1)):
        if name in schema and not least <= sum(accepts(part, value, root) for part in schema[name]) <= most:
            return False
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "number": (int, float), "integer": int}
    kind = schema.get("type")
    wrong = kind is not None and (not isinstance(value, kinds[kind]) or (isinstance(value, bool) and kind != "boolean"))
    if wrong and not (kind == "string" and hasattr(value, "isoformat")):
        return False
    if ("enum" in schema and value not in schema["enum"]) or ("const" in schema and value != schema["const"]):
        return False
    if isinstance(value, int | float):
        if value < schema.get("minimum", value) or value > schema.get("maximum", value):
            return False
        if "exclusiveMinimum" in schema and value <= schema["exclusiveMinimum"]:
            return False
    if isinstance(value, dict):
        known = schema.get("properties", {})
        if not set(schema.get("required", ())) <= set(value):
            return False
        if schema.get("additionalProperties") is False and not set(value) <= set(known):
            return False
        return all(accepts(known[k], v, root) for k, v in value.items() if k in known)
    if isinstance(value, list):
        return all(accepts(schema.get("items", {}), v, root) for v in value)
    return True


@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: file.stem)
def test_the_schema_accepts_every_shipped_scenario_and_refuses_a_slip(file: Path) -> None:
    schema = json.loads(schema_text("scenario"))
    data = tomllib.loads(file.read_text())
    assert accepts(schema, data, schema)
    assert not accepts(schema, data | {"vehicel": {}}, schema)
    if BASE not in data:
        whole = read_merged(file).data
        assert not accepts(schema, whole | {"contact": whole.get("contact", {}) | {"friction": 7.0}}, schema)
        assert not accepts(schema, whole | {"contact": whole.get("contact", {}) | {"normal": "herz"}}, schema)


def test_the_schema_of_studies_accepts_the_shipped_one() -> None:
    schema = json.loads(schema_text("study"))
    data = tomllib.loads((ROOT / "scenarios/studies/friction_speed.toml").read_text())
    assert accepts(schema, data, schema)
    assert not accepts(schema, data | {"vary": [{"kind": "gird", "key": "a", "values": [1]}]}, schema)


@pytest.mark.parametrize("file", FILES)
def test_every_key_says_what_it_may_be_with_an_example(file: str) -> None:
    for table in tables_of(file):
        for entry in entries(table):
            assert entry.allowed, f"{table.header} {entry.key}"
            assert entry.example or entry.allowed.startswith(("a table", "a list of tables", "tables")), (
                f"{table.header} {entry.key}"
            )


@pytest.mark.parametrize("kind", ANALYSES)
def test_a_new_scenario_can_be_run(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    answer = runner.invoke(app, ["new", kind, "-o", str(file)])
    assert answer.exit_code == 0, answer.output
    setup = build(load(file))
    assert setup.analysis == kind
    text = file.read_text()
    assert max(map(len, text.splitlines())) <= 120
    again = runner.invoke(app, ["new", kind, "-o", str(file)])
    assert again.exit_code == 0  # its own file, unchanged
    file.write_text(text + "# mine\n")
    refused = runner.invoke(app, ["new", kind, "-o", str(file)])
    assert refused.exit_code == 2 and "has changed since" in refused.output


def test_keys_of_a_table_are_printed_and_a_slip_names_the_nearest() -> None:
    answer = runner.invoke(app, ["keys", "contact"])
    assert answer.exit_code == 0 and "tangential" in answer.output and "half-space" in answer.output
    answer = runner.invoke(app, ["keys", "contcat"])
    assert answer.exit_code == 2 and "did you mean 'contact'?" in answer.output
    answer = runner.invoke(app, ["keys", "--file", "stduy"])
    assert answer.exit_code == 2 and "did you mean 'study'?" in answer.output
    found = json.loads(runner.invoke(app, ["keys", "run", "--json"]).output)
    assert {e["key"] for e in found["[run]"]} >= {"step_us", "output_interval_ms"}
