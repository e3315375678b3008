"""What the pages name exists: modules, files, commands, scenarios, links."""

import re
from collections.abc import Iterator
from pathlib import Path
from pydoc import locate

from support.scripts import ROOT, script
from typer.main import get_command

from wrsim.cli import app

BUILT = script("docs/make_keys.py").PAGES
"""What makes the pages that exist when the site is built."""
PAGES = [ROOT / "README.md", *sorted(set((ROOT / "docs").rglob("*.md")) - set(BUILT))]
ROOMS = ("core", "contact", "analysis", "results")
FOLDERS = ("wrsim", "tests", "benchmarks", "campaigns", "docs", "models", "scenarios", *ROOMS)


def named(pattern: str) -> Iterator[tuple[Path, str]]:
    for page in PAGES:
        for name in sorted(set(re.findall(pattern, page.read_text()))):
            yield page, name


def test_commands_that_pages_name_exist() -> None:
    commands = get_command(app).commands
    found = list(named(r"(?:`|^ {4}|\n)wrsim (?:-[^\s`]+ )*([a-z]+)"))
    assert len(found) > 30 and [one for one in found if one[1] not in commands] == []


def test_modules_that_pages_name_exist() -> None:
    found = list(named(r"\b(wrsim(?:\.[a-z_]\w*)+)\b(?!/)"))
    assert len(found) > 30 and [one for one in found if locate(one[1]) is None] == []


def test_files_that_pages_name_exist() -> None:
    files = list(named(r"`((?:" + "|".join(FOLDERS) + r")/[\w/.-]+\.(?:py|toml|md|svg|png|csv))`"))
    links = list(named(r"\]\(([\w/.-]+\.(?:md|png|svg))(?:#[\w-]*)?\)"))
    assert len(files) > 30 and len(links) > 30
    for page, name in files:
        assert any((folder / name).exists() for folder in (ROOT, ROOT / "wrsim", page.parent)), f"{page.name}: {name}"
    for page, name in links:
        path = (page.parent / name).resolve()
        assert path.exists() or path in BUILT, f"{page.name}: {name}"


def test_every_shipped_scenario_is_in_the_guide() -> None:
    text = BUILT[ROOT / "docs" / "user" / "scenarios.md"]()
    for scenario in (ROOT / "scenarios").glob("*.toml"):
        assert scenario.name in text, scenario.name
