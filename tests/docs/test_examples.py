"""The examples of the pages: Python runs, command lines are understood, keys exist, every page is on the site."""

import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support.scripts import ROOT, script
from typer.main import get_command

from wrsim import load
from wrsim.cli import app

BUILT = script("docs/make_keys.py").PAGES
PAGES = [ROOT / "README.md", *sorted(set((ROOT / "docs").rglob("*.md")) - set(BUILT))]
WITH_PYTHON = [*PAGES, *sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))]
PARTS = {"carbody", "bogie", "front", "rear", "outer", "inner", "frame", "outer box", "motor", "motors"}
NAMES = PARTS | {"from", "to", "step"}
"""Names that the files on the pages give to their parts, and the words of a series."""


def blocks(page: Path, language: str) -> list[str]:
    """The examples of a page in a language, one after the other; of a notebook its cells."""
    if page.suffix == ".ipynb":
        return ["".join(c["source"]) for c in json.loads(page.read_text())["cells"] if c["cell_type"] == "code"]
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.M | re.S)


def command_lines(page: Path) -> list[list[str]]:
    """Words of all lines that call wrsim, in fenced and in indented examples; comments, explanations, files that take
    the output and what stands in brackets as optional are left out."""
    lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
    lines += re.findall(r"^ {4}(wrsim .*)$", page.read_text(), re.M)
    plain = (re.split(r"\s{2,}| > ", re.sub(r"\[-[^]]*\]", "", line))[0] for line in lines if line.startswith("wrsim "))
    return [shlex.split(line, comments=True)[1:] for line in plain]


def keys_of(table: Any) -> Iterator[str]:
    """All keys of a table and of those in it."""
    if isinstance(table, dict):
        for key, value in table.items():
            yield key
            yield from keys_of(value)
    elif isinstance(table, list):
        for value in table:
            yield from keys_of(value)


@pytest.mark.parametrize("page", [page for page in WITH_PYTHON if blocks(page, "python")], ids=lambda page: page.name)
def test_the_python_examples_of_a_page_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenarios").mkdir()
    short = load(ROOT / "scenarios/curve_r300.toml").with_values({"run.distance_m": 20, "output.patches_at_m": [10]})
    (tmp_path / "scenarios/curve_r300.toml").write_text(short.text)
    names: dict[str, object] = {}
    for number, block in enumerate(blocks(page, "python"), 1):
        exec(compile(block, f"{page.name}, example {number}", "exec"), names)


def test_the_command_lines_of_all_pages_are_understood() -> None:
    commands = get_command(app).commands  # type: ignore[attr-defined]
    lines = [(page.name, line) for page in PAGES for line in command_lines(page)]
    assert len(lines) > 50
    for page, (name, *words) in lines:
        try:
            name.startswith("-") or commands[name].make_context(name, words)
        except Exception as error:
            raise AssertionError(f"{page}: {name} {shlex.join(words)}") from error


def test_the_keys_in_the_files_that_pages_show_exist() -> None:
    known = NAMES | set(re.findall(r"`(\w+)`", BUILT[ROOT / "docs" / "reference" / "keys.md"]()))
    files = [(page.name, tomllib.loads(block)) for page in PAGES for block in blocks(page, "toml")]
    assert len(files) > 20
    for page, found in files:
        names = set(keys_of(found))
        assert names and names <= known, f"{page}: {sorted(names - known)}"


def test_every_page_is_on_the_site() -> None:
    listed = (ROOT / "docs" / "index.md").read_text().split()
    for page in (ROOT / "docs").rglob("*.md"):
        name = page.relative_to(ROOT / "docs").with_suffix("").as_posix()
        assert name == "index" or name in listed, name
