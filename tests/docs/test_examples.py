"""The Python examples of the pages run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from wrsim import load

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path) -> list[str]:
    """The Python examples of a page, one after the other."""
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), re.M | re.S)


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page)], ids=lambda page: page.name)
def test_the_python_examples_of_a_page_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenarios").mkdir()
    short = load(ROOT / "scenarios/curve_r300.toml").with_values({"run.distance_m": 20, "output.patches_at_m": [10]})
    (tmp_path / "scenarios/curve_r300.toml").write_text(short.text)
    names: dict[str, object] = {}
    for number, block in enumerate(blocks(page), 1):
        exec(compile(block, f"{page.name}, example {number}", "exec"), names)
