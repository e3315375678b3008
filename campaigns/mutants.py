"""Do the tests notice a fault in the code? Mutants of it, one operator changed in each, and who survives them.

    python campaigns/mutants.py PACKAGE [--number 100] [--seed 1] [--folder build/mutants] -- TEST ...
    python campaigns/mutants.py PACKAGE --yardstick REFERENCE [--number 50] ...

PACKAGE is a folder of modules or one module, as wrsim/contact; the tests run until one fails. Works with cosmic-ray
(extra ``campaign``) in a copy of the sources, so run it from their root. Each mutant is a fork of one process that has
imported all but our own modules. Kernels compile anew for every mutant of wrsim/core: for these set NUMBA_DISABLE_JIT=1
and take tests that are quick without the compiler. Prints survivors as differences.

--yardstick: signs, operators and factors (numbers with a point) change, and the short form of campaigns/benchmark runs
until its first red comparison: quick ones without the compiler, then the others with compiled kernels. The caches of
kernels in wrsim/core/jit are left out, not its splines.
"""

import argparse
import ast
import difflib
import importlib
import os
import random
import re
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

LIKELY = re.compile(
    "NumberReplacer|AddNot|Mul_Div|Div_Mul|Add_Sub|Sub_Add|Delete_|TrueWithFalse|FalseWithTrue|AndWithOr|OrWithAnd|"
    "Comparison.*_(Eq_NotEq|NotEq_Eq|Lt_LtE|LtE_Lt|Gt_GtE|GtE_Gt|Lt_Gt|Gt_Lt)$|ZeroIteration|BreakWith|ContinueWith"
)
"""Operators that stand for slips of a hand; those of unions in annotations would change nothing."""
OPERATORS = {name: get_operator(name)() for name in operator_names() if LIKELY.search(name)}
SIGNS = re.compile("(Mul_Div|Div_Mul|Add_Sub|Sub_Add|Delete_USub)$")
"""Those that stand for a wrong sign or a factor in the wrong place."""
OWN = re.compile("wrsim|support|conftest|_?pytest|_?hypothesis|xdist")
"""What each fork imports for itself: ours, and what pytest must rewrite."""


def mutants_of(file: Path, factors: bool = False) -> list[tuple[Path, str, int]]:
    """Each operator at each of its places in a file, or wrong signs and factors alone."""
    nodes = list(ast_nodes(get_ast(file.read_text())))
    found = []
    for name, what in OPERATORS.items():
        owners = [node for node in nodes for _ in what.mutation_positions(node)]
        found += [(file, name, i) for i, node in enumerate(owners) if not factors or is_factor(name, node)]
    return found


def is_factor(name: str, node: Any) -> bool:
    """Whether an operator at a node makes a wrong sign or a wrong factor; numbers are factors within products."""
    return bool(SIGNS.search(name)) or (name.endswith("NumberReplacer") and node.parent.type == "term")


def no_kernels(file: Path) -> bool:
    """Whether a file holds the machinery of compiled kernels."""
    return file.parent.name == "jit" and file.name != "spline.py"


Check = Callable[[], int]
"""Gives 0 where all is well."""


def run_tests(check: Check, cpu_seconds: int, modules: Path | None = None) -> tuple[bool, float]:
    """Whether they pass in a fork that may take so long, and how long it took; notes imported modules in a file."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    if (child := os.fork()) == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds))
        os.dup2(os.open("output", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 1)
        sys.dont_write_bytecode = modules is None
        try:
            code = check()
        except Exception as problem:
            print(f"{type(problem).__name__}: {problem}")
            code = 1
        sys.stdout.flush()
        if modules is not None:
            others = [n for n, m in sys.modules.items() if "site-packages" in (getattr(m, "__file__", "") or "")]
            modules.write_text("\n".join(n for n in others if not OWN.match(n)))
        os._exit(int(code))
    _, status = os.waitpid(child, 0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return status == 0, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


QUICKLY = ["--short", "--first-red", "--jobs", "1"]
QUICK = 8.0  # cost of comparisons that run without the compiler [s]
PATIENCE = 900.0  # for all of them with the compiler [s]


def measured(reference: Path) -> int:
    """What the quick comparisons end with."""
    from campaigns.benchmark.__main__ import main

    return main([str(reference), *QUICKLY, "--cost", "0", str(QUICK)])


def users(changed: Path) -> set[Path]:
    """A module and all that import it, directly or not: their kernels may hold its code."""
    found, modules = {changed}, list(Path("wrsim").rglob("*.py"))
    imports = {file: set(imported(file)) for file in modules}
    while more := {file for file in modules if imports[file] & found} - found:
        found |= more
    return found


def imported(file: Path) -> Iterator[Path]:
    """Modules of ours that a module imports from."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            for name in (node.module, *(f"{node.module}.{each.name}" for each in node.names)):
                yield Path(name.replace(".", "/")).with_suffix(".py")


def compiled(reference: Path, changed: Path | None = None) -> bool:
    """Whether the others stay green with compiled kernels; those that cannot hold code of a changed module are taken
    from the cache of the first call."""
    command = [sys.executable, "-m", "campaigns.benchmark", str(reference), *QUICKLY, "--cost", str(QUICK), "inf"]
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
    cache = Path("cache")
    if changed is not None:
        shutil.copytree(cache, cache := Path("own_cache"))
        kept = {(f.parent.name, f.stem) for f in set(Path("wrsim/core").rglob("*.py")) - users(changed)}
        for file in cache.rglob("*.nb?"):
            if (file.parent.name.rpartition("_")[0], file.name.split(".")[0]) not in kept:
                file.unlink()
    environment["NUMBA_CACHE_DIR"] = str(cache.resolve())
    with open("output", "w") as output:
        told = {"stdout": output, "stderr": output}
        try:
            return subprocess.run(command, env=environment, timeout=PATIENCE, check=False, **told).returncode == 0
        except subprocess.TimeoutExpired:
            return False
        finally:
            shutil.rmtree("own_cache", ignore_errors=True)


def main() -> None:
    """Make, try and count them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=Path)
    parser.add_argument("--number", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("build/mutants"))
    parser.add_argument("--yardstick", type=Path, metavar="REFERENCE")
    parser.add_argument("tests", nargs="*")
    options = parser.parse_args()
    if bool(options.tests) == bool(options.yardstick):
        parser.error("give tests, or --yardstick REFERENCE")
    check = partial(pytest.main, ["-x", "-q", "-p", "no:cacheprovider", *options.tests])
    if options.yardstick:
        options.yardstick = options.yardstick.resolve()
        check = partial(measured, options.yardstick)
        os.environ["NUMBA_DISABLE_JIT"] = "1"
    place = options.folder.resolve()
    shutil.rmtree(place, ignore_errors=True)
    for name in ("wrsim", "tests", "models", "scenarios", "campaigns", "docs"):
        shutil.copytree(name, place / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy("pyproject.toml", place)
    os.chdir(place)
    sys.path.insert(0, str(place))
    os.environ["PYTHONPATH"] = os.pathsep.join([str(place), os.environ.get("PYTHONPATH", "")])
    first, spent = run_tests(check, 3600, place / "modules")
    for name in (place / "modules").read_text().split() if first else ():
        with suppress(ImportError):
            importlib.import_module(name)
    again, usual = (first, spent) if options.yardstick else run_tests(check, 3600)
    if not (first and again and (not options.yardstick or compiled(options.yardstick))):
        sys.exit(f"the tests must pass where nothing is changed: see {place / 'output'}")
    files = [options.package] if options.package.is_file() else sorted(options.package.rglob("*.py"))
    chosen = [file for file in files if not (options.yardstick and no_kernels(file))]
    every = [mutant for file in chosen for mutant in mutants_of(file, bool(options.yardstick))]
    kept = random.Random(options.seed).sample(every, min(options.number, len(every)))
    survivors = done = 0
    try:
        for file, name, occurrence in kept:
            code, times = file.read_text(), file.stat()
            mutant = mutate_code(code, OPERATORS[name], occurrence)
            file.write_text(mutant)  # its time is new: Python takes no compiled file of the old one
            survived = slow = bool(options.yardstick) and "body" in file.parts  # without the compiler
            if not slow:
                survived, _ = run_tests(check, 10 + int((3 if options.yardstick else 10) * usual))
            if survived and options.yardstick:
                survived = compiled(options.yardstick, file)
            file.write_text(code)
            os.utime(file, (times.st_atime, times.st_mtime))
            done += 1
            if survived:
                survivors += 1
                lines = difflib.unified_diff(code.split("\n"), mutant.split("\n"), str(file), name, lineterm="")
                print("\n".join(lines), flush=True)
            elif options.yardstick:
                red = [line for line in Path("output").read_text().splitlines() if line.startswith("red")]
                print(f"{file} {name} {occurrence}: {red[0] if red else 'stopped'}", flush=True)
    except KeyboardInterrupt:
        print("interrupted; so far:")
    print(f"{done} mutants of {len(every)}, {done - survivors} killed")


if __name__ == "__main__":
    main()
