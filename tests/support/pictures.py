"""Pictures that are neither put together nor painted, for tests of what becomes of their files."""

import base64
import importlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import pytest

PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
"""The smallest picture."""


@contextmanager
def _drawing(figures: Mapping[str, object], paint: object = None) -> Iterator[object]:
    kinds = getattr(paint, "__name__", "") == "_in_all_kinds"
    yield lambda: dict.fromkeys(figures, {"png": PIXEL} if kinds else PIXEL)


def leave_unpainted(patch: pytest.MonkeyPatch) -> None:
    """Put the smallest picture in the place of each."""
    for module in ("wrsim.plots", "wrsim.plots.drawing", "wrsim.report.page"):
        patch.setattr(importlib.import_module(module), "drawing", _drawing)
