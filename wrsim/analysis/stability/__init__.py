"""Stability of a vehicle on straight track: modes over speed, linear and nonlinear critical speed, limit cycles."""
