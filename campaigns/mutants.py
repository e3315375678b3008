"""Do the tests notice a fault in the code? Mutants of it, one operator changed in each, and who survives them.

    python campaigns/mutants.py PACKAGE [--number 100] [--seed 1] [--folder build/mutants] -- TEST ...

PACKAGE is a folder of modules, as wrsim/contact; the tests run until one fails. Works with cosmic-ray (extra
``campaign``) in a copy of the sources, so run it from their root. Kernels compile anew for every mutant of wrsim/core:
for these set NUMBA_DISABLE_JIT=1 and take tests that are quick without the compiler. Prints survivors as differences.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

LIKELY = re.compile(
    "NumberReplacer|AddNot|Mul_Div|Div_Mul|Add_Sub|Sub_Add|Delete_|TrueWithFalse|FalseWithTrue|AndWithOr|OrWithAnd|"
    "Comparison.*_(Eq_NotEq|NotEq_Eq|Lt_LtE|LtE_Lt|Gt_GtE|GtE_Gt|Lt_Gt|Gt_Lt)$|ZeroIteration|BreakWith|ContinueWith"
)
"""Operators that stand for slips of a hand; those of unions in annotations would change nothing."""
CONFIG = """[cosmic-ray]
module-path = "{package}"
timeout = 900.0
excluded-modules = []
test-command = "{command}"
[cosmic-ray.distributor]
name = "local"
"""


def main() -> None:
    """Make, try and count them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package")
    parser.add_argument("--number", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("build/mutants"))
    parser.add_argument("tests", nargs="+")
    options = parser.parse_args()
    place = options.folder.resolve()
    shutil.rmtree(place, ignore_errors=True)
    for name in ("wrsim", "tests", "models", "scenarios", "campaigns", "docs"):
        shutil.copytree(name, place / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy("pyproject.toml", place)
    tests = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *options.tests]
    (place / "config.toml").write_text(CONFIG.format(package=options.package, command=" ".join(tests)))

    def run(words: list[str]) -> None:
        paths = os.pathsep.join([str(place), os.environ.get("PYTHONPATH", "")])
        subprocess.run(words, cwd=place, env=os.environ | {"PYTHONPATH": paths}, check=True)

    def cosmic_ray(command: str) -> None:
        run([sys.executable, "-m", "cosmic_ray.cli", command, "config.toml", "session"])

    run(tests)  # they must pass where nothing is changed
    cosmic_ray("init")
    with closing(sqlite3.connect(place / "session")) as session:
        every = session.execute("SELECT job_id, operator_name FROM mutation_specs ORDER BY module_path, start_pos_row")
        likely = [job for job, operator in every if LIKELY.search(operator)]
        kept = random.Random(options.seed).sample(likely, min(options.number, len(likely)))
        for table in ("mutation_specs", "work_items"):
            marks = ",".join("?" * len(kept))
            session.execute(f"DELETE FROM {table} WHERE job_id NOT IN ({marks})", kept)
        session.commit()
    try:
        cosmic_ray("exec")
    except KeyboardInterrupt:
        print("interrupted; so far:")
    with closing(sqlite3.connect(place / "session")) as session:
        found = session.execute("SELECT test_outcome, diff FROM work_results").fetchall()
    survivors = [diff for outcome, diff in found if outcome == "SURVIVED"]
    print("\n".join(survivors))
    print(f"{len(found)} mutants of {len(likely)}, {len(found) - len(survivors)} killed")


if __name__ == "__main__":
    main()
