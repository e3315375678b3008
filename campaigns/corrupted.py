"""Corrupted and crafted result and run files, and caches of kernels.

Run: python campaigns/corrupted.py [N] [--commands M] [--caches C] [--json]

Takes a short run's ``result.nc`` and ``result.nc.part``, changes some bits, bytes or blocks of a copy, cuts it off or
puts something in, and reads it as ``wrsim show`` does. What must not be: another answer than numbers or an InputError,
text on stderr from a library, and numbers that are not those of the whole file. Of a run file, which is read as far
as it is whole, every sample has to be one of the whole run's. Half of the copies get a right checksum: ``wrsim show``
may give their numbers, whatever they are, or refuse as below.

With ``--commands``, M more files, of runs, poses, studies and services, go through every command that reads them. One
in four is damaged, one in four is damaged and has a right checksum, two have odd content and a right checksum
(``crafted.py``). A command may give its numbers, or refuse in one line and with exit code 2, within 60 s of a processor
and 2 GB.

With ``--caches``, a short run is computed by C new processes, each with a copy of a cache of compiled kernels in
which one to three files are damaged. It has to give the same numbers, with at most one line on stderr, and to leave a
cache that the next process loads without a word.
"""

import argparse
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import crafted
import numpy as np
import xarray as xr
from hostile import until_ctrl_c

from wrsim.analysis import run
from wrsim.errors import InputError
from wrsim.report.output_folder import read
from wrsim.results import Result
from wrsim.results.netcdf import write_netcdf
from wrsim.scenario.loading import load
from wrsim.simulation.integrate import recorded_motion
from wrsim.study.evolution.history import COLUMNS

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from support.commands import call, forked  # noqa: E402

VALUES = {
    "track.segments": [{"kind": "straight", "length_m": 8.0}],
    "run.distance_m": 6.0,
    "run.output_interval_ms": 2.0,  # every step
    "run.step_us": 2000,
    "output.patches_at_m": [2.0],
    "contact.strips": 12,
    "contact.cells": 4,
}

COMMANDS = {
    "show": ("show", "FILE"),
    "plot": ("plot", "FILE", "-o", "OUT"),
    "report": ("report", "FILE", "-o", "OUT/report.html"),
    "view": ("view", "FILE", "-o", "OUT/view.html"),
    "diff": ("diff", "FILE", "WHOLE"),
    "export": ("export", "FILE", "--to", "mat,csv", "-o", "OUT"),
    "resolve": ("resolve", "FILE", "--contact", "kik-piotrowski+fastsim", "-o", "OUT", "--no-pictures"),
    "assess": ("assess", "FILE", "-o", "OUT", "--no-pictures"),
    "ride": ("ride", "FILE", "-o", "OUT", "--no-pictures"),
}
GOOD = ("refused", "numbers")
LONGEST, ROOM = 60, 2 << 30
"""Of one command: processor time [s], and memory beyond that of its parent [bytes]."""


def corrupted(content: bytes, rng: random.Random) -> bytes:
    """A copy with one to three changes."""
    data = bytearray(content)
    for _ in range(rng.randint(1, 3)):
        n = len(data)
        if n < 2:
            break
        start, length = rng.randrange(n), rng.randint(1, min(512, n))
        second = rng.randrange(n)
        action = rng.randrange(8)
        if action == 0:
            data[start] ^= 1 << rng.randrange(8)
        elif action == 1:
            data[start : start + length] = bytes(rng.randrange(256) for _ in data[start : start + length])
        elif action == 2:
            data[start : start + length] = bytes(len(data[start : start + length]))
        elif action == 3:
            del data[start:]
        elif action == 4:
            del data[start : start + length]
        elif action == 5:
            data[start:start] = data[second : second + length]
        elif action == 6:
            data[start : start + length], data[second : second + length] = (
                data[second : second + length],
                data[start : start + length],
            )
        else:
            data += data[second : second + length]
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
    samples = zip(motion.times, motion.q, motion.q_t, strict=True)
    return all(rows.get(float(t)) == q.tobytes() + q_t.tobytes() for t, q, q_t in samples)


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
        if i % 4 > 1:
            copy.write_bytes(checked_again(content, copy))
            answer = answer_of(("show", str(copy)), copy)
            if answer not in GOOD:
                print(f"{copy.name} {i}: {answer}", flush=True)
            answers["right checksum: " + (answer if answer in GOOD else "WRONG")] += 1
            continue
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


def answer_of(command: Sequence[str], file: Path) -> str:
    """How the command ends in a process that is forked from this one: a word, and what is wrong with it if anything."""
    done = forked(*command, first=_bound)
    code, told, lines = done.returncode, done.stderr, done.stderr.count("\n")
    if code in (-signal.SIGALRM, -signal.SIGXCPU, -signal.SIGKILL):
        return "HANGS"
    if code in (0, 3, 4) and not any(word in told for word in ("Traceback", "HDF5-DIAG")):
        return "numbers"
    if code == 2 and lines == 1 and len(told) < 1000:
        return "refused" if str(file) in told else f"REFUSED WITHOUT THE FILE'S NAME: {told.strip()}"
    return f"EXIT {code}, {lines} LINES: {told[:300]!r}"


def _bound() -> None:
    """Give this process no more memory and time than a command may take."""
    used = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + ROOM, used + ROOM))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(10 * LONGEST)  # it may wait for a processor
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))


def sources(folder: Path) -> list[Path]:
    """Files of all kinds that hold results, whole."""
    record = folder / "run.nc.part"
    runs = load(ROOT / "scenarios/curve_r300.toml").with_values(VALUES)
    files = [run(runs, record=record).save(folder / "run.nc"), record]
    coach = VALUES | {
        "run.output_interval_ms": 8.0,
        "run.distance_m": 40.0,
        "track.segments": [{"kind": "straight", "length_m": 60.0}],
    }
    ride = load(ROOT / "scenarios/manchester_ride_160.toml").with_values(
        coach | {"ride.from_m": 0.0, "track.irregularities": []}
    )
    files.append(run(ride).save(folder / "coach.nc"))
    poses = load(ROOT / "scenarios/static_s1002.toml")
    files.append(run(poses.with_values({"static.lateral_mm": [0, 5], "contact.strips": 12})).save(folder / "poses.nc"))
    return [*files, _study(folder / "study.nc"), _service(folder / "wear.nc")]


def _study(path: Path) -> Path:
    """A study of three cases."""
    columns = {"status": ["completed", "derailed", "missing"], "message": ["", "off", ""], "name": ["a", "b", "c"]}
    texts = {name: ("speed", np.array(column, dtype=object)) for name, column in columns.items()}
    numbers = {n: ("speed", np.array([1.0, 2.0, np.nan]), {"units": "kN"}) for n in ("Y_max", "Q_max")}
    coords = {"speed": ("speed", np.array([10.0, 20.0, 30.0]), {"key": "vehicle.speed_kmh"})}
    about = {"format": "wrsim study", "title": "a study", "analysis": "curving", "study_text": "", "scenario_text": ""}
    return write_netcdf(path, xr.Dataset(numbers | texts, coords, about))


def _service(path: Path) -> Path:
    """Wheels at two mileages."""
    numbers = {
        name: ("point", np.array([0.0, 1.0]), {"units": unit, "long_name": meaning})
        for name, (_, _, unit, meaning) in COLUMNS.items()
    }
    of_profile = {n: (("point", "place"), np.ones((2, 5)), {"units": "m"}) for n in ("u", "w", "depth")}
    about = {
        "format": "wrsim wear",
        "title": "wheels",
        "law": "archard",
        "wheel": "S1002",
        "conicity_amplitude_m": 0.003,
    }
    about |= {"evolution_text": "", "cases_text": "", "scenario_text": ""}
    return write_netcdf(
        path, xr.Dataset(numbers | of_profile | {"unworn_u": ("place", np.arange(5.0), {"units": "m"})}, attrs=about)
    )


def by_command(number: int, rng: random.Random, folder: Path) -> dict[str, Counter[str]]:
    """What every command said to so many files; files that it should not have said that to are kept."""
    answers: dict[str, Counter[str]] = {name: Counter() for name in COMMANDS}
    whole = {path: path.read_bytes() for path in sources(folder)}
    reference = folder / "reference.nc"
    shutil.copy(folder / "run.nc", reference)
    for path in (folder / "run.nc", folder / "coach.nc"):
        _warmed_up(path, reference, folder / "warm")
    for i in until_ctrl_c(number):
        path, content = rng.choice([*whole.items()])
        is_part = path.suffix == ".part"
        if i % 4 < 2:
            made = corrupted(content, rng)
            if i % 4:
                made = checked_again(made, path)
        else:
            made = (crafted.part if is_part else crafted.numbers)(content, rng)
        case_folder = folder / str(i)
        case_folder.mkdir()
        file = case_folder / path.name
        file.write_bytes(made)
        bad = False
        for name, command in COMMANDS.items():
            if path.stem in ("study", "wear") and name != "report":
                continue
            answer = answer_of(_filled(command, file, reference, case_folder / "out"), file)
            answers[name][answer.split(":")[0]] += 1
            if answer not in GOOD:
                bad = True
                print(f"{i} {path.name} {name}: {answer}", flush=True)
        if not bad:
            shutil.rmtree(case_folder)
    return answers


def _filled(command: Sequence[str], file: Path, whole: Path, out: Path) -> list[str]:
    places = {"FILE": str(file), "WHOLE": str(whole)}
    return [places.get(w, w.replace("OUT", str(out))) for w in command]


def _warmed_up(file: Path, whole: Path, out: Path) -> None:
    """Let every command come to its end once: the processes that fork from this one find modules and kernels there."""
    for command in COMMANDS.values():
        call(*_filled(command, file, whole, out))


def checked_again(content: bytes, path: Path) -> bytes:
    """A damaged file with a right checksum; of a run file each record, as far as it can be told apart."""
    if path.suffix != ".part":
        return crafted.sealed_again(content)
    try:
        return crafted.run_file(crafted.records(content))
    except Exception:
        return content


def with_damaged_caches(number: int, rng: random.Random, folder: Path) -> Counter[str]:
    """What a process says to a cache of compiled kernels with damaged files."""
    answers: Counter[str] = Counter()
    whole = folder / "whole"
    _short_run(whole, folder / "first")
    first = _short_run(whole, folder / "first")
    for i in until_ctrl_c(number):
        copy = folder / "copy"
        shutil.copytree(whole, copy)
        for path in rng.sample(sorted(copy.rglob("*.nb[ic]")), rng.randint(1, 3)):
            path.write_bytes(rng.choice((corrupted(path.read_bytes(), rng), b"", path.read_bytes()[:-1])))
        damaged, healed = _short_run(copy, folder / str(i)), _short_run(copy, folder / str(i))
        lines = damaged[2].count("\n")
        good = damaged[:2] == healed[:2] == first[:2] and lines <= 1 and not healed[2]
        answer = f"healed, {lines} lines" if good else f"WRONG: {damaged} {healed}"[:500]
        if not good:
            print(f"cache {i}: {answer}", flush=True)
        answers[answer.split(":")[0]] += 1
        shutil.rmtree(copy)
    return answers


def _short_run(cache: Path, out: Path) -> tuple[int, str, str]:
    """Exit code, numbers and messages of a short run that is computed with a cache."""
    command = (sys.executable, "-m", "wrsim", "run", "scenarios/curve_r300.toml", "-o", str(out), "--no-pictures",
               "--force", "--json", "--set", "run.distance_m=0.3", "--set", "output.patches_at_m=[]")  # fmt: skip
    done = subprocess.run(command, cwd=ROOT, env=os.environ | {"XDG_CACHE_HOME": str(cache)}, capture_output=True)
    summary = json.loads(done.stdout or b"{}").get("summary", {})
    numbers = json.dumps([summary.get(name) for name in ("extent", "wheelsets", "wheels")])
    return done.returncode, numbers, done.stderr.decode(errors="replace")


def main() -> None:
    """Count the answers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", nargs="?", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--commands", type=int, default=0, metavar="M")
    parser.add_argument("--caches", type=int, default=0, metavar="C")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        answers = counted(options.number, random.Random(options.seed), Path(name))
    if options.commands:
        with tempfile.TemporaryDirectory() as name:
            said = by_command(options.commands, random.Random(options.seed), Path(name))
        for command, counts_of_command in said.items():
            print(f"{command}: " + ", ".join(f"{answer} {n}" for answer, n in counts_of_command.most_common()))
    wrong_caches = 0
    if options.caches:
        with tempfile.TemporaryDirectory() as name:
            said_of_caches = with_damaged_caches(options.caches, random.Random(options.seed), Path(name))
        print("caches: " + ", ".join(f"{answer} {n}" for answer, n in said_of_caches.most_common()))
        wrong_caches = said_of_caches["WRONG"]
    good = {
        "refused": answers["refused"],
        "read_the_same": answers["read, the same numbers"],
        "right_checksum_refused": answers["right checksum: refused"],
        "right_checksum_numbers": answers["right checksum: numbers"],
    }
    number = sum(answers.values())
    counts = {"files": number, **good, "wrong": number - sum(good.values())}
    print(", ".join(f"{word.replace('_', ' ')} {number}" for word, number in counts.items()))
    if options.json:
        print(json.dumps({"corrupted": counts}))
    raise SystemExit(int(counts["wrong"] + wrong_caches > 0))


if __name__ == "__main__":
    main()
