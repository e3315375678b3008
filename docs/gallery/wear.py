"""
Where profiles wear
===================

Depth that one passage of a curve takes off the profiles of a wheelset and of its rails, by two laws.
"""

# %%
# ``[wear]`` of a scenario names the laws.
from wrsim import load, run

scenario = load("../../scenarios/curve_r300.toml")
laws = {"run.distance_m": 110, "output.patches_at_m": [100], "wear.laws": ["usfd", "archard"]}
figure = run(scenario.with_values(laws)).plot("wear")
