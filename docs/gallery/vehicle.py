"""
A vehicle from three sides
==========================

Bodies, wheels, springs, dampers and stops of a vehicle file, to one scale.
"""

# %%
# The picture shows at once where an element was fixed at the wrong place.
from wrsim import load_vehicle
from wrsim.plots.vehicle import vehicle_figure

figure = vehicle_figure(load_vehicle("vehicles/manchester_1.toml"))
