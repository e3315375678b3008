"""Memory and disk of a long run of the coach. Run: python campaigns/long_run.py [KM] [--speed 200] [--json]

The Manchester coach over curves of 3000 m and straights between them, Kik-Piotrowski with few strips: what is stored
does not depend on that. Memory of the process (resident, MB) at a tenth, at half and at the end of the way;
then, each in a process of its own, the largest while the result of the first tenth, half and all of it is put together
and saved, and while its tables are written, each with what of it the system cannot drop (anonymous); the size of what
stands on disk, a kilometre.
"""

import argparse
import json
import os
import resource
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from wrsim.analysis import run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion import run as motion_run
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.motion.result import result_of
from wrsim.results import Result, write_run
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.integrate import Motion, recorded_motion

ROOT = Path(__file__).parents[1]
PLACES = (0.1, 0.5, 1.0)


def line(kilometres: float) -> list[dict[str, Any]]:
    """Segments of a line of that length."""
    bend = {"kind": "transition", "length_m": 150.0}
    piece = [
        {"kind": "straight", "length_m": 200.0}, bend,
        {"kind": "arc", "length_m": 400.0, "radius_m": 3000.0, "cant_mm": 100.0}, bend,
    ]  # fmt: skip
    count = int(kilometres * 1e3 / 900.0) + 2
    return [s | ({"radius_m": -3000.0} if i % 2 and s["kind"] == "arc" else {}) for i in range(count) for s in piece]


def values(kilometres: float, speed: float) -> dict[str, Any]:
    """Keys of the run."""
    return {
        "vehicle.speed_kmh": speed,
        "track.segments": line(kilometres),
        "run.distance_m": 1e3 * kilometres,
        "run.output_interval_ms": 5.0,
        "output.patches_at_m": [],
        "contact.normal": "kik-piotrowski",
        "contact.strips": 8,
        "contact.cells": 3,
    }


def memory() -> list[float]:
    """Memory of this process now [MB]: all that is resident, and anonymous pages."""
    lines = Path("/proc/self/smaps_rollup").read_text(encoding="utf-8").splitlines()[1:]
    sizes = {line.split()[0]: int(line.split()[1]) for line in lines}
    return [1.024e-3 * sizes[key] for key in ("Rss:", "Anonymous:")]


def in_a_child(work: Callable[[], Any]) -> list[float]:
    """Largest `memory` of a process that does some work [MB], over what it began with."""
    back, forth = os.pipe()
    child = os.fork()
    if child == 0:
        before, going = memory(), True
        largest = before

        def watch() -> None:
            nonlocal largest
            while going:
                largest = [max(pair) for pair in zip(largest, memory(), strict=True)]
                time.sleep(0.02)

        threading.Thread(target=watch, daemon=True).start()
        try:
            work()
            os.write(forth, json.dumps([round(a - b, 1) for a, b in zip(largest, before, strict=True)]).encode())
        finally:
            os._exit(0)
    os.close(forth)
    with os.fdopen(back) as stream:
        told: list[float] = json.loads(stream.read())
    os.waitpid(child, 0)
    return told


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kilometres", nargs="?", type=float, default=10.0)
    parser.add_argument("--speed", type=float, default=200.0, help="[km/h]")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        figures = measured(Path(name), options.kilometres, options.speed)
    for word, value in figures.items():
        print(f"{word}: {value}")
    if options.json:
        print(json.dumps({"long_run": figures}))


def measured(folder: Path, kilometres: float, speed: float) -> dict[str, Any]:
    """Run, put together, write."""
    scenario = load(ROOT / "scenarios/manchester_r300.toml").with_values(values(kilometres, speed))
    record = folder / "result.nc.part"
    memory_at: dict[float, float] = {}

    def progress(fraction: float, left: float) -> None:
        for place in PLACES:
            if fraction >= place - 1e-9 and place not in memory_at:
                memory_at[place] = round(memory()[0], 1)

    def no_result(*arguments: Any) -> None:  # only the samples here; results are made in processes of their own
        return None

    whole = motion_run.result_of
    motion_run.result_of = no_result  # type: ignore[assignment]
    began = time.process_time()
    run(scenario, progress, record=record)
    seconds = time.process_time() - began
    motion_run.result_of = whole
    setup = build(scenario)
    law = force_law(setup)
    motion = recorded_motion(record, Monitor(law, setup.plan.speed))
    n = len(motion.times)
    together, written, disk = {}, {}, {}
    for place in PLACES:
        part = Motion(
            *(a[: max(int(place * n), 2)] for a in (motion.times, motion.q, motion.q_t)), motion.step, "completed"
        )
        out = folder / f"{place:g}"
        together[place] = in_a_child(lambda p=part, o=out: result_of(setup, law, p, [], folder).save(o / "result.nc"))
        written[place] = in_a_child(lambda o=out: write_run(Result.load(o / "result.nc"), o))
        disk[place] = sum(f.stat().st_size for f in out.rglob("*") if f.is_file()) / 1e6
    label = {place: f"{place * kilometres:g} km" for place in PLACES}
    return {
        "samples": n,
        "run_MB": {label[p]: memory_at[p] for p in PLACES},
        "put_together_MB": {label[p]: together[p] for p in PLACES},
        "written_MB": {label[p]: written[p] for p in PLACES},
        "part_file_MB_a_km": round(record.stat().st_size / 1e6 / kilometres, 2),
        "result_MB_a_km": round((folder / "1/result.nc").stat().st_size / 1e6 / kilometres, 2),
        "all_files_MB_a_km": round(disk[1.0] / kilometres, 2),
        "run_processor_s": round(seconds, 1),
        "largest_MB": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, 1),
    }


if __name__ == "__main__":
    main()
