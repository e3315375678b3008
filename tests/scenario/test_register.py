"""The register of analyses: what it names is there, and a scenario takes the tables that it says."""

from dataclasses import fields

import pytest

from wrsim.register import ANALYSES, TABLES, resolved
from wrsim.scenario.schema import ScenarioFile


@pytest.mark.parametrize("name", ANALYSES)
def test_every_function_that_the_register_names_is_there(name: str) -> None:
    analysis = ANALYSES[name]
    named = [getattr(analysis, field.name) for field in fields(analysis)]
    dotted = [value for value in named if isinstance(value, str) and ":" in value]
    assert len(dotted) >= 2
    assert all(callable(resolved(value)) for value in dotted)


def test_a_scenario_takes_the_tables_of_all_analyses() -> None:
    assert set(TABLES) < set(ScenarioFile.model_fields)
    for name, place in TABLES.items():
        assert resolved(place).header == f"[{name}]"
