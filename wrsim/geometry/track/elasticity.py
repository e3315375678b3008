"""Elastic rails: what holds the piece of rail under a wheel."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RailElasticity:
    """A mass on a spring and a damper under each wheel, that moves along with it; lateral, then vertical.

    stiffness [N/m], damping [N s/m], mass [kg] of the rail, and of what moves with it, as one wheel feels it. The
    pieces of two wheels, and of two rails, know nothing of each other; what a wheel has pushed down is forgotten when
    it has passed.
    """

    stiffness: tuple[float, float]
    damping: tuple[float, float]
    mass: tuple[float, float]
