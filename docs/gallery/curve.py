"""
A wheelset in a curve
=====================

A scenario is loaded, shortened, run and looked at: forces, contact angles, one contact patch, medians in the full
curve.
"""

# %%
# ``load`` checks every key of the file. ``with_values`` gives another scenario with keys changed, in the units of the
# file: here the run ends in the full curve, and patches are stored at 20 m (straight) and 100 m (full curve).
from wrsim import load, run

scenario = load("../../scenarios/curve_r300.toml")
changes = {"run.distance_m": 120, "output.patches_at_m": [20, 100]}
result = run(scenario.with_values(changes))
result

# %%
# The guiding forces Y and the wheel loads Q over the distance. The transition begins at 30 m, the full curve at 70 m.
forces = result.plot("Y", "Q")

# %%
# The contact angle is not one number: it varies over a patch that bends around the gauge corner.
# The overview shows its range as a band.
angles = result.plot("overview")

# %%
# One patch as arrays, the one with the largest force. ``s`` is the curved axis, ``x`` the rolling direction; all in SI
# units.
patch = result.patch(100, "right")
print(f"N = {float(patch.N) / 1e3:.1f} kN, p0 = {float(patch.p0) / 1e6:.0f} MPa")
print(f"{patch.sizes['s']} strips carry {float(patch.strip_N.sum()) / 1e3:.1f} kN")

# %%
# Drawn in mm and MPa:
from matplotlib.figure import Figure

picture = Figure(figsize=(6.0, 3.0), layout="constrained")
axes = picture.add_subplot(aspect="equal")
pressure = 1e-6 * patch.p.where(patch.p > 0.0).T
mesh = axes.pcolormesh(1e3 * patch.s, 1e3 * patch.x, pressure, cmap="magma_r", vmin=0.0)
axes.set_xlabel("curved axis s [mm], field side to the right")
axes.set_ylabel("rolling direction x [mm]")
bar = picture.colorbar(mesh, label="pressure [MPa]")

# %%
# Medians in the full curve, as in ``summary.json``:
for curve in result.summary()["wheelsets"]["wheelset"]["full_curves"]:
    outer = curve["right"]
    print(f"R {curve['radius_m']:.0f} m, angle of attack {curve['yaw_mrad']:.2f} mrad")
    print(f"outer wheel: Y/Q {outer['Y_over_Q']:.3f}, T-gamma {outer['T_gamma_N']:.1f} N")
