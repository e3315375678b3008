"""
Modes of a bogie over speed
===========================

Root locus, damping and frequency of Cooperrider's bogie; the damping crosses zero at the critical speed.
"""

# %%
# Linear modes alone take seconds; the limit cycles of the same scenario take longer.
from wrsim import load, run

scenario = load("../../scenarios/stability_cooperrider.toml")
result = run(scenario.with_values({"stability.nonlinear": False}))
figure = result.plot()
