"""Compiled kernels from one process to the next: the user's cache, and behind it kernels that came with the package.

The files of numba's cache are pickles: who writes one decides what the next process executes. So they are only taken
from folders that nobody but this user can write to. The folder is named after a hash of all kernels, because numba's
cache does not notice an edit in a *called* function of another file. Each file ends with a digest of its content:
machine code of which a bit has changed is not executed but compiled again.

A wheel may hold a folder ``kernels`` (made by ``.ci/wheel``): cache files, compiled for a common level of processors,
and beside them what they were made with and of. They are read where they are installed, beside the sources, and trusted
as these are. They are taken only if numba, Python, platform and sources are the same and the processor has what they
use. Before the first time a process of its own repeats stored calls of them, bit against bit
(`jit.stages.repeat_calls`): a wrong bit, a crash, an illegal instruction, any doubt, and the kernels are compiled here
as without them. What it found is kept in the cache.
"""

import contextlib
import hashlib
import io
import json
import logging
import os
import pickle
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import llvmlite
import numba
from llvmlite import binding, ir
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.codegen import get_host_cpu_features
from numba.core.runtime import rtsys

from wrsim.system import NO_LINK

CONFIG: Any = numba.config
if CONFIG.CPU_NAME is None and CONFIG.CPU_FEATURES is None and binding.get_process_triple().startswith("x86_64"):
    # LLVM gathers numbers where loops are vectors; one load each is faster (docs/developers/cost.md)
    CONFIG.CPU_FEATURES = ",".join(filter(None, [get_host_cpu_features(), "+prefer-no-gather"]))
LOGGER = logging.getLogger("wrsim.cache")

PLAIN = os.environ.get("WRSIM_PLAIN_NUMBA", "0") not in ("", "0")
"""Whether numba compiles in its own way (docs/developers/numba.md), into a cache of its own."""

PACKAGE = Path(__file__).parents[1]
ROOMS = ("jit", "contact", "track", "vehicle/dynamics")
"""Folders of the package that have kernels."""
FOLDER = PACKAGE / "kernels"
ABOUT, CALL = "about.json", "call-{}.npz"
TRYING = "WRSIM_TRIES_SHIPPED_KERNELS"
"""Set in the process that tries them."""

PRIVATE = 0o700
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def is_private(path: str) -> bool:
    """Make a folder; whether it can be written to by this user and by nobody else."""
    try:
        os.makedirs(path, mode=PRIVATE, exist_ok=True)
        status = os.lstat(path)
    except OSError:
        return False
    if not stat.S_ISDIR(status.st_mode) or not os.access(path, os.W_OK | os.X_OK):
        return False
    if not hasattr(os, "getuid"):  # owners and modes are of another kind there
        return True
    return status.st_uid == os.getuid() and not status.st_mode & OTHERS_WRITE


def _restrict_mode(path: str) -> None:
    """Take from others the right to write to a folder of this user's: older versions left it to the group."""
    if sys.platform != "win32":
        with contextlib.suppress(OSError):
            folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY | NO_LINK)
            try:
                if os.fstat(folder).st_uid == os.getuid():
                    os.fchmod(folder, PRIVATE)
            finally:
                os.close(folder)


def _parent_is_safe(path: str) -> bool:
    """True if nobody else can put another folder in the place of one of this user's in there."""
    try:
        mode = os.stat(path).st_mode
    except OSError:
        return True  # it is not there yet, and will be this user's
    return not hasattr(os, "getuid") or not mode & OTHERS_WRITE or bool(mode & stat.S_ISVTX)


def cache_folder(name: str) -> str | None:
    """The folder ``name`` for compiled kernels, or None where there is no safe place: then nothing is kept. In the
    user's cache; where that cannot be written, in a folder of the user's in the temporary directory."""
    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    user = f"wrsim-{os.getuid()}" if hasattr(os, "getuid") else "wrsim"
    for parent, folder in ((home, "wrsim"), (tempfile.gettempdir(), user)):
        root = os.path.join(parent, folder)
        if not _parent_is_safe(parent):
            continue
        _restrict_mode(root)
        if is_private(root) and is_private(os.path.join(root, name)):
            return os.path.join(root, name)
    print(
        f"wrsim: neither {home} nor {tempfile.gettempdir()} can hold a folder that only you can write to; the kernels "
        "are compiled anew in every process, a minute or two each (XDG_CACHE_HOME names another place)",
        file=sys.stderr,
    )
    return None


def sources() -> list[Path]:
    """Files that may contain kernels."""
    return sorted(path for room in ROOMS for path in (PACKAGE / room).rglob("*.py"))


def digest_of_sources(*more: str) -> str:
    """Digest of the sources in ``ROOMS``, and of more words: of what the kernels compute."""
    digest = hashlib.sha256(" ".join(more).encode())
    for source in sources():
        digest.update(source.relative_to(PACKAGE).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


CACHE = os.environ.get("NUMBA_CACHE_DIR") or cache_folder(
    "kernels-" + digest_of_sources(numba.__version__, sys.version, *["plain"] * PLAIN)
)
"""Folder of compiled kernels; None where they are not kept."""
if PLAIN and CACHE and os.environ.get("NUMBA_CACHE_DIR") == CACHE:
    CACHE = os.path.join(CACHE, "plain")
if CACHE:
    CONFIG.CACHE_DIR = CACHE


def build_info() -> dict[str, str]:
    """What compiled kernels depend on besides the processor."""
    return {
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "python": f"{sys.implementation.name} {sys.version_info[0]}.{sys.version_info[1]}",
        "platform": binding.get_process_triple(),
        "sources": digest_of_sources(),
    }


def python_process(code: str, environment: Mapping[str, str] = MappingProxyType({})) -> dict[str, Any]:
    """Arguments for ``subprocess`` of a process that runs this code with the same sources."""
    paths = os.pathsep.join([str(PACKAGE.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {"args": [sys.executable, "-P", "-c", code], "env": {**os.environ, **environment, "PYTHONPATH": paths}}


class CheckedFile(IndexDataCacheFile):
    """The index and the data files of a kernel, each with a digest of its content as its end."""

    @contextlib.contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[Any]:
        with super()._open_for_write(filepath) as stream:
            content = io.BytesIO()
            yield content
            stream.write(content.getvalue() + hashlib.sha256(content.getvalue()).digest())

    def _content(self, path: str) -> bytes:
        """Content of a file without its digest; ValueError if they do not agree."""
        size = hashlib.sha256().digest_size
        whole = Path(path).read_bytes()
        if hashlib.sha256(whole[:-size]).digest() != whole[-size:]:
            raise ValueError(f"{path} is damaged")
        return whole[:-size]

    def _load_index(self) -> Any:
        with contextlib.suppress(FileNotFoundError):  # numba has an empty index then
            self._content(self._index_path)
        return super()._load_index()

    def _load_data(self, name: str) -> Any:
        return pickle.loads(self._content(self._data_path(name)))


class Shipped:
    """Kernels in a folder, made for a target: the triple, processor and features of numba's caches."""

    def __init__(self, folder: Path, target: Sequence[str], cache: str) -> None:
        self.folder, self.target, self.cache = Path(folder), tuple(target), cache
        self._usable: bool | None = True if os.environ.get(TRYING) else None

    @property
    def usable(self) -> bool:
        """Whether they compute the same bits on this machine: tried once, and kept in the cache."""
        if self._usable is None:
            kept = Path(self.cache) / "shipped.json"
            try:
                self._usable = json.loads(kept.read_text(encoding="utf-8"))["usable"] is True
            except (OSError, ValueError, KeyError, TypeError):
                self._usable = self._pass()
                with contextlib.suppress(OSError):
                    kept.write_text(json.dumps({"usable": self._usable}), encoding="utf-8")
        return self._usable

    def _pass(self) -> bool:
        """Whether another process repeats the calls that came with the kernels."""
        code = f"from wrsim.jit.stages import repeat_calls; repeat_calls({str(self.folder)!r})"
        try:
            process = python_process(code, {TRYING: "1"})
            return subprocess.run(**process, capture_output=True, timeout=120).returncode == 0
        except (OSError, subprocess.SubprocessError):
            return False

    def data(self, function: Any, base: str, stamp: Any, key: Any) -> Any:
        """What a cache holds for a function of one of the sources; None if there is nothing or it cannot be read."""
        room = Path(function.__code__.co_filename).parent
        signature, (triple, *_), code = key
        if not room.is_relative_to(PACKAGE) or triple != self.target[0]:
            return None
        file = CheckedFile(str(self.folder / room.relative_to(PACKAGE)), base, stamp)
        return file.load((signature, self.target, code))


def shipped(cache: str | None, folder: Path = FOLDER) -> Shipped | None:
    """The kernels in a folder, if they can be those of these sources on this machine; else None. cache: where is kept
    whether they could be used; without one nothing is taken."""
    if cache is None or PLAIN or CONFIG.DISABLE_JIT or CONFIG.CPU_NAME is not None:
        return None
    try:
        about = json.loads((Path(folder) / ABOUT).read_text(encoding="utf-8"))
        if any(about[name] != word for name, word in build_info().items()):
            return None
        features = binding.get_host_cpu_features()
        if not all(features.get(name) for name in about["needs"]) or not _same_permissions(Path(folder)):
            return None
        return Shipped(folder, about["target"], cache)
    except (OSError, ValueError, KeyError, TypeError, RuntimeError):
        return None


def _same_permissions(folder: Path) -> bool:
    """Whether nobody else can write to a folder, and to what is in it, than to the sources."""
    package = os.stat(PACKAGE)
    for path in (folder, *folder.rglob("*")):
        status = os.lstat(path)
        if status.st_uid != package.st_uid or status.st_mode & OTHERS_WRITE & ~package.st_mode:
            return False
        if not (stat.S_ISDIR(status.st_mode) or stat.S_ISREG(status.st_mode)):
            return False
    return True


class Stored(CompileResultCacheImpl):
    """What is stored of a kernel: machine code, the names of its functions, and LLVM's code for those who link it. To
    read that takes most of the time to load a kernel, so it is done when it is asked for."""

    def reduce(self, cres: Any) -> Any:
        names = ir.Module()
        for one in cres.library._get_module_for_linking().functions:
            if not one.is_declaration:
                function = ir.Function(names, ir.FunctionType(ir.VoidType(), ()), one.name)
                ir.IRBuilder(function.append_basic_block()).unreachable()
        (name, kind, (machine_code, code)), *others = super().reduce(cres)
        return code, (name, kind, (machine_code, binding.parse_assembly(str(names)).as_bitcode())), *others

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        code, *others = payload
        made = super().rebuild(target_context, others)
        made.library._get_module_for_linking = lambda: binding.parse_bitcode(code)
        return made


class KernelCache(FunctionCache):
    """The user's cache of a kernel, and behind it the kernels that were shipped. What cannot be loaded is removed and
    compiled again."""

    _impl_class = Stored
    shipped = shipped(CACHE)
    """Kernels that came with the package (`Shipped`), of all caches."""
    faults: ClassVar[set[str]] = set()
    """Messages of this process, each given once."""

    def __init__(self, py_func: Any) -> None:
        super().__init__(py_func)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = CheckedFile(self._cache_path, self._impl.filename_base, stamp)

    def _warn(self, fault: str) -> None:
        if fault not in self.faults:
            self.faults.add(fault)
            LOGGER.warning("%s, first %s in %s", fault, self._impl.filename_base, CONFIG.CACHE_DIR)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """As numba's, without what types and lowers functions: only to compile needs it, and loads it itself."""
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        overload = None
        try:
            overload = super()._load_overload(sig, target_context)
        except Exception:  # whatever a damaged file makes of itself
            self._warn("damaged files of compiled kernels are removed and compiled again")
            with contextlib.suppress(OSError):
                os.unlink(self._cache_file._index_path)
        if overload is not None or self.shipped is None or not self._enabled or not self.shipped.usable:
            return overload
        try:
            key = self._index_key(sig, target_context.codegen())
            stamp = self._impl.locator.get_source_stamp()
            data = self.shipped.data(self._py_func, self._impl.filename_base, stamp, key)
            return None if data is None else self._impl.rebuild(target_context, data)
        except Exception:  # the same of a shipped file
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except (OSError, ValueError) as error:  # a full disk, a folder where the file should be
            reason = error.strerror if isinstance(error, OSError) else "a damaged file is not removed"
            self._warn(f"compiled kernels cannot be stored ({reason})")
