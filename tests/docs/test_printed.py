"""What pages show of the output of commands."""

import shutil
from pathlib import Path

import pytest
from support.scripts import ROOT, script

guide = script("docs/run_guide.py")
PAGE = ROOT / "docs/user/first_hour.md"


def test_every_output_on_a_page_is_of_a_command_on_it() -> None:
    for page in guide.PAGES:
        text = page.read_text(encoding="utf-8")
        printed = list(guide.PRINTED.finditer(text))
        assert len(printed) == text.count("<!-- printed:"), page.name
        assert {block[2] for block in printed} <= set(guide.lines(page)), page.name
        assert printed or page.stem not in guide.FIRST, page.name
        assert all(block[4].strip() for block in printed), page.name


@pytest.mark.parametrize(
    ("printed", "same"),
    [
        ("max Y 4.657 kN at 71.1 m", True),
        ("max  Y  4.658 kN at 71.3 m", True),
        ("max Y 4.72 kN at 71.1 m", False),
        ("max Y -4.657 kN at 71.1 m", False),
        ("max Q 4.657 kN at 71.1 m", False),
        ("max Y 4.657 kN at 71.1 m\nmax Q 4.657 kN", False),
    ],
)
def test_outputs_may_differ_in_last_digits_and_in_nothing_else(printed: str, same: bool) -> None:
    assert guide.alike("max Y 4.657 kN at 71.1 m", printed) == same


def test_the_first_hour_shows_what_its_quick_commands_print(tmp_path: Path) -> None:
    for name in ("scenarios", "models"):
        shutil.copytree(ROOT / name, tmp_path / name)
    for line in guide.lines(PAGE):
        if line.startswith(("wrsim new", "wrsim check")):
            code, output = guide.executed(line, tmp_path, as_is=True)
            assert code == 0 and guide.has_printed(PAGE, line, output, write=False), line
