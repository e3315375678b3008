"""Numba kernels: plain floats and arrays in, values and an integer status out.

Contract of every function below this package:

- arguments are floats, integers and C-contiguous float64 arrays; no Python objects, no strings, no globals that a
  user may change;
- nothing is allocated; results go to arrays of the caller or come back as tuples of numbers;
- nothing is raised; a status says what went wrong, and the shell above raises;
- lengths in metres, forces in newtons, angles in radians.

The compiled code is cached on disk (``wrsim.core.cache``), in a folder named after a hash of this whole package.
"""

import os
import sys

import numba

from wrsim.core.cache import cache_folder
from wrsim.core.shipped import digest_of_sources

CACHE = os.environ.get("NUMBA_CACHE_DIR") or cache_folder(
    "kernels-" + digest_of_sources(numba.__version__, sys.version)
)
"""Folder of compiled kernels; None where they are not kept."""
if CACHE:
    numba.config.CACHE_DIR = CACHE
