"""Mutated input files of every kind: scenarios, vehicles, trains, tracks, profiles, tables, studies, services, records.

Run: python campaigns/hostile.py [N] [--json]

Takes N (default 1000) mutants of the shipped files, some bytes, lines, numbers or words changed in each, and reads
each as far as ``wrsim check``, ``study --dry-run``, ``wear`` and ``recording`` do before they begin. Some lists become
20 000 entries long, some numbers 5000 digits, some files end their lines in CR or give way to a pipe. Counts what must
not be: an answer other than "valid" or an InputError, a message that does not name a file, an answer that takes more
than 20 s of processor time. ``--seed`` begins elsewhere; Ctrl-C ends the count and tells what there is.
"""

import argparse
import json
import os
import random
import re
import shutil
import signal
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from wrsim.errors import InputError
from wrsim.recording.reading import recording_from
from wrsim.recording.restoring import restore
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.study.evolution.reading import read_evolution
from wrsim.study.plan import planned

ROOT = Path(__file__).parents[1]
LONGEST = 20.0  # processor time of one answer [s]
NAMED = re.compile(r"\S*\.(?:toml|csv|whl)(?:, |:)")
"""How a message begins: with the file."""
PLACED = re.compile(
    r"\.(?:toml|csv|whl)(?::\d+)+: |, line \d+|\(\w+[\w.\[\]]* in |: [\w.\[\]]+(?: = | is missing|: )"
    r"|not UTF-8|empty|has no rows|: is a pipe|: has [\d.]+ MB|: is [\d.]+ m long"
)
"""Where in the file: a line, a key, the key that names the file; or that all of it is no text, too large or short."""
NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
NUMBERS = (
    b"0", b"-1", b"1e-9", b"1e9", b"nan", b"inf", b"-0.0", b"1e400", b"9" * 20, b"0x10", b"3,5", b"",
    b"5e-324", b"1e-160", b"9" * 5000,
)  # fmt: skip
MANY = 20_000  # entries of a long list
WORDS = (b"true", b'"x"', b"[]", b"[1, 2]", b"{}", b"{from = 0, to = 1e9, step = 1e-9}", b"\xff\xfe", b'"\\u0000"')
KINDS = (
    "scenarios/*.toml",
    "models/vehicles/*.toml",
    "models/trains/*.toml",
    "models/tracks/*.toml",
    "models/wheels/*.toml",
    "models/rails/*.toml",
    "scenarios/measured/*.csv",
    "scenarios/measured/*.whl",
    "scenarios/measured/*.toml",
    "scenarios/studies/*.toml",
    "scenarios/wear/*",
    "scenarios/recorded/*",
)
BARE = ("ball", "hollow", "corner", "crown", "groove")  # curves that are placed by their origins


PIPE = b"a pipe"
"""In the place of a content: a pipe that nobody writes into."""


class TooSlow(BaseException):
    """An answer took too long."""


def mutated(content: bytes, rng: random.Random) -> bytes:
    """One to four changes at random places."""
    for _ in range(rng.randint(1, 4)):
        lines = content.split(b"\n")
        line = rng.randrange(len(lines))
        action = rng.choices(range(11), (4, 4, 4, 4, 4, 4, 4, 4, 1, 1, 1))[0]
        if action == 0 and content:  # a byte
            index = rng.randrange(len(content))
            content = content[:index] + bytes([rng.randrange(256)]) + content[index + 1 :]
        elif action == 1:
            content = b"\n".join(lines[:line] + lines[line + 1 :])
        elif action == 2:
            content = b"\n".join([*lines[:line], lines[line], *lines[line:]])
        elif action in (3, 4, 5):  # a number becomes another one, or something else
            matches = list(NUMBER.finditer(content))
            if matches:
                place = rng.choice(matches)
                new = rng.choice(NUMBERS if action < 5 else WORDS)
                if action == 3:
                    new = repr(float(place.group()) * 10.0 ** rng.uniform(-6, 6) * rng.choice((1, 1, -1))).encode()
                content = content[: place.start()] + new + content[place.end() :]
        elif action == 6:  # cut off
            content = content[: rng.randrange(len(content) + 1)]
        elif action == 8:  # all lines end as on old machines
            content = content.replace(b"\n", b"\r")
        elif action == 9:  # a list, or all rows of a table from a line on, many times over
            begin = content.find(b"[[")
            part = content[begin:] if begin >= 0 else b"\n".join(lines[line:])
            content = content[: len(content) - len(part)] + part * (MANY // max(part.count(b"\n"), 1) + 1)
        elif action == 10:  # one list becomes long
            matches = list(re.finditer(rb"\[([^][\n]+)\]\n", content))
            if matches:
                place = rng.choice(matches)
                new = b", ".join([place[1]] * MANY)
                content = content[: place.start(1)] + new + content[place.end(1) :]
        else:  # two lines change places
            second_line = rng.randrange(len(lines))
            lines[line], lines[second_line] = lines[second_line], lines[line]
            content = b"\n".join(lines)
    return content


def user_of(file: Path) -> tuple[Path, dict[str, str]]:
    """A scenario that reads the file, and the keys that make it do so."""
    relative = file.relative_to(ROOT)
    if relative.parts[0] == "scenarios":
        whole = file.suffix == ".toml" and file.parent.name == "scenarios"
        return (file if whole else ROOT / "scenarios/static_measured.toml"), {}
    name = relative.relative_to("models").as_posix()
    if relative.parts[1] == "trains":
        return ROOT / "scenarios/train_s_curve.toml", {}
    if relative.parts[1] == "tracks":
        return ROOT / "scenarios/mixed_line.toml", {}
    if relative.parts[1] == "vehicles":
        metre = "lrv" in relative.name
        return ROOT / f"scenarios/{'lrv_curve' if metre else 'manchester_r300'}.toml", {"vehicle.model": name}
    bare = relative.name.startswith(BARE)
    user = ROOT / f"scenarios/{'static_deep_groove' if bare else 'static_s1002'}.toml"
    return user, {"vehicle.wheel" if relative.parts[1] == "wheels" else "track.rail": name}


def read(folder: Path, relative: Path) -> None:
    """Read a file in a copy of the shipped ones, ``relative`` among them, as far as the command goes that it is for."""
    copy, models = folder / relative, [folder / "models"]
    kind = relative.parts[1] if len(relative.parts) > 2 else ""
    if kind == "studies":
        planned(copy, folder / "results", models)
    elif kind == "wear" and relative.stem not in ("coach", "leading_wheelset"):
        read_evolution(copy.with_name("service.toml") if relative.suffix == ".csv" else copy, models)
    elif kind == "wear":
        read_evolution(copy.with_name("coach_service.toml" if relative.stem == "coach" else "service.toml"), models)
    elif kind == "recorded":
        table = copy.with_suffix(".csv")
        restore(recording_from(table, copy.with_suffix(".toml"), part=(None, None)), (3.0, 70.0), 8.0)
    else:
        user, keys = user_of(ROOT / relative)
        scenario = load(folder / user.relative_to(ROOT), models)
        build(scenario.with_values(keys) if keys else scenario)


def check(folder: Path, file: Path, content: bytes) -> str:
    """Check a mutant in a copy of the shipped files; says what became of it."""
    copy = folder / file.relative_to(ROOT)
    original = copy.read_bytes()
    if content == PIPE:
        copy.unlink()
        os.mkfifo(copy)
    else:
        copy.write_bytes(content)

    def stop(number: int, stack: object) -> None:
        raise TooSlow

    signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    try:
        read(folder, file.relative_to(ROOT))
        return "valid"
    except InputError as error:
        message = str(error)
        return "refused" if NAMED.match(message) and PLACED.search(message) else f"no place: {message[:300]}"
    except TooSlow:
        return "too slow"
    except Exception as fault:
        where = traceback.extract_tb(fault.__traceback__)[-1]
        return f"{type(fault).__name__} in {Path(where.filename).name}:{where.lineno}: {str(fault)[:120]}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        copy.unlink()
        copy.write_bytes(original)


def until_ctrl_c(number: int) -> Iterator[int]:
    """Numbers from 0 on, fewer if Ctrl-C comes first; the one under way is finished."""
    asked = []
    before = signal.signal(signal.SIGINT, lambda *_: asked.append(True))
    try:
        for i in range(number):
            if asked:
                return
            yield i
    finally:
        signal.signal(signal.SIGINT, before)


def counted(number: int, rng: random.Random) -> tuple[Counter[str], float]:
    """What became of so many mutants, and the longest processor time of an answer [s]."""
    files = [sorted(ROOT.glob(kind)) for kind in KINDS]
    answers: Counter[str] = Counter()
    slowest = 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("models", "scenarios"):
            shutil.copytree(ROOT / part, folder / part)
        for i in until_ctrl_c(number):
            file = rng.choice(files[i % len(files)])
            content = PIPE if rng.random() < 0.02 else mutated(file.read_bytes(), rng)
            began = time.process_time()
            answer = check(folder, file, content)
            slowest = max(slowest, time.process_time() - began)
            if answer not in ("valid", "refused") and answer not in answers:
                keep = Path(tempfile.gettempdir()) / f"hostile_{i}_{file.name}"
                keep.write_bytes(content)
                print(f"{answer}\n    mutant of {file.relative_to(ROOT)}, kept as {keep}", flush=True)
            answers[answer] += 1
    return answers, slowest


def main() -> None:
    """Count the answers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", nargs="?", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    answers, slowest = counted(options.number, random.Random(options.seed))
    number = sum(answers.values())
    wrong = sum(n for answer, n in answers.items() if answer not in ("valid", "refused"))
    print(f"{number} mutants: {answers['valid']} valid, {answers['refused']} refused, {wrong} wrong answers; "
          f"slowest {slowest:.1f} s")  # fmt: skip
    if options.json:
        counts = {"mutants": number, "valid": answers["valid"], "refused": answers["refused"], "wrong": wrong}
        print(json.dumps({"hostile": counts | {"slowest_s": slowest}}))
    raise SystemExit(int(wrong > 0))


if __name__ == "__main__":
    main()
