"""
A wheel profile
===============

Shape, slope and curvature of a profile. Curvature decides where a patch is narrow.
"""

# %%
# ``load_profile`` reads TOML files, tables of points, MiniProf and SIMPACK files.
from wrsim import load_profile
from wrsim.plots.profile import profile_figure

figure = profile_figure(load_profile("wheels/S1002.toml"))
