"""Studies and profile evolution: many runs, which go on where they were."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wrsim.api.outcome import Bar, Outcome, no_bar, results_folder
from wrsim.errors import STOPPED
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.study.plan import Plan

log = logging.getLogger("wrsim.api")


def run_study(
    file: str | Path, output: str | Path | None = None, *, workers: int | None = None, scheduler: str | None = None,
    slurm: bool = False, tls: Path | None = None, retry: bool = False, dry_run: bool = False,
    models: Sequence[str | Path] = (), pictures: bool = True, force: bool = False, bar: Bar = no_bar,
    notify: Callable[[str], None] = lambda line: None, warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Run a scenario many times with some keys varied; started again, only what is missing runs.

    Parameters
    ----------
    file : str or Path
        Study file.
    output : str or Path, optional
        Folder; results/<name of the file> unless given. All others as of ``wrsim study``; notify: takes lines on its
        progress, warn: a warning, bar: gives a context with the callback of a progress bar.

    Returns
    -------
    Outcome
        ``found`` is the plan; ``["faults"]`` lists cases without a result.

    Raises
    ------
    InputError
        With all faults of the file and of its cases.
    """
    from wrsim.study.engine import check_workers, kept_folder, worker_pool

    directory = results_folder(file, output)
    for words in check_workers(workers, scheduler, slurm, tls):
        warn(words)
    from wrsim.study.collect import OUTPUTS, faults_of, markers_of, study_tables, write_study
    from wrsim.study.estimate import estimated_cost
    from wrsim.study.plan import planned

    with timed("plan of the cases"):
        plan, reads = planned(Path(file), directory, list(models))
    if dry_run:
        numbers, table = estimated_cost(plan, workers)
        return Outcome([table], numbers, found=plan)
    pool = partial(worker_pool, workers, scheduler, slurm, tls, progress=bar)
    with kept_folder(directory, reads, force, OUTPUTS):
        try:
            ran = _run_missing(plan, retry, "cases", pool, notify)
        except KeyboardInterrupt:
            write_study(plan, markers_of(plan), pictures=False)
            raise _interrupted(directory) from None
        markers = markers_of(plan)
        with timed("tables and pictures of the study"):
            report, files = write_study(plan, markers, pictures)
    code = STOPPED if report["unfinished"] else 0
    faults = partial(faults_of, report, markers)
    numbers = report | {"exit_code": code, "ran": ran}
    return Outcome(study_tables(report), numbers, files, faults, code, directory)


def _run_missing(
    plan: Plan, retry: bool, what: str, pool: Callable[..., AbstractContextManager[Any]], notify: Callable[[str], None]
) -> int:
    """Run the cases of a plan that have not come to an end; gives their number. what: their word; pool: of workers."""
    from wrsim.study.engine import missing

    todo = missing(plan, retry)
    known = len(plan.cases) - len(todo)
    notify(f"{len(plan.cases)} {what}" + (f", {known} of them known already" if known else ""))
    if todo:
        with timed(f"{len(todo)} {what}"), pool(most=len(todo)) as work:
            work(plan, todo)
    return len(todo)


def run_type_test(
    file: str | Path, output: str | Path | None = None, *, workers: int | None = None, scheduler: str | None = None,
    slurm: bool = False, tls: Path | None = None, retry: bool = False, dry_run: bool = False,
    models: Sequence[str | Path] = (), force: bool = False, bar: Bar = no_bar,
    notify: Callable[[str], None] = lambda line: None, warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """A vehicle in several states through all runs and stationary tests of a programme, judged clause by clause.

    Parameters
    ----------
    file : str or Path
        File of a type test.
    output : str or Path, optional
        Folder; results/<name of the file> unless given. All others as of `run_study`.

    Returns
    -------
    Outcome
        ``["passed"]``; ``found`` lists the verdicts; ``code`` 3 where a run is missing, 4 where a limit is exceeded.

    Raises
    ------
    InputError
        With all faults of the file and of its runs.
    """
    from wrsim.report.study import type_test_page
    from wrsim.study import type_test as tests
    from wrsim.study.collect import markers_of
    from wrsim.study.engine import check_workers, kept_folder, worker_pool
    from wrsim.study.estimate import estimated_cost
    from wrsim.study.programme import read_programme
    from wrsim.study.task import COMPLETED, DERAILED

    directory = results_folder(file, output)
    for words in check_workers(workers, scheduler, slurm, tls):
        warn(words)
    with timed("plan of the runs"):
        programme = read_programme(Path(file), directory, list(models))
    plan = programme.plan
    if dry_run:
        numbers, table = estimated_cost(plan, workers)
        return Outcome([table], numbers, found=plan)
    pool = partial(worker_pool, workers, scheduler, slurm, tls, progress=bar)
    with kept_folder(directory, programme.reads, force, tests.OUTPUTS):
        try:
            ran = _run_missing(plan, retry, "runs", pool, notify)
        except KeyboardInterrupt:
            raise _interrupted(directory) from None
        markers = markers_of(plan)
        with timed("verdicts"):
            found, notes = tests.verdicts(programme, markers)
            numbers, words = tests.verdict_numbers(plan.title, found, notes), tests.verdict_words(found)
            states = {state.name: [v for v in found if v.state == state.name] for state in programme.spec.states}
            pages = {name: tests.state_table(own) for name, own in states.items()}
            texts = {"Programme": plan.source, "Base scenario": plan.text}
            page = type_test_page(
                plan.title, tests.summary_words(programme), pages, notes, words, numbers["passed"], texts
            )
            files = tests.write_verdicts(directory, numbers, tests.whole_table(plan.title, found), page)
            tables = tests.worst_tables(plan.title, found, notes)
    code = 0 if numbers["passed"] else 4
    if any(m.status not in (COMPLETED, DERAILED) for m in markers):
        code = STOPPED
    return Outcome(tables, numbers | {"exit_code": code, "ran": ran}, files, found, code, directory)


def run_wear(
    file: str | Path, output: str | Path | None = None, *, workers: int | None = None, scheduler: str | None = None,
    slurm: bool = False, tls: Path | None = None, models: Sequence[str | Path] = (), pictures: bool = True,
    force: bool = False, bar: Bar = no_bar, notify: Callable[[str], None] = lambda line: None,
    warn: Callable[[str], None] = log.warning,
) -> Outcome:  # fmt: skip
    """Profile evolution: cases by their shares, a worn profile, again; started again, it goes on.

    Parameters
    ----------
    file : str or Path
        File of a profile evolution.
    output : str or Path, optional
        Folder; results/<name of the file> unless given. All others as of `run_study`.

    Returns
    -------
    Outcome
        ``found`` is the dataset over the mileage.

    Raises
    ------
    InputError
        With all faults of the file and of its cases.
    """
    from wrsim.study.engine import check_workers, kept_folder, worker_pool
    from wrsim.study.evolution.history import OUTPUTS, evolution_report, mileage_table, write_history
    from wrsim.study.evolution.reading import read_evolution
    from wrsim.study.evolution.steps import Step, wear_steps

    directory = results_folder(file, output)
    for words in check_workers(workers, scheduler, slurm, tls):
        warn(words)
    evolution, reads = read_evolution(Path(file), list(models))
    steps: list[Step] = []
    with (
        kept_folder(directory, reads, force, OUTPUTS),
        worker_pool(workers, scheduler, slurm, tls, len(evolution.shares), bar) as work,
    ):
        try:
            for step in wear_steps(evolution, directory, work):
                steps.append(step)
                notify(step.words(evolution.mileage))
        except KeyboardInterrupt:
            raise _interrupted(directory) from None
        dataset, files = write_history(evolution, steps, directory, pictures)
    numbers = evolution_report(dataset) | {"directory": str(directory)}
    return Outcome([mileage_table(dataset)], numbers, files, dataset, folder=directory)


def _interrupted(directory: Path) -> KeyboardInterrupt:
    """With where the finished part is."""
    return KeyboardInterrupt(f"interrupted; what is done is safe in {directory}: start the same command again to go on")
