"""Machine code of stages for C libraries, kept beside the kernels."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wrsim.jit.cache import CACHE
from wrsim.jit.objects import TARGETS, emit_objects


def kept_objects(stages: Mapping[str, Any], target: str) -> list[bytes]:
    """`emit_objects` of stages of the package, kept beside its kernels: the strip model's take ten seconds each."""
    if CACHE is None:
        return emit_objects(stages, target)
    names = [(name, stage.py_func.__module__, stage.py_func.__name__) for name, stage in stages.items()]
    processor = next(iter(stages.values())).targetctx.codegen().magic_tuple()
    key = hashlib.sha256(repr((names, processor, target)).encode()).hexdigest()[:16]
    paths = [Path(CACHE) / f"{key}-{level}.o" for level in range(len(TARGETS[target].levels))]
    if not all(path.exists() for path in paths):
        for path, code in zip(paths, emit_objects(stages, target), strict=True):
            made = path.with_suffix(".part")
            made.write_bytes(code)
            made.replace(path)
    return [path.read_bytes() for path in paths]
