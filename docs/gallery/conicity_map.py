"""
Conicity over the gauge
=======================

Equivalent conicity and nonlinearity parameter of one pair of profiles where the gauge changes.
"""

# %%
# A folder in place of a profile gives a line, or a row of a map, for each profile in it.
from wrsim.analysis.conicity.pairs import Pairing
from wrsim.plots.conicity import conicity_map_figure

pairing = Pairing(1.36, "1:40", "none")
conicities = pairing.map("wheels/S1002.toml", "rails/60E1.toml", (1430.0, 1440.0, 2.5), 0.46)
figure = conicity_map_figure(conicities, conicities.title)
