"""Elastic modes of a body: from a file of frequencies and mode shapes, or those of a beam; [bodies.NAME.flexible].

Modes are those of the free body. Their equations: ``dynamics.flexible``.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.inputs.csv_tables import are_allowed
from wrsim.inputs.mode_tables import SLOWEST_MODE, check_number, of_modes, read_mode_table
from wrsim.inputs.section import Section
from wrsim.inputs.toml_files import read_bytes
from wrsim.inputs.values import number, positive, requirement, text
from wrsim.vehicle.elements import Array

_Frequency = Annotated[float, number(SLOWEST_MODE, 1500, "Hz")]
_Damping = Annotated[float, number(0, 1, "of critical")]
_Place = Annotated[float, number(-1e5, 1e5, "mm in the axes of the vehicle or part")]
_Shift = Annotated[float, number(-1e6, 1e6, "per unit of the mode")]
_Turn = Annotated[float, number(-1e6, 1e6, "rad per m of the mode")]
MODE_COLUMNS = of_modes(1500.0, 1e6)
PLACES = dict.fromkeys(("x_mm", "y_mm", "z_mm"), _Place)
SHIFTS, TURNS = dict.fromkeys(("ux", "uy", "uz"), _Shift), dict.fromkeys(("rx", "ry", "rz"), _Turn)
"""Columns of a file of modes; those of turns may be left out."""


@dataclass(frozen=True, eq=False)
class Modes(ABC):
    """Modes of a free body: frequencies [Hz], damping ratios, modal masses [kg], each (n,)."""

    frequencies: Array
    damping: Array
    masses: Array

    @abstractmethod
    def shapes(self, points: Array) -> Array:
        """Displacement [1] and turn [1/m] along x, y, z (n, p, 6) at points (p, 3) of the vehicle [m]. Raises
        InputError for a point that the modes do not reach."""

    def gyroscopic(self) -> tuple[Array, Array]:
        """Sums G (n, n) and g (n, 3) of ``dynamics.flexible``; 0 for what does not spin."""
        n = len(self.frequencies)
        return np.zeros((n, n)), np.zeros((n, 3))


def carried(arms: Array, shapes: Array) -> Array:
    """Displacement and turn (n, p, 6) of points that stiff arms (p, 3) carry from points with these (n, p, 6)."""
    motion = shapes.copy()
    motion[..., :3] += np.cross(shapes[..., 3:], arms)
    return motion


@dataclass(frozen=True, eq=False)
class PointModes(Modes):
    """Modes given at points.

    points (p, 3) [m] and values (n, p, 6) in the axes of a part; origin, signs: of these axes in the vehicle's; reach:
    how far stiff arms lead from a point [m]; source: for messages.
    """

    points: Array
    values: Array
    reach: float
    source: str = ""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    signs: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def save(self, path: str | Path) -> Path:
        """Write an NPZ file that ``[bodies.NAME.flexible] modes`` takes; in the axes of the points. Raises InputError
        where there is a file already."""
        path = Path(path)
        if path.suffix != ".npz" or path.exists():
            raise InputError(f"{path}: " + ("exists already" if path.exists() else "must end in .npz"))
        np.savez(
            path, frequency_Hz=self.frequencies, damping=self.damping, modal_mass_kg=self.masses,
            points_mm=1e3 * self.points, shapes=self.values,
        )  # fmt: skip
        return path

    def shapes(self, points: Array) -> Array:
        signs = np.array(self.signs)
        arms = (points - np.array(self.origin)) * signs
        far = np.linalg.norm(arms[:, None] - self.points, axis=-1)
        nearest = np.argmin(far, axis=1)
        worst = int(np.argmax(far[np.arange(len(arms)), nearest], axis=0)) if len(arms) else 0
        if len(arms) and (away := far[worst, nearest[worst]]) > self.reach:
            x, y, z = 1e3 * arms[worst]
            raise InputError(
                f"{self.source}: no point of the modes lies near the attachment at x = {x:.5g}, y = {y:.5g}, "
                f"z = {z:.5g} mm: the nearest is {1e3 * away:.4g} mm away; allowed: reach_mm = {1e3 * self.reach:g}"
            )
        motion = carried(arms - self.points[nearest], self.values[:, nearest])
        return np.asarray(motion * np.append(signs, np.prod(signs) * signs))


def read_modes(path: Path, reach: float) -> PointModes:
    """Modes in a CSV file (``wrsim.inputs.mode_tables``) or in an NPZ file of arrays ``frequency_Hz``, ``damping``,
    ``modal_mass_kg`` (n,), ``points_mm`` (p, 3), ``shapes`` (n, p, 3 or 6). Raises InputError."""
    frequencies, damping, masses, points, values = (_from_npz if path.suffix == ".npz" else _from_csv)(path)
    largest = np.abs(values[..., :3]).max(axis=(1, 2))
    if not largest.all():
        raise InputError(f"{path}: mode {int(np.argmin(largest)) + 1} moves no point")
    scaled = values / largest[:, None, None]
    return PointModes(frequencies, damping, masses / largest**2, points, scaled, reach, str(path))


ModeArrays = tuple[Array, Array, Array, Array, Array]


def _from_csv(path: Path) -> ModeArrays:
    table = read_mode_table(path, MODE_COLUMNS, PLACES, SHIFTS | TURNS, list(SHIFTS))
    return table.frequencies, table.damping, table.masses, table.places / 1e3, table.shapes


def _from_npz(path: Path) -> ModeArrays:
    kinds = {name: MODE_COLUMNS[name] for name in ("frequency_Hz", "damping", "modal_mass_kg")}
    kinds |= {"points_mm": _Place, "shapes": _Shift}
    try:
        with zipfile.ZipFile(io.BytesIO(read_bytes(path, "file of modes"))) as archive:
            missing = [name for name in kinds if f"{name}.npy" not in archive.namelist()]
            if missing:
                raise InputError(f"{path}: array '{missing[0]}' is missing; a file of modes has {', '.join(kinds)}")
            parts = [io.BytesIO(archive.read(f"{name}.npy")) for name in kinds]
        arrays = [np.lib.format.read_array(part, allow_pickle=False) for part in parts]
    except (OSError, ValueError, EOFError, MemoryError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"{path}: is no NPZ file of modes ({error})") from None
    n, p = (max(np.shape(array)[:1], default=1) for array in (arrays[0], arrays[3]))
    check_number(path, n)
    wanted = [(n,), (n,), (n,), (p, 3), (n, p, 3 if arrays[4].shape[-1:] == (3,) else 6)]
    for (name, kind), array, shape in zip(kinds.items(), arrays, wanted, strict=True):
        if array.shape != shape or array.dtype.kind not in "iuf" or not array.size:
            raise InputError(f"{path}: array '{name}' must be real numbers in the shape {shape}, at least one")
        if not are_allowed(kind, array):
            raise InputError(f"{path}: array '{name}': each must be {requirement(kind)}")
    frequencies, damping, masses, points, values = (np.asarray(array, dtype=float) for array in arrays)
    if values.shape[2] == 3:
        values = np.concatenate([values, np.zeros_like(values)], axis=2)
    return frequencies, damping, masses, points / 1e3, values


def free_roots(count: int) -> Array:
    """Roots of cos(x) cosh(x) = 1 above 0: wave numbers of the modes of a free beam times its length."""
    guesses = np.pi * (np.arange(count) + 1.5)
    return np.array(
        [scipy.optimize.brentq(lambda x: np.cos(x) - 1.0 / np.cosh(x), g - 0.1, g + 0.1, xtol=1e-14) for g in guesses]
    )


@dataclass(frozen=True, eq=False)
class BeamModes(Modes):
    """Bending modes of a free uniform beam along x without shear: roots of ``free_roots`` and planes (0: vertical, 1:
    lateral) (n,), its middle (3,) and its length [m]."""

    roots: Array
    planes: NDArray[np.intp]
    middle: Array
    length: float

    @classmethod
    def of_body(
        cls, mass: float, middle: tuple[float, float, float], length: float, frequencies: tuple[float | None, ...],
        count: int, damping: float,
    ) -> BeamModes:  # fmt: skip
        """frequencies: of the first mode in each plane [Hz], None: stiff; count: modes in a plane. The others have
        frequencies in proportion to the squares of their roots; all have a quarter of the mass, for an end moves by 1.
        """
        roots = free_roots(count)
        planes = np.array([i for i, first in enumerate(frequencies) if first is not None])
        rising = np.concatenate([(roots / roots[0]) ** 2 * f for f in frequencies if f is not None])
        even, repeated = np.ones(len(rising)), np.tile(roots, len(planes))
        return cls(
            rising, damping * even, 0.25 * mass * even, repeated, np.repeat(planes, count), np.array(middle), length
        )

    def shapes(self, points: Array) -> Array:
        arms = points - self.middle
        along = np.clip(arms[:, 0] / self.length + 0.5, 0.0, 1.0)
        values = np.zeros((len(self.roots), len(points), 6))
        for shape, k, plane in zip(values, self.roots, self.planes, strict=True):
            moved, slope = _free_shape(k, along)
            shape[:, 2 - plane] = moved
            shape[:, 4 + plane] = (slope if plane else -slope) / self.length
        arms[:, 0] = 0.0
        return carried(arms, values)


def _free_shape(k: float, x: Array) -> tuple[Array, Array]:
    """Deflection of a free beam of length 1 in the mode with the root k, 1 at x = 0, and its slope."""
    s = (np.cosh(k) - np.cos(k)) / (np.sinh(k) - np.sin(k))
    # cosh - s sinh without the difference of large numbers
    near, far = 0.5 * (1.0 + s) * np.exp(-k * x), 0.5 * (1.0 - s) * np.exp(k * x)
    moved = near + far + np.cos(k * x) - s * np.sin(k * x)
    slope = k * (far - near - np.sin(k * x) - s * np.cos(k * x))
    return 0.5 * moved, 0.5 * slope


class FlexibleTable(Section, header="[bodies.NAME.flexible]"):
    """[bodies.NAME.flexible]: elastic modes of a body, from a file or those of a free uniform beam along x."""

    one_of = ("modes length_mm",)
    goes_with: ClassVar[dict[str, str]] = dict.fromkeys(
        ("first_vertical_Hz", "first_lateral_Hz", "count", "damping"), "length_mm"
    ) | {"length_mm": "first_vertical_Hz first_lateral_Hz"}

    modes: Annotated[str, text('a CSV or NPZ file such as "carbody_modes.csv"')] | None = None
    """File of frequencies, damping, modal masses and mode shapes at points."""
    reach_mm: Annotated[float, positive(10_000, "mm")] = 500.0
    """Longest stiff arm from a point of the file to a suspension element or a point of the results."""
    length_mm: Annotated[float, positive(100_000, "mm, of the beam")] | None = None
    """Length of the beam, in place of a file; its middle is the centre of mass."""
    first_vertical_Hz: _Frequency | None = None
    """Frequency of the first vertical bending mode of the free beam; stiff where it is not given."""
    first_lateral_Hz: _Frequency | None = None
    """Frequency of the first lateral bending mode."""
    count: Annotated[int, number(1, 20)] = 3
    """Bending modes in each of these planes."""
    damping: _Damping = 0.015
    """Damping ratio of the modes of the beam."""

    def of_body(
        self, mass: float, centre: tuple[float, float, float], origin: tuple[float, float, float],
        signs: tuple[float, float, float], find: Callable[[str], Path],
    ) -> Modes:  # fmt: skip
        """Modes of a body of this mass [kg] and centre [m]; origin, signs: of its part's axes. Raises InputError."""
        if self.modes is None:
            first = (self.first_vertical_Hz, self.first_lateral_Hz)
            return BeamModes.of_body(mass, centre, (self.length_mm or 0.0) / 1e3, first, self.count, self.damping)
        modes = read_modes(find(self.modes), self.reach_mm / 1e3)
        return PointModes(**vars(modes) | {"origin": origin, "signs": signs})
