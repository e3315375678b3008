"""
A coach in a curve
==================

Guiding forces of the four wheelsets of a coach that enters a curve of 300 m radius, as small multiples.
"""

# %%
# Kik and Piotrowski's model is quick enough for a look at forces.
from wrsim import load, run

scenario = load("../../scenarios/manchester_r300.toml")
quick = {"contact.normal": "kik-piotrowski", "run.distance_m": 130}
result = run(scenario.with_values(quick))

# %%
# A panel for each wheelset, all on one scale, over the place of each wheelset.
from wrsim.plots import standard_figures

figure = standard_figures(result.dataset)["vehicle_guiding"]()
