"""Does the yardstick notice a wrong sign or factor in a kernel? Many of them in one build, switched in forks.

    python campaigns/yardstick_mutants.py REFERENCE [--number 50] [--seed 1] [--folder build/yardstick_mutants]
        [--only NUMBER ...] [--comparisons NAME ...]

Draws mutants of signs, operators and factors of `wrsim/jit` (`campaigns.mutants`), writes them all into a copy of the
sources as ``changed if which(number) == 1 else original``, compiles that once and runs the short form of the benchmark,
which must be green. Then, in the order of the draw, until ``number`` mutants have counted: a fork runs the short form
until its first red comparison, cheap ones first, and if none is, another one asks whether the mutant is equivalent
(docs/developers/yardstick.md), which does not count. A quotient of whole numbers in the place of their product, which
may be an index, is rounded down. A mutant that changes a constant of a module or what writes kernels has no switch and
is passed over. Needs a C compiler (cc). A fork that is stopped, also by its time, counts as red, and as not equivalent.
"""

import argparse
import ast
import ctypes
import os
import random
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

os.environ["NUMBA_DISABLE_JIT"] = "0"
ROOT = Path(__file__).parents[1]
PATIENCE = 150  # processor time of a mutant [s]
SPARE = 2  # mutants are drawn for each that is asked
ANSWERS = 60  # poses of each contact
RUNS = {
    "bridge": (25.0, 1250), "freight_r300": (6.0, 2000), "curve_r300": (60.0, 1500), "flat_on_sleepers": (1.5, 50),
    "crossing": (1.5, 100),
}  # fmt: skip
"""Scenarios: how far they run [m], with which step [us]."""
FINER = 0.98  # of the time step: what that changes, and one strip more, is no change
LIMITS = 1e-4, 1e-2  # held between these
C_CODE = """static long at = -1, met = 0;
long wrsim_mutant(long number) { if (number != at) return 0; met++; return 1; }
void wrsim_set(long to) { at = to; met = 0; }
long wrsim_met(void) { return met; }
"""
WHICH = '''"""Which mutant is at work."""
import operator

import llvmlite.binding
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

llvmlite.binding.load_library_permanently({library!r})


@intrinsic
def which(context, number):
    def code(context, builder, signature, arguments):
        known = builder.module.globals.get("wrsim_mutant")
        kind = ir.FunctionType(ir.IntType(64), [ir.IntType(64)])
        return builder.call(known or ir.Function(builder.module, kind, "wrsim_mutant"), arguments)

    return types.int64(types.int64), code


@intrinsic
def quotient(context, a, b):
    whole = isinstance(a, types.Integer) and isinstance(b, types.Integer)
    divide = operator.floordiv if whole else operator.truediv
    signature = context.resolve_function_type(divide, (types.unliteral(a), types.unliteral(b)), {{}})

    def code(context, builder, own, arguments):
        pairs = zip(arguments, own.args, signature.args)
        return context.get_function(divide, signature)(builder, [context.cast(builder, *pair) for pair in pairs])

    return signature.return_type(a, b), code
'''
Place = tuple[str, int, int, int | None, int | None]


def place(node: ast.AST) -> Place:
    """What an expression is and where."""
    numbers = (getattr(node, name, 0) for name in ("lineno", "col_offset", "end_lineno", "end_col_offset"))
    return (type(node).__name__, *numbers)  # type: ignore[return-value]


def difference(before: ast.AST, after: ast.AST) -> tuple[ast.AST, ast.AST]:
    """The smallest pair of nodes that holds all that differs between two trees."""
    pairs = []
    for name, value in ast.iter_fields(before) if type(before) is type(after) else ():
        beside = getattr(after, name)
        values, besides = (value, beside) if isinstance(value, list) else ([value], [beside])
        if len(values) != len(besides):
            return before, after
        for a, b in zip(values, besides, strict=True):
            if not isinstance(a, ast.AST):
                if a != b:
                    return before, after
            elif ast.dump(a) != ast.dump(b):
                pairs.append((a, b))
    if len(pairs) != 1:
        return before, after
    inner = difference(*pairs[0])
    return (before, after) if isinstance(inner[0], ast.operator | ast.unaryop) else inner


class Switches(ast.NodeTransformer):
    """Puts mutants beside the expressions that they change."""

    def __init__(self, mutants: dict[Place, tuple[int, ast.expr]]) -> None:
        self.mutants = mutants

    def visit(self, node: ast.AST) -> ast.AST:
        place_of_node = place(node)
        self.generic_visit(node)
        if place_of_node not in self.mutants or not isinstance(node, ast.expr):
            return node
        number, changed = self.mutants.pop(place_of_node)
        if isinstance(changed, ast.BinOp) and isinstance(changed.op, ast.Div):
            changed = ast.Call(ast.Name("quotient", ast.Load()), [changed.left, changed.right], [])
        call = ast.Call(ast.Name("which", ast.Load()), [ast.Constant(number)], [])
        asked = ast.Compare(call, [ast.Eq()], [ast.Constant(1)])
        return ast.IfExp(asked, changed, node)


def build(folder: Path, number: int, seed: int) -> dict[int, str]:
    """A copy of the sources with a switch for each mutant of the draw; the mutants in words."""
    from cosmic_ray.mutating import mutate_code

    from campaigns.mutants import OPERATORS, mutants_of, no_kernels

    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in ("wrsim", "models", "scenarios", "campaigns", "docs", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "w.c").write_text(C_CODE)
    library = str(folder / "libw.so")
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", library, str(folder / "w.c")], check=True)
    (folder / "wrsim/jit/which.py").write_text(WHICH.format(library=library))
    os.chdir(folder)
    every = [m for f in sorted(Path("wrsim/jit").rglob("*.py")) if not no_kernels(f) and f.name != "which.py"
             for m in mutants_of(f, factors=True)]  # fmt: skip
    descriptions: dict[int, str] = {}
    of_files: dict[Path, dict[Place, tuple[int, ast.expr]]] = {}
    random.Random(seed).shuffle(every)
    for i, mutant in enumerate(every[:number]):
        code = mutant.file.read_text()
        old, new = difference(*map(ast.parse, (code, mutate_code(code, OPERATORS[mutant.operator], mutant.occurrence))))
        descriptions[i] = f"{mutant.file}:{mutant.function} {ast.unparse(old)} -> {ast.unparse(new)}"
        switch = mutant.function and mutant.file.parent.name != "jit"
        if not switch or not isinstance(old, ast.expr) or not isinstance(new, ast.expr):
            descriptions[i] += " (no switch)"
        else:
            of_files.setdefault(mutant.file, {})[place(old)] = i, new
    for file, mutants in of_files.items():
        tree = Switches(mutants).visit(ast.parse(file.read_text()))
        first = next(i for i, node in enumerate(tree.body) if isinstance(node, ast.ImportFrom | ast.Import))
        tree.body.insert(first, ast.parse("from wrsim.jit.which import quotient, which").body[0])
        file.write_text(ast.unparse(ast.fix_missing_locations(tree)))
        for number, _ in mutants.values():
            descriptions[number] += " (no switch)"
    return descriptions


def first_red(reference: Path, names: Sequence[str], warm: bool = False) -> str:
    """The first red comparison of the short form, or of those named, with its errors; empty where all are green."""
    from campaigns.benchmark.__main__ import code_of, comparisons
    from campaigns.benchmark.comparison import run_comparison

    code = code_of("wrsim", reference)
    for name, comparison in comparisons(names).items():
        if not comparison.short:
            continue
        verdict = run_comparison(name, comparison, code, True)
        if verdict.word == "red":
            beyond = [
                f"{outcome.quantity} {', '.join(outcome.beyond)}"
                for outcome in verdict.outcomes
                if outcome.word == "red"
            ]
            return f"red {name}: {'; '.join(beyond)} {verdict.problem or ''}".strip()
        if warm and verdict.word == "not offered":  # all of them are asked, or mutants go unseen
            return f"{name} is not offered"
        if warm:
            print(f"{name} {verdict.word} {verdict.seconds:.1f} s", flush=True)
    return ""


Answers = Iterator[tuple[str, NDArray[np.float64]]]


def answers(fine: bool = False) -> Answers:
    """What the code gives where no comparison asks: forces and pressures at random poses, and in runs the distribution
    of wheel forces and of displacements of rails and decks. fine: a strip more, and shorter time steps."""
    from support.contacts import RADIUS, contact_model, rail_profile, wheel_profile

    from wrsim.analysis import run
    from wrsim.scenario.loading import load

    draw = np.random.default_rng(1)
    pair = wheel_profile("S1002"), rail_profile("60E1", 40)
    for normal, tangential in (("strips", "fastrip"), ("kik-piotrowski", "fastsim"), ("strips", "polach")):
        model = contact_model(*pair, normal=normal, tangential=tangential, friction=0.3, strips=20 + fine)
        poses = np.zeros((ANSWERS, 12))
        poses[:, 1], poses[:, 2] = draw.uniform(-8e-3, 7e-3, ANSWERS), RADIUS + 0.04
        yaw, creep = draw.normal(0.0, 5e-3, ANSWERS), draw.normal(1.0, 2e-3, ANSWERS)
        poses[:, 3], poses[:, 4], poses[:, 6] = -np.sin(yaw), np.cos(yaw), 20.0
        poses[:, 9:] = poses[:, 3:6] * (20.0 * creep / RADIUS)[:, None]
        solved = model.solve_many(poses, 6e4, threads=1)
        for name in ("force", "moment", "p0", "area"):
            yield f"{normal}, {tangential}: {name}", np.nan_to_num(getattr(solved, name))
    for name, (way, step) in RUNS.items():
        keys = {"run.distance_m": way, "run.step_us": round(step * FINER) if fine else step}
        data = run(load(f"scenarios/{name}.toml").with_values(keys)).dataset
        for channel in ("Y", "Q", "X", "rail_displacement_z", "deck_acceleration"):
            if channel in data:
                yield f"{name}: {channel}", np.nanquantile(data[channel], np.linspace(0.0, 1.0, 21))


def change(values: NDArray[np.float64], base_values: NDArray[np.float64]) -> float:
    """Largest difference over the largest number of the second."""
    apart = (
        np.abs(values - base_values).max() / max(np.abs(base_values).max(), 1e-30)
        if values.shape == base_values.shape
        else np.inf
    )
    return float(np.nan_to_num(apart, nan=np.inf))


def alike(number: int, library: ctypes.CDLL, base: dict[str, Any], limits: dict[str, float]) -> str:
    """Whether a mutant changes answers by no more than a finer computation does, in words; else nothing."""
    most, worst = 0.0, ""
    for name, values in answers():
        changed = change(values, base[name])
        if changed > limits[name]:
            return ""
        most, worst = max((most, worst), (changed, name))
    met = library.wrsim_met()
    return f"equivalent: asked {met} times, {most:.1e} ({worst})" if met else ""


def in_fork(ask: Callable[[], str], number: int, library: ctypes.CDLL) -> str:
    """What a function says with a mutant at work."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        limit = int(time.process_time()) + PATIENCE
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        library.wrsim_set(number)
        try:
            verdict = ask()
        except Exception as problem:
            verdict = f"red, stopped: {type(problem).__name__}: {problem}"
        os.write(writing, verdict.encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as told:
        verdict = told.read()
    _, status = os.waitpid(child, 0)
    return verdict or f"red, stopped by signal {os.WTERMSIG(status)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", type=Path)
    parser.add_argument("--number", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="+")
    parser.add_argument("--comparisons", nargs="+", default=[], metavar="NAME")
    parser.add_argument("--folder", type=Path, default=Path("build/yardstick_mutants"))
    arguments = parser.parse_args()
    reference, folder = arguments.reference.resolve(), arguments.folder.resolve()
    descriptions = build(folder, SPARE * arguments.number, arguments.seed)
    for name in [name for name in sys.modules if name.split(".")[0] in ("wrsim", "campaigns", "support")]:
        del sys.modules[name]  # those of the copy are taken
    sys.path[:0] = [str(folder), str(folder / "tests")]
    os.environ["NUMBA_CACHE_DIR"] = str(folder / "cache")
    names = arguments.comparisons
    if red := first_red(reference, names, warm=True) or first_red(reference, names):
        sys.exit(f"the yardstick must be green where nothing is changed: {red}")
    base = dict(answers())
    limits = {name: float(np.clip(change(values, base[name]), *LIMITS)) for name, values in answers(fine=True)}
    print("what a finer computation changes:", *(f"{name} {limit:.1e}" for name, limit in limits.items()), sep="\n  ")
    library = ctypes.CDLL(str(folder / "libw.so"))
    library.wrsim_met.restype = ctypes.c_long
    count = dict.fromkeys(("red", "survives", "equivalent"), 0)
    for i in (i for i in arguments.only or descriptions if not descriptions[i].endswith("(no switch)")):
        if count["red"] + count["survives"] == arguments.number:
            break
        verdict = in_fork(lambda: first_red(reference, names) or "survives", i, library)
        if verdict == "survives":
            same = in_fork(partial(alike, i, library, base, limits), i, library)
            verdict = same if same.startswith("equivalent") else verdict
        count[verdict.replace(":", " ").replace(",", " ").split()[0]] += 1
        print(f"{i} {descriptions[i]}: {verdict}", flush=True)
        print(", ".join(f"{number} {word}" for word, number in count.items()), flush=True)


if __name__ == "__main__":
    main()
