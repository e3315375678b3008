"""
Nadal's limit
=============

Quotient Y/Q above which a wheel in full slip climbs its flange, over friction and the angle of the flange.
"""

# %%
# The same function gives the limit in an assessment.
import numpy as np
from matplotlib.figure import Figure

from wrsim.assessment.nadal import nadal_limit

friction = np.linspace(0.1, 0.6, 51)
figure = Figure(figsize=(6.5, 3.2), layout="constrained")
axes = figure.add_subplot()
for angle, look in ((60.0, ":"), (65.0, "--"), (70.0, "-")):
    limits = [nadal_limit(np.radians(angle), mu) for mu in friction]
    axes.plot(friction, limits, look, label=f"flange of {angle:g}°")
axes.axhline(0.8, color="#b00020", linewidth=0.8)
axes.set(xlabel="coefficient of friction", ylabel="limit of Y/Q", ylim=(0.0, 2.5))
legend = axes.legend(frameon=False)
