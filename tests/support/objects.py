"""Machine code of stages for C libraries, kept beside the kernels."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wrsim.jit.cache import CACHE
from wrsim.jit.objects import emit_object, target


def kept_object(stages: Mapping[str, Any]) -> bytes:
    """`emit_object` of stages of the package, kept beside its kernels: the strip model's takes ten seconds."""
    if CACHE is None:
        return emit_object(stages)
    names = [(name, stage.py_func.__module__, stage.py_func.__name__, *target(stage)) for name, stage in stages.items()]
    path = Path(CACHE) / f"{hashlib.sha256(repr(names).encode()).hexdigest()[:16]}.o"
    if not path.exists():
        made = path.with_suffix(".part")
        made.write_bytes(emit_object(stages))
        made.replace(path)
    return path.read_bytes()
