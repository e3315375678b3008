"""What systems do differently is in one module, and the same to its callers."""

import ast
import os
from pathlib import Path

import pytest

from wrsim import system
from wrsim.errors import WrsimError
from wrsim.results.files import plain_disk_errors

PACKAGE = Path(system.__file__).parent
MODULES = {"fcntl", "resource", "pty", "pwd", "grp", "termios", "msvcrt"}
NAMES = {"fork", "forkpty", "pread", "sched_getaffinity", "prctl", "mkfifo", "O_NONBLOCK", "O_NOFOLLOW"}
TEXTS = {"read_text": 0, "write_text": 1}
"""Methods of paths, and the arguments of theirs before the encoding."""


def faults(path: Path) -> list[str]:
    """What in a source runs on some systems alone, or reads text in an encoding that depends on the system."""
    messages = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        line = f"{path.name}:{getattr(node, 'lineno', 0)}"
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = {getattr(node, "module", None), *(alias.name for alias in node.names)}
            messages += [f"{line}: import {name}" for name in names & (MODULES | NAMES)]
        elif isinstance(node, ast.Attribute) and node.attr in NAMES:
            messages.append(f"{line}: {node.attr}")
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in TEXTS:
            named = any(keyword.arg == "encoding" for keyword in node.keywords)
            if not named and len(node.args) == TEXTS[node.func.attr]:
                messages.append(f"{line}: {node.func.attr} without an encoding")
    return messages


def test_one_module_alone_has_what_runs_on_some_systems_only() -> None:
    sources = [path for path in PACKAGE.rglob("*.py") if path != Path(system.__file__)]
    assert [fault for path in sources for fault in faults(path)] == []
    assert len(faults(Path(system.__file__))) >= 5


def test_a_lock_keeps_others_out_until_its_file_is_closed_and_lets_them_read(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"content")
    with open(path, "r+b") as first, open(path, "r+b") as second:
        system.lock(first)
        for shared in (False, True):
            with pytest.raises(BlockingIOError):
                system.lock(second, shared)
        assert second.read() == b"content"
        first.close()
        system.lock(second, shared=True)
        with open(path, "rb") as third:
            system.lock(third, shared=True)


def test_reading_at_a_place_moves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"one\r\ntwo\x1athree")  # bytes that Windows would take for text
    handle = os.open(path, os.O_RDONLY | system.PLAIN)
    try:
        os.lseek(handle, 2, os.SEEK_SET)
        assert system.read_at(handle, 100, 4) == b"\ntwo\x1athree"
        assert os.lseek(handle, 0, os.SEEK_CUR) == 2
    finally:
        os.close(handle)


def test_commands_are_quoted_for_the_shell_that_they_are_typed_in(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(system.sys, "platform", "win32")
        quoted = [system.quoted(word) for word in (r"C:\Runs\coach_1", "my runs", "it's", "a&b")]
    assert quoted == [r"C:\Runs\coach_1", '"my runs"', '"it\'s"', '"a&b"']
    with monkeypatch.context() as patch:
        patch.setattr(system.sys, "platform", "linux")
        assert system.quoted("my runs") == "'my runs'"


@pytest.mark.parametrize(
    ("problem", "name", "remedy"),
    [
        (
            PermissionError(13, "Permission denied"),
            "channels.csv",
            "file open .close it there",
        ),
        (FileNotFoundError(2, "No such file"), "x" * 260, "more than 259 letters: choose a shorter directory"),
    ],
)
def test_errors_that_windows_alone_has_name_the_remedy(problem, name, remedy, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(system.sys, "platform", "win32")
    with pytest.raises(WrsimError, match=remedy), plain_disk_errors(tmp_path / name):
        raise problem
