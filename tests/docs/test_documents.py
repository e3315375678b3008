"""What the pages name exists: modules, files, commands, scenarios, links."""

import re
from pathlib import Path
from pydoc import locate

import pytest
from support.scripts import script
from typer.main import get_command

from wrsim.cli import app

ROOT = Path(__file__).parents[2]
BUILT = script("docs/make_keys.py").pages()
"""Pages that exist when the site is built."""
PAGES = [ROOT / "README.md", *sorted(set((ROOT / "docs").rglob("*.md")) - set(BUILT))]
ROOMS = ("core", "contact", "analysis", "results")
FOLDERS = ("wrsim", "tests", "benchmarks", "campaigns", "docs", "models", "scenarios", *ROOMS)


def named(pattern: str, page: Path) -> list[str]:
    return re.findall(pattern, page.read_text())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_that_a_page_names_exist(page: Path) -> None:
    commands = get_command(app).commands
    used = named(r"(?:`|^ {4}|\n)wrsim (?:-[^\s`]+ )*([a-z]+)", page)
    assert set(used) <= set(commands), page.name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_modules_that_a_page_names_exist(page: Path) -> None:
    for name in named(r"\b(wrsim(?:\.[a-z_]\w*)+)\b(?!/)", page):
        assert locate(name) is not None, f"{page.name}: {name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_a_page_names_exist(page: Path) -> None:
    for name in named(r"`((?:" + "|".join(FOLDERS) + r")/[\w/.-]+\.(?:py|toml|md|svg|png|csv))`", page):
        assert any((folder / name).exists() for folder in (ROOT, ROOT / "wrsim", page.parent)), f"{page.name}: {name}"
    for link in named(r"\]\(([\w/.-]+\.(?:md|png|svg))(?:#[\w-]*)?\)", page):
        path = (page.parent / link).resolve()
        assert path.exists() or path in BUILT, f"{page.name}: {link}"


def test_every_shipped_scenario_is_in_the_guide() -> None:
    text = BUILT[ROOT / "docs" / "user" / "scenarios.md"]
    for scenario in (ROOT / "scenarios").glob("*.toml"):
        assert scenario.name in text, scenario.name
