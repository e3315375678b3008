"""Do the tests notice a fault in the code? Mutants of it, one operator changed in each, and who survives them.

    python campaigns/mutants.py PACKAGE ... [--number 100] [--seed 1] [--folder build/mutants] -- TEST_FILE ...

PACKAGE is a folder of modules or one module, as wrsim/contact. Works with cosmic-ray (extra ``campaign``) in a copy of
the sources, so run it from their root. First all mutants are tried without the compiler, each in a fork of one process
that has imported all but our own modules, then those that survive with compiled kernels; kernels that cannot hold the
changed code come from a cache. Prints each mutant by its number in the draw with what kills it, survivors as
differences; ``--only NUMBER ...`` tries these again.

Tests run until one fails: those that call the changed function (`campaigns.calls`, once for each test file, kept in
build/calls), one of each test function before its other parameters, quick ones first, as many as take LONG.
"""

import argparse
import ast
import difflib
import hashlib
import importlib
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

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


class Mutant(NamedTuple):
    """An operator at one of its places in a file, and the outermost function around it ("" if there is none)."""

    file: Path
    function: str
    operator: str
    occurrence: int


def mutants_of(file: Path, factors: bool = False) -> list[Mutant]:
    """Each operator at each of its places in a file, or wrong signs and factors alone."""
    nodes = list(ast_nodes(get_ast(file.read_text(encoding="utf-8"))))
    mutants = []
    for name, operator in OPERATORS.items():
        owners = [node for node in nodes for _ in operator.mutation_positions(node)]
        chosen = ((i, node) for i, node in enumerate(owners) if not factors or is_factor(name, node))
        mutants += [Mutant(file, function_around(node), name, i) for i, node in chosen]
    return mutants


def function_around(node: Any) -> str:
    """Qualified name of the outermost function."""
    names: list[str] = []
    while node := node.parent:
        if node.type == "funcdef":
            names = [node.name.value]
        elif node.type == "classdef" and names:
            names.insert(0, node.name.value)
    return ".".join(names)


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
            module_names = [n for n, m in sys.modules.items() if "site-packages" in (getattr(m, "__file__", "") or "")]
            modules.write_text("\n".join(n for n in module_names if not OWN.match(n)))
        os._exit(int(code))
    _, status = os.waitpid(child, 0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return status == 0, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@cache
def imports() -> dict[Path, set[Path]]:
    """Modules of ours that each of them imports from."""
    return {file: set(imported(file)) for file in Path("wrsim").rglob("*.py")}


def imported(file: Path) -> Iterator[Path]:
    """Modules of ours that a module imports from."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            for name in (node.module, *(f"{node.module}.{each.name}" for each in node.names)):
                yield Path(name.replace(".", "/")).with_suffix(".py")


def users(changed: Path) -> set[Path]:
    """A module and all that import it, directly or not: their kernels may hold its code."""
    users_found = {changed}
    while more := {file for file, imported in imports().items() if imported & users_found} - users_found:
        users_found |= more
    return users_found


PATIENCE = 900  # processor time with the compiler [s]


def run_compiled(command: list[str], changed: Path | None = None, **variables: str) -> bool:
    """Whether a command ends well with compiled kernels; those that cannot hold code of a changed module are taken
    from the cache, which commands without one fill."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"} | variables
    cache, limit = Path("cache"), resource.RLIM_INFINITY
    if changed is not None:
        shutil.copytree(cache, cache := Path("own_cache"))
        limit = PATIENCE
        kept = {(f.parent.name, f.stem) for f in set(Path("wrsim/jit").rglob("*.py")) - users(changed)}
        for file in cache.rglob("*.nb?"):
            if (file.parent.name.rpartition("_")[0], file.name.split(".")[0]) not in kept:
                file.unlink()
    environment["NUMBA_CACHE_DIR"] = str(cache.resolve())
    bound = partial(resource.setrlimit, resource.RLIMIT_CPU, (limit, limit))
    with open("output", "w", encoding="utf-8") as output:
        done = subprocess.run(command, env=environment, stdout=output, stderr=output, check=False, preexec_fn=bound)
    shutil.rmtree("own_cache", ignore_errors=True)
    return done.returncode == 0


LONG = 60.0
"""Tests of a mutant, without the compiler and again with it [s]."""
PYTEST = ["-q", "-p", "no:cacheprovider"]


class Tests:
    """Tests that call what is changed look at mutants."""

    longest = MappingProxyType({"plain": 1.2, "compiled": 20.0})  # test [s]

    def __init__(self, files: list[str], kept: Path) -> None:
        self.files, self.kept = files, kept.resolve()
        self.seconds: dict[str, dict[str, float]] = {form: {} for form in self.longest}
        self.calls: dict[str, set[str]] = {}

    def everything(self) -> int:
        """Imports what `quick` does."""
        return int(pytest.main([*PYTEST, "--collect-only", *self.files]))

    def ready(self) -> bool:
        """Notes what tests call and take; those that fail where nothing is changed are not asked."""
        self.kept.mkdir(parents=True, exist_ok=True)
        run_compiled([sys.executable, "tests/support/kernels.py"], PYTHONPATH=f"tests:{os.environ['PYTHONPATH']}")
        for form in self.longest:
            for file in self.files:
                record = self.kept / f"{hashlib.sha1(Path(file).read_bytes()).hexdigest()[:12]}.{form}.json"
                if not record.exists():
                    environment = {"CALLS": str(record), "PATIENCE": str(self.longest[form])}
                    environment |= {"NUMBA_DISABLE_JIT": "1"} if form == "plain" else {}
                    run_compiled(
                        [sys.executable, "-m", "pytest", *PYTEST, "-p", "campaigns.calls", file], **environment
                    )
                for test, (passed, seconds, calls) in json.loads(record.read_text()).items():
                    self.calls.setdefault(test, set()).update(calls)
                    if passed:
                        self.seconds[form][test] = seconds
        return bool(self.calls)

    def chosen(self, mutant: Mutant, form: str, done: Collection[str] = ()) -> dict[str, float]:
        """Tests with their times [s]: of the function, then of its module and modules that import it."""
        near = {str(file) for file, imported in imports().items() if mutant.file in imported} | {str(mutant.file)}
        reach = {test for test, calls in self.calls.items() if near & {call.split(":")[0] for call in calls}}
        exact = {test for test in reach if f"{mutant.file}:{mutant.function}" in self.calls[test]}
        if form == "plain" and exact:
            reach = exact
        turns: Counter[tuple[bool, str]] = Counter()
        order = []
        for test in sorted(reach & self.seconds[form].keys() - set(done), key=self.seconds[form].__getitem__):
            turns[family := (test not in exact, test.split("[")[0])] += 1
            order.append((test not in exact, turns[family], self.seconds[form][test], test))
        order_chosen: dict[str, float] = {}
        for *_, seconds, test in sorted(order):
            if sum(order_chosen.values()) + seconds <= LONG:
                order_chosen[test] = seconds
        return order_chosen

    def quick(self, mutant: Mutant) -> tuple[Check, float] | None:
        """What to try without the compiler, and its usual time [s]."""
        tests = self.chosen(mutant, "plain")
        return (partial(pytest.main, [*PYTEST, "-x", *tests]), sum(tests.values())) if tests else None

    def slow(self, mutant: Mutant) -> list[str] | None:
        """The command to try with compiled kernels."""
        tests = self.chosen(mutant, "compiled", self.chosen(mutant, "plain"))
        return [sys.executable, "-m", "pytest", *PYTEST, "-x", *tests] if tests else None


def survives(mutant: Mutant, judge: Tests, slowly: bool) -> tuple[bool, list[str]]:
    """Whether nobody notices it, and its difference or what does."""
    file, code, times = mutant.file, mutant.file.read_text(), mutant.file.stat()
    changed = mutate_code(code, OPERATORS[mutant.operator], mutant.occurrence)
    file.write_text(changed)  # its time is new: Python takes no compiled file of the old one
    try:
        if slowly:
            alive = not (command := judge.slow(mutant)) or run_compiled(command, file)
        else:
            quick = judge.quick(mutant)
            alive = not quick or run_tests(quick[0], 20 + int(10 * quick[1]))[0]
    finally:
        file.write_text(code)
        os.utime(file, (times.st_atime, times.st_mtime))
    if alive:
        name = mutant.operator
        return True, list(difflib.unified_diff(code.split("\n"), changed.split("\n"), str(file), name, lineterm=""))
    lines = Path("output").read_text(encoding="utf-8", errors="replace").splitlines()
    return False, [line for line in lines if line.startswith(("red", "FAILED", "ERROR"))][:1] or ["stopped"]


def main() -> None:
    """Make, try and count them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packages", type=Path, nargs="+", metavar="PACKAGE")
    parser.add_argument("--number", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="+")
    parser.add_argument("--folder", type=Path, default=Path("build/mutants"))
    cut = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    options, tests = parser.parse_args(sys.argv[1:cut]), sys.argv[cut + 1 :]
    if not tests:
        parser.error("give tests behind --")
    judge = Tests(tests, Path("build/calls"))
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    shutil.rmtree(options.folder, ignore_errors=True)
    place = options.folder.resolve() / "sources"
    place.mkdir(parents=True)
    for name in ("wrsim", "tests", "models", "scenarios", "campaigns", "docs"):
        shutil.copytree(name, place / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy("pyproject.toml", place)
    os.chdir(place)
    sys.path.insert(0, str(place))
    os.environ["PYTHONPATH"] = os.pathsep.join([str(place), os.environ.get("PYTHONPATH", "")])
    first, _ = run_tests(judge.everything, 3600, place / "modules")
    for name in (place / "modules").read_text().split() if first else ():
        with suppress(ImportError):
            importlib.import_module(name)
    if not (first and judge.ready()):
        sys.exit(f"the tests must pass where nothing is changed: see {place / 'output'}")
    files = [f for each in options.packages for f in ([each] if each.is_file() else sorted(each.rglob("*.py")))]
    every = [mutant for file in files for mutant in mutants_of(file)]
    drawn = dict(enumerate(random.Random(options.seed).sample(every, min(options.number, len(every)))))
    alive = {i: drawn[i] for i in options.only or drawn}
    tried = len(alive)
    try:
        for slowly in (False, True):
            for i, mutant in list(alive.items()):
                survived, why = survives(mutant, judge, slowly)
                if not survived:
                    del alive[i]
                print(f"{i} {mutant.file}:{mutant.function}", "survives" if survived else "dies",
                      "compiled" if slowly else "plain", *why, sep="\n" if survived else " ", flush=True)  # fmt: skip
    except KeyboardInterrupt:
        print("interrupted; so far:")
    print(f"{tried} mutants of {len(every)}, {tried - len(alive)} killed; survivors: {' '.join(map(str, alive))}")


if __name__ == "__main__":
    main()
