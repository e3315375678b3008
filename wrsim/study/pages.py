"""The page about what the user names: results of runs, one study, or one service."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from wrsim.errors import InputError
from wrsim.report.output_folder import beside, read
from wrsim.report.page import report_page, rerun
from wrsim.report.study import service_page, study_page
from wrsim.report.view import view_page
from wrsim.study.collect import is_study, read_study
from wrsim.study.service.record import is_service, read_record, table_of


def page_of(paths: Sequence[Path], with_view: bool, models: Sequence[Path]) -> str:
    """The report as HTML; with_view: with the viewer of each result inside. Raises InputError."""
    for path in paths:
        kind = "study" if is_study(path) else "service" if is_service(path) else ""
        if kind and len(paths) > 1:
            raise InputError(f"{path}: is a {kind}: a report takes one {kind}, or results of runs")
        if kind and with_view:
            raise InputError(f"--view: {path} is a {kind}; it is for results of runs, as each case of a {kind} is")
        if kind == "study":
            return study_page(read_study(path), str(path))
        if kind == "service":
            dataset = read_record(path)
            return service_page(dataset, str(path), table_of(dataset))
    results = [read(path) for path in paths]
    sources = [str(path) for path in paths]
    commands = [rerun(result, source) for result, source in zip(results, sources, strict=True)]
    pairs = zip(results, paths, strict=True)
    viewers = [view_page(result, beside(path), models) for result, path in pairs] if with_view else []
    return report_page(results, sources, commands=commands, viewers=viewers)
