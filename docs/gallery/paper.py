"""
A picture for a paper
=====================

The same pictures for a column of 85 mm, in the letters of the text around them.
"""

# %%
# ``wrsim plot RESULT --width-mm 85 --font "DejaVu Serif" --format svg,pdf`` does the same on the command line.
from wrsim import load, look, run

result = run(load("../../scenarios/curve_r300.toml").with_values({"run.distance_m": 110, "output.patches_at_m": [100]}))
with look(width_mm=85, font="DejaVu Serif"):
    figure = result.plot("Y", "Y_over_Q")
