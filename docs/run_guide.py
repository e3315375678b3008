"""Executes the commands of the user guide, page by page, in one folder.

    python docs/run_guide.py [--short] [PAGE ...]

Lines that call ``wrsim``, ``cp`` or ``mkdir`` count, but those with a word in capitals, which stands for a name, and
those of LEFT_OUT. Tutorials run as they are, unless --short is given (that of a study always); scenarios of other pages
run in a short form. A line that ends with another exit code than 0, or than those of EXPECTED, is an error.
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
from pathlib import Path

from typer.testing import CliRunner

from wrsim import load
from wrsim.cli import app

ROOT = Path(__file__).parents[1]
FIRST = ["first_hour", "own_vehicle", "own_track", "own_profile", "acceptance", "own_study"]
"""Tutorials, in their order."""
LEFT_OUT = re.compile(r"\b[A-Z]{3,}\b|--slurm|scenarios/wear/|studies/coach_|wrsim warm")
"""A name to be filled in, a cluster, minutes of work."""
EXPECTED = {"assess": (0, 2), "diff": (0, 4)}
"""Short runs have no section to assess; two different runs differ."""
SHORT = {
    "curving": {"run.distance_m": 2, "output.patches_at_m": [1]},
    "ride": {"run.distance_m": 30, "ride.from_m": 10},
    "stability": {"stability.speed_kmh": 100, "stability.nonlinear": False},
    "steady": {"steady.radius_m": 2000, "steady.speed_kmh": 80},
    "climb": {"climb.angle_of_attack_mrad": 10, "climb.Y_over_Q": 1.99},
}
"""What a scenario runs with on pages that are no tutorials, by its analysis."""


def lines(page: Path) -> list[str]:
    """Command lines of a page, in fenced and in indented examples; explanations behind two blanks are no part."""
    text = page.read_text(encoding="utf-8")
    found = [line for block in re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S) for line in block.splitlines()]
    found += re.findall(r"^ {4}(wrsim .*)$", text, re.M)
    plain = [re.split(r"\s{2,}", line)[0] for line in found]
    return [line for line in plain if line.split(" ")[0] in ("wrsim", "cp", "mkdir") and not LEFT_OUT.search(line)]


def shortened(words: list[str]) -> list[str]:
    """The words of ``run FILE`` or ``compare`` with the short form of its scenario, of ``plot`` with a place in it."""
    if words[0] == "plot" and "--at" in words:
        return [*words[: words.index("--at")], "--at", "1", *words[words.index("--at") + 2 :]]
    if words[0] not in ("run", "compare") or not Path(words[1]).is_file():
        return words
    scenario = load(words[1])
    values = dict(SHORT.get(scenario.analysis, {}))
    if re.search(r"^time_s\b", scenario.text, re.M) and values.pop("run.distance_m", None):
        values["run.time_s"] = 0.2  # one of both is allowed
    if words[0] == "compare":  # has no --set
        short = Path(words[1]).with_stem(f"{Path(words[1]).stem}_short")
        short.write_text(scenario.with_values(values).text, encoding="utf-8")
        return ["compare", str(short), *words[2:]]
    return [*words, *(word for key, value in values.items() for word in ("--set", f"{key}={value}".lower()))]


def main(chosen: list[str]) -> int:
    """Execute the pages; returns the number of faults."""
    pages = sorted((ROOT / "docs" / "user").glob("*.md"), key=lambda p: (p.stem not in FIRST, *_place(p)))
    whole = FIRST if "--short" not in chosen else ["own_study"]  # its report needs all cases
    chosen = [name for name in chosen if name != "--short"]
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in ("scenarios", "models"):
            shutil.copytree(ROOT / name, Path(folder) / name)
        for page in (page for page in pages if not chosen or page.stem in chosen):
            for line in lines(page):
                begin = time.perf_counter()
                code, output = executed(line, Path(folder), page.stem in whole)
                words = shlex.split(line)
                good = code in EXPECTED.get(words[1], (0,)) if words[0] == "wrsim" else code == 0
                faults += not good
                word = "ok" if good else f"exit code {code}"
                print(f"{word:6} {time.perf_counter() - begin:5.1f} s  {page.stem}: {line}", flush=True)
                if not good:
                    print(output[-2000:])
    return faults


def _place(page: Path) -> tuple[int, str]:
    return (FIRST.index(page.stem) if page.stem in FIRST else 0, page.stem)


def executed(line: str, folder: Path, whole: bool) -> tuple[int, str]:
    """Exit code and output of a line in a folder; whole: not in the short form."""
    words = shlex.split(line)
    if words[:2] == ["wrsim", "study"] and not whole and "--dry-run" not in words:
        words.append("--dry-run")
    if words[0] != "wrsim":
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr
    with contextlib.chdir(folder):
        answer = CliRunner().invoke(app, words[1:] if whole else shortened(words[1:]), env={"COLUMNS": "120"})
    return answer.exit_code, answer.output


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) > 0)
