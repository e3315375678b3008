"""
Friction that falls with slip
=============================

Coefficient of friction over the slip velocity, for three laws of falling friction.
"""

# %%
# ``Friction`` holds the law; a contact model takes it in place of a mere number.
import numpy as np
from matplotlib.figure import Figure

from wrsim import Friction

slip = np.linspace(0.0, 2.0, 201)
figure = Figure(figsize=(6.5, 3.2), layout="constrained")
axes = figure.add_subplot()
for ratio, look in ((1.0, "-"), (0.6, "--"), (0.4, ":")):
    law = Friction(0.35, falling_ratio=ratio, falling_decay=0.6)
    values = law.static * ((1.0 - ratio) * np.exp(-law.falling_decay * slip) + ratio)
    axes.plot(slip, values, look, label=f"A = {ratio:g}")
axes.set(xlabel="slip velocity [m/s]", ylabel="coefficient of friction", ylim=(0.0, 0.4))
legend = axes.legend(frameon=False)
