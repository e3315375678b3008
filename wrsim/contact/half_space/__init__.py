"""The exact half-space solver: slow and trusted (docs/theory/half_space.md)."""

from wrsim.contact.half_space.patch import HalfSpaceContact, Patch, Region
from wrsim.contact.half_space.solver import HalfSpace

__all__ = ["HalfSpace", "HalfSpaceContact", "Patch", "Region"]
