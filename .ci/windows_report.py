"""What `.ci/windows` came to.

python .ci/windows_report.py numbers LINUX WINDOWS    numbers of the summaries in two folders of results, side by side
python .ci/windows_report.py tests FILE.xml ...       tests that passed, and others, by pytest's JUnit files
"""

import json
import sys
import tomllib
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

PART = 1e-6
"""Largest difference of a number, as a part of it."""
SHARE = 0.99
"""Of the tests that are not skipped, those that pass."""


def numbers(tree: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """All numbers of a tree, with their places."""
    if isinstance(tree, dict | list):
        for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from numbers(value, f"{place}/{key}")
    elif isinstance(tree, int | float) and not isinstance(tree, bool):
        yield place, float(tree)


def _expected() -> dict[str, str]:
    """What may fail, with its reason."""
    return tomllib.loads((Path(__file__).parent / "windows_failures.toml").read_text(encoding="utf-8"))


def compare(linux: Path, windows: Path) -> bool:
    """Whether all numbers of both folders agree, but those that may not."""
    good, expected = True, _expected()
    for path in sorted(linux.glob("*/summary.json")):
        ours, theirs = (
            dict(numbers(json.loads(file.read_text(encoding="utf-8"))))
            for file in (path, windows / path.relative_to(linux))
        )
        apart = {
            place: abs(value - theirs.get(place, float("inf"))) / max(abs(value), 1e-300)
            for place, value in ours.items()
            if value != theirs.get(place) and "wall_time" not in place
        }
        known = {place: reason for place in apart if (reason := expected.get(path.parent.name + place))}
        for place, reason in known.items():
            print(f"{path.parent.name}: {apart.pop(place):.2g} {place}: {reason}")
        worst = max(apart, key=lambda place: apart[place], default="")
        print(f"{path.parent.name}: {len(ours)} numbers, largest difference {apart.get(worst, 0.0):.2g} {worst}")
        good &= set(ours) == set(theirs) and apart.get(worst, 0.0) <= PART
    return good


def tests(files: list[Path]) -> bool:
    """Whether enough tests pass, and those alone fail that may."""
    expected = _expected()
    counts, skipped, unexpected = Counter[str](), Counter[str](), []
    left = {name: reason for name, reason in expected.items() if name.startswith("tests/")}
    for file in files:
        for case in ET.parse(file.with_suffix(".xml")).iter("testcase"):
            skipped.update(str(child.get("message")) for child in case.iter("skipped"))
            name = f"{case.get('classname', '').replace('.', '/')}::{case.get('name')}"
            kinds = {child.tag for child in case}
            failed = bool(kinds & {"failure", "error"})
            reason = next((entry for entry in expected if failed and name.startswith(entry)), None)
            counts["failed" if failed else "skipped" if "skipped" in kinds else "passed"] += 1
            if failed and reason is None:
                unexpected.append(name)
            elif reason is not None:
                left.pop(reason, None)
                print(f"fails: {name}: {expected[reason]}")
    share = counts["passed"] / max(counts["passed"] + counts["failed"], 1)
    print(
        f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped; {100 * share:.1f} % pass"
    )
    for reason, count in skipped.most_common():
        print(f"{count} skipped: {reason}")
    for name in unexpected:
        print(f"fails and is not in windows_failures.toml: {name}")
    for name in left:
        print(f"passes, take it out of windows_failures.toml: {name}")
    return share >= SHARE and not unexpected


if __name__ == "__main__":
    what, *names = sys.argv[1:]
    done = compare(*map(Path, names)) if what == "numbers" else tests([Path(name) for name in names])
    sys.exit(not done)
