"""
Two runs over each other
========================

A wheelset in a curve on dry and on greased rails.
"""

# %%
# Two scenarios that differ in one key.
from wrsim import load, run
from wrsim.plots.compare import overlay_figure

scenario = load("../../scenarios/curve_r300.toml").with_values({"run.distance_m": 110, "output.patches_at_m": [100]})
values = {"dry, 0.35": 0.35, "greased, 0.15": 0.15}
results = [run(scenario.with_values({"contact.friction": mu})) for mu in values.values()]
figure = overlay_figure([result.wheelset() for result in results], list(values))
