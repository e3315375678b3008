"""The yardstick: every comparison with figures of others, in one command.

    python -m campaigns.benchmark REFERENCE [--code wrsim] [--only NAME ...] [--short] [--cost ABOVE TO] [--first-red]
        [--jobs 2] [-o FILE] [--report]

Run from the root of the repository. REFERENCE: folder of tables that are not part of it. --code: wrsim, hertz-fastsim,
or MODULE:CLASS of another code (``adapter.py``). A comparison is red where an error is beyond its tolerance; any red
one ends the command with 1. -o: errors as a table; --report: into
docs/data/standing/yardstick.csv, and the validation report anew. Ctrl-C keeps what is done.
"""

import argparse
import csv
import os
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from importlib import import_module
from math import inf
from multiprocessing import Pool
from pathlib import Path
from signal import SIG_IGN, SIGINT, signal

from campaigns.benchmark.adapter import Code
from campaigns.benchmark.comparison import HERE, ROOT, ComparisonFile, Verdict, read_comparison, run_comparison
from wrsim.errors import INTERRUPTED, InputError

CODES = {
    "wrsim": "campaigns.benchmark.wrsim_adapter:Wrsim",
    "hertz-fastsim": "campaigns.benchmark.hertz_fastsim:HertzFastsim",
}
ERRORS = "median", "most", "worst"
STANDING = ROOT / "docs/data/standing/yardstick.csv"
HEAD = ["comparison", "quantity", "cases", *ERRORS, *(f"{error}_limit" for error in ERRORS), "case", "verdict"]


def comparisons(only: Sequence[str] = ()) -> dict[str, ComparisonFile]:
    """All comparisons, or those that are named; cheap ones first."""
    files = {path.stem: path for path in sorted((HERE / "comparisons").glob("*.toml"))}
    if unknown := [name for name in only if name not in files]:
        raise InputError(f"--only {unknown[0]}: must be one of {', '.join(files)}")
    chosen = {name: read_comparison(path) for name, path in files.items() if not only or name in only}
    return dict(sorted(chosen.items(), key=lambda item: item[1].cost))


def code_of(name: str, reference: Path) -> Code:
    """A code by its name or by module and class."""
    module, _, kind = CODES.get(name, name).partition(":")
    try:
        return getattr(import_module(module), kind)(reference)
    except (ImportError, AttributeError, ValueError) as problem:
        if isinstance(problem, ModuleNotFoundError) and problem.name and not module.startswith(problem.name):
            raise InputError(f'--code {name}: needs {problem.name}: pip install -e ".[dev]"') from None
        raise InputError(f"--code {name}: must be {', '.join(CODES)} or MODULE:CLASS: {problem}") from None


def verdicts(asked: argparse.Namespace, chosen: dict[str, ComparisonFile]) -> Iterator[Verdict]:
    """Of all comparisons as they come in; in one process in their order."""
    if asked.jobs == 1:
        code = code_of(asked.code, asked.reference)
        for name, comparison in chosen.items():
            yield run_comparison(name, comparison, code, asked.short)
        return
    with Pool(asked.jobs, signal, (SIGINT, SIG_IGN)) as pool:
        ask = partial(in_process, asked.code, asked.reference, asked.short)
        yield from pool.imap_unordered(ask, reversed(chosen))  # the dear ones first


def in_process(code: str, reference: Path, short: bool, name: str) -> Verdict:
    """One comparison in a process of its own."""
    return run_comparison(name, comparisons([name])[name], code_of(code, reference), short)


def lines_about(verdict: Verdict, comparison: ComparisonFile) -> str:
    """Lines about a verdict: one, and one for each quantity beyond its tolerance."""
    count = max((o.cases for o in verdict.outcomes), default=0)
    lines = [
        f"{verdict.word:11s} {verdict.comparison:24s} {count:5d} cases {verdict.seconds:7.1f} s  {comparison.title}"
    ]
    for o in verdict.outcomes:
        if o.word == "red":
            lines.append(f"            {o.quantity}: {', '.join(o.beyond) or 'no figure'} (case {o.case})")
    return "\n".join(lines + [f"            {verdict.problem}"] * bool(verdict.problem))


def write(path: Path, done: Sequence[Verdict]) -> None:
    """Errors and tolerances, a row a quantity."""
    with path.open("w", encoding="utf-8", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(HEAD)
        for verdict in sorted(done, key=lambda v: v.comparison):
            for o in verdict.outcomes:
                limits = ["" if limit is None else f"{limit:g}" for limit in o.limits]
                out.writerow(
                    [o.comparison, o.quantity, o.cases, *(f"{e:.3g}" for e in o.errors), *limits, o.case, o.word]
                )


def run(asked: argparse.Namespace) -> int:
    """Run them, print a line each; 0 if all that are offered are green."""
    chosen = comparisons(asked.only)
    low, high = asked.cost
    chosen = {
        name: comparison
        for name, comparison in chosen.items()
        if low < comparison.cost <= high and (comparison.short or not asked.short)
    }
    done: list[Verdict] = []
    began, interrupted = time.perf_counter(), False
    try:
        for verdict in verdicts(asked, chosen):
            done.append(verdict)
            print(lines_about(verdict, chosen[verdict.comparison]), flush=True)
            if asked.first_red and verdict.word == "red":
                break
    except KeyboardInterrupt:
        interrupted = True
        print("interrupted; so far:")
    counts = {word: sum(v.word == word for v in done) for word in ("green", "red", "not offered")}
    told = ", ".join(f"{count} {word}" for word, count in counts.items())
    print(f"{told}, {len(chosen) - len(done)} not run; {time.perf_counter() - began:.0f} s")
    whole = len(done) == len(comparisons()) and not asked.short and asked.code == "wrsim"
    if asked.output:
        write(asked.output, done)
    if asked.report and not whole:
        print("no report: it is made of a full run of wrsim")
    elif asked.report:
        write(STANDING, done)
        sys.path.insert(0, str(ROOT / "docs/figures"))
        import_module("make_standing").main()
    return INTERRUPTED if interrupted else int(counts["red"] > 0 or not counts["green"])


def main(arguments: Sequence[str] | None = None) -> int:
    """See above."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", type=Path)
    parser.add_argument("--code", default="wrsim")
    parser.add_argument("--only", nargs="+", default=())
    parser.add_argument("--short", action="store_true", help="few cases of cheap comparisons")
    parser.add_argument("--cost", type=float, nargs=2, default=(0.0, inf), metavar=("ABOVE", "TO"), help="in seconds")
    parser.add_argument("--first-red", action="store_true", help="end with the first red comparison")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("-o", "--output", type=Path, metavar="FILE")
    parser.add_argument("--report", action="store_true")
    asked = parser.parse_args(arguments)
    asked.reference = asked.reference.resolve()
    try:
        return run(asked)
    except InputError as problem:
        print(problem, file=sys.stderr)
        return problem.exit_code


if __name__ == "__main__":
    sys.exit(main())
