"""Machine code of stages for linkers, kept beside the kernels: that of the strip model takes ten seconds."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wrsim.core.jit.cache import CACHE
from wrsim.core.jit.objects import emit_object, target


def kept_object(stages: Mapping[str, Any]) -> bytes:
    """`emit_object` of stages of the package, from the folder of its kernels where it has been there before."""
    if CACHE is None:
        return emit_object(stages)
    names = [(name, stage.py_func.__module__, stage.py_func.__name__, *target(stage)) for name, stage in stages.items()]
    path = Path(CACHE) / f"{hashlib.sha256(repr(names).encode()).hexdigest()[:16]}.o"
    if not path.exists():
        made = path.with_suffix(".part")
        made.write_bytes(emit_object(stages))
        made.replace(path)
    return path.read_bytes()
