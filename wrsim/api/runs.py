"""Scenarios: checked, run, shown, compared with other contact models, solved again."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from wrsim.api.outcome import (
    Bar,
    Given,
    Outcome,
    Values,
    as_result,
    as_scenario,
    exit_code,
    folder_beside,
    no_bar,
    paths_among,
    results_folder,
)
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.scenario.loading import Scenario

log = logging.getLogger("wrsim.api")


def check(scenario: Scenario | str | Path, values: Values = (), models: Sequence[str | Path] = ()) -> Outcome:
    """Check a scenario and all the files it names, without running it.

    Parameters
    ----------
    scenario : Scenario, str or Path
        A scenario or its file.
    values : sequence of str, or mapping
        Keys to be changed, ``"vehicle.speed_kmh=60"`` or ``{"vehicle.speed_kmh": 60}``.
    models : sequence of str or Path
        Folders with model files of your own.

    Returns
    -------
    Outcome
        Facts, ``["warnings"]`` of implausible values, and what the run will cost.

    Raises
    ------
    InputError
        With all faults.
    """
    from wrsim.analysis import check_step, cost_of
    from wrsim.scenario.build import build
    from wrsim.scenario.plausibility import facts, facts_table, warnings

    changed = as_scenario(scenario, models).with_set(values)
    setup = build(changed)
    if getattr(setup.plan, "limited", False):
        check_step(changed, setup)
    found = facts(setup) | cost_of(setup)
    name = str(changed.path or changed.title)
    numbers = {"status": "valid", "scenario": name, "warnings": warnings(setup), **found}
    return Outcome([facts_table(f"{name}: valid", found)], numbers, found=setup)


def run_scenario(
    file: Scenario | str | Path, output: str | Path | None = None, values: Values = (), *,
    models: Sequence[str | Path] = (), resume: bool = False, threads: int | None = None, pictures: bool = True,
    force: bool = False, bar: Bar = no_bar, warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Run a scenario into a folder: dataset, tables, summary and pictures.

    Parameters
    ----------
    file : Scenario, str or Path
        A scenario or its file.
    output : str or Path, optional
        Folder; results/<name of the file> unless given.
    values : sequence of str, or mapping
        As of `check`. All others as of ``wrsim run``; bar, warn as of `run_study`.

    Returns
    -------
    Outcome
        ``found`` is a `wrsim.report.output_folder.Written`, with the Result.

    Raises
    ------
    InputError, SimulationError
        As of `run`.
    """
    from wrsim.analysis import exact_run_warning
    from wrsim.report.output_folder import run_into
    from wrsim.scenario.build import build
    from wrsim.scenario.plausibility import warnings

    with timed("scenario read and checked"):
        scenario = as_scenario(file, models).with_set(values)
    path = scenario.path or Path("scenario")
    directory = results_folder(path, output)
    with timed("vehicle, track and profiles built"):
        setup = build(scenario)  # what cannot run leaves nothing behind
    for words in (*(f"{path}: warning: {w}" for w in warnings(setup)), *exact_run_warning(setup)):
        warn(words)
    written = run_into(
        directory, scenario, setup, path, resume=resume, threads=threads, pictures=pictures, force=force, progress=bar()
    )
    result, code = written.result, exit_code(written.result)
    numbers = {
        "status": result.status,
        "exit_code": code,
        "directory": str(directory),
        "files": [str(f) for f in written.files],
        "removed": [str(f) for f in written.removed],
        "summary": {**result.summary(), **written.took},
    }
    lines = [written.words] if written.words else []
    return Outcome(result.numbers(), numbers, written.files, written, code, directory, lines)


def show(result: Given) -> Outcome:
    """The summary of a result, or of what there is of a run.

    Parameters
    ----------
    result : Result, str or Path
        Any result.

    Returns
    -------
    Outcome
        ``found`` is the Result.

    Raises
    ------
    InputError
        For a file that is no result.
    """
    loaded = as_result(result)
    lines = [f"stopped: {loaded.stop_reason}"] if loaded.stop_reason else []
    return Outcome(loaded.numbers(), loaded.summary(), found=loaded, lines=lines)


def compare(
    scenario: Scenario | str | Path, contact: str, reference: str | None = None, output: str | Path | None = None, *,
    models: Sequence[str | Path] = (), pictures: bool = True, bar: Bar = no_bar,
    warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Compare contact models on the poses or the run of a scenario.

    Parameters
    ----------
    scenario : Scenario, str or Path
        A scenario or its file.
    contact : str
        Names of models with commas between; reference: whom the others are measured against, the first unless given.
    output : str or Path, optional
        Folder; without it nothing is written. All others as of ``wrsim compare``; bar, warn as of `run_study`.

    Returns
    -------
    Outcome
        ``found`` has the result of every model, differences and times.

    Raises
    ------
    InputError, SimulationError
        For names that are no models; when a model has no result at all.
    """
    from wrsim.analysis import exact_run_warning
    from wrsim.analysis.compare import compare_models, comparison_report, comparison_tables
    from wrsim.report.outputs import write_comparison
    from wrsim.scenario.build import build
    from wrsim.scenario.contact_choice import split_names, with_contact_model

    loaded, names = as_scenario(scenario, models), split_names(contact)
    for words in [w for name in names for w in exact_run_warning(build(with_contact_model(loaded, name)))]:
        warn(words)
    with bar() as progress:
        found = compare_models(loaded, names, reference, progress)
    report = comparison_report(found, str(loaded.path or loaded.title))
    folder = None if output is None else Path(output)
    files = [] if folder is None else write_comparison(found, report, folder, pictures, loaded.title)
    code = max(exit_code(model.result) for model in found.models)
    return Outcome(comparison_tables(found, report), report, files, found, code, folder)


def resolve(
    result: Given, contact: str = "half-space", output: str | Path | None = None, *, at: Sequence[str] = (),
    wheelset: str | None = None, same: str = "load", models: Sequence[str | Path] = (), pictures: bool = True,
    force: bool = False, bar: Bar = no_bar,
) -> Outcome:  # fmt: skip
    """Solve the contacts at the snapshots of a result again, by the exact solver or any other contact model.

    Parameters
    ----------
    result : Result, str or Path
        A run or poses.
    contact : str
        Contact model.
    output : str or Path, optional
        Folder; one of the model's name beside the result unless given.
    at, wheelset, same
        Snapshots and wheelset; ``"load"`` or ``"pose"`` of the wheels stays. All others as of ``wrsim resolve``.

    Returns
    -------
    Outcome
        ``found`` is the new Result.

    Raises
    ------
    InputError
        For a result without poses of its wheels, and when one of several wheelsets has to be named.
    """
    from wrsim.analysis.resolve import resolve_contacts
    from wrsim.report.output_folder import RECORD, claimed, naming, write
    from wrsim.report.outputs import file_name
    from wrsim.results import write_atomically
    from wrsim.results.moments import moments_at, resolved_table
    from wrsim.results.summary_tables import first_lines, remarks
    from wrsim.scenario.kept import scenario_of

    before, paths = as_result(result), paths_among(result)
    directory = Path(output) if output else folder_beside(result, None) / file_name(contact)
    with naming(*paths), bar() as progress:
        moments = moments_at(before.wheelset(wheelset), at, "--at") if at else None
        beside = folder_beside(result, None) if paths else Path()
        scenario = scenario_of(before.dataset.attrs, beside, models)
        after = resolve_contacts(
            before, scenario, contact, keep=same, moments=moments, wheelset=wheelset, progress=progress
        )
    with claimed(directory, force, paths) as keeper:
        write_atomically(directory / RECORD, after.dataset.attrs["scenario_text"].encode())
        files = write(after, directory, pictures)
        keeper.clear(files)
    notes = first_lines(remarks(after.summary()), "remarks")
    tables = [resolved_table(before.wheelset(wheelset), after.wheelset(), notes)]
    return Outcome(tables, {"directory": str(directory), "summary": after.summary()}, files, after, folder=directory)
