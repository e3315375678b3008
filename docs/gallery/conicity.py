"""
Equivalent conicity
===================

Rolling radius difference, conicity over the amplitude, contact points and contact angles of a wheelset.
"""

# %%
# A scenario with ``analysis = "conicity"`` names wheel, rail, gauge and inclination.
from wrsim import load, run

result = run(load("../../scenarios/conicity_s1002.toml"))
figure = result.plot("conicity")
