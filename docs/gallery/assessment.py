"""
An assessment against its limits
================================

Which part of each limit of EN 14363 a run uses: every section is a point, the worst one a bar.
"""

# %%
# The coach of the page before, a little further into the curve.
from wrsim import load, run

scenario = load("../../scenarios/manchester_r300.toml")
quick = {"contact.normal": "kik-piotrowski", "run.distance_m": 150}
result = run(scenario.with_values(quick))

# %%
# Values are filtered as the standard asks, section by section of the track.
from wrsim.assessment.assess import assess_runs
from wrsim.plots.assessment import limits_figure

figure = limits_figure(assess_runs(result))
