"""
Contact models on one wheel
===========================

One wheel is pushed sideways over its rail under a constant load. Two normal models and the exact solver tell pressure
and patch. No scenario file is needed.
"""

# %%
# Profiles come from files, the rail is laid with its inclination.
from wrsim import ContactSettings, Pose, contact_model, load_profile, solve_poses

wheel = load_profile("wheels/S1002.toml")
rail = load_profile("rails/60E1.toml").inclined(1 / 40)
shifts = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]  # mm, of a right wheel towards its flange
poses = [Pose(lateral=-1e-3 * shift, load=60e3) for shift in shifts]

# %%
# One ``ContactModel`` for each set of choices; ``solve_poses`` looks for the height that carries the load.
results = {}
for normal in ("kik-piotrowski", "strips", "half-space"):
    settings = ContactSettings(normal=normal)
    model = contact_model(wheel, rail, radius=0.46, settings=settings)
    frictionless = {"side": "right", "rolling": False}
    results[normal] = solve_poses(model, poses, **frictionless, title=normal)

# %%
# The largest pressure over the shift. ``dataset`` is labelled: wheelset, wheel and patch are dimensions of it.
from matplotlib.figure import Figure

figure = Figure(figsize=(6.5, 3.2), layout="constrained")
axes = figure.add_subplot()
looks = ("o-", "s--", "x:")
for (normal, result), look in zip(results.items(), looks, strict=True):
    largest = 1e-6 * result.dataset["p0"].max("patch").squeeze()
    axes.plot(shifts, largest, look, label=normal)
axes.set_xlabel("lateral shift towards the flange [mm]")
axes.set_ylabel("largest pressure [MPa]")
axes.set_ylim(0.0)
legend = axes.legend(frameon=False)

# %%
# How far the fast models are from the exact one, in the median over the poses:
exact = results["half-space"].dataset
for normal in ("kik-piotrowski", "strips"):
    ratio = results[normal].dataset["p0"].max("patch") / exact["p0"].max("patch")
    print(f"{normal:15s} {100 * (float(ratio.median()) - 1):+.1f} % in the median")

# %%
# Any channel can be drawn over the poses, and the patches of chosen poses with the pictures of the command line.
patches = results["half-space"].plot("patches")
