"""What the pages name exists: channels, modules, files, commands, scenarios, links."""

import re
from pathlib import Path
from pydoc import locate

import pytest
from typer.main import get_command

from wrsim.cli import app
from wrsim.results import CHANNELS

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
ROOMS = ("core", "contact", "analysis", "results")
FOLDERS = ("wrsim", "tests", "benchmarks", "campaigns", "docs", "models", "scenarios", *ROOMS)


def named(pattern: str, page: Path) -> list[str]:
    return re.findall(pattern, page.read_text())


def listed_channels() -> dict[str, str]:
    """Unit for readers by channel, from the tables of the nomenclature page."""
    found = {}
    for line in (ROOT / "docs" / "reference" / "nomenclature.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        names = re.findall(r"`(\w+)`", cells[1]) if line.startswith("|") and len(cells) == 4 else []
        units = [unit.strip() for unit in cells[2].split(",")] if names else []
        units = units * len(names) if len(units) == 1 else units
        found |= dict(zip(names, units, strict=True))
    return found


def test_every_channel_is_on_the_nomenclature_page_with_its_unit() -> None:
    assert listed_channels() == {name: channel.shown.symbol for name, channel in CHANNELS.items()}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_that_a_page_names_exist(page: Path) -> None:
    commands = get_command(app).commands
    used = named(r"(?:`|^ {4}|\n)wrsim (?:-\S+ )*([a-z]+)", page)
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
        assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_every_shipped_scenario_is_in_the_guide() -> None:
    text = (ROOT / "docs" / "user" / "scenarios.md").read_text()
    for scenario in (ROOT / "scenarios").glob("*.toml"):
        short = f"`_{scenario.stem.split('_')[-1]}`"
        assert scenario.name in text or short in text, scenario.name
