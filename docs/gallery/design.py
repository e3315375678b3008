"""
A design study: which profile, which friction
=============================================

A vehicle in steady curves, without running through them: how the wear number of the leading outer wheel depends on the
curve, with new and with worn wheels, on dry and on greased rails.
"""

# %%
# ``analysis = "steady"`` balances all forces in a full curve by Newton's method. Changed keys make the variants. Of
# forces alone Kik-Piotrowski's model gives an idea in seconds; the usual strip model takes longer.
from wrsim import load, run

radii = [1500, 800, 500, 300]
scenario = load("../../scenarios/steady_manchester.toml")
quick = {"contact.normal": "kik-piotrowski", "steady.speed_kmh": 60}
base = scenario.with_values({"steady.radius_m": radii} | quick)
variants = {
    "S1002, dry": {},
    "S1002, greased": {"contact.friction": 0.15},
    "worn, dry": {"vehicle.wheel": "wheels/S1002_worn.toml"},
}
results = {name: run(base.with_values(keys)) for name, keys in variants.items()}
results["S1002, dry"]

# %%
# In a left curve the right wheel of the leading wheelset guides.
from matplotlib.figure import Figure

leading = results["S1002, dry"].dataset["wheelset"].values[0]
figure = Figure(figsize=(6.5, 3.4), layout="constrained")
wear, quotient = figure.subplots(1, 2)
for (name, result), marker in zip(results.items(), "os^", strict=True):
    outer = result.wheelset(leading).sel(wheel="right")
    curvature = 1e3 / outer["pose_radius"]
    wear.plot(curvature, outer["T_gamma"], marker=marker, ms=4, label=name)
    quotient.plot(curvature, outer["Y_over_Q"], marker=marker, ms=4)
wear.set(xlabel="curvature [1/km]", ylabel=r"wear number $T\gamma$ [N]")
quotient.set(xlabel="curvature [1/km]", ylabel="derailment quotient Y/Q")
legend = wear.legend(frameon=False)

# %%
# The same as a table; units are in ``table.attrs["units"]``.
table = results["S1002, greased"].to_dataframe(leading)
table[[("", "", "pose_radius"), ("", "right", "T_gamma"), ("", "right", "Y_over_Q"), ("", "", "yaw")]]

# %%
# For hundreds of variants on many processors take ``wrsim study``.
