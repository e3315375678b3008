"""Corrupted result and run files. Run: python benchmarks/corrupted.py [N] [--json] [--seed S]

Takes a short run's ``result.nc`` and ``result.nc.part``, changes some bits, bytes or blocks of a copy, cuts it off or
puts something in, and reads it as ``wrsim show`` does. What must not be: another answer than numbers or an InputError,
text on stderr from a library, and numbers that are not those of the whole file. Of a run file, which is read as far
as it is whole, every sample has to be one of the whole run's.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hostile import until_ctrl_c

from wrsim.analysis import run
from wrsim.cli.storing import read
from wrsim.errors import InputError
from wrsim.results import Result
from wrsim.scenario.loading import load
from wrsim.simulation.integrate import recorded_motion

ROOT = Path(__file__).parents[1]
VALUES = {
    "track.segments": [{"kind": "straight", "length_m": 8.0}],
    "run.distance_m": 6.0,
    "run.output_interval_ms": 2.0,  # every step
    "run.step_us": 2000,
    "output.patches_at_m": [2.0],
    "contact.strips": 12,
    "contact.cells": 4,
}


def corrupted(content: bytes, rng: random.Random) -> bytes:
    """A copy with one to three changes."""
    data = bytearray(content)
    for _ in range(rng.randint(1, 3)):
        n = len(data)
        if n < 2:
            break
        at, length = rng.randrange(n), rng.randint(1, min(512, n))
        other = rng.randrange(n)
        action = rng.randrange(8)
        if action == 0:
            data[at] ^= 1 << rng.randrange(8)
        elif action == 1:
            data[at : at + length] = bytes(rng.randrange(256) for _ in data[at : at + length])
        elif action == 2:
            data[at : at + length] = bytes(len(data[at : at + length]))
        elif action == 3:
            del data[at:]
        elif action == 4:
            del data[at : at + length]
        elif action == 5:
            data[at:at] = data[other : other + length]
        elif action == 6:
            data[at : at + length], data[other : other + length] = data[other : other + length], data[at : at + length]
        else:
            data += data[other : other + length]
    return bytes(data)


@contextmanager
def noise(path: Path) -> Iterator[None]:
    """Send everything that reaches stderr, from C as well, to a file."""
    kept = os.dup(2)
    with open(path, "wb") as stream:
        os.dup2(stream.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)


def same_result(path: Path, whole: Result) -> bool:
    """Whether a file reads as the very same numbers."""
    return bool(read(path).dataset.identical(whole.dataset))


def same_rows(path: Path, rows: dict[float, bytes]) -> bool:
    """Whether all samples of a run file are those of the whole run."""
    motion = recorded_motion(path)
    found = zip(motion.times, motion.q, motion.q_t, strict=True)
    return all(rows.get(float(t)) == q.tobytes() + q_t.tobytes() for t, q, q_t in found)


def counted(number: int, rng: random.Random, folder: Path) -> Counter[str]:
    """What became of the files."""
    record, path = folder / "whole.nc.part", folder / "copy"
    result = run(load(ROOT / "scenarios/curve_r300.toml").with_values(VALUES), record=record)
    whole = Result.load(result.save(folder / "whole.nc"))
    motion = recorded_motion(record)
    rows = {float(t): q.tobytes() + v.tobytes() for t, q, v in zip(motion.times, motion.q, motion.q_t, strict=True)}
    contents = (folder / "whole.nc").read_bytes(), record.read_bytes()
    answers: Counter[str] = Counter()
    for i in until_ctrl_c(number):
        part = i % 2
        content = corrupted(contents[part], rng)
        copy = path.with_suffix(".nc.part" if part else ".nc")
        copy.write_bytes(content)
        with noise(folder / "noise"):
            try:
                same = same_rows(copy, rows) if part else same_result(copy, whole)
                answer = "read, the same numbers" if same else "WRONG NUMBERS"
            except InputError as error:
                answer = "refused" if str(copy) in str(error) else f"refused without the file's name: {error}"
            except Exception as fault:
                answer = f"{type(fault).__name__}: {fault}"
        if said := (folder / "noise").read_text(errors="replace"):
            answer = f"noise: {said[:200]}"
        if answer not in ("refused", "read, the same numbers"):
            print(f"{copy.name} {i}: {answer}", flush=True)
        answers[answer] += 1
    return answers


def main() -> None:
    """Count the answers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", nargs="?", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        answers = counted(options.number, random.Random(options.seed), Path(name))
    good = {"refused": answers["refused"], "read_the_same": answers["read, the same numbers"]}
    number = sum(answers.values())
    counts = {"files": number, **good, "wrong": number - sum(good.values())}
    print(", ".join(f"{word.replace('_', ' ')} {number}" for word, number in counts.items()))
    if options.json:
        print(json.dumps({"corrupted": counts}))


if __name__ == "__main__":
    main()
