"""Machine code of stages for C libraries, kept beside the kernels."""

import hashlib
import os
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wrsim.contact.library.build import LINKING, compiler_for
from wrsim.jit.cache import CACHE, cache_folder
from wrsim.jit.objects import TARGETS, emit_objects


def kept_objects(stages: Mapping[str, Any], target: str) -> list[bytes]:
    """`emit_objects` of stages of the package, each kept beside its kernels: that of the strip model takes ten seconds,
    and all libraries have it."""
    return [code for name, stage in stages.items() for code in _kept(name, stage, target)]


def _kept(name: str, stage: Any, target: str) -> list[bytes]:
    if CACHE is None:
        return emit_objects({name: stage}, target)
    processor = stage.targetctx.codegen().magic_tuple()
    identity = name, stage.py_func.__module__, stage.py_func.__name__, processor, target
    key = hashlib.sha256(repr(identity).encode()).hexdigest()[:16]
    paths = [Path(CACHE) / f"{key}-{level}.o" for level in range(len(TARGETS[target].levels))]
    if not all(path.exists() for path in paths):
        for path, code in zip(paths, emit_objects({name: stage}, target), strict=True):
            made = path.with_suffix(f".{os.getpid()}")
            made.write_bytes(code)
            made.replace(path)
    return [path.read_bytes() for path in paths]


def begin_wasm_library(output: Path) -> subprocess.Popen[bytes]:
    """A process that links nothing for WebAssembly: zig builds the C library for it from its sources, once."""
    cache = cache_folder("zig") or str(output.parent)
    command = [*compiler_for("wasm"), "-O2", "-x", "c", os.devnull, "-o", str(output), *LINKING["wasm"][2].split()]
    return subprocess.Popen(command, env=os.environ | {"ZIG_GLOBAL_CACHE_DIR": cache, "ZIG_LOCAL_CACHE_DIR": cache})
