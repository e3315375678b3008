"""The workspace of contact kernels: arrays packed into one buffer, and those of one wheel by their names."""

from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.contact import records as k
from wrsim.contact.arrays import Arrays
from wrsim.contact.strips.records import V
from wrsim.contact.wheel_rail import search, wheel_rail
from wrsim.jit import Array, Records

WARM_TOLERANCE = 1e-9  # of the strip model from its last contact, over the deepest penetration: that of a cold start
ALIGNMENT = 8  # doubles: every array starts on a cache line of its own


@dataclass(frozen=True)
class Workspace:
    """One buffer, its index (K, 4), and the arrays as views on it: what kernels write is seen in the views."""

    buffer: Array
    index: NDArray[np.int64]
    views: tuple[NDArray[Any], ...]

    def part(self, first: int, count: int) -> "Workspace":
        """``count`` of the arrays as a workspace of their own, in the same buffer."""
        return Workspace(self.buffer, self.index[first : first + count], self.views[first : first + count])

    def places(self, view: NDArray[Any]) -> NDArray[np.int64]:
        """Places in the buffer, in a row, of all numbers of a view on it."""
        begin = view.__array_interface__["data"][0] - self.buffer.__array_interface__["data"][0]
        places = np.array(begin // 8)
        for count, stride in zip(view.shape, view.strides, strict=True):
            places = np.add.outer(places, np.arange(count) * (stride // 8))
        if view.dtype.itemsize > 8:
            places = np.add.outer(places, np.arange(view.dtype.itemsize // 8))
        return places.ravel()

    def mutable_slices(self, left_out: Container[int]) -> list[Array]:
        """Views on the slices of the buffer that hold all arrays but those with these numbers."""
        slices: list[list[int]] = []
        for i, view in enumerate(self.views):
            if i in left_out:
                continue
            begin = int(self.index[i, 0])
            end = begin + packed_size(view)
            if slices and slices[-1][1] == begin:
                slices[-1][1] = end
            else:
                slices.append([begin, end])
        return [self.buffer[begin:end] for begin, end in slices]


def packed_size(array: NDArray[Any]) -> int:
    """How many numbers of a buffer an array takes."""
    return -(-array.nbytes // 8 // ALIGNMENT) * ALIGNMENT


def pack(arrays: Sequence[NDArray[Any]]) -> Workspace:
    """Copy arrays of one to three dimensions, or of one or two with records, into a new workspace. An array given more
    than once (the same object: a table that wheels share) is copied once."""
    index = np.zeros((len(arrays), 4), dtype=np.int64)
    end = 0
    places: dict[int, int] = {}
    for row, array in zip(index, arrays, strict=True):
        shape = array.shape if array.dtype.names is None else (*array.shape, array.dtype.itemsize // 8)
        row[1 : 1 + len(shape)] = shape
        if id(array) in places:
            row[0] = places[id(array)]
            continue
        row[0] = places[id(array)] = end
        end += packed_size(array)
    buffer = np.zeros(end)
    views = []
    for row, array in zip(index, arrays, strict=True):
        numbers = buffer[row[0] : row[0] + array.nbytes // 8]
        numbers[:] = np.ascontiguousarray(array).view(np.float64).ravel()  # records would be copied field by field
        views.append(numbers.view(array.dtype).reshape(array.shape))
    return Workspace(buffer, index, tuple(views))


class KernelArrays:
    """The arrays of one wheel on one rail by their names (contact.arrays.Arrays), and the kernel on them."""

    def __init__(self, workspace: Workspace, follows: bool) -> None:
        """follows: whether the normal model can start from the contact of the last call."""
        self.buffer, self.index, self._follows = workspace.buffer, workspace.index, follows
        self.rows = Arrays(*workspace.views)
        self.wheel: Array = self.rows.wheel
        self.rail: Array = self.rows.rail
        self.rows.model.flags.writeable = False
        self.model: Any = self.rows.model[0]
        self.inputs: Any = self.rows.call[0]
        self.pose: Array = self.rows.pose
        self.state: Any = self.rows.state[0]
        self.contacts: Records = self.rows.contacts
        self.patches: Records = self.rows.patches
        self.strips: Records = self.rows.strips
        self.total: Any = self.rows.total[0]
        # views of one number each: a run reads them after every step
        self._status, self._substitutes = self.rows.total["status"], self.rows.memo["substitutes"]

    @property
    def force(self) -> Array:
        """On the wheel (t, o, b) [N]."""
        return np.array([self.total.Ft, self.total.Fo, self.total.Fb])

    @property
    def moment(self) -> Array:
        """On the wheel about its profile origin (t, o, b) [N m]."""
        return np.array([self.total.Mt, self.total.Mo, self.total.Mb])

    def set_call(
        self, place: float = 0.0, turning: tuple[float, float, float] = (0.0, 0.0, 0.0), wheel_angle: float = 0.0
    ) -> None:
        """Set what an evaluation needs besides the pose; see `ContactModel.evaluate`."""
        self.inputs.place, self.inputs.wheel_angle = place, wheel_angle
        self.inputs.twist, self.inputs.bow_o, self.inputs.bow_b = turning

    def evaluate(self) -> int:
        """Run the kernel on the pose that is set; returns its status."""
        return int(wheel_rail(self.buffer, self.index))

    def search(self) -> tuple[int, int]:
        """Look for contacts at the pose that is set, see ``contacts``; returns their number and the status."""
        count, status = search(self.buffer, self.index)
        return int(count), int(status)

    @property
    def status(self) -> int:
        """Status of the contact found last, see `wrsim.contact.status`."""
        return self._status.item()

    @property
    def substitutes(self) -> int:
        """Calls so far in which the strip model was not solved and a substitute was used."""
        return self._substitutes.item()

    def follow(self, on: bool, tolerance: float = WARM_TOLERANCE) -> None:
        """From now on the strip model starts from the contact solved last (in runs), or cold each time. Its answer
        is the same to this tolerance."""
        self.state.start = k.FROM_LAST if on else k.COLD_START
        self.state.tolerance = tolerance
        self.rows.memo["grids_before"] = 0

    def kept(self) -> tuple[NDArray[Any], ...]:
        """Views on what one call leaves for the next: the last contact, if the model follows it. Who puts them back
        gives up the inverse that is stored besides (``rows.memo``)."""
        if not (self._follows and self.state.start):
            return ()
        grids, places = self.rows.grids, self.rows.places
        memo = self.rows.memo
        return (
            memo["grids_before"], memo["substitutes"], self.rows.vectors[V.X],
            *(grids[name] for name in ("active", "start_held", "end_held")),
            *(places[name] for name in ("lo", "hi", "s")),
        )  # fmt: skip
