"""Compiled kernels that came with the package: taken in place of compiling, where all that they depend on is the same.

A wheel may hold a folder ``kernels`` (made by ``wrsim.analysis.shipping``): numba's cache files of the kernels,
compiled for a common level of processors, and beside them what they were made with and of. They are read where they are
installed, beside the sources, and trusted as these are: nobody may write there who could not change wrsim itself.
Nothing is unpacked.

They are taken only if numba, Python, platform and sources are the same and the processor has what they use. Before the
first time a process of its own computes contacts with them, bit against bit (core.trial): a wrong bit, a crash, an
illegal instruction, any doubt, and the kernels are compiled here as without them. What it found is kept in the cache.
"""

import hashlib
import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import llvmlite
import numba
from llvmlite import binding
from numba.core.caching import FunctionCache, IndexDataCacheFile

from wrsim.core.cache import OTHERS_WRITE

SOURCES = Path(__file__).parent
FOLDER = SOURCES.parent / "kernels"
ABOUT, CONTACT = "about.json", "contact-{}.npz"
TRYING = "WRSIM_TRIES_SHIPPED_KERNELS"
"""Set in the process that tries them."""

LEVEL = "x86-64-v3"
NEEDED = (
    "avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt",
    "sse3", "sse4.1", "sse4.2", "ssse3",
)  # fmt: skip
"""The level of processors that they are compiled for, and its features by LLVM's names."""


def digest_of_sources(*more):
    """Digest of the sources of ``wrsim.core``, and of more words: of what the kernels compute."""
    digest = hashlib.sha256(" ".join(more).encode())
    for source in sorted(SOURCES.rglob("*.py")):
        digest.update(source.relative_to(SOURCES).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def made_with():
    """What compiled kernels depend on besides the processor."""
    return {
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "python": f"{sys.implementation.name} {sys.version_info[0]}.{sys.version_info[1]}",
        "platform": binding.get_process_triple(),
        "sources": digest_of_sources(),
    }


class Shipped:
    """Kernels in a folder, made for a target: the triple, processor and features of numba's caches."""

    def __init__(self, folder, target, cache):
        self.folder, self.target, self.cache = Path(folder), tuple(target), cache
        self._usable = True if os.environ.get(TRYING) else None

    @property
    def usable(self):
        """Whether they compute what they shall, on this machine: tried once, and kept in the cache."""
        if self._usable is None:
            kept = Path(self.cache) / "shipped.json"
            try:
                self._usable = json.loads(kept.read_text())["usable"] is True
            except (OSError, ValueError, KeyError, TypeError):
                self._usable = self._pass()
                kept.write_text(json.dumps({"usable": self._usable}))
        return self._usable

    def _pass(self):
        """Whether another process computes the contacts that came with the kernels."""
        command = [sys.executable, "-P", "-c", "from wrsim.core.trial import main; main()"]
        paths = os.pathsep.join([str(SOURCES.parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])])
        try:
            done = subprocess.run(
                command, env=os.environ | {TRYING: "1", "PYTHONPATH": paths}, capture_output=True, timeout=120
            )
        except (OSError, subprocess.SubprocessError):
            return False
        return done.returncode == 0

    def data(self, function, base, stamp, key):
        """What a cache holds for a function of one of the sources; None if there is nothing or it cannot be read."""
        room = Path(function.__code__.co_filename).parent
        if not room.is_relative_to(SOURCES):
            return None
        signature, (triple, _, _), code = key
        file = IndexDataCacheFile(str(self.folder / room.relative_to(SOURCES)), base, stamp)
        return file.load((signature, (triple, *self.target[1:]), code)) if triple == self.target[0] else None


def shipped(cache, folder=FOLDER):
    """The kernels in a folder, if they can be those of these sources on this machine; else None.

    cache: where is kept whether they could be used; without one nothing is taken.
    """
    if cache is None or numba.config.DISABLE_JIT or numba.config.CPU_NAME is not None:
        return None
    try:
        about = json.loads((Path(folder) / ABOUT).read_text())
        if any(about[name] != word for name, word in made_with().items()):
            return None
        found = binding.get_host_cpu_features()
        if not all(found.get(name) for name in about["needs"]) or not _as_shut_as_sources(Path(folder)):
            return None
        return Shipped(folder, about["target"], cache)
    except (OSError, ValueError, KeyError, TypeError, RuntimeError):
        return None


def _as_shut_as_sources(folder):
    """Whether nobody else can write to a folder, and to what is in it, than to the sources."""
    of_sources = os.stat(SOURCES)
    for path in (folder, *folder.rglob("*")):
        found = os.lstat(path)
        if found.st_uid != of_sources.st_uid or found.st_mode & OTHERS_WRITE & ~of_sources.st_mode:
            return False
        if not (stat.S_ISDIR(found.st_mode) or stat.S_ISREG(found.st_mode)):
            return False
    return True


class KernelCache(FunctionCache):
    """The user's cache of a kernel, and behind it the kernels that were shipped."""

    shipped = None
    """Kernels that came with the package (`Shipped`), of all caches."""

    def _load_overload(self, sig, target_context):
        found = super()._load_overload(sig, target_context)
        if found is not None or self.shipped is None or not self._enabled or not self.shipped.usable:
            return found
        try:
            key = self._index_key(sig, target_context.codegen())
            stamp = self._impl.locator.get_source_stamp()
            data = self.shipped.data(self._py_func, self._impl.filename_base, stamp, key)
            return None if data is None else self._impl.rebuild(target_context, data)
        except Exception:  # whatever a damaged file makes of itself: it is compiled
            return None
