"""Pictures of a result. Functions take and return matplotlib axes, and compute nothing but what drawing needs.

``standard_pictures(dataset, directory)`` writes the set that suits the analysis; the modules draw single panels on axes
of the caller, or whole figures without pyplot.
"""

from wrsim.plots.cross_section import section_gallery
from wrsim.plots.drawing import drawing
from wrsim.plots.patches import patch_gallery
from wrsim.plots.pictures import standard_figures, standard_pictures
from wrsim.plots.theme import new_figure, save, style

__all__ = [
    "drawing", "new_figure", "patch_gallery", "save", "section_gallery", "standard_figures", "standard_pictures",
    "style",
]  # fmt: skip
