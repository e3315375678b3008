"""Stress tensors and their measures. Axes: x along the rail, s across, z into the body; tension is positive."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wrsim.jit import Array

PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Places of the six components in a tensor."""


@dataclass(frozen=True)
class Stress:
    """Stresses at points: components (..., 6) xx, ss, zz, sz, xz, xs [Pa]."""

    components: Array

    @property
    def tensor(self) -> Array:
        """(..., 3, 3) [Pa]."""
        tensor = np.empty((*self.components.shape[:-1], 3, 3))
        for k, (i, j) in enumerate(PAIRS):
            tensor[..., i, j] = tensor[..., j, i] = self.components[..., k]
        return tensor

    @cached_property
    def principal(self) -> Array:
        """Principal stresses (..., 3) by falling value [Pa]."""
        return np.asarray(np.linalg.eigvalsh(self.tensor)[..., ::-1], dtype=np.float64)

    @property
    def mean(self) -> Array:
        """Hydrostatic stress, a third of the trace [Pa]."""
        return np.asarray(self.components[..., :3].mean(axis=-1))

    @property
    def von_mises(self) -> Array:
        """Equivalent stress of von Mises (sub-mises) [Pa]."""
        normal, shear = self.components[..., :3], self.components[..., 3:]
        differences = normal - np.roll(normal, 1, axis=-1)
        return np.sqrt(0.5 * (differences**2).sum(axis=-1) + 3.0 * (shear**2).sum(axis=-1))

    @property
    def tresca(self) -> Array:
        """Equivalent stress of Tresca: difference of the extreme principal stresses, twice the largest shear [Pa]."""
        return np.asarray(self.principal[..., 0] - self.principal[..., 2])
