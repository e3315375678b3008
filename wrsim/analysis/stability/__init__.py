"""Stability of a vehicle on straight track: modes over speed, linear and nonlinear critical speed, limit cycles."""

from wrsim.analysis.stability.run import run_stability

__all__ = ["run_stability"]
