"""No test depends on a file of one machine: what opens a file beside the repository fails.

Allowed are the repository, the environment (Python, its packages, the system, caches of the user) and
temporary folders."""

import os
import sys
import sysconfig
import tempfile
from pathlib import Path

import pytest

LINKS = sys.platform != "win32"
"""Whether anybody can make symbolic links; on Windows that is a right."""
ROOT = Path(__file__).resolve().parents[2]
SYSTEM = "/bin", "/dev", "/etc", "/lib", "/lib64", "/opt", "/proc", "/run", "/sys", "/usr", "/var"
WINDOWS = [os.environ.get(name) for name in ("SYSTEMROOT", "LOCALAPPDATA")]
DEVICES = "\\\\.\\"
"""Begins the names of Windows' devices."""
CACHES = ".cache", ".config", ".local", ".matplotlib"
foreign: list[str] = []
"""Files outside that have been opened and not yet been reported."""


def allowed_folders(config: pytest.Config) -> tuple[str, ...]:
    """Folders that tests may read, with a slash behind."""
    named = [folder for folder in (config.option.reference, os.environ.get("XDG_CACHE_HOME")) if folder]
    python = sys.prefix, sys.base_prefix, *sysconfig.get_paths().values(), *sys.path
    folders = {*SYSTEM, *WINDOWS, *python, *named, *(Path.home() / cache for cache in CACHES)}
    forms = os.path.abspath, os.path.realpath
    return tuple(f"{form(folder)}{os.sep}" for folder in folders if folder for form in forms)


def watch_files(config: pytest.Config) -> None:
    """Takes down each file that is opened outside. A hook of the interpreter, which stays."""
    inside, allowed = f"{ROOT}{os.sep}", allowed_folders(config)
    temporary, beside = (f"{folder}{os.sep}" for folder in (os.path.realpath(tempfile.gettempdir()), ROOT.parent))
    if beside == temporary:
        beside = inside  # whose files are allowed

    def opened(event: str, arguments: tuple[object, ...]) -> None:
        if event == "open" and isinstance(arguments[0], str | bytes):
            path = f"{os.path.abspath(os.fsdecode(arguments[0]))}{os.sep}"
            lent = path.startswith(temporary) and not path.startswith(beside)
            if not (path.startswith((inside, DEVICES, *allowed)) or lent):
                foreign.append(path[:-1])

    sys.addaudithook(opened)


def report_foreign() -> None:
    """Fails where a file outside has been opened."""
    if foreign:
        files = ", ".join(dict.fromkeys(foreign))
        foreign.clear()
        pytest.fail(f"opened outside of the repository, the environment and temporary folders: {files}", pytrace=False)
