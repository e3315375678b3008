"""``wrsim compare``: one scenario by several contact models, side by side."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wrsim.cli.ending import exit_code, told
from wrsim.cli.options import Json, ModelFiles, Pictures
from wrsim.cli.showing import print_json, progress_bar, tell_slow

if TYPE_CHECKING:
    from wrsim.analysis.compare import Comparison

SHOWN = ("p0", "area", "approach", "N", "contact_angle", "X", "Y", "T_gamma")
"""Quantities in the table on the screen."""
FEW = 4
"""Poses and wheels of a small comparison, whose values are printed one by one."""


def compare(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Scenario file (TOML): static poses or a run.")],
    models: Annotated[
        str,
        typer.Option(
            "--models",
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
    model_files: ModelFiles = None,
    pictures: Pictures = True,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar, no table.")] = False,
) -> None:
    """Compare contact models on the poses or the run of a scenario: differences, patches, time per evaluation."""
    with told(as_json):
        from wrsim.analysis.compare import compare as analyse
        from wrsim.scenario.build import build
        from wrsim.scenario.contact_choice import split_names, with_contact_model
        from wrsim.scenario.loading import load

        scenario = load(file, model_files or ())
        names = split_names(models)
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
            plain = DIFFERENCES[quantity] == PLAIN
            factor, unit = (57.29577951308232, "deg") if plain else (100.0, "percent")
            differences[f"{quantity}_{unit}"] = {name: factor * value for name, value in numbers.items()}
        dataset = model.result.dataset
        unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
        models[model.name] = {
            "status": model.result.status,
            "unsolved_poses": unsolved,
            "evaluation_us": None if model.evaluation_time != model.evaluation_time else 1e6 * model.evaluation_time,
            "run_s": model.run_time,
            "differences": differences,
        }
    kinds = {quantity: kind for quantity, kind in DIFFERENCES.items() if kind != PLAIN}
    return {"scenario": scenario, "reference": found.reference, "relative_to": kinds, "models": models}


def table_of(found: Comparison) -> list[list[str]]:
    """One row per sample, wheel and model; the first is the header. Differences in per cent or degrees."""
    from wrsim.analysis.compare import DIFFERENCES, PLAIN
    from wrsim.results import CHANNELS

    values = found.values
    sample = "time" if "time" in values.dims else "pose"
    context = [n for n in (sample, "distance", "lateral_shift", "yaw", "load") if n in values.coords]
    quantities = list(DIFFERENCES)
    factors = {q: 57.29577951308232 if DIFFERENCES[q] == PLAIN else 100.0 for q in quantities}
    header = [CHANNELS[n].column for n in context] + ["wheel", "model"] + [CHANNELS[q].column for q in quantities]
    header += [f"{q}_difference_{'deg' if DIFFERENCES[q] == PLAIN else 'percent'}" for q in quantities]
    rows = [header]
    for i in range(values.sizes[sample]):
        place = [_cell(values[n].values[i], CHANNELS[n].shown.factor) for n in context]
        for j, wheel in enumerate(values["wheel"].values):
            for m, model in enumerate(values["model"].values):
                cells = [_cell(values[q].values[m, i, j], CHANNELS[q].shown.factor) for q in quantities]
                cells += [_cell(values[f"{q}_difference"].values[m, i, j], factors[q]) for q in quantities]
                rows.append([*place, str(wheel), str(model), *cells])
    return rows


def _cell(value: Any, factor: float) -> str:
    if isinstance(value, str):
        return str(value)
    return "" if value != value else f"{float(value) * factor + 0.0:.10g}"


def _write(found: Comparison, report: dict[str, Any], directory: Path, pictures: bool, title: str) -> list[Path]:
    from wrsim.results import write_atomically

    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(table_of(found))
    text = json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    files = [
        write_atomically(directory / "comparison.json", text.encode()),
        write_atomically(directory / "comparison.csv", stream.getvalue().encode()),
    ]
    for model in found.models:
        folder = "".join(c if c.isalnum() or c in "-+._" else "_" for c in model.name)
        files.append(model.result.save(directory / folder / "result.nc"))
    if pictures:
        from wrsim.plots import save
        from wrsim.plots.compare import patches_figure, values_figure
        from wrsim.plots.moments import has_patches
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
    from rich.console import Console
    from rich.table import Table

    from wrsim.analysis.compare import DIFFERENCES, OF_LOAD, PLAIN
    from wrsim.results import CHANNELS

    console = Console(highlight=False)
    values, models = found.values, report["models"]
    sample = "time" if "time" in values.dims else "pose"
    table = Table(box=None, pad_edge=False)
    table.add_column("")
    for name in models:
        table.add_column(name, justify="right", overflow="fold")
    if values.sizes[sample] * values.sizes["wheel"] <= FEW:
        for i, place in enumerate(values[sample].values):
            for j, wheel in enumerate(values["wheel"].values):
                table.add_row(f"{place} {wheel}" if sample == "pose" else str(wheel), style="bold")
                for q in SHOWN:
                    numbers = values[q].values[:, i, j] * CHANNELS[q].shown.factor
                    table.add_row(CHANNELS[q].column, *("-" if n != n else f"{n:.5g}" for n in numbers))
    table.add_row("difference, median / 95 %", style="bold")
    for q in SHOWN:
        unit = {PLAIN: "deg", OF_LOAD: "% of N"}.get(DIFFERENCES[q], "%")
        key = f"{q}_{'deg' if DIFFERENCES[q] == PLAIN else 'percent'}"
        told = [model["differences"].get(key) for model in models.values()]
        cells = ["-" if t is None else f"{t['median']:.2g} / {t['p95']:.2g}" for t in told]
        cells = ["reference" if n == found.reference else c for n, c in zip(models, cells, strict=True)]
        table.add_row(f"{q} ({unit})", *cells)
    table.add_row("time", style="bold")
    times = [model["evaluation_us"] for model in models.values()]
    table.add_row("one contact (us)", *("-" if t is None else f"{t:.3g}" for t in times))
    table.add_row("all (s)", *(f"{model['run_s']:.3g}" for model in models.values()))
    console.print(table)
    for name, model in models.items():
        if model["unsolved_poses"]:
            console.print(f"{name}: {model['unsolved_poses']} poses without a solution")
    console.print(f"{files} files in {directory}", soft_wrap=True)
