"""What the samples of a run miss: how far vertical wheel forces go beyond them at the steps that lie between.

Samples every 10 ms show what rings at 113 Hz as a slow swing of 13 Hz, and miss its peaks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from wrsim.contact.model import ContactModel
    from wrsim.simulation.system import Array

PART = 0.05
"""Part of the mean wheel load beyond which it is told."""


@dataclass(frozen=True)
class Missed:
    """Force of a wheel between samples [N]: what it reaches, and by how much beyond the samples beside it.

    time [s], distance of the vehicle [m].
    """

    wheel: int
    force: float
    beyond: float
    time: float
    distance: float


class Between:
    """Looks at the forces after every step, as the law has computed them last; costs no evaluation."""

    def __init__(self, wheels: Sequence[ContactModel]) -> None:
        self.forces = [model.arrays.rows.total["Fb"] for model in wheels]
        n = len(self.forces)
        self.sample, self.sampled = np.zeros(n), False
        self.steps: list[list[float]] = []
        """Rows (time, distance, forces) of the steps since the last sample."""
        self.worst = np.zeros((n, 4))
        """Of every wheel: beyond the samples by, force, time, distance."""

    def step(self, t: float, distance: float, sampled: bool) -> None:
        """After a step at time t [s]; sampled: whether its state is kept."""
        row = [force.item() for force in self.forces]
        if not sampled:
            self.steps.append([t, distance, *row])
            return
        forces = np.array(row)
        if self.steps and self.sampled:
            rows = np.array(self.steps)
            high, low = np.maximum(self.sample, forces), np.minimum(self.sample, forces)
            beyond = np.maximum(rows[:, 2:] - high, low - rows[:, 2:])
            at = np.argmax(beyond, axis=0)
            for i in np.flatnonzero(beyond.max(axis=0) > self.worst[:, 0]):
                place = rows[at[i]]
                self.worst[i] = beyond[at[i], i], place[2 + i], place[0], place[1]
        self.steps.clear()
        self.sample, self.sampled = forces, True

    def missed(self, wheel_load: float) -> Missed | None:
        """The largest of what the samples do not show, if it is a considerable part of the load [N]."""
        if not self.worst.size:
            return None
        i = int(np.argmax(self.worst[:, 0]))
        beyond, force, time, distance = self.worst[i].tolist()
        return Missed(i, force, beyond, time, distance) if beyond > PART * wheel_load else None

    def memory(self) -> Array:
        """See ``simulation.recorder.Remembers``."""
        rows = np.ravel(self.steps)
        return np.concatenate([[float(len(self.steps)), float(self.sampled)], self.sample, self.worst.ravel(), rows])

    def recall(self, memory: Array) -> None:
        """Put back what ``memory`` gave."""
        count, n = int(memory[0]), self.sample.size
        self.sampled, self.sample, rest = bool(memory[1]), memory[2 : 2 + n].copy(), memory[2 + n :]
        self.worst = rest[: 4 * n].reshape(n, 4).copy()
        self.steps = rest[4 * n :].reshape(count, 2 + n).tolist()
