"""What Linux, macOS and Windows do each in its way: locks, descriptors, processors, processes, commands, messages."""

import ctypes
import errno
import os
import re
import shlex
import signal
import sys
import time
from pathlib import Path
from typing import IO, TextIO

PLAIN = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
"""Flags with which a file is opened: opening never waits, and bytes are not translated."""
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
"""Flag that refuses a symbolic link; 0 where there is none."""
FORKS = sys.platform == "linux"
"""Whether a process can be forked that draws: macOS's own libraries do not survive that."""
_BLANKS = " " * 60 + "\b" * 60
ERASE, BOLD, USUAL = (_BLANKS, "", "") if sys.platform == "win32" else ("\x1b[K", "\x1b[1m", "\x1b[0m")
"""Clears a line of a terminal to its end; bold letters; usual ones. Older consoles of Windows know no codes."""
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables of the environment with the number of threads of BLAS, before OMP_NUM_THREADS."""
PATIENCE = 1.0
"""Time for which Windows' indexers and virus scanners may hold a new file [s]."""

if sys.platform == "win32":
    import msvcrt
    from ctypes import wintypes

    class _Overlapped(ctypes.Structure):
        """OVERLAPPED of Windows: place of the byte that is locked."""

        _fields_ = (
            ("_internal", ctypes.c_void_p * 2),
            ("low", wintypes.DWORD),
            ("high", wintypes.DWORD),
            ("_event", wintypes.HANDLE),
        )

    _KERNEL = ctypes.WinDLL("kernel32", use_last_error=True)
    _AT_ONCE, _EXCLUSIVE, _IN_USE = 1, 2, 33  # LOCKFILE_FAIL_IMMEDIATELY, LOCKFILE_EXCLUSIVE_LOCK, ERROR_LOCK_VIOLATION

    def lock(stream: IO[bytes], shared: bool = False) -> None:
        """Lock an open file until it is closed. Raises BlockingIOError where another one holds it, or OSError."""
        # a byte far behind the end: others could not read it
        handle, place = wintypes.HANDLE(msvcrt.get_osfhandle(stream.fileno())), _Overlapped(high=0x40000000)
        flags = _AT_ONCE if shared else _AT_ONCE | _EXCLUSIVE
        if not _KERNEL.LockFileEx(handle, flags, 0, 1, 0, ctypes.byref(place)):
            code = ctypes.get_last_error()
            raise BlockingIOError(errno.EAGAIN, "in use") if code == _IN_USE else ctypes.WinError(code)

    def read_at(file: int, size: int, place: int) -> bytes:
        """Bytes at a place of a file, whose position stays."""
        before = os.lseek(file, 0, os.SEEK_CUR)
        try:
            os.lseek(file, place, os.SEEK_SET)
            return os.read(file, size)
        finally:
            os.lseek(file, before, os.SEEK_SET)

else:
    import fcntl

    def lock(stream: IO[bytes], shared: bool = False) -> None:
        """Lock an open file until it is closed. Raises BlockingIOError where another one holds it, or OSError."""
        fcntl.flock(stream, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)

    read_at = os.pread


def encoding(stream: TextIO) -> str | None:
    """Encoding of a stream of text; None: as it is. In files and pipes UTF-8 on Windows, too."""
    plain = sys.platform != "win32" or stream.isatty() or "PYTHONIOENCODING" in os.environ
    return None if plain else "utf-8"


def replace(source: Path, target: Path) -> None:
    """Rename a file over another one."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            os.replace(source, target)
            return
        except PermissionError:
            if sys.platform != "win32" or time.monotonic() > until:
                raise
            time.sleep(0.05)


def processors() -> int:
    """How many processors this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def limit_blas_threads() -> None:
    """Let BLAS have one thread, unless the environment says how many; to be called before numpy is imported.

    Matrices here are small; threads that wait awake for the next one take some 45 ms of another processor each time.
    """
    if "OMP_NUM_THREADS" not in os.environ:
        for name in BLAS_THREADS:
            os.environ.setdefault(name, "1")


def die_with(parent: int) -> None:
    """End this forked process as soon as its parent does (Linux)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
        if os.getppid() != parent:
            os._exit(1)


def quoted(word: str) -> str:
    """A word of a command as one types it here: in a shell of POSIX, or in both of Windows."""
    if sys.platform != "win32":
        return shlex.quote(word)
    return word if re.fullmatch(r"[\w.:/\\+-]+", word) else f'"{word}"'


def remedy(problem: OSError, path: Path) -> str:
    """Why a file cannot be written that nobody else has, and what helps; empty where the error says it."""
    if sys.platform == "win32":
        if len(os.path.abspath(path)) > 259 and problem.errno in (errno.ENOENT, errno.EINVAL):
            return "the path has more than 259 letters: choose a shorter directory, or let Windows take long paths"
        if isinstance(problem, PermissionError):
            return "another program has this file open (close it there), or this place may not be written to"
    return ""
