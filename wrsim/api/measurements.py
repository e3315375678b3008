"""Models beside measurements: validated, and calibrated."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Unpack

from wrsim.api import options
from wrsim.api.options import Argument, Computing, documented
from wrsim.api.outcome import Outcome
from wrsim.api.studies import Retry, _Computation
from wrsim.timing import timed


@documented
def validate(
    file: Annotated[str | Path, Argument("Validation file (TOML).", "FILE")],
    output: options.Output = None,
    *,
    retry: Retry = False,
    pictures: options.Pictures = True,
    **computing: Unpack[Computing],
) -> Outcome:
    """Model beside measurement, section by section, by the quantities of EN 14363.

    The exit code is 4 where a limit of the differences is exceeded.

    Returns
    -------
    Outcome
        ``["passed"]``, ``["differences"]``, ``["series"]``; ``value`` lists the differences of every quantity.

    Raises
    ------
    InputError
        With all faults of the file and of the measured files, before anything runs.
    """
    from wrsim.plots.drawing import save_all
    from wrsim.report.study import verdict_page
    from wrsim.results.table import Table, as_records
    from wrsim.study import validation
    from wrsim.study.plan import Plan

    computation = _Computation(file, output, **computing)
    with timed("measured files and plan of the runs"):
        read = validation.read_validation(Path(file), computation.directory, computation.models)
    with computation.locked(read.reads, validation.OUTPUTS):
        markers = [
            computation.run_missing(run, retry, f"run of {record.name}")[1][0] if isinstance(run, Plan) else None
            for run, record in zip(read.runs, read.records, strict=True)
        ]
        with timed("differences"):
            compared = read.compared(markers)
            rows, assessed = validation.judged(compared)
            passed, words = validation.verdict(rows)
            notes = validation.basis(compared, rows, assessed)
            tables = [validation.judged_table(rows), validation.series_table(compared)]
            sections = validation.sections_table(rows)
            makers = validation.figures(compared, rows)
            summary = f"{read.given.spec.title}. Model {assessed.title}, beside {len(compared)} measured files."
            shown = {"Differences": tables[0], "Series": tables[1], "Sections": sections}
            texts = {"Validation": read.given.text} | {
                c.record.name: str(c.model.dataset.attrs["scenario_text"]) for c in compared
            }
            page = verdict_page(
                read.given.spec.title, summary, shown, notes, words, passed, texts, makers if pictures else {}
            )
            numbers = {
                "title": read.given.spec.title, "passed": passed, "verdict": words, "notes": notes,
                "shifts": {c.record.name: {"value": c.shift.value, "unit": c.record.unit} for c in compared},
                "differences": as_records(tables[0]), "series": as_records(tables[1]),
            }  # fmt: skip
            files = validation.write_validation(computation.directory, numbers, sections, page)
        files += save_all(makers, computation.directory) if pictures else []
    code = 0 if passed else 4
    end = Table("", notes=(*(f"note: {note}" for note in notes), words))
    return Outcome([*tables, end], numbers | {"exit_code": code}, files, rows, code, computation.directory)
