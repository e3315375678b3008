"""Stationary tests of a vehicle: wheel unloading on a twisted track, resistance of its bogies against rotation."""
