"""Scenarios: checked, run, shown, compared with other contact models, solved again."""

import logging
from pathlib import Path
from typing import Annotated

from wrsim.api import options
from wrsim.api.options import AnyPath, Option, documented, into
from wrsim.api.outcome import (
    Outcome,
    as_result,
    as_scenario,
    exit_code,
    folder_beside,
    folder_or_none,
    no_bar,
    paths_in,
    results_folder,
)
from wrsim.timing import timed

log = logging.getLogger("wrsim.api")


@documented
def check(scenario: options.ScenarioFile, values: options.Values = (), models: options.Models = ()) -> Outcome:
    """Check a scenario and all the files it names, without running it.

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
    numbers = facts(setup) | cost_of(setup)
    name = str(changed.path or changed.title)
    tables = [facts_table(f"{name}: valid", numbers)]
    return Outcome(tables, {"status": "valid", "scenario": name, "warnings": warnings(setup), **numbers}, value=setup)


@documented
def run_scenario(
    file: options.ScenarioFile,
    output: options.Output = None,
    values: options.Values = (),
    *,
    resume: Annotated[bool, Option("Resume the interrupted run in DIR.")] = False,
    threads: Annotated[
        int | None,
        Option("Cores that compute contacts; default: 1, all for trains of three vehicles and more.", least=1),
    ] = None,
    models: options.Models = (),
    pictures: options.Pictures = True,
    force: options.Force = False,
    bar: options.ShowsProgress = no_bar,
    warn: options.Warn = log.warning,
) -> Outcome:
    """Run a scenario; writes dataset, tables, summary and pictures to a folder.

    While it lasts, a run is stored in result.nc.part there, so that one that was cut off can be resumed.

    Returns
    -------
    Outcome
        ``value`` is a `wrsim.report.output_folder.Written`, with the Result.

    Raises
    ------
    InputError, SimulationError
        As of `run`.
    """
    from wrsim.analysis import exact_run_warning
    from wrsim.report.output_folder import run_into
    from wrsim.results.summary_tables import numbers_of
    from wrsim.scenario.build import build
    from wrsim.scenario.plausibility import warnings

    with timed("scenario read and checked"):
        scenario = as_scenario(file, models).with_set(values)
    path = scenario.path or Path("scenario")
    directory = results_folder(path, output)
    with timed("vehicle, track and profiles built"):
        setup = build(scenario)  # what cannot run leaves nothing behind
    for message in (*(f"{path}: warning: {text}" for text in warnings(setup)), *exact_run_warning(setup)):
        warn(message)
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
        "summary": {**written.summary, **written.took},
    }
    lines = [written.message] if written.message else []
    return Outcome(numbers_of(result.dataset, written.summary), numbers, written.files, written, code, directory, lines)


@documented
def show(result: options.ResultFile) -> Outcome:
    """Print the summary of a result or of an interrupted run.

    Returns
    -------
    Outcome
        ``value`` is the Result.
    """
    from wrsim.results.summary_tables import numbers_of

    loaded = as_result(result)
    lines, summary = [f"stopped: {loaded.stop_reason}"] if loaded.stop_reason else [], loaded.summary()
    return Outcome(numbers_of(loaded.dataset, summary), summary, value=loaded, lines=lines)


@documented
def compare(
    scenario: options.ScenarioFile,
    contact: Annotated[
        str,
        Option(
            "half-space, kik-piotrowski+polach, kik-piotrowski+strips=80, hertz; strips+strip_width_mm=: without this "
            "key of FILE; file: as in FILE.",
            "A,B,...",
        ),
    ],
    reference: Annotated[str | None, Option("Reference model; default: the first.", "A")] = None,
    output: Annotated[
        AnyPath, into("Folder for tables and pictures.", "DIR", default="results/<FILE>_compared")
    ] = None,
    *,
    models: options.Models = (),
    pictures: options.Pictures = True,
    bar: options.ShowsProgress = no_bar,
    warn: options.Warn = log.warning,
) -> Outcome:
    """Compare contact models on the poses or the run of a scenario: differences, patches, time per evaluation.

    Returns
    -------
    Outcome
        ``value`` has the result of every model, differences and times.

    Raises
    ------
    InputError, SimulationError
        For names that are no models; when a model has no result at all.
    """
    from wrsim.analysis import exact_run_warning
    from wrsim.analysis.compare import compare_models, comparison_report, comparison_tables
    from wrsim.report.outputs import write_comparison
    from wrsim.scenario.build import build
    from wrsim.scenario.contact_choice import HERTZ, split_names, with_contact_model

    loaded, names = as_scenario(scenario, models), split_names(contact)
    models_of = [with_contact_model(loaded, name) for name in names if name != HERTZ]
    for message in [text for changed in models_of for text in exact_run_warning(build(changed))]:
        warn(message)
    with bar() as progress:
        comparison = compare_models(loaded, names, reference, progress)
    report = comparison_report(comparison, str(loaded.path or loaded.title))
    folder = folder_or_none(output)
    files = [] if folder is None else write_comparison(comparison, report, folder, pictures, loaded.title)
    code = max(exit_code(model.result) for model in comparison.models)
    return Outcome(comparison_tables(comparison, report), report, files, comparison, code, folder)


@documented
def resolve(
    result: options.ResultFile,
    contact: Annotated[str, Option("Contact model, such as half-space+fastsim.", "NAME")] = "half-space",
    output: Annotated[AnyPath, into("Folder; <folder of RESULT>/<NAME> unless given.", "DIR")] = None,
    *,
    at: options.Places = (),
    wheelset: options.OneWheelset = None,
    same: Annotated[str, Option("What every wheel keeps: its load or its height.", "load|pose")] = "load",
    subsurface: Annotated[bool, Option("Compute the stresses below the surface.")] = False,
    body: Annotated[str, Option("Body below whose surface: rail or wheel.", "rail|wheel")] = "rail",
    bending_limit_MPa: Annotated[
        float | None, Option("Fatigue limit of its steel in reversed bending, for fatigue by depth.", "MPA", 1.0)
    ] = None,
    torsion_limit_MPa: Annotated[
        float | None, Option("Fatigue limit of its steel in reversed torsion, for fatigue by depth.", "MPA", 1.0)
    ] = None,
    models: options.Models = (),
    pictures: options.Pictures = True,
    force: options.Force = False,
    bar: options.ShowsProgress = no_bar,
) -> Outcome:
    """Solve the contacts at the snapshots of a result by the exact solver or another contact model.

    Returns
    -------
    Outcome
        ``value`` is the new Result.

    Raises
    ------
    InputError
        For a result without poses of its wheels, and when one of several wheelsets has to be named.
    """
    from wrsim.analysis.resolve import below_surface, resolve_contacts
    from wrsim.report.output_folder import RECORD, claimed, naming, write
    from wrsim.report.outputs import file_name
    from wrsim.results import write_atomically
    from wrsim.results.moments import moments_at, resolved_table, subsurface_tables
    from wrsim.results.summary_tables import first_lines, remarks
    from wrsim.scenario.kept import scenario_of

    below = below_surface(subsurface, body, bending_limit_MPa, torsion_limit_MPa)
    before, paths = as_result(result), paths_in(result)
    directory = Path(output) if output else folder_beside(result) / file_name(contact)
    with naming(*paths), bar() as progress:
        moments = moments_at(before.wheelset(wheelset), at, "--at") if at else None
        beside = folder_beside(result) if paths else Path()
        scenario = scenario_of(before.dataset.attrs, beside, models)
        after = resolve_contacts(
            before, scenario, contact, keep=same, moments=moments, wheelset=wheelset, subsurface=below,
            progress=progress,
        )  # fmt: skip
    with claimed(directory, force, paths) as keeper:
        write_atomically(directory / RECORD, after.dataset.attrs["scenario_text"].encode())
        summary, files = write(after, directory, pictures)
        keeper.clear(files)
    notes = first_lines(remarks(summary), "remarks")
    tables = [resolved_table(before.wheelset(wheelset), after.wheelset(), notes), *subsurface_tables(after.wheelset())]
    return Outcome(tables, {"directory": str(directory), "summary": summary}, files, after, folder=directory)
