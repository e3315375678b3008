"""Ride: accelerations at points of a vehicle, their spectra, third-octaves and comfort.

``evaluate_ride(result) -> Ride`` is a pure function of a result.
"""

from wrsim.analysis.ride.evaluate import evaluate_ride

__all__ = ["evaluate_ride"]
