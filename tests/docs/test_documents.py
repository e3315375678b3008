"""What the pages name exists: modules, files, commands, scenarios, links."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from pydoc import locate
from typing import get_args

import jinja2
import pytest
import yaml
from support.scripts import ROOT, script
from typer.main import get_command

from wrsim.analysis.motion.messages import EventKind
from wrsim.analysis.stability.cycles import Ending
from wrsim.cli import app
from wrsim.contact.status import WORDS
from wrsim.simulation.recorder import Cause
from wrsim.study.task import STATUSES

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


def test_every_status_word_of_the_code_is_in_the_reference() -> None:
    text = BUILT[ROOT / "docs" / "reference" / "status.md"]()
    words = filter(None, (*get_args(Cause), *get_args(EventKind), *get_args(Ending), *STATUSES))
    for word in words:
        assert f"| `{word}` |" in text, word
    for bit, message in WORDS.items():
        assert f"| `{bit}` | {message} |" in text, message


def test_a_word_without_its_meaning_is_refused() -> None:
    table = script("docs/make_keys.py")._meanings
    for words in (("rest",), ("rest", "cycle", "new")):
        with pytest.raises(ValueError, match=r"new|cycle"):
            table("word", words, {"rest": "the motion decays", "cycle": "a limit cycle"})


def test_every_shipped_scenario_is_in_the_guide() -> None:
    text = BUILT[ROOT / "docs" / "user" / "scenarios.md"]()
    for scenario in (ROOT / "scenarios").glob("*.toml"):
        assert scenario.name in text, scenario.name


def test_the_conda_recipe_is_that_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = (ROOT / ".ci" / "conda" / "meta.yaml").read_text()
    recipe = yaml.safe_load(jinja2.Template(text, undefined=jinja2.StrictUndefined).render(PYTHON="python"))
    assert recipe["package"] == {"name": project["name"], "version": project["version"]}
    script = recipe["build"]["script"]
    assert all(isinstance(line, str) and line.startswith("python -m pip install ") for line in script)
    assert recipe["build"]["entry_points"] == [f"{name} = {of}" for name, of in project["scripts"].items()]
    needed = {name.replace("matplotlib>", "matplotlib-base>") for name in project["dependencies"]}
    own = {
        name.replace(" ", "") for name in recipe["requirements"]["run"] if name.split()[0] not in ("python", "libgl")
    }
    by_pip = needed - own
    assert own <= needed and len(by_pip) == 1 and all(any(f" {name} " in line for line in script) for name in by_pip)


def test_the_container_file_copies_what_there_is_and_has_a_python_of_the_project() -> None:
    text = (ROOT / "Containerfile").read_text()
    copied = [name for line in re.findall(r"^COPY (.+)$", text, re.MULTILINE) for name in line.split()[:-1]]
    assert len(copied) > 5 and all((ROOT / name).exists() for name in copied)
    classifiers = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["classifiers"]
    (version,) = re.findall(r"^FROM .*python:(3\.\d+)-", text, re.MULTILINE)
    assert f"Programming Language :: Python :: {version}" in classifiers
