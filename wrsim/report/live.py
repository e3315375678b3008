"""Live pages: a program (WebAssembly) and what it computes with, in one file that needs nothing else."""

from typing import Any

import numpy as np

from wrsim import __version__
from wrsim.report.page import page_template
from wrsim.report.view_data import packed


def packed_bytes(content: bytes) -> dict[str, Any]:
    """Bytes as text of a page, compressed."""
    return packed(np.frombuffer(content, np.uint8), "u1")


class Segments:
    """Pieces of files that pages assemble: those that several files have in common are held once."""

    def __init__(self) -> None:
        self.packed: list[dict[str, Any]] = []
        self._places: dict[bytes, int] = {}

    def add(self, pieces: list[bytes]) -> list[int]:
        """Numbers of the pieces of a file."""
        for piece in pieces:
            if piece not in self._places:
                self._places[piece] = len(self.packed)
                self.packed.append(packed_bytes(piece))
        return [self._places[piece] for piece in pieces]


def live_page(template: str, title: str, program: bytes, data: dict[str, Any]) -> str:
    """A live page as HTML. program: WebAssembly that asks nothing of its host."""
    data = {"title": title, "program": packed_bytes(program)} | data
    return page_template(template).render(title=title, version=__version__, data=data)
