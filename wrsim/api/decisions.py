"""Searches for values of keys: optimisation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Unpack

from wrsim.api import options
from wrsim.api.options import Argument, Computing, Option, documented
from wrsim.api.outcome import Outcome, no_bar
from wrsim.api.studies import _Computation
from wrsim.errors import STOPPED
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.study.optimisation.reading import Optimisation


@documented
def optimise(
    file: Annotated[str | Path, Argument("Optimisation file (TOML).", "FILE")],
    output: options.Output = None,
    *,
    dry_run: Annotated[bool, Option("Tell candidates and estimated time; run nothing.")] = False,
    pictures: options.Pictures = True,
    **computing: Unpack[Computing],
) -> Outcome:
    """Optimisation: values of keys that make outputs of scenarios best within constraints; resumes where it stopped.

    Returns
    -------
    Outcome
        ``["best"]``, ``["limits"]``; ``value`` is the history, a dataset; ``code`` 3 where no candidate keeps all
        constraints.

    Raises
    ------
    InputError
        With all faults of the file and of its start.
    """
    from wrsim.plots.drawing import save_all
    from wrsim.plots.optimisation import optimisation_figures
    from wrsim.report.study import verdict_page
    from wrsim.results import write_atomically
    from wrsim.study.optimisation import files as written
    from wrsim.study.optimisation.outcome import (
        NOTES,
        history,
        neighbours,
        optimisation_report,
        optimisation_tables,
        verdict_text,
    )  # fmt: skip
    from wrsim.study.optimisation.reading import read_optimisation
    from wrsim.study.optimisation.search import Search, cma_package
    from wrsim.system import processors

    computation = _Computation(file, output, **computing)
    with timed("check of the optimisation"):
        optimisation = read_optimisation(Path(file), computation.directory, computation.models)
        if len(optimisation.candidates.varied) > 1:
            cma_package()
    at_once = max(optimisation.spec.search.generation(len(optimisation.candidates.varied)), 2)
    if dry_run:
        return _cost(optimisation, min(at_once, computation.workers or processors()))
    names, candidates = [each.name for each in optimisation.candidates.scenarios], optimisation.candidates
    with computation.locked(optimisation.reads, written.written_names(names)):
        with timed("candidates"), computation.pool(most=at_once, progress=no_bar) as work:
            search = Search(optimisation, work, computation.notify)
            search.run()
            beside = neighbours(search) if optimisation.spec.search.front is None else []
        report, dataset = optimisation_report(search, beside), history(search)
        files = written.write_optimisation(search, dataset, report, computation.directory)
        tables = optimisation_tables(report)
        makers = optimisation_figures(dataset, [point["number"] for point in report.get("front", [])])
        shown = makers if pictures else {}
        feasible = search.best().feasible
        texts = {f"Scenario {each.name}": each.base.text for each in candidates.scenarios}
        texts = {"Optimisation": candidates.source.text} | texts
        sentence = verdict_text(report)
        page = verdict_page(candidates.title, optimisation.summary, tables, NOTES, sentence, feasible, texts, shown)
        files.append(write_atomically(computation.directory / written.PAGE, page.encode()))
        files += save_all(makers, computation.directory) if pictures else []
    code = 0 if feasible else STOPPED
    return Outcome(list(tables.values()), report | {"exit_code": code}, files, dataset, code, computation.directory)


def _cost(optimisation: Optimisation, at_once: int) -> Outcome:
    """Scenarios, candidates and the time that they will take."""
    from wrsim.study.estimate import estimated_search

    candidates = optimisation.candidates
    most = optimisation.spec.search.evaluations + 2 * len(candidates.varied)
    told = f"at most {most} candidates, {len(candidates.scenarios) * most} cases, {at_once} at once"
    numbers, table = estimated_search(candidates, most, at_once, 0, told, "at most {}")
    return Outcome([table], numbers, value=optimisation)
