"""What the pages name exists: modules, files, commands, scenarios, links."""

import json
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path
from pydoc import locate
from typing import Any, get_args

import jinja2
import pytest
import yaml
from support.scripts import ROOT, script
from typer.main import get_command

from wrsim import load
from wrsim.analysis.motion.messages import EventKind
from wrsim.analysis.stability.cycles import Ending
from wrsim.cli import application
from wrsim.contact.status import WORDS
from wrsim.simulation.recorder import Cause
from wrsim.study.task import STATUSES

BUILT = script("docs/make_keys.py").PAGES
"""What makes the pages that exist when the site is built."""
PAGES = [ROOT / "README.md", *sorted(set((ROOT / "docs").rglob("*.md")) - set(BUILT))]
ROOMS = ("jit", "contact", "vehicle", "track", "analysis", "results")
FOLDERS = ("wrsim", "tests", "benchmarks", "campaigns", "docs", "models", "scenarios", *ROOMS)


def named(pattern: str) -> Iterator[tuple[Path, str]]:
    for page in PAGES:
        for name in sorted(set(re.findall(pattern, page.read_text()))):
            yield page, name


def test_commands_modules_and_files_that_pages_name_exist() -> None:
    commands = get_command(application()).commands
    names = list(named(r"(?:`|^ {4}|\n)wrsim (?:-[^\s`]+ )*([a-z]+)"))
    assert len(names) > 30 and [name for name in names if name[1] not in commands] == []
    names = list(named(r"\b(wrsim(?:\.[a-z_]\w*)+)\b(?!/)"))
    assert len(names) > 30 and [name for name in names if locate(name[1]) is None] == []
    files = list(named(r"`((?:" + "|".join(FOLDERS) + r")/[\w/.-]+\.(?:py|toml|md|svg|png|csv))`"))
    links = list(named(r"\]\(([\w/.-]+\.(?:md|png|svg))(?:#[\w-]*)?\)"))
    assert len(files) > 30 and len(links) > 30
    for page, name in files:
        assert any((folder / name).exists() for folder in (ROOT, ROOT / "wrsim", page.parent)), f"{page.name}: {name}"
    for page, name in links:
        path = (page.parent / name).resolve()
        assert path.exists(), f"{page.name}: {name}"


def test_equations_that_docstrings_name_are_on_a_theory_page() -> None:
    pages = "".join(page.read_text() for page in (ROOT / "docs/theory").glob("*.md"))
    labels = set(re.findall(r"^ *\$\$ \(([\w-]+)\)$", pages, flags=re.MULTILINE))
    kinds = "|".join({label.split("-")[0] for label in labels})
    pattern = re.compile(rf"\(((?:{kinds})-[a-z]+)\)")
    code = {path: set(pattern.findall(path.read_text())) for path in ROOT.glob("wrsim/**/*.py")}
    assert [(path.name, names - labels) for path, names in code.items() if names - labels] == []
    strips = set().union(*(names for path, names in code.items() if path.parent.name == "strips"))
    # of the energy the model has the derivatives
    assert {label for label in labels if label.startswith("strip-")} - strips == {"strip-energy"}


MOST_WORDS = 25
"""Longest sentence of the user guide: CONTRIBUTING.md and engineers who read English as a second language."""
BLOCKS = re.compile(r"^```.*?^```$|^\$\$.*?^\$\$[^\n]*$|<!--.*?-->", re.DOTALL | re.MULTILINE)
LINES = re.compile(r"^(?: {4}|\||#|:::|>).*$", re.MULTILINE)
LINK, NAME = re.compile(r"!?\[((?:`[^`]*`|[^]`])*)\]\([^)]*\)"), re.compile(r"`[^`]*`|\$[^$\n]*\$")


def sentences(page: str) -> Iterator[str]:
    """Sentences of a Markdown text without code, tables, headings; names and formulae are one word each."""
    prose = NAME.sub("X", LINK.sub(r"\1", LINES.sub("\n", BLOCKS.sub("\n\n", page))))
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )", prose):
        yield from re.split(r"(?<=[.!?])\**\s+(?=[^a-z])|(?<=:)\s+(?=[A-Z*])", " ".join(block.split()))


@pytest.mark.parametrize("page", sorted((ROOT / "docs/user").glob("*.md")), ids=lambda page: page.stem)
def test_sentences_of_the_guide_are_short(page: Path) -> None:
    lengths = {each: len(re.findall(r"\S*\w\S*", each)) for each in sentences(page.read_text(encoding="utf-8"))}
    assert {each: count for each, count in lengths.items() if count > MOST_WORDS} == {}


def test_a_long_sentence_is_seen_past_names_links_and_lists() -> None:
    long = " ".join(["word"] * 24)
    text = (
        f"# {long} {long}\n\n- {long} `a b c`. Next `k = 1.` one\n- {long} [two words](x.md)\n  $x y$.\n\n| {long} |\n"
    )
    assert [len(re.findall(r"\w+", each)) for each in sentences(text) if each] == [25, 3, 27]


def slug(heading: str) -> str:
    """The anchor of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.replace("`", "").lower()).strip().replace(" ", "-")


def test_every_relative_link_of_the_pages_leads_to_what_is_in_the_tree() -> None:
    """Not to what the site alone makes."""
    pages = [*ROOT.glob("*.md"), *(page for page in (ROOT / "docs").rglob("*.md") if "auto_gallery" not in page.parts)]
    links = [
        (page, a or b)
        for page in pages
        for a, b in re.findall(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"", page.read_text())
        if not re.match(r"[a-z]+:", a or b)
    ]
    dead = []
    for page, link in links:
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        anchored = anchor and target.suffix == ".md" and target.is_file()
        text = target.read_text() if anchored else ""
        anchors = {*map(slug, re.findall(r"(?m)^#+ (.+)$", text)), *re.findall(r"(?m)^\(([\w-]+)\)=$", text)}
        if not target.exists() or "auto_gallery" in target.parts or (anchored and anchor not in anchors):
            dead.append(f"{page.relative_to(ROOT)}: {link}")
    assert len(links) > 200 and {"README.md", "CHANGELOG.md", "CONTRIBUTING.md"} <= {page.name for page in pages}
    assert dead == []


def test_every_status_word_has_its_meaning_in_the_reference() -> None:
    text = BUILT[ROOT / "docs" / "reference" / "status.md"]()
    codes = filter(None, (*get_args(Cause), *get_args(EventKind), *get_args(Ending), *STATUSES))
    for word in codes:
        assert f"| `{word}` |" in text, word
    for bit, message in WORDS.items():
        assert f"| `{bit}` | {message} |" in text, message
    table = script("docs/make_keys.py")._meanings
    for codes in (("rest",), ("rest", "cycle", "new")):
        with pytest.raises(ValueError, match=r"new|cycle"):
            table("word", codes, {"rest": "the motion decays", "cycle": "a limit cycle"})


def test_every_shipped_scenario_is_in_the_guide_and_every_page_on_the_site() -> None:
    text = BUILT[ROOT / "docs" / "user" / "scenarios.md"]()
    for scenario in (ROOT / "scenarios").glob("*.toml"):
        assert scenario.name in text, scenario.name
    listed = (ROOT / "docs" / "index.md").read_text().split()
    for page in (ROOT / "docs").rglob("*.md"):
        name = page.relative_to(ROOT / "docs").with_suffix("").as_posix()
        assert name == "index" or name in listed, name


def test_the_conda_recipe_is_that_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    text = (ROOT / ".ci" / "conda" / "meta.yaml").read_text()
    recipe = yaml.safe_load(jinja2.Template(text, undefined=jinja2.StrictUndefined).render(PYTHON="python"))
    assert recipe["package"] == {"name": project["name"], "version": project["version"]}
    script = recipe["build"]["script"]
    assert all(isinstance(line, str) and line.startswith("python -m pip install ") for line in script)
    assert recipe["build"]["entry_points"] == [f"{name} = {of}" for name, of in project["scripts"].items()]
    needed = {name.replace("matplotlib>", "matplotlib-base>") for name in project["dependencies"]}
    by_conda = {
        name.replace(" ", "") for name in recipe["requirements"]["run"] if name.split()[0] not in ("python", "libgl")
    }
    by_pip = needed - by_conda
    assert (
        by_conda <= needed and len(by_pip) == 1 and all(any(f" {name} " in line for line in script) for name in by_pip)
    )


def test_the_container_file_copies_what_there_is_and_has_a_python_of_the_project() -> None:
    text = (ROOT / "Containerfile").read_text()
    copied = [name for line in re.findall(r"^COPY (.+)$", text, re.MULTILINE) for name in line.split()[:-1]]
    assert len(copied) > 5 and all((ROOT / name).exists() for name in copied)
    classifiers = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["classifiers"]
    (version,) = re.findall(r"^FROM .*python:(3\.\d+)-", text, re.MULTILINE)
    assert f"Programming Language :: Python :: {version}" in classifiers


# The examples of the pages: Python runs, command lines are understood, keys exist, every page is on the site.
WITH_PYTHON = [*PAGES, *sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))]
PARTS = {"carbody", "bogie", "front", "rear", "outer", "inner", "frame", "outer box", "motor", "motors"}
NAMES = PARTS | {"from", "to", "step"}
"""Names that the files on the pages give to their parts, and the words of a series."""


def blocks(page: Path, language: str) -> list[str]:
    """The examples of a page in a language, one after the other; of a notebook its cells."""
    if page.suffix == ".ipynb":
        return [
            "".join(c["source"])
            for c in json.loads(page.read_text(encoding="utf-8"))["cells"]
            if c["cell_type"] == "code"
        ]
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


def command_lines(page: Path) -> list[list[str]]:
    """Words of all lines that call wrsim, in fenced and in indented examples; comments, explanations, files that take
    the output and what stands in brackets as optional are left out."""
    lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
    lines += re.findall(r"^ {4}(wrsim .*)$", page.read_text(encoding="utf-8"), re.M)
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


def test_command_lines_and_keys_of_all_pages_exist() -> None:
    commands = get_command(application()).commands  # type: ignore[attr-defined]
    lines = [(page.name, line) for page in PAGES for line in command_lines(page)]
    assert len(lines) > 50
    for page, (name, *arguments) in lines:
        try:
            name.startswith("-") or commands[name].make_context(name, arguments)
        except Exception as error:
            raise AssertionError(f"{page}: {name} {shlex.join(arguments)}") from error
    known = NAMES | set(re.findall(r"`(\w+)`", BUILT[ROOT / "docs" / "reference" / "keys.md"]()))
    files = [(page.name, tomllib.loads(block)) for page in PAGES for block in blocks(page, "toml")]
    assert len(files) > 20
    for page, tree in files:
        names = {name.rpartition(".")[2] for name in keys_of(tree)}  # values of "vehicle.carbody.mass_kg" are set
        assert names and names <= known, f"{page}: {sorted(names - known)}"
