"""The command in this process, or in one that is forked from it, which imports nothing anew; started on Windows."""

import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile

import pytest
import typer.testing
from click.testing import Result
from typer.main import get_command
from typer.testing import CliRunner

from wrsim.cli import application, main

app = application()

# made once and not for each call: options of all commands are read from signatures, for a tenth of a second
typer.testing._get_command = cache(get_command)


def call(*arguments: str | Path) -> Result:
    """Call ``wrsim`` with these arguments in this process."""
    return CliRunner().invoke(app, [str(a) for a in arguments], env={"COLUMNS": "200"})


def ok(*arguments: str | Path) -> Result:
    """Call it in this process; it must end well."""
    answer = call(*arguments)
    assert answer.exit_code == 0, answer.output
    return answer


def refusal(*arguments: str | Path) -> str:
    """What it prints when it refuses these arguments, or what they name."""
    answer = call(*arguments)
    assert answer.exit_code == 2 and "Traceback" not in answer.output, answer.output
    return answer.output


def forked(
    *arguments: str | Path, first: Callable[[], object] = bool, encoding: str = "utf-8"
) -> subprocess.CompletedProcess[str]:
    """Run ``wrsim`` with these arguments in a process of its own; first: what that does before; encoding: of what it
    prints."""
    command_line = [str(a) for a in arguments]
    if sys.platform == "win32":
        if first is not bool:
            pytest.skip("Windows forks no process that could be prepared")
        command, environment = (
            [sys.executable, "-m", "wrsim", *command_line],
            os.environ | {"PYTHONIOENCODING": encoding},
        )
        return subprocess.run(command, env=environment, capture_output=True, encoding=encoding, check=False)
    with TemporaryFile() as out, TemporaryFile() as err:
        child = os.fork()
        if child == 0:
            for number, stream in ((1, out), (2, err)):
                os.dup2(stream.fileno(), number)
            _be_the_command(command_line, first, encoding)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        told = []
        for stream in (out, err):
            stream.seek(0)
            told.append(stream.read().decode(errors="replace"))
    return subprocess.CompletedProcess(command_line, code, *told)


def on_a_terminal(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """The same on a terminal, which gets both streams."""
    if sys.platform == "win32":
        pytest.skip("Windows has no pseudo-terminals of POSIX")
    import pty

    command_line = [str(a) for a in arguments]
    child, terminal = pty.fork()
    if child == 0:
        _be_the_command(command_line)
    told = b""
    with suppress(OSError):  # so it ends on Linux
        while part := os.read(terminal, 65536):
            told += part
    os.close(terminal)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return subprocess.CompletedProcess(command_line, code, told.decode(), "")


def _be_the_command(command_line: list[str], first: Callable[[], object] = bool, encoding: str = "utf-8") -> None:
    code = 70
    try:
        first()
        sys.stdout, sys.stderr = (open(number, "w", encoding=encoding, closefd=False) for number in (1, 2))  # noqa: SIM115
        sys.argv = ["wrsim", *command_line]
        main()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
