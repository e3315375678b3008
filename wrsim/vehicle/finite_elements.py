"""Modes of a free body from its finite element matrices: Matrix Market files, or Exudyn's ``FEMinterface``."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.io import mminfo, mmread
from scipy.linalg import eigh, svd
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import ArpackError, eigsh

from wrsim.errors import InputError
from wrsim.inputs.mode_tables import MOST_MODES
from wrsim.vehicle.elements import Array
from wrsim.vehicle.flexible import PointModes

RIGID = 6
"""Motions of a free body without deformation."""
DENSE = 600
"""Unknowns up to which all natural frequencies are computed at once."""
SAME = 1e-8
"""Part of a shape of a basis that the others lack, below which it is one of theirs."""
SHIFT = 1.0
"""Where natural frequencies are searched from [Hz]: K + (2 pi)^2 M can be factorised, K of a free body cannot."""


def free_modes(
    stiffness: str | Path | Any, mass: str | Path | Any, nodes: ArrayLike, points: ArrayLike, *, count: int = 10,
    damping: float = 0.01, radius: float = 0.1, basis: Array | None = None,
) -> PointModes:  # fmt: skip
    """Elastic modes of a free body at the points where it is held.

    Parameters
    ----------
    stiffness, mass : str, Path or array_like
        Matrix Market files, or matrices, sparse or not; three unknowns a node along x, y, z, node after node [N/m, kg].
    nodes : array_like
        Places of the nodes (n, 3), in the axes of the vehicle [m].
    points : array_like
        Where suspension elements and points of the results are (p, 3) [m].
    count : int
        Number of modes.
    damping : float
        Damping ratio of all.
    radius : float
        The nodes within so far from a point [m] carry it as a stiff body, in the mean of least squares; at least three
        of them.
    basis : ndarray, optional
        Shapes (3 n, b) in whose combinations and rigid motions the modes are searched, as those of Craig and Bampton.

    Returns
    -------
    PointModes
        ``save(path)`` writes the NPZ file that ``[bodies.NAME.flexible] modes`` takes.

    Raises
    ------
    InputError
        For matrices that do not fit the nodes, that are not those of a free body, and a point without nodes.

    Examples
    --------
    >>> from wrsim import free_modes
    >>> free_modes("K.mtx", "M.mtx", nodes, [[9.5, 1.0, 1.0]]).save("carbody_modes.npz")

    From an ``exudyn.FEM.FEMinterface``, within its basis of Craig and Bampton:

    >>> matrices = fem.GetStiffnessMatrix(), fem.GetMassMatrix(), fem.GetNodePositionsAsArray()
    >>> free_modes(*matrices, [[9.5, 1.0, 1.0]], basis=fem.modeBasis["matrix"])
    """
    places, held = np.asarray(nodes, dtype=float), np.asarray(points, dtype=float)
    size = 3 * len(places)
    k, m = (_matrix(source, name, size) for source, name in ((stiffness, "stiffness"), (mass, "mass")))
    if basis is not None:
        if np.ndim(basis) != 2 or len(basis) != size:
            raise InputError(f"basis: has the shape {np.shape(basis)}; allowed: ({size}, shapes)")
        # boundary modes often leave out those of the first interface, and with them the rigid motions
        shapes = np.hstack([_rigid(places - places.mean(axis=0)).reshape(size, RIGID), basis])
        left, sizes, _ = svd(shapes / np.linalg.norm(shapes, axis=0), full_matrices=False)
        basis = left[:, sizes > SAME * sizes[0]]
        k, m = (csc_matrix(basis.T @ (matrix @ basis)) for matrix in (k, m))
    most = min(k.shape[0] - RIGID, MOST_MODES)
    if not 0 < count <= most:
        raise InputError(f"count = {count}: must be from 1 to {most}")
    squares, vectors = _eigen(k, m, count + RIGID)
    if basis is not None:
        vectors = basis @ vectors
    if squares[RIGID - 1] > 1e-4 * squares[RIGID]:
        free = int(np.sum(squares < 1e-4 * squares[RIGID]))
        raise InputError(f"the matrices are not those of a free body: {free} of 6 motions have no stiffness")
    frequencies = np.sqrt(squares[RIGID:]) / (2.0 * np.pi)
    moved = vectors[:, RIGID:].T.reshape(count, -1, 3)
    values = np.stack([_carried(places, moved, point, radius) for point in held], axis=1)
    largest = np.abs(values[..., :3]).max(axis=(1, 2))
    return PointModes(
        frequencies, np.full(count, damping), largest**-2.0, held, values / largest[:, None, None], radius, "modes"
    )


def _matrix(source: Any, name: str, size: int) -> csc_matrix:
    """A matrix (size, size) of a file or an array; the sizes of a file are read ahead of what they ask room for."""
    is_file = isinstance(source, str | Path)
    if is_file:
        try:
            shape, entries = (head := mminfo(str(source)))[:2], head[2]
            if shape == (size, size) and entries <= Path(source).stat().st_size:
                source = mmread(str(source), spmatrix=False)
            elif shape == (size, size):
                raise ValueError(f"it is too short for {entries} numbers")
        except (OSError, ValueError, OverflowError, MemoryError) as error:
            raise InputError(f"{source}: is no Matrix Market file of the {name} ({error})") from None
    shape = tuple(shape) if is_file else np.shape(source)
    if shape != (size, size):
        raise InputError(f"{name}: has the shape {shape}; allowed: {(size, size)} for {size // 3} nodes")
    return csc_matrix(source, dtype=float)


def _eigen(k: csc_matrix, m: csc_matrix, count: int) -> tuple[Array, Array]:
    """The smallest eigenvalues omega^2 (count,) and their vectors (n, count), of unit modal mass."""
    n = k.shape[0]
    if count >= n - 1 or n <= DENSE:
        squares, vectors = eigh(k.toarray(), m.toarray(), subset_by_index=[0, count - 1])
        return np.abs(squares), vectors
    try:
        squares, vectors = eigsh(k, count, m, sigma=-((2.0 * np.pi * SHIFT) ** 2))
    except (ArpackError, RuntimeError) as error:
        raise InputError(f"stiffness and mass have no natural frequencies ({error})") from None
    order = np.argsort(squares)
    return np.abs(squares[order]), vectors[:, order]


def _rigid(arms: Array) -> Array:
    """Displacements (p, 3, 6) of points at arms (p, 3) by units of displacement and turn."""
    turned = np.cross(np.eye(3)[:, None], arms).transpose(1, 2, 0)
    return np.concatenate([np.broadcast_to(np.eye(3), turned.shape), turned], axis=2)


def _carried(places: Array, moved: Array, point: Array, radius: float) -> Array:
    """Displacement and turn (n, 6) of a point that the nodes (p, 3) near it carry; moved: their own (n, p, 3)."""
    near = np.flatnonzero(np.linalg.norm(places - point, axis=1) <= radius)
    if len(near) < 3:
        x, y, z = point
        message = f"{len(near)} nodes within radius = {radius:g} m; allowed: at least 3, not on a line"
        raise InputError(f"point ({x:g}, {y:g}, {z:g}) m: has {message}")
    motion = np.linalg.lstsq(
        _rigid(places[near] - point).reshape(-1, RIGID), moved[:, near].reshape(len(moved), -1).T, rcond=1e-9
    )[0]
    return np.asarray(motion.T)
