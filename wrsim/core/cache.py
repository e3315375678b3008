"""Where compiled kernels are kept from one process to the next.

The files of numba's cache are pickles: who writes one decides what the next process executes. So they are only taken
from folders that nobody but this user can write to. The folder is named after a hash of all kernels, because numba's
cache does not notice an edit in a *called* function of another file.
"""

import contextlib
import os
import stat
import sys
import tempfile

PRIVATE = 0o700
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def is_private(path: str) -> bool:
    """Make a folder, and say whether it can be written to by this user and by nobody else."""
    try:
        os.makedirs(path, mode=PRIVATE, exist_ok=True)
        found = os.lstat(path)
    except OSError:
        return False
    if not stat.S_ISDIR(found.st_mode) or not os.access(path, os.W_OK | os.X_OK):
        return False
    if not hasattr(os, "getuid"):  # owners and modes are of another kind there
        return True
    return found.st_uid == os.getuid() and not found.st_mode & OTHERS_WRITE


def _shut(path: str) -> None:
    """Take from others the right to write to a folder of this user's: older versions left it to the group."""
    if hasattr(os, "getuid"):
        with contextlib.suppress(OSError):
            folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                if os.fstat(folder).st_uid == os.getuid():
                    os.fchmod(folder, PRIVATE)
            finally:
                os.close(folder)


def _keeps_its_folders(path: str) -> bool:
    """True if nobody else can put another folder in the place of one of this user's in there."""
    try:
        mode = os.stat(path).st_mode
    except OSError:
        return True  # it is not there yet, and will be this user's
    return not hasattr(os, "getuid") or not mode & OTHERS_WRITE or bool(mode & stat.S_ISVTX)


def cache_folder(name: str) -> str | None:
    """The folder ``name`` for compiled kernels, or None where there is no safe place: then nothing is kept.

    In the user's cache; where that cannot be written, in a folder of the user's in the temporary directory.
    """
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    user = f"wrsim-{os.getuid()}" if hasattr(os, "getuid") else "wrsim"
    for parent, own in ((home, "wrsim"), (tempfile.gettempdir(), user)):
        root = os.path.join(parent, own)
        if not _keeps_its_folders(parent):
            continue
        _shut(root)
        if is_private(root) and is_private(os.path.join(root, name)):
            return os.path.join(root, name)
    print(
        f"wrsim: neither {home} nor {tempfile.gettempdir()} can hold a folder that only you can write to; the kernels "
        "are compiled anew in every process, a minute or two each (XDG_CACHE_HOME names another place)",
        file=sys.stderr,
    )
    return None
