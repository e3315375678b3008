"""Pictures that are not painted, or not even put together, for tests of what becomes of their files."""

import base64
import importlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import pytest

PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
DRAWING = b'<svg xmlns="http://www.w3.org/2000/svg" width="1" height="1"/>'
"""The smallest pictures."""


@contextmanager
def _drawing(figures: Mapping[str, object], paint: object = None) -> Iterator[object]:
    kinds = getattr(paint, "__name__", "") == "in_all_kinds"
    yield lambda: dict.fromkeys(figures, {"png": PIXEL} if kinds else PIXEL)


@contextmanager
def _sketching(figures: Mapping[str, Callable[[], object]], paint: object = None) -> Iterator[object]:
    for make in figures.values():
        make()
    with _drawing(figures, paint) as finish:
        yield finish


def sketch(patch: pytest.MonkeyPatch) -> None:
    """Put pictures together, and the smallest one in the place of each."""
    patch.setattr("wrsim.plots.drawing", _sketching)
    patch.setattr(importlib.import_module("wrsim.plots.drawing"), "drawing", _sketching)


def leave_unpainted(patch: pytest.MonkeyPatch) -> None:
    """Put the smallest picture in the place of each."""
    for module in ("wrsim.plots", "wrsim.plots.drawing", "wrsim.report.page"):
        patch.setattr(importlib.import_module(module), "drawing", _drawing)
    patch.setattr("wrsim.report.page.rendered", lambda figure, kind: DRAWING)
