"""How a command ends: every error that a user can meet is one message and an exit code.

The message goes to stderr, with ``--json`` one JSON object to stdout.

==== ==================================================================
0    done
1    the result could not be written: full disk, no permission
2    bad input: a file, a key, a value, an argument
3    the run stopped early, cases of a study have no result; what was computed is on disk
4    two results differ by more than allowed (``wrsim diff``); a limit is exceeded (``wrsim type-test``)
70   a mistake in wrsim itself; WRSIM_DEBUG=1 shows where
130  interrupted with Ctrl-C; what was computed is on disk
==== ==================================================================
"""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from wrsim import __version__, system
from wrsim.cli.console import print_error, print_json
from wrsim.errors import INTERRUPTED, WrsimError

INTERNAL = 70
FULL_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
DEBUG = "WRSIM_DEBUG"


def any_output() -> None:
    """Let text through to any stdout and stderr: closed ones, and those that cannot take every letter."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 (it lasts as long as the process)
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(encoding=system.encoding(stream), errors="backslashreplace")


@contextmanager
def usage_as_json(as_json: bool) -> Iterator[bool]:
    """Report wrong options and arguments as JSON too. Gives whether the command line may report them itself."""
    try:
        yield not as_json
    except Exception as error:
        if not as_json or not hasattr(error, "format_message"):  # typer's own copy of click has no public name for it
            raise
        _print_error(error.format_message(), "UsageError", 2)
        sys.exit(2)


@contextmanager
def reporting_errors(as_json: bool) -> Iterator[None]:
    """Turn every error of a command into a message and an exit code."""
    try:
        yield
        sys.stdout.flush()
    except WrsimError as error:
        _fail(str(error), type(error).__name__, error.exit_code, as_json)
    except KeyboardInterrupt as interrupt:
        _fail(str(interrupt) or "interrupted", "KeyboardInterrupt", INTERRUPTED, as_json)
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit from None
    except OSError as error:
        full = error.errno in FULL_DISK
        reason = "the disk is full; free some space or choose another directory" if full else error.strerror
        mute = not error.filename and _takes_no_text()
        if mute and error.errno == errno.EINVAL:  # a broken pipe of Windows
            raise typer.Exit from None
        where = "standard output: " if mute else f"{error.filename}: " if error.filename else ""
        _fail(f"{where}{reason or error}", "WrsimError", WrsimError.exit_code, as_json and not mute)
    except MemoryError:
        message = "out of memory: fewer poses, a larger output interval or fewer patches_at_m need less"
        _fail(message, "MemoryError", WrsimError.exit_code, as_json)
    except Exception as error:
        if isinstance(error, typer.Exit) or os.environ.get(DEBUG):
            raise
        message = (
            f"internal error: {type(error).__name__}: {error}\n"
            f"This is a mistake in wrsim {__version__}, not in your input. Please report it with the scenario; "
            f"{DEBUG}=1 shows where it happened."
        )
        _fail(message, "InternalError", INTERNAL, as_json)


@contextmanager
def writing_files(as_json: bool, force: bool, *reads: Path, of: Path | None = None) -> Iterator[None]:
    """The same of a command that writes files; see `wrsim.results.files.writing`."""
    with reporting_errors(as_json):
        from wrsim.results.files import writing

        with writing(force, *reads, of=of):
            yield


def _takes_no_text() -> bool:
    """True where stdout is what cannot be written; it is given up then."""
    try:
        print(flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return True
    return False


def _fail(message: str, kind: str, code: int, as_json: bool) -> None:
    if as_json:
        _print_error(message, kind, code)
    else:
        print_error(message)
    raise typer.Exit(code) from None


def _print_error(message: str, kind: str, code: int) -> None:
    print_json({"error": {"kind": kind, "exit_code": code, "messages": message.split("\n")}})
