"""``wrsim resolve``: the kept moments of a result by another contact model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures, Quiet, beside
from wrsim.cli.showing import print_json, print_some, print_table, progress_bar, say
from wrsim.errors import InputError

if TYPE_CHECKING:
    from xarray import Dataset

COLUMNS = ("N", "p0", "area", "approach", "Fx", "Fy")


def resolve(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="A result file, or the folder of a run.")],
    contact: Annotated[
        str, typer.Option("--contact", metavar="NAME", help="Contact model, such as half-space+fastsim.")
    ] = "half-space",
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at", metavar="PLACE", help="Only where the wheelset is there, in m, or this pose; may be repeated."
        ),
    ] = None,
    wheelset: Annotated[
        str | None, typer.Option(metavar="NAME", help="Where there are several: this one, or that number.")
    ] = None,
    same: Annotated[
        str, typer.Option(metavar="load|pose", help="What every wheel keeps: its vertical force or its height.")
    ] = "load",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: <folder of RESULT>/<NAME>.")
    ] = None,
    models: Models = None,
    pictures: Pictures = True,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Solve the contacts at the kept moments of a result again, by the exact solver or any other contact model."""
    with reporting_errors(as_json):
        if same not in ("load", "pose"):
            raise InputError(f"--same {same}: must be load or pose")
        from wrsim.analysis.resolve import resolve as solve
        from wrsim.cli.storing import RECORD, claimed, read, write
        from wrsim.results import write_atomically
        from wrsim.results.moments import moments_at
        from wrsim.scenario.loading import load_text

        before = read(result)
        moments = moments_at(before.wheelset(wheelset), at, "--at") if at else None
        folder = beside(result)
        scenario = load_text(before.dataset.attrs["scenario_text"], folder, models or (), closed=True)
        with progress_bar(not (quiet or as_json)) as progress:
            after = solve(before, scenario, contact, keep=same, moments=moments, wheelset=wheelset, progress=progress)  # type: ignore[call-arg, arg-type]
        directory = output or folder / "".join(c if c.isalnum() or c in "-+._" else "_" for c in contact)
        with claimed(directory, force, (result,)) as keeper:
            write_atomically(directory / RECORD, after.dataset.attrs["scenario_text"].encode())
            files = write(after, directory, pictures)
            keeper.clear(files)
        if as_json:
            print_json({"directory": str(directory), "files": [str(f) for f in files], "summary": after.summary()})
        elif not quiet:
            _print(before.wheelset(wheelset), after.wheelset())
            print_some([f"{place}: {words}" for place, words in after.summary().get("remarks", {}).items()], "remarks")
            say(f"{len(files)} files in {directory}")


def _print(old: Dataset, new: Dataset) -> None:
    """Largest patch of every moment and wheel, before and after."""
    import numpy as np

    from wrsim.results import CHANNELS

    sample = "time" if "time" in new.dims else "pose"
    rows = []
    for i, place in enumerate(new[sample].values):
        j = int(np.flatnonzero(old[sample].values == place)[0])
        words = f"{float(new['distance'].values[i]):.1f} m" if sample == "time" else str(place)
        for w, wheel in enumerate(new["wheel"].values):
            for when, dataset, at in (("was", old, j), ("now", new, i)):
                cells = [f"{dataset[c].values[at, w, 0] * CHANNELS[c].shown.factor:.4g}" for c in COLUMNS]
                first = when == "was"
                rows.append([words if first and w == 0 else "", str(wheel) if first else "", when, *cells])
    print_table(["at", "wheel", "", *(CHANNELS[c].column for c in COLUMNS)], rows, left=("at", "wheel", ""))
