"""
Contacts over the lateral shift
===============================

Contact angle, pressure, normal force and area of both wheels of a wheelset that is moved sideways.
"""

# %%
# The scenario is a list of poses. Here Kik and Piotrowski's model solves them: it takes seconds.
from wrsim import load, run

scenario = load("../../scenarios/static_s1002.toml").with_values({"contact.normal": "kik-piotrowski"})
figure = run(scenario).plot("contact")
