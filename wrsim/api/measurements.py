"""Models beside measurements: validated, and calibrated."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Unpack

from wrsim.api import options
from wrsim.api.options import Argument, Computing, Option, documented
from wrsim.api.outcome import Outcome
from wrsim.api.studies import Retry, _Computation
from wrsim.errors import STOPPED
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.study.calibration.reading import Calibration


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
            passed, sentence = validation.verdict(rows)
            notes = validation.basis(compared, rows, assessed)
            tables = [validation.judged_table(rows), validation.series_table(compared)]
            sections = validation.sections_table(rows)
            makers = validation.figures(compared, rows)
            summary = f"{read.source.spec.title}. Model {assessed.title}, beside {len(compared)} measured files."
            shown = {"Differences": tables[0], "Series": tables[1], "Sections": sections}
            texts = {"Validation": read.source.text} | {
                c.record.name: str(c.model.dataset.attrs["scenario_text"]) for c in compared
            }
            page = verdict_page(
                read.source.spec.title, summary, shown, notes, sentence, passed, texts, makers if pictures else {}
            )
            numbers = {
                "title": read.source.spec.title, "passed": passed, "verdict": sentence, "notes": notes,
                "shifts": {c.record.name: {"value": c.shift.value, "unit": c.record.unit} for c in compared},
                "differences": as_records(tables[0]), "series": as_records(tables[1]),
            }  # fmt: skip
            files = validation.write_validation(computation.directory, numbers, sections, page)
        files += save_all(makers, computation.directory) if pictures else []
    code = 0 if passed else 4
    end = Table("", notes=(*(f"note: {note}" for note in notes), sentence))
    return Outcome([*tables, end], numbers | {"exit_code": code}, files, rows, code, computation.directory)


@documented
def calibrate(
    file: Annotated[str | Path, Argument("Calibration file (TOML).", "FILE")],
    output: options.Output = None,
    *,
    dry_run: Annotated[bool, Option("Tell candidates and estimated time; run nothing.")] = False,
    pictures: options.Pictures = True,
    **computing: Unpack[Computing],
) -> Outcome:
    """Calibration: values of keys with which a model is nearest to measured series, with intervals; resumes.

    Returns
    -------
    Outcome
        ``["keys"]``, ``["series"]``, ``["notes"]``; ``value`` has the fit; ``code`` 3 where it did not converge.

    Raises
    ------
    InputError
        With all faults of the file, its start and the measured files, before anything runs.
    SimulationError
        Where the start, or all candidates beside a point, have no result.
    """
    from wrsim.plots.drawing import save_all
    from wrsim.report.study import verdict_page
    from wrsim.results.table import Table
    from wrsim.study.calibration import outcome
    from wrsim.study.calibration.fit import Fit
    from wrsim.study.calibration.intervals import knowledge
    from wrsim.study.calibration.reading import read_calibration

    computation = _Computation(file, output, **computing)
    with timed("check of the calibration"):
        calibration = read_calibration(Path(file), computation.directory, computation.models)
    candidates = calibration.candidates
    if dry_run:
        return _cost(computation, calibration)
    names = [each.name for each in candidates.scenarios]
    with computation.locked(calibration.reads, outcome.written_names(names)):
        with timed("candidates"), computation.pool(most=2 * len(candidates.varied)) as work:
            fit = Fit(calibration, work, computation.notify)
            fit.begin()
            fit.run()
            calibrated = outcome.Calibrated.from_fit(fit, knowledge(fit))
        numbers, notes, makers = calibrated.numbers(), calibrated.notes(), calibrated.figures()
        tables = [calibrated.keys_table(), calibrated.targets_table()]
        texts = {"Calibration": calibration.source.text} | {
            f"Scenario {s.name}": s.base.text for s in candidates.scenarios
        }
        files = ", ".join(record.file.name for record in calibration.records.values())
        summary = f"{candidates.title}. Fitted in {', '.join(names)} to {files or 'measured numbers'}."
        page = verdict_page(
            candidates.title, summary, {t.title: t for t in tables}, notes, calibrated.sentence, fit.converged, texts,
            makers if pictures else {},
        )  # fmt: skip
        written = calibrated.write(computation.directory, page)
        written += save_all(makers, computation.directory) if pictures else []
    code = 0 if fit.converged else STOPPED
    end = Table("", notes=(*(f"note: {note}" for note in notes), calibrated.sentence))
    return Outcome([*tables, end], numbers | {"exit_code": code}, written, calibrated, code, computation.directory)


def _cost(computation: _Computation, calibration: Calibration) -> Outcome:
    """Candidates and the time that they will take."""
    from wrsim.study.estimate import estimated_search
    from wrsim.system import processors

    candidates = calibration.candidates
    keys = len(candidates.varied)
    steps = 4 + keys
    count = steps * (1 + keys) + 2 * keys
    told = f"about {count} candidates for {keys} keys, of which {steps} run alone"
    total_told = "about {}; what is known already does not run again"
    at_once = min(computation.workers or processors(), keys)
    numbers, table = estimated_search(candidates, count, at_once, steps, told, total_told)
    return Outcome([table], numbers, value=calibration)
