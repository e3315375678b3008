"""
Wheel on rail in section
========================

One wheel at three shifts on its rail: outlines, patches and the pressure along the normals.
"""

# %%
# A right wheel is moved towards its flange under a constant load.
from wrsim import ContactSettings, Pose, contact_model, load_profile, solve_poses

wheel = load_profile("wheels/S1002.toml")
rail = load_profile("rails/60E1.toml").inclined(1 / 40)
model = contact_model(wheel, rail, radius=0.46, settings=ContactSettings())
poses = [Pose(lateral=-1e-3 * shift, load=60e3) for shift in (0.0, 4.0, 6.3)]
result = solve_poses(model, poses, side="right", rolling=False, title="S1002 on 60E1")
figure = result.plot("sections")
