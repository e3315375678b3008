"""How long a run takes on this machine: the last one tells it for the next."""

import contextlib
import json
from pathlib import Path
from typing import Any

from wrsim.jit.cache import cache_folder
from wrsim.results.files import write_atomically

LEAST = 1.0
"""Shortest run that tells it [s]: the search for the motion at the start takes tenths of a second anyway."""
SPREAD = 2.0
"""Factor about the expected time within which runs lie: contacts and steps cost more in some runs than in others."""


def _file() -> Path | None:
    folder = cache_folder("run-times")
    return None if folder is None else Path(folder) / "factors.json"


def _factors() -> dict[str, float]:
    """Wall time of the last run over the expected one of a common processor, by contact model; nothing unless known."""
    factors: dict[str, Any] = {}
    with contextlib.suppress(OSError, ValueError, AttributeError):
        file = _file()
        factors = dict(json.loads(file.read_text(encoding="utf-8")).items()) if file is not None else {}
    return {name: value for name, value in factors.items() if isinstance(value, float) and 1e-3 < value < 1e3}


def learn(normal: str, expected: float, wall: float) -> None:
    """Note what a run took. normal: its contact model; expected, wall: time as `forecast` gave it, and in truth [s]."""
    factors = _factors()
    if wall >= LEAST and expected > 0.0 and (file := _file()) is not None:
        factors[normal] = factors.get(normal, 1.0) * wall / expected
        with contextlib.suppress(OSError):
            write_atomically(file, json.dumps(factors).encode())


def forecast(normal: str, common: float) -> tuple[float, str]:
    """The expected time of a run [s], and from where it is known. common: time on a common processor [s]."""
    factor = _factors().get(normal)
    return common * (factor or 1.0), "the last run on this machine" if factor else "a common processor"
