"""Takes up the figures of an example of the gallery that stand in variables: those of wrsim are made without pyplot."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

KEPT: dict[int, Figure] = {}
"""Figures that were taken up already; kept, so that no other one gets their number."""


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the new figures of a block; returns what shows them."""
    paths = []
    for thing in block_vars["example_globals"].values():
        if isinstance(thing, Figure) and id(thing) not in KEPT:
            KEPT[id(thing)] = thing
            paths.append(next(block_vars["image_path_iterator"]))
            thing.savefig(paths[-1], dpi=150, bbox_inches="tight")
    return str(figure_rst(paths, gallery_conf["src_dir"]))
