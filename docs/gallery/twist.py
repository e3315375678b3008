"""
A wagon on twisted track
========================

Wheel loads of a freight wagon on rails that are twisted there and back: friction of the suspension makes loops.
"""

# %%
# The test at rest of EN 14363 for running on twisted track.
from wrsim import load_vehicle
from wrsim.analysis.stationary.loops import twist_test
from wrsim.plots.vehicle import loops_figure

wagon = load_vehicle("vehicles/freight_y25.toml")
test = twist_test(wagon)
lines = [(f"{m.name} left", test.part, 1e-3 * test.wheel_loads[:, i, 0]) for i, m in enumerate(wagon.wheelsets[:2])]
figure = loops_figure(wagon.name, [("part of the full twists", "wheel load Q [kN]", lines)])
