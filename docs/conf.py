"""The documentation site: every page of this folder, the gallery, the names of the package. Built by ``.ci/site``."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import matplotlib
from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import make_keys  # noqa: E402

import wrsim  # noqa: E402

matplotlib.use("agg")
make_keys.write(make_keys.pages())

project = "wrsim"
author = "the wrsim authors"
copyright = "2026, the wrsim authors"
release = version = wrsim.__version__

extensions = ["mathml", "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["gallery", "data", "**/GALLERY_HEADER.*"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
highlight_language = "none"
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|xarray|matplotlib|pandas|pathlib)\..*"),  # types of other libraries: no inventory is fetched
    ("py:.*", r"(array_like|callable|mapping|ndarray|path|(a )?sequence|these|Path)"),
    ("py:.*", r"[A-Z]\w+"),  # of wrsim, not among its public names
    ("py:class", r".*[\[\]|].*"),  # pieces of unions and of types with parameters
]

myst_enable_extensions = ["amsmath", "deflist", "dollarmath"]
html_math_renderer = "mathml"
numfig = math_numfig = True  # equations are numbered by the sections of the theory
myst_heading_anchors = 3

autodoc_typehints = "none"  # docstrings say the types in words
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = True

html_theme = "furo"
html_title = f"wrsim {release}"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["../build/pages"]  # live pages, which the gallery makes
(HERE.parent / "build" / "pages").mkdir(parents=True, exist_ok=True)

LIVE = {"index": "live/contact.html", "user/live": "../live/contact.html"}
"""Pages whose link to a live page leads in the tree to the manual or to what makes it, on the site to it."""


def lead_to_live_page(app: Sphinx, name: str, source: list[str]) -> None:
    """Change the first link of a page of LIVE."""
    if name in LIVE:
        source[0], count = re.subn(r"\[(.+?)\]\(\S+\)", rf'<a href="{LIVE[name]}">\1</a>', source[0], count=1)
        assert count == 1


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("source-read", lead_to_live_page)


sphinx_gallery_conf = {
    "examples_dirs": ["gallery"],
    "gallery_dirs": ["auto_gallery"],
    "filename_pattern": r".*\.py",
    "image_scrapers": ("gallery_pictures.scrape",),
    "reset_modules": (),
    "capture_repr": ("_repr_html_", "__repr__"),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,  # a page of it would load scripts from outside
    "plot_gallery": True,
}
