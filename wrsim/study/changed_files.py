"""Files with values that a search has found: a scenario over the one it started from, the vehicle's file as a whole."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wrsim.errors import InputError
from wrsim.inputs.changes import full_path
from wrsim.inputs.lookup import Finder, shipped_models
from wrsim.inputs.toml_files import write_toml
from wrsim.results import write_atomically
from wrsim.scenario.loading import Scenario, own_path
from wrsim.scenario.merging import value_at
from wrsim.scenario.vehicle_build import vehicle_tables, wheel_tables
from wrsim.study.candidates import ONLY, Candidates


def file_names(kind: str, scenarios: Sequence[str]) -> tuple[str, ...]:
    """Names of the files of `write_changed`."""
    return (f"{kind}_vehicle.toml", f"{kind}_wheel.toml", *(_scenario_file(kind, name) for name in scenarios))


def write_changed(
    folder: Path, kind: str, candidates: Candidates, values: Sequence[Any], done: str, remarks: Sequence[str]
) -> list[Path]:
    """The scenarios with new values, and the files of vehicle and wheel in which they change something.

    kind: first word of the names of the files; done: what was done to a scenario, for its title."""
    changes, scenarios = candidates.changes(values), candidates.scenarios
    files = []
    for scenario in scenarios:
        place, title = folder / _scenario_file(kind, scenario.name), f"{scenario.base.title}, {done}"
        files.append(write_scenario(place, scenario.base, changes, title, remarks))
    first = scenarios[0].base.with_values(changes)
    if changed_in(changes, "changes"):
        files.append(write_vehicle(folder / f"{kind}_vehicle.toml", first, remarks))
    if changed_in(changes, "wheel_changes"):
        files.append(write_wheel(folder / f"{kind}_wheel.toml", first, remarks))
    return files


def _scenario_file(kind: str, name: str) -> str:
    return f"{kind}.toml" if name == ONLY else f"{kind}_{name}.toml"


def write_scenario(
    file: Path, base: Scenario, changes: Mapping[str, Any], title: str, remarks: Sequence[str] = ()
) -> Path:
    """A scenario that starts from the file of ``base`` and has its changed keys; remarks: comments at its head.

    A list of which an entry is changed is written as a whole: lists of a base are replaced."""
    scenario = base.with_values(dict(changes))
    tables: dict[str, Any] = {"title": title}
    if base.path is not None:
        tables["base"] = _seen_from(file, base.path)
    for key in changes:
        path = full_path(scenario.merged.data, own_path(key), by_name=False)
        path = path[: next((i for i, part in enumerate(path) if isinstance(part, int)), len(path))]
        inner = tables
        for part in path[:-1]:
            inner = inner.setdefault(str(part), {})
        inner[str(path[-1])] = value_at(scenario.merged.data, path)
    return _written(file, tables, remarks)


def write_vehicle(file: Path, scenario: Scenario, remarks: Sequence[str] = ()) -> Path:
    """The vehicle's file with all that the scenario changes in it; names of files beside it lead there."""
    model = scenario.find(("vehicle", "model"), scenario.spec.vehicle.model)
    return _written(file, _moved(vehicle_tables(scenario), file, scenario.finder.beside(model)), remarks)


def write_wheel(file: Path, scenario: Scenario, remarks: Sequence[str] = ()) -> Path:
    """The file of the wheel's profile with all that the scenario changes in it."""
    wheel = scenario.find(("vehicle", "wheel"), str(scenario.spec.vehicle.wheel))
    return _written(file, _moved(wheel_tables(scenario), file, scenario.finder.beside(wheel)), remarks)


def changed_in(changes: Mapping[str, Any], table: str) -> bool:
    """Whether some of the keys are of the vehicle's file (table "changes") or of the wheel's ("wheel_changes")."""
    return any(own_path(key)[:2] == ("vehicle", table) for key in changes)


def _moved(value: Any, file: Path, finder: Finder) -> Any:
    """Tables whose names of files are seen from another place; models that come with wrsim keep their names."""
    if isinstance(value, dict):
        return {key: _moved(inner, file, finder) for key, inner in value.items()}
    if isinstance(value, list):
        return [_moved(inner, file, finder) for inner in value]
    if not isinstance(value, str) or not Path(value).suffix:
        return value
    try:
        named = finder.find(value)
    except InputError:
        return value
    return value if named.resolve().is_relative_to(shipped_models().resolve()) else _seen_from(file, named)


def _seen_from(file: Path, named: Path) -> str:
    """The name of a file as another one in its folder has it; a whole path on another drive."""
    try:
        return Path(os.path.relpath(named.resolve(), file.parent.resolve())).as_posix()
    except ValueError:
        return named.resolve().as_posix()


def _written(file: Path, tables: dict[str, Any], remarks: Sequence[str]) -> Path:
    comments = "".join(f"# {line}\n" for remark in remarks for line in remark.splitlines())
    return write_atomically(file, f"{comments}{write_toml(tables)}".encode())
