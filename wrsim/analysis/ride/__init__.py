"""Ride: accelerations at points of a vehicle, their spectra, third-octaves and comfort."""
