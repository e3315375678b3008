"""The Exudyn system of a vehicle, its force law, integration and steady states."""

from typing import Literal

Integrator = Literal["generalised-alpha", "rk44"]
"""The implicit method of Chung and Hulbert in the form of Arnold and Bruls (Multibody System Dynamics 18, 2007); or
Runge-Kutta's explicit one of fourth order."""

DEFAULT_INTEGRATOR: Integrator = "generalised-alpha"
