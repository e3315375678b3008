"""Makes the folder of compiled kernels that a wheel may hold (``wrsim.jit.cache``); called by ``.ci/wheel``.

NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES= NUMBA_CACHE_DIR=CACHE python .ci/ship_kernels.py FOLDER
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core.caching import UserProvidedCacheLocator

from wrsim.analysis.precompile import warm
from wrsim.contact import records as k
from wrsim.contact.models import NORMAL_MODELS, contact_model
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.settings import ContactSettings
from wrsim.contact.wheel_rail import compile_stages, wheel_rail
from wrsim.errors import WrsimError
from wrsim.jit.cache import ABOUT, CALL, PACKAGE, build_info, sources

LEVEL = "x86-64-v3"
NEEDED = (
    "avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt",
    "sse3", "sse4.1", "sse4.2", "ssse3",
)  # fmt: skip
"""The level of processors that they are compiled for, and its features by LLVM's names."""

RADIUS = 0.46
APPROACH = 50e-6
"""Of the wheel in the pose that the kernels are tried on [m]: some 50 kN."""


def ship(folder: Path) -> int:
    """Compile what runs and poses need and put it into a new folder; returns how many files it holds.

    Raises WrsimError where numba compiles for this machine alone, or into a folder that holds more than that.
    """
    config: Any = numba.config
    if config.CPU_NAME != LEVEL or config.CPU_FEATURES != "" or not config.CACHE_DIR:
        raise WrsimError(f"NUMBA_CPU_NAME must be {LEVEL}, NUMBA_CPU_FEATURES empty, NUMBA_CACHE_DIR an empty folder")
    warm()
    gather(Path(config.CACHE_DIR), folder, NEEDED)
    return sum(1 for path in folder.rglob("*") if path.is_file())


def gather(cache: Path, folder: Path, needs: Sequence[str]) -> None:
    """Put the compiled kernels of a cache into a new folder, with contacts to try them on.

    needs: features of the processor that they take.
    """
    folder.mkdir(parents=True)
    for name, normal in NORMAL_MODELS.items():
        if normal.solve is None:
            np.savez_compressed(folder / CALL.format(name), **_contact(ContactSettings(normal=name)))
    for room in sorted({source.parent for source in sources()}):
        kept = cache / UserProvidedCacheLocator.get_suitable_cache_subpath(str(room / "any.py"))
        for file in sorted(kept.glob("*.nb[ic]")):
            place = folder / room.relative_to(PACKAGE)
            place.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, place)
    target = wheel_rail.targetctx.codegen().magic_tuple()
    about = build_info() | {"target": list(target), "needs": list(needs)}
    (folder / ABOUT).write_text(json.dumps(about, indent=2))


def _contact(settings: ContactSettings) -> dict[str, Any]:
    """The workspace of one rolling contact before and after the kernel, its status, and the stages that it takes."""
    wheel, rail = load_profile("wheels/S1002.toml"), load_profile("rails/60E1.toml").inclined(1 / 40)
    arrays = contact_model(wheel, rail, RADIUS, settings).arrays
    speed = 10.0
    arrays.pose[:] = (0.0, 0.002, RADIUS - APPROACH, 0.002, 1.0, 0.0, speed, 0.0, 0.0, 0.0, speed / RADIUS, 0.0)
    stages = [k.CONTACT, NORMAL_MODELS[settings.normal].kernel, k.CREEP_FORCES]
    compile_stages(*stages)
    before = arrays.buffer.copy()
    status = arrays.evaluate()
    return {
        "module": wheel_rail.py_func.__module__, "stages": stages, "before": before, "after": arrays.buffer,
        "index": arrays.index, "status": status,
    }  # fmt: skip


if __name__ == "__main__":
    print(f"{ship(Path(sys.argv[1]))} files in {sys.argv[1]}")
