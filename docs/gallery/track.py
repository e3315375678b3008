"""
A track from above
==================

Plan, curvature, cant and gauge of the track of a scenario: two curves of opposite hand.
"""

# %%
# The track of a scenario is built without a run.
from wrsim import load
from wrsim.plots.track import track_figure
from wrsim.scenario.build import build

figure = track_figure(build(load("../../scenarios/s_curve.toml")).track)
