"""Numba kernels: plain floats and arrays in, values and an integer status out.

Contract of every function below this package:

- arguments are floats, integers and C-contiguous float64 arrays; no Python objects, no strings, no globals that a
  user may change;
- nothing is allocated; results go to arrays of the caller or come back as tuples of numbers;
- nothing is raised; a status says what went wrong, and the shell above raises;
- lengths in metres, forces in newtons, angles in radians.

The compiled code is cached on disk. Numba's cache does not notice an edit in a *called* function of another file,
so the cache lives in a directory named after a hash of this whole package.
"""

import hashlib
import os
import sys
import tempfile
from pathlib import Path

import numba


def sources_digest() -> str:
    """Digest of the sources of this package, the numba and the Python version: of what the kernels compute."""
    digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.relative_to(Path(__file__).parent).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _cache_directory() -> str:
    """Directory for compiled kernels, named after the sources of this package and the numba version."""
    name = "kernels-" + sources_digest()
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    for root in (home, tempfile.gettempdir()):
        path = os.path.join(root, "wrsim", name)
        try:
            os.makedirs(path, exist_ok=True)
        except OSError:
            continue
        if os.access(path, os.W_OK):
            return path
    return tempfile.mkdtemp(prefix="wrsim-")


if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = _cache_directory()
