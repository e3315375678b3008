"""Executes the commands of the user guide, page by page, in one folder.

    python docs/run_guide.py [--short | --whole | --write] [PAGE ...]

Lines that call ``wrsim``, ``cp`` or ``mkdir`` count, but those with a word in capitals, which stands for a name, and
those of LEFT_OUT; a line on two pages is executed on the first. Tutorials run as they are; scenarios of other pages run
in a short form, without pictures, but for what their lines set themselves. Studies in short form have the ends of their
ranges alone; optimisations and calibrations tell their cost; units and live pages have a step that is given and, where
they are for all systems, one of these. With --short LONG lines of tutorials have this form, too, and two processes
share the pages. A line that ends with another exit code than 0, or than those of EXPECTED, is an error.

Behind a command a page may have what the terminal prints: ``<!-- printed: COMMAND | 1-5 20-24 -->`` and a block of text
with these lines. Such commands run as they are, but for LONG ones, and their blocks on all pages are compared: words as
they are, numbers within 1 % or two units of the last digit, so that they hold on other machines. --whole runs all lines
as they are; --write does so and writes what is printed.
"""

from __future__ import annotations

import contextlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from typer.testing import CliRunner

from wrsim import load
from wrsim.cli import application
from wrsim.jit.objects import this_target

app = application()

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *(ROOT / "docs" / "user").glob("*.md")]
FIRST = ["README", "first_hour", "own_vehicle", "own_track", "own_profile", "acceptance", "own_study"]
"""Tutorials, in their order."""
ALONE = {"own_vehicle", "own_profile"}
"""Those that need nothing of the others, nor they of them."""
LEFT_OUT = re.compile(r"\b[A-Z]{3,}\b|--slurm|scenarios/(?:wear|type_test)/|studies/coach_|wrsim warm")
"""A name to be filled in, a cluster, minutes of work."""
LONG = re.compile(r"freight_long|results/freight|line/scenario.toml --set|results/line\b|-o results/my_study")
"""Outputs of runs of a minute each: of tutorials they are compared without --short alone, of others with --whole."""
LEFT_OUT_SHORT = re.compile(r"wrsim study \S+crossing_speed")
"""With --short: what prepares the scenario of another line once more, for half a minute."""
EXPECTED = {"assess": (0, 2), "diff": (0, 4)}
"""Short runs have no section to assess; two different runs differ."""
SHORT = {
    "curving": {"run.distance_m": 2, "output.patches_at_m": [1]},
    "ride": {"run.distance_m": 30, "ride.from_m": 10},
    "stability": {"stability.speed_kmh": 100, "stability.nonlinear": False},
    "static": {"static.lateral_mm": [0, 4]},
    "steady": {"steady.radius_m": 2000, "steady.speed_kmh": 80},
    "climb": {"climb.angle_of_attack_mrad": 10, "climb.Y_over_Q": 1.99},
}
"""What a scenario runs with on pages that are no tutorials, by its analysis."""
PRINTED = re.compile(r"(<!-- printed: (.+?) \| ([\d -]+?) -->\n```text\n)(.*?)(^```)", re.M | re.S)
"""What a page has of the output of a command: head, command, lines, text, end."""
PROGRESS = re.compile(r"\d+%, .* (?:left|expected)$|running$")
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]\d+)?")
FINE = {"run.distance_m": 0.2, "output.patches_at_m": []}
"""The same of scenarios with a short step of their own."""


def lines(page: Path) -> list[str]:
    """Command lines of a page, in fenced and in indented examples; explanations behind two blanks are no part."""
    text = page.read_text(encoding="utf-8")
    commands = [line for block in re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S) for line in block.splitlines()]
    commands += re.findall(r"^ {4}(wrsim .*)$", text, re.M)
    plain = [re.split(r"\s{2,}", line)[0] for line in commands]
    return [line for line in plain if line.split(" ")[0] in ("wrsim", "cp", "mkdir") and not LEFT_OUT.search(line)]


def cut(output: str, ranges: str) -> str:
    """Lines of an output, counted from 1, such as "1-5 20-24"; three points stand for what is left out."""
    rows, parts = [row for row in output.splitlines() if not PROGRESS.match(row)], list[str]()
    for first, last in (map(int, part.split("-")) for part in ranges.split()):
        parts.append("\n".join(row.rstrip() for row in rows[first - 1 : last]))
    return "\n...\n".join(parts) + "\n"


def alike(written: str, printed: str) -> bool:
    """Whether two outputs differ in nothing but the last digits of numbers: 1 %, or two units of the last digit."""
    if re.sub(r" +|-{3,}", " ", NUMBER.sub("#", written)) != re.sub(r" +|-{3,}", " ", NUMBER.sub("#", printed)):
        return False
    for number, printed_number in zip(NUMBER.findall(written), NUMBER.findall(printed), strict=True):
        unit = 10.0 ** -len(number.partition("e")[0].partition(".")[2])
        if abs(float(number) - float(printed_number)) > max(0.01 * abs(float(number)), 2.0 * unit * ("." in number)):
            return False
    return True


def ends(text: str) -> str:
    """The text of a study with the ends of its ranges alone."""
    text = re.sub(r"^values = \[([^,\]]+),.*,([^,\]]+)\]", r"values = [\1,\2]", text, flags=re.M)
    rise = re.compile(r"from = (\S+), to = (\S+), step = [^ }]+")
    return rise.sub(lambda m: f"{m[0].rpartition('step')[0]}step = {float(m[2]) - float(m[1]):g}", text)


def shortened(arguments: list[str]) -> list[str]:
    """The words of ``run FILE`` or ``compare`` with the short form of its scenario, of ``study`` with that of the
    study; searches run nothing."""
    if arguments[0] in ("optimise", "calibrate"):
        return [*arguments, "--dry-run"]
    if arguments[0] == "fmu":  # a step is tried over the whole run, and zig makes the libraries of other systems first
        option = arguments.index("--for") if "--for" in arguments else len(arguments)
        return [*arguments[:option], *arguments[option + 2 :], "--for", this_target(), "--step-ms", "1"]
    if arguments[0] == "live" and arguments[1] != "contact":
        return [*arguments, "--step-ms", "1"]
    if arguments[0] == "study":
        short = Path(arguments[1]).with_stem(f"{Path(arguments[1]).stem}_short")
        short.write_text(ends(Path(arguments[1]).read_text(encoding="utf-8")), encoding="utf-8")
        return ["study", str(short), *arguments[2:]]
    if arguments[0] not in ("run", "compare") or not Path(arguments[1]).is_file():
        return arguments
    scenario = load(arguments[1])
    values = dict(SHORT.get(scenario.analysis, {}))
    values |= FINE if scenario.analysis == "curving" and re.search(r"^step_us\b", scenario.text, re.M) else {}
    values = {key: value for key, value in values.items() if not any(word.startswith(f"{key}=") for word in arguments)}
    arguments = [*arguments, "--no-pictures"]
    if re.search(r"^time_s\b", scenario.text, re.M) and values.pop("run.distance_m", None):
        values["run.time_s"] = 0.2  # one of both is allowed
    if arguments[0] == "compare":  # has no --set
        short = Path(arguments[1]).with_stem(f"{Path(arguments[1]).stem}_short")
        short.write_text(scenario.with_values(values).text, encoding="utf-8")
        return ["compare", str(short), *arguments[2:]]
    return [*arguments, *(word for key, value in values.items() for word in ("--set", f"{key}={str(value).lower()}"))]


def main(chosen: list[str]) -> int:
    """Execute the pages; returns the number of faults."""
    if "--help" in chosen:
        print(__doc__)
        return 0
    names = [name for name in chosen if not name.startswith("--")]
    pages = [page for page in sorted(PAGES, key=_place) if not names or page.stem in names]
    if "--short" not in chosen:
        write = "--write" in chosen
        return faults_of(pages, short=False, whole=write or "--whole" in chosen, write=write)
    first = [page for page in pages if page.stem in set(FIRST) - ALONE or uses_others(page)]
    shares = (first, [page for page in pages if page not in first])
    with ProcessPoolExecutor(2) as pool:
        faults = sum(pool.map(partial(faults_of, short=True), shares))
    print(f"guide: {faults} lines with faults")
    return faults


def uses_others(page: Path) -> bool:
    """Whether a page reads results that it does not make."""
    made = set[str]()
    for line in lines(page):
        arguments = line.split()
        if arguments[:2] == ["wrsim", "run"] and "-o" not in arguments:
            made.add(f"results/{Path(arguments[2]).stem}")
        made |= {arguments[k + 1] for k, word in enumerate(arguments[:-1]) if word == "-o"}
        if not made.issuperset(re.findall(r"results/\w+", line)):
            return True
    return False


def faults_of(pages: list[Path], short: bool, whole: bool = False, write: bool = False) -> int:
    """Execute pages in a folder of their own; returns the number of faults. whole: all of them as they are; write: what
    they print into them."""
    faults, done = 0, set[str]()
    shown = {block[2] for page in PAGES for block in PRINTED.finditer(page.read_text(encoding="utf-8"))}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("scenarios", "models"):
            shutil.copytree(ROOT / name, Path(folder) / name)
        for page in pages:
            for line in lines(page):
                if line in done or (short and LEFT_OUT_SHORT.search(line)):  # done: on an earlier page
                    continue
                done.add(line)
                begin = time.perf_counter()
                brief = LONG.search(line) and (short or page.stem not in FIRST)
                as_is = whole or (not brief and (page.stem in FIRST or line in shown))
                code, output = executed(line, Path(folder), as_is, page.stem in FIRST)
                arguments = shlex.split(line)
                good = code in EXPECTED.get(arguments[1], (0,)) if arguments[0] == "wrsim" else code == 0
                faults += not good
                word = "ok" if good else f"exit code {code}"
                print(f"{word:6} {time.perf_counter() - begin:5.1f} s  {page.stem}: {line}", flush=True)
                if not good:
                    print(output[-2000:])
                elif as_is:
                    faults += sum(not has_printed(each, line, output, write) for each in PAGES)
    return faults


def has_printed(page: Path, line: str, output: str, write: bool) -> bool:
    """Whether what a page has of the output of a line is what it prints; write: put it there."""
    text = page.read_text(encoding="utf-8")
    for match in PRINTED.finditer(text):
        if match[2] != line:
            continue
        printed = cut(output, match[3])
        if write:
            page.write_text(text.replace(match[0], match[1] + printed + match[5]), encoding="utf-8")
        elif not alike(match[4], printed):
            print(f"the page {page.stem} has another output of: {line}\n{printed}")
            return False
    return True


def _place(page: Path) -> tuple[int, str]:
    return (FIRST.index(page.stem) if page.stem in FIRST else len(FIRST), page.stem)


def executed(line: str, folder: Path, as_is: bool, tutorial: bool = True) -> tuple[int, str]:
    """Exit code and output of a line in a folder; as_is: not in its short form. Studies of tutorials run in any."""
    arguments = shlex.split(line)
    if arguments[:2] == ["wrsim", "study"] and not (as_is or tutorial) and "--dry-run" not in arguments:
        arguments.append("--dry-run")
    if arguments[0] != "wrsim":
        done = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr
    with contextlib.chdir(folder):
        brief = arguments[1:] if as_is else shortened(arguments[1:])
        answer = CliRunner().invoke(app, brief, env={"COLUMNS": "120"})
    return answer.exit_code, answer.output


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
