"""Pictures of a result. Functions take and return matplotlib axes, and compute nothing but what drawing needs.

``standard_pictures(dataset, directory)`` writes the set that suits the analysis; the functions below it draw single
panels on axes of the caller, or whole figures without pyplot.
"""

from wrsim.plots.cross_section import cross_section, cross_section_zoom, section_gallery
from wrsim.plots.drawing import drawing
from wrsim.plots.histories import (
    channels_figure,
    contact_angle,
    history,
    mark_snapshots,
    overview_figure,
    stacked,
    track_layout,
)
from wrsim.plots.marks import mark_stop
from wrsim.plots.moments import PatchAt, choose_moments
from wrsim.plots.patches import contact_patch, patch_gallery, pressure_scale
from wrsim.plots.pictures import standard_figures, standard_pictures
from wrsim.plots.static import against_pose, static_figure
from wrsim.plots.style import new_figure, save, style

__all__ = [
    "PatchAt",
    "against_pose",
    "channels_figure",
    "choose_moments",
    "contact_angle",
    "contact_patch",
    "cross_section",
    "cross_section_zoom",
    "drawing",
    "history",
    "mark_snapshots",
    "mark_stop",
    "new_figure",
    "overview_figure",
    "patch_gallery",
    "pressure_scale",
    "save",
    "section_gallery",
    "stacked",
    "standard_figures",
    "standard_pictures",
    "static_figure",
    "style",
    "track_layout",
]
