"""``wrsim compare``: one scenario by several contact models, side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim.cli.ending import exit_code, reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures, Quiet
from wrsim.cli.showing import print_json, print_tables, progress_bar, say, tell_slow
from wrsim.cli.storing import writing

if TYPE_CHECKING:
    from wrsim.analysis.compare import Comparison


def compare(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Scenario file (TOML): static poses or a run.")],
    contact: Annotated[
        str,
        typer.Option(
            "--contact",
            metavar="A,B,...",
            help="Contact models: half-space, kik-piotrowski+polach, kik-piotrowski+strips=80; file: as in FILE.",
        ),
    ],
    reference: Annotated[
        str | None, typer.Option(metavar="A", help="Whom the others are measured against; default: the first.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: results/<name of FILE>_compared.")
    ] = None,
    models: Models = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compare contact models on the poses or the run of a scenario: differences, patches, time per evaluation."""
    with reporting_errors(as_json), writing(force, file):
        from wrsim.analysis.compare import compare as analyse
        from wrsim.analysis.compare_tables import report_of, tables_of
        from wrsim.scenario.build import build
        from wrsim.scenario.contact_choice import split_names, with_contact_model
        from wrsim.scenario.loading import load

        scenario = load(file, models or ())
        names = split_names(contact)
        for name in names:
            setup = build(with_contact_model(scenario, name))
            if not quiet:
                tell_slow(setup)
        with progress_bar(not (quiet or as_json)) as progress:
            found = analyse(scenario, names, reference, progress)
        directory = output if output is not None else Path("results") / f"{file.stem}_compared"
        report = report_of(found, str(file))
        files = _write(found, report, directory, pictures, scenario.title)
        if as_json:
            print_json({**report, "files": [str(f) for f in files]})
        elif not quiet:
            print_tables(tables_of(found, report))
            say(f"{len(files)} files in {directory}")
        code = max(exit_code(m.result) for m in found.models)
        if code:
            raise typer.Exit(code)


def _write(found: Comparison, report: dict[str, Any], directory: Path, pictures: bool, title: str) -> list[Path]:
    from wrsim.analysis.compare_tables import rows_of_samples
    from wrsim.results.files import as_csv, as_json, write_atomically

    files = [
        write_atomically(directory / "comparison.json", as_json(report)),
        write_atomically(directory / "comparison.csv", as_csv(rows_of_samples(found))),
    ]
    for model in found.models:
        folder = "".join(c if c.isalnum() or c in "-+._" else "_" for c in model.name)
        files.append(model.result.save(directory / folder / "result.nc"))
    if pictures:
        from wrsim.plots import save
        from wrsim.plots.compare import patches_figure, values_figure
        from wrsim.results.moments import has_patches
        from wrsim.results.wheelsets import of_wheelset, wheelsets

        main = found.main
        results = {m.name: m.result.dataset for m in (main, *(m for m in found.models if m is not main))}
        files.append(save(values_figure(found.values, found.reference, title), directory / "compare_values.png"))
        names = wheelsets(main.result.dataset)
        for name in names:
            each = {n: of_wheelset(d, name) for n, d in results.items()}
            own, words = (f"_{name}", f"{title}: {name}") if len(names) > 1 else ("", title)
            if all(has_patches(d) for d in each.values()):
                files.append(save(patches_figure(each, words), directory / f"compare_patches{own}.png"))
    return files
