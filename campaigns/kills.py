"""Runs killed at random places and gone on with. Run: python campaigns/kills.py [KILLS] [--json] [--seed S]

Takes a short run with its tables and pictures, uninterrupted, as the truth. Then the command is started again and again
with ``--resume`` in other folders and killed (SIGKILL) after a random time, in its start-up, its steps, its tables or
its pictures, until it ends by itself. Counts kills, files that cannot be read after one, and files of a folder that
differ from the uninterrupted run's by a byte (the result: by a number). Most commands are forked from a process that
has imported everything, every fifth starts from nothing.
"""

import argparse
import contextlib
import csv
import json
import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

import xarray as xr
from hostile import until_ctrl_c

from wrsim.cli import main as command
from wrsim.errors import InputError
from wrsim.results import Result
from wrsim.results.files import MANIFEST
from wrsim.scenario.loading import load
from wrsim.simulation.recorder import RecordedRun

ROOT = Path(__file__).parents[1]
VALUES = {
    "track.segments": [
        {"kind": "straight", "length_m": 3.0},
        {"kind": "transition", "length_m": 8.0},
        {"kind": "arc", "length_m": 10.0, "radius_m": 300.0, "cant_mm": 60.0},
    ],
    "output.patches_at_m": [2.0, 14.0],
    "contact.strips": 12,
    "contact.cells": 4,
}
LEFT_ALONE = 0.25
"""Share of the commands that may end by themselves."""

FROM_NOTHING = 0.2
"""Share of the commands that are no fork."""


def started(arguments: list[str], fresh: bool) -> int:
    """Start the command in a process of its own; returns its number."""
    if fresh:
        code = "import sys; sys.argv[0] = 'wrsim'; from wrsim.cli import main; main()"
        streams = [(os.POSIX_SPAWN_OPEN, stream, os.devnull, os.O_RDWR, 0) for stream in (0, 1, 2)]
        return os.posix_spawn(
            sys.executable, [sys.executable, "-c", code, *arguments], os.environ, file_actions=streams
        )
    child = os.fork()
    if child:
        return child
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    sys.argv = ["wrsim", *arguments]
    code = 70
    try:
        command()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    finally:
        os._exit(code)


def run_for(arguments: list[str], fresh: bool, seconds: float) -> int | None:
    """Let the command run for so long at most, then kill it; its exit code, None where it was killed."""
    child = started(arguments, fresh)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def contents(folder: Path) -> dict[str, object]:
    """All files of a run but the manifest, which tells its story; of the result what it holds: netCDF-C writes the time
    of the clock into its file."""
    files = [p for p in folder.iterdir() if p.name != MANIFEST]
    return {p.name: Result.load(p).dataset.load() if p.name == "result.nc" else p.read_bytes() for p in files}


def alike(before: object, after: object) -> bool:
    """Whether two files hold the same."""
    return (
        before.identical(after) if isinstance(before, xr.Dataset) and isinstance(after, xr.Dataset) else before == after
    )


def broken(folder: Path) -> list[str]:
    """Files that carry a name of ours and cannot be read."""
    faults = []
    for path in folder.iterdir() if folder.exists() else ():
        try:
            if path.name == "result.nc":
                Result.load(path)
            elif path.name == "result.nc.part":
                with contextlib.suppress(InputError):  # cut off before its start, it says so
                    RecordedRun.read(path)
            elif path.suffix == ".json":
                json.loads(path.read_text())
            elif path.suffix == ".csv":
                with open(path, encoding="utf-8", newline="") as stream:
                    rows = list(csv.reader(stream))
                assert len({len(row) for row in rows}) == 1 and path.read_bytes().endswith(b"\n")
            elif path.suffix == ".png":
                assert path.read_bytes().endswith(b"IEND\xaeB`\x82")
            elif path.suffix == ".toml":
                load(path)
        except Exception as fault:
            faults.append(f"{path.name}: {type(fault).__name__}: {fault}")
    return faults


def main() -> None:
    """Count kills and what they cost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kills", nargs="?", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rng = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as name:
        counts = counted(Path(name), options.kills, rng)
    print(", ".join(f"{word.replace('_', ' ')} {number}" for word, number in counts.items()))
    if options.json:
        print(json.dumps({"kills": counts}))
    raise SystemExit(int(counts["broken_files"] + counts["different_files"] + counts["other_ends"] > 0))


def counted(folder: Path, kills: int, rng: random.Random) -> dict[str, int | float]:
    """How many kills at which stage, and what was broken or different after them."""
    scenario = folder / "short.toml"
    scenario.write_text(load(ROOT / "scenarios/curve_r300.toml").with_values(VALUES).text)
    whole = folder / "whole"
    seconds = {}
    for fresh in (True, False, False):
        began = time.monotonic()
        code = run_for(["run", str(scenario), "-o", str(whole), "-q"], fresh, 1e9)
        seconds[fresh] = time.monotonic() - began
        if code:
            raise SystemExit(f"the uninterrupted run ended with exit code {code}")
    truth = contents(whole)
    counts: dict[str, int | float] = dict.fromkeys(
        ("kills", "runs", "broken_files", "other_ends", "different_files"), 0
    )
    stages = dict.fromkeys(("start-up", "steps", "tables", "pictures"), 0)
    for _ in until_ctrl_c(10 * kills):
        if counts["kills"] >= kills:
            break
        out = folder / f"out{counts['runs']}"
        arguments = ["run", str(scenario), "-o", str(out), "-q", "--resume"]
        while True:
            fresh = rng.random() < FROM_NOTHING
            last = counts["kills"] >= kills or rng.random() < LEFT_ALONE
            code = run_for(arguments, fresh, 1e9 if last else rng.uniform(0.0, 1.1) * seconds[fresh])
            if code is not None:
                break
            counts["kills"] += 1
            names = {p.name for p in out.iterdir()} if out.exists() else set()
            # pictures are drawn behind the tables, then saved at once
            written = names >= {name for name in truth if name.endswith(".csv")}
            stages["pictures" if written else "tables" if "result.nc" in names else
                   "steps" if "result.nc.part" in names else "start-up"] += 1  # fmt: skip
            for fault in broken(out):
                counts["broken_files"] += 1
                print(f"broken after kill {counts['kills']}: {fault}", flush=True)
        counts["runs"] += 1
        if code:
            counts["other_ends"] += 1
            print(f"run {counts['runs']} ended with exit code {code}", flush=True)
        after = contents(out)
        for file in sorted({*truth, *after}):
            if not alike(truth.get(file), after.get(file)):
                counts["different_files"] += 1
                print(f"run {counts['runs']}: {file} is not that of the uninterrupted run", flush=True)
    return counts | stages | {"files_of_a_run": len(truth), "seconds_of_a_run": round(seconds[False], 1)}


if __name__ == "__main__":
    main()
