"""What a force law computes at sampled states, in a copy of its workspace: a run may go on with the law meanwhile."""

from typing import Any

import numpy as np

from wrsim.contact.patches import RawContacts
from wrsim.errors import SimulationError
from wrsim.simulation.force_law import Array
from wrsim.simulation.law import OFF_TRACK, VehicleOnTrack
from wrsim.vehicle.dynamics import vehicle_forces
from wrsim.vehicle.dynamics.sampling import forces_in_turn


class SampledForces:
    """Forces and contacts at states in the order of time, each from the contacts of the one before.

    ``forces`` (room, size): generalised forces; ``lost``: why a state could not be evaluated, if one could not. What
    the law knows of each state besides: `of`.
    """

    def __init__(self, law: VehicleOnTrack, room: int, strips: bool) -> None:
        """room: states that are kept; strips: whether the strips of their contacts are kept as well."""
        self.law, self.lost = law, ""
        views, workspace = law.workspace.views, law.workspace
        with law.following():  # the first state from a cold start
            self._buffer = workspace.buffer.copy() if law.compiled else workspace.buffer
        kept: dict[str, Any] = {
            "reading": law.readings, "loss": law.elements["loss"], "unit": views[vehicle_forces.UNITS],
            "load": views[vehicle_forces.LOADS], "axle": law.axles,
        }  # fmt: skip
        kept |= {"wagon": views[vehicle_forces.WAGONS]["loss"]} if len(law.wagons) else {}
        for i, model in enumerate(wheel.model for pair in law.wheels for wheel in pair):
            rows = model.arrays.rows
            kept |= {f"patches {i}": rows.patches, f"total {i}": rows.total, f"pose {i}": rows.pose}
            kept |= {f"strips {i}": rows.strips} if strips else {}
        self._layout: dict[str, tuple[slice, Any, tuple[int, ...]]] = {}
        places, end = [], 0
        for name, view in kept.items():
            places.append(workspace.places(view))
            self._layout[name] = slice(end, end := end + len(places[-1])), view.dtype, view.shape
        self._places = np.concatenate(places)
        self.forces, self._rows = np.zeros((room, law.size)), np.zeros((room, end))

    def evaluate(self, first: int, times: Array, q: Array, q_t: Array, places: Array) -> int:
        """Take states (n, size) at times (n,) [s] into the rows from ``first`` on; places: see `VehicleOnTrack.places`.
        Returns how many come before one that the law cannot evaluate."""
        law, to = self.law, slice(first, first + len(times))
        forces, rows = self.forces[to], self._rows[to]
        if law.compiled:
            starts = law.search_starts(places)
            memory = self._buffer, law.workspace.index
            n = int(forces_in_turn(times, q, q_t, law.seeds, starts, self._places, forces, rows, *memory))
            if n < len(times):
                self.lost = OFF_TRACK.format(times[n])
            return n
        with law.following():
            for i in range(len(times)):
                law.set_search_start(places[i])
                try:
                    law(times[i], q[i], q_t[i], forces[i])
                except SimulationError as error:
                    self.lost = str(error)
                    return i
                rows[i] = self._buffer[self._places]
        return len(times)

    def of(self, name: str, n: int) -> Any:
        """What the law knows of the first n states, (n, ...): ``reading`` of all elements and their ``loss``, records
        ``unit``, ``load``, ``axle``, the loss ``wagon`` of vehicles along the track alone; of every wheel ``pose``,
        ``total``, ``patches``, ``strips``, its number behind."""
        columns, kind, shape = self._layout[name]
        return self._rows[:n, columns].view(kind).reshape(n, *shape)

    def contacts(self, n: int) -> list[RawContacts]:
        """Contacts of every wheelset at the first n states."""
        patches, totals = (
            [self.of(f"{part} {i}", n) for i in range(2 * len(self.law.wheels))] for part in ("patches", "total")
        )
        return [
            RawContacts(np.stack(patches[i : i + 2], axis=1), np.concatenate(totals[i : i + 2], axis=1))
            for i in range(0, len(patches), 2)
        ]
