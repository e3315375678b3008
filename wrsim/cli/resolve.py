"""``wrsim resolve``: the kept moments of a result by another contact model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Force, Json, Models, Pictures, Quiet, beside
from wrsim.cli.showing import print_json, print_tables, progress_bar, say
from wrsim.errors import InputError


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
        from wrsim.cli.storing import RECORD, claimed, read, told_of, write
        from wrsim.results import write_atomically
        from wrsim.results.moments import moments_at, side_by_side
        from wrsim.results.summary_tables import listed, remarks
        from wrsim.results.table import Table
        from wrsim.scenario.loading import load_text

        before = read(result)
        folder = beside(result)
        with told_of(result), progress_bar(not (quiet or as_json)) as progress:
            moments = moments_at(before.wheelset(wheelset), at, "--at") if at else None
            scenario = load_text(before.dataset.attrs["scenario_text"], folder, models or (), closed=True)
            after = solve(before, scenario, contact, keep=same, moments=moments, wheelset=wheelset, progress=progress)  # type: ignore[call-arg, arg-type]
        directory = output or folder / "".join(c if c.isalnum() or c in "-+._" else "_" for c in contact)
        with claimed(directory, force, (result,)) as keeper:
            write_atomically(directory / RECORD, after.dataset.attrs["scenario_text"].encode())
            files = write(after, directory, pictures)
            keeper.clear(files)
        if as_json:
            print_json({"directory": str(directory), "files": [str(f) for f in files], "summary": after.summary()})
        elif not quiet:
            said = listed(remarks(after.summary()), "remarks")
            print_tables([side_by_side(before.wheelset(wheelset), after.wheelset()), Table("", notes=said)])
            say(f"{len(files)} files in {directory}")
