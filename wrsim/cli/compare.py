"""``wrsim compare``: one scenario by several contact models, side by side."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim.cli.ending import exit_code, reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures, Quiet
from wrsim.cli.showing import print_json, print_some, print_table, progress_bar, say, tell_slow
from wrsim.cli.storing import writing

if TYPE_CHECKING:
    from wrsim.analysis.compare import Comparison
    from wrsim.results import Result

SHOWN = ("p0", "area", "approach", "N", "contact_angle", "X", "Y", "T_gamma")
"""Quantities in the table on the screen."""
UNITS = {"relative": (100.0, "percent"), "of the normal force": (100.0, "percent"), "plain": (180.0 / pi, "deg")}
"""Factor and unit of differences, by their kind."""
FEW = 4
"""Poses and wheels of a small comparison, whose values are printed one by one."""


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
            _print(found, report, directory, len(files))
        code = max(exit_code(m.result) for m in found.models)
        if code:
            raise typer.Exit(code)


def report_of(found: Comparison, scenario: str) -> dict[str, Any]:
    """Everything in numbers: differences in per cent or degrees, times in microseconds and seconds."""
    from wrsim.analysis.compare import DIFFERENCES, PLAIN, summary

    models = {}
    for model in found.models:
        differences = {}
        for quantity, numbers in summary(found, model.name).items():
            factor, unit = UNITS[DIFFERENCES[quantity]]
            differences[f"{quantity}_{unit}"] = {name: factor * value for name, value in numbers.items()}
        dataset = model.result.dataset
        unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
        models[model.name] = {
            "status": model.result.status,
            "unsolved_poses": unsolved,
            "remarks": remarks_of(model.result),
            "evaluation_us": None if model.evaluation_time != model.evaluation_time else 1e6 * model.evaluation_time,
            "run_s": model.run_time,
            "differences": differences,
        }
    kinds = {quantity: kind for quantity, kind in DIFFERENCES.items() if kind != PLAIN}
    return {"scenario": scenario, "reference": found.reference, "relative_to": kinds, "models": models}


def remarks_of(result: Result) -> list[str]:
    """Events of a run, and what the contacts of poses have to say."""
    summary = result.summary()
    events = [f"{event['distance_m']:.1f} m: {event['event']}" for event in summary.get("events", [])]
    return events + [f"{place}: {words}" for place, words in summary.get("remarks", {}).items()]


def table_of(found: Comparison) -> list[list[str]]:
    """One row per sample, wheel and model; the first is the header. Differences in per cent or degrees."""
    import numpy as np

    from wrsim.analysis.compare import DIFFERENCES
    from wrsim.results import CHANNELS
    from wrsim.results.rows import cells_of, number_cells, rows_of

    values = found.values
    sample = "time" if "time" in values.dims else "pose"
    i, j, m = (index.ravel() for index in np.indices([values.sizes[d] for d in (sample, "wheel", "model")]))
    context = [n for n in (sample, "distance", "lateral_shift", "yaw", "load") if n in values.coords]
    columns = [(CHANNELS[n].column, cells_of(n, values[n].values[i])) for n in context]
    columns += [("wheel", list(values["wheel"].values[j])), ("model", list(values["model"].values[m]))]
    columns += [(CHANNELS[q].column, cells_of(q, values[q].values[m, i, j])) for q in DIFFERENCES]
    for q, kind in DIFFERENCES.items():
        difference = values[f"{q}_difference"].values[m, i, j]
        columns.append((f"{q}_difference_{UNITS[kind][1]}", number_cells(UNITS[kind][0] * difference)))
    return rows_of(columns)


def _write(found: Comparison, report: dict[str, Any], directory: Path, pictures: bool, title: str) -> list[Path]:
    from wrsim.results.files import as_csv, as_json, write_atomically

    files = [
        write_atomically(directory / "comparison.json", as_json(report)),
        write_atomically(directory / "comparison.csv", as_csv(table_of(found))),
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


def _print(found: Comparison, report: dict[str, Any], directory: Path, files: int) -> None:
    """The values when they are few, differences and times; a column for every model. And where everything is."""
    from wrsim.analysis.compare import DIFFERENCES, OF_LOAD, PLAIN
    from wrsim.results import CHANNELS

    values, models = found.values, report["models"]
    sample = "time" if "time" in values.dims else "pose"
    rows: list[list[str]] = []
    if values.sizes[sample] * values.sizes["wheel"] <= FEW:
        for i, place in enumerate(values[sample].values):
            for j, wheel in enumerate(values["wheel"].values):
                rows.append([f"{place} {wheel}" if sample == "pose" else str(wheel)])
                for q in SHOWN:
                    numbers = values[q].values[:, i, j] * CHANNELS[q].shown.factor
                    rows.append([CHANNELS[q].column, *("-" if n != n else f"{n:.5g}" for n in numbers)])
    rows.append(["difference, median / 95 %"])
    for q in SHOWN:
        unit = {PLAIN: "deg", OF_LOAD: "% of N"}.get(DIFFERENCES[q], "%")
        key = f"{q}_{UNITS[DIFFERENCES[q]][1]}"
        known = [model["differences"].get(key) for model in models.values()]
        cells = ["-" if t is None else f"{t['median']:.2g} / {t['p95']:.2g}" for t in known]
        cells = ["reference" if n == found.reference else c for n, c in zip(models, cells, strict=True)]
        rows.append([f"{q} ({unit})", *cells])
    times = [model["evaluation_us"] for model in models.values()]
    rows.append(["time"])
    rows.append(["one contact (us)", *("-" if t is None else f"{t:.3g}" for t in times)])
    rows.append(["all (s)", *(f"{model['run_s']:.3g}" for model in models.values())])
    print_table(["", *models], rows, left=("",))
    for name, model in models.items():
        if model["unsolved_poses"]:
            say(f"{name}: {model['unsolved_poses']} poses without a solution")
        print_some([f"{name}: {words}" for words in model["remarks"]], "remarks")
    say(f"{files} files in {directory}")
