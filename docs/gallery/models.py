"""
Contact models beside each other
================================

What three contact models find in the same poses, and how far they are from the reference.
"""

# %%
# The reference lies on top, in black.
from wrsim import load
from wrsim.analysis.compare import compare_models
from wrsim.plots.compare import values_figure

scenario = load("../../scenarios/static_s1002.toml")
comparison = compare_models(scenario, ["strips", "kik-piotrowski"])
figure = values_figure(comparison.values, comparison.reference, scenario.title)
