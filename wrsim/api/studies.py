"""Studies, type tests and profile evolution: many runs, which go on where they were."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Unpack

from wrsim.api import options
from wrsim.api.options import Argument, Computing, Option, documented
from wrsim.api.outcome import Outcome, no_bar, results_folder
from wrsim.errors import STOPPED
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.study.plan import Plan
    from wrsim.study.task import Marker

log = logging.getLogger("wrsim.api")
DryRun = Annotated[bool, Option("List the cases and their estimated time; run nothing.")]
Retry = Annotated[bool, Option("Repeat cases that failed, stopped or ran out of time.")]


class _Computation:
    """The folder of a study, a type test or a profile evolution, and the workers of its cases."""

    def __init__(
        self, file: str | Path, output: str | Path | None, *, models: Sequence[str | Path] | None = None,
        workers: int | None = None, scheduler: str | None = None, slurm: bool = False, tls: Path | None = None,
        force: bool = False, bar: options.Bar = no_bar, notify: Callable[[str], None] = lambda line: None,
        warn: Callable[[str], None] = log.warning,
    ) -> None:  # fmt: skip
        from wrsim.study.engine import check_workers, worker_pool

        self.directory, self.models = results_folder(file, output), list(models or ())
        self.workers, self.force, self.notify = workers, force, notify
        for message in check_workers(workers, scheduler, slurm, tls):
            warn(message)
        self.pool: Callable[..., AbstractContextManager[Any]] = partial(
            worker_pool, workers, scheduler, slurm, tls, progress=bar
        )

    @contextmanager
    def locked(self, reads: Sequence[Path], outputs: Sequence[str]) -> Iterator[None]:
        """The folder for this process alone; where it is interrupted, the message names the folder."""
        from wrsim.study.engine import kept_folder

        with kept_folder(self.directory, reads, self.force, outputs):
            try:
                yield
            except KeyboardInterrupt:
                resumed = "start the same command again to go on"
                message = f"interrupted; what is done is safe in {self.directory}: {resumed}"
                raise KeyboardInterrupt(message) from None

    def estimate(self, plan: Plan) -> Outcome:
        """The time that the cases of a plan will take."""
        from wrsim.study.estimate import estimated_cost

        numbers, table = estimated_cost(plan, self.workers)
        return Outcome([table], numbers, value=plan)

    def run_missing(self, plan: Plan, retry: bool, noun: str) -> tuple[int, list[Marker]]:
        """Run the cases of a plan that have not come to an end; gives their number, and how all cases ended."""
        from wrsim.study.collect import markers_of
        from wrsim.study.task import missing

        todo = missing(plan, retry)
        known = len(plan.cases) - len(todo)
        self.notify(f"{len(plan.cases)} {noun}" + (f", {known} of them known already" if known else ""))
        if todo:
            with timed(f"{len(todo)} {noun}"), self.pool(most=len(todo)) as work:
                work(plan, todo)
        return len(todo), markers_of(plan)


@documented
def run_study(
    file: Annotated[str | Path, Argument("Study file (TOML).", "FILE")],
    output: options.Output = None,
    *,
    dry_run: DryRun = False,
    retry: Retry = False,
    pictures: options.Pictures = True,
    **computing: Unpack[Computing],
) -> Outcome:
    """Parameter study; resumes where it stopped.

    Returns
    -------
    Outcome
        ``value`` is the plan in a dry run, else a function that gives faults; ``code`` 3 where a case has no result.

    Raises
    ------
    InputError
        With all faults of the file and of its cases.
    """
    from wrsim.study.collect import OUTPUTS, faults_of, markers_of, study_tables, write_study
    from wrsim.study.plan import planned

    computation = _Computation(file, output, **computing)
    with timed("plan of the cases"):
        plan, reads = planned(Path(file), computation.directory, computation.models)
    if dry_run:
        return computation.estimate(plan)
    with computation.locked(reads, OUTPUTS):
        try:
            ran, markers = computation.run_missing(plan, retry, "cases")
        except KeyboardInterrupt:
            write_study(plan, markers_of(plan), pictures=False)
            raise
        with timed("tables and pictures of the study"):
            report, files = write_study(plan, markers, pictures)
    code = STOPPED if report["unfinished"] else 0
    numbers = report | {"exit_code": code, "ran": ran}
    faults = partial(faults_of, report, markers)
    return Outcome(study_tables(report), numbers, files, faults, code, computation.directory)


@documented
def run_type_test(
    file: Annotated[str | Path, Argument("File of a type test (TOML).", "FILE")],
    output: options.Output = None,
    *,
    dry_run: DryRun = False,
    retry: Retry = False,
    **computing: Unpack[Computing],
) -> Outcome:
    """Type test: states of a vehicle through runs and stationary tests, judged clause by clause.

    It resumes where it stopped. The exit code is 4 where a limit is exceeded.

    Returns
    -------
    Outcome
        ``["passed"]``; ``value`` lists the verdicts; ``code`` 3 where a run is missing, 4 where a limit is exceeded.

    Raises
    ------
    InputError
        With all faults of the file and of its runs.
    """
    from wrsim.report.study import verdict_page
    from wrsim.study import type_test as tests
    from wrsim.study.programme import read_programme
    from wrsim.study.task import COMPLETED, DERAILED

    computation = _Computation(file, output, **computing)
    with timed("plan of the runs"):
        programme = read_programme(Path(file), computation.directory, computation.models)
    plan = programme.plan
    if dry_run:
        return computation.estimate(plan)
    with computation.locked(programme.reads, tests.OUTPUTS):
        ran, markers = computation.run_missing(plan, retry, "runs")
        with timed("verdicts"):
            verdicts, notes = tests.verdicts(programme, markers)
            numbers, sentence = tests.verdict_numbers(plan.title, verdicts, notes), tests.verdict_text(verdicts)
            names = [state.name for state in programme.spec.states]
            pages = {f"State: {n}": tests.state_table([v for v in verdicts if v.state == n]) for n in names}
            texts = {"Programme": plan.source, "Base scenario": plan.text}
            summary = tests.summary_text(programme)
            page = verdict_page(plan.title, summary, pages, notes, sentence, numbers["passed"], texts)
            table = tests.whole_table(plan.title, verdicts)
            files = tests.write_verdicts(computation.directory, numbers, table, page)
    code = 0 if numbers["passed"] else 4
    if any(m.status not in (COMPLETED, DERAILED) for m in markers):
        code = STOPPED
    tables = tests.worst_tables(plan.title, verdicts, notes)
    return Outcome(tables, numbers | {"exit_code": code, "ran": ran}, files, verdicts, code, computation.directory)


@documented
def run_wear(
    file: Annotated[str | Path, Argument("File of a profile evolution (TOML).", "FILE")],
    output: options.Output = None,
    *,
    pictures: options.Pictures = True,
    **computing: Unpack[Computing],
) -> Outcome:
    """Profile evolution: weighted cases wear the profile step by step; resumes where it stopped.

    Returns
    -------
    Outcome
        ``value`` is the dataset over the mileage.

    Raises
    ------
    InputError
        With all faults of the file and of its cases.
    """
    from wrsim.study.evolution.history import OUTPUTS, evolution_report, mileage_table, write_history
    from wrsim.study.evolution.reading import read_evolution
    from wrsim.study.evolution.steps import Step, wear_steps

    computation = _Computation(file, output, **computing)
    evolution, reads = read_evolution(Path(file), computation.models)
    steps: list[Step] = []
    with computation.locked(reads, OUTPUTS), computation.pool(most=len(evolution.shares)) as work:
        for step in wear_steps(evolution, computation.directory, work):
            steps.append(step)
            computation.notify(step.label(evolution.mileage))
        dataset, files = write_history(evolution, steps, computation.directory, pictures)
    numbers = evolution_report(dataset) | {"directory": str(computation.directory)}
    return Outcome([mileage_table(dataset)], numbers, files, dataset, folder=computation.directory)
