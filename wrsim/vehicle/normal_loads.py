"""What presses the surfaces of friction elements together: the forces of other elements at rest and in motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wrsim.errors import InputError, suggest
from wrsim.vehicle.elements import Triple
from wrsim.vehicle.elements.bilinear_spring import BilinearSpring

if TYPE_CHECKING:
    from wrsim.vehicle.preload import Preload
    from wrsim.vehicle.vehicle import Vehicle

LEAST = 1e-6
"""Part of the vehicle's weight that an element must carry at rest to press anything together."""


def normal_loads(vehicle: Vehicle, preloads: Sequence[Preload]) -> list[tuple[int, Triple] | None]:
    """Of every element whose friction depends on a load: the number of the element that gives the load, and what its
    reading is multiplied with, component by component. A load counts as positive that acts as it does at rest, or as
    the slider says.

    Raises InputError for an element that does not exist, whose own friction depends on a load, or that carries nothing
    at rest; and for a bilinear spring that does not.
    """
    for element, preload in zip(vehicle.elements, preloads, strict=True):
        if isinstance(element, BilinearSpring) and abs(preload.force[0]) < LEAST * vehicle.mass * vehicle.gravity:
            raise InputError(f"bilinear spring '{element.name}' carries nothing at rest: it must be under load there")
    numbers = {element.name: i for i, element in enumerate(vehicle.elements)}
    found: list[tuple[int, Triple] | None] = []
    for element in vehicle.elements:
        normal = None if element.slider is None else element.slider.normal
        if element.slider is None or normal is None:
            found.append(None)
            continue
        name = normal.of or element.name
        if name not in numbers:
            raise InputError(f"friction '{element.name}': there is no spring '{name}'{suggest(name, list(numbers))}")
        i = numbers[name]
        other = vehicle.elements[i]
        if normal.of and other.slider is not None and other.slider.normal is not None and other.slider.normal.of:
            raise InputError(f"friction '{element.name}': the friction of '{name}' depends on a load itself")
        if normal.sense is not None:
            x, y, z = element.slider.friction * normal.factor * normal.sense * np.eye(3)[normal.axis]
            found.append((i, (float(x), float(y), float(z))))
            continue
        at_rest = other.reading_at_rest(preloads[i].force)
        axis = normal.axis if len(other.directions) > 1 else int(np.argmax(np.abs(at_rest)))
        if abs(at_rest[axis]) < LEAST * vehicle.mass * vehicle.gravity:
            raise InputError(
                f"friction '{element.name}' has no normal force: '{name}' carries nothing along "
                f"{'xyz'[axis] if len(other.directions) > 1 else 'its direction'} at rest"
            )
        x, y, z = element.slider.friction * normal.factor * np.sign(at_rest[axis]) * np.eye(3)[axis]
        found.append((i, (float(x), float(y), float(z))))
    return found
