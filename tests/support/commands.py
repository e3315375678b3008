"""The command in a process that is forked from this one: what it prints and how it ends, without importing all anew."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

from wrsim.cli import main


def forked(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run ``wrsim`` with these arguments."""
    words = [str(a) for a in arguments]
    with TemporaryFile() as out, TemporaryFile() as err:
        child = os.fork()
        if child == 0:
            _be_the_command(words, out, err)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        told = []
        for stream in (out, err):
            stream.seek(0)
            told.append(stream.read().decode())
    return subprocess.CompletedProcess(words, code, *told)


def _be_the_command(words: list[str], out: IO[bytes], err: IO[bytes]) -> None:
    code = 70
    try:
        for number, stream in ((1, out), (2, err)):
            os.dup2(stream.fileno(), number)
        sys.stdout, sys.stderr = (open(number, "w", encoding="utf-8", closefd=False) for number in (1, 2))  # noqa: SIM115
        sys.argv = ["wrsim", *words]
        main()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
