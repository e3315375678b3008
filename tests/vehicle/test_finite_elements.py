"""Modes from the matrices of finite elements: through files, with a basis of shapes, from Exudyn's interface."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from exudyn.FEM import FEMinterface
from scipy.io import mmwrite
from scipy.sparse import csr_matrix

from wrsim import free_modes
from wrsim.errors import InputError
from wrsim.vehicle.flexible import BeamModes, PointModes, read_modes

LENGTH, MASS = 24.0, 30e3
POINTS = np.array([(x, y, 0.0) for x in (-9.25, 9.25) for y in (-0.3, 0.3)])
BEAM = BeamModes.of_body(MASS, (0.0, 0.0, 0.0), LENGTH, (9.0, 12.0), 2, 0.01)


@cache
def box() -> tuple[csr_matrix, csr_matrix, np.ndarray]:
    """Stiffness and mass of point masses on a box that has the modes of a beam, and far above them all others."""
    places = ((np.arange(48) + 0.5) * LENGTH / 48 - 0.5 * LENGTH, (-0.35, -0.25, 0.25, 0.35), (-0.05, 0.05))
    nodes = np.array(np.meshgrid(*places, indexing="ij")).reshape(3, -1).T
    mass = MASS / len(nodes)
    rigid = np.zeros((6, len(nodes), 3))
    rigid[range(3), :, range(3)] = 1.0
    rigid[3:] = np.cross(np.eye(3)[:, None], nodes[None])
    shapes = np.concatenate([rigid, BEAM.shapes(nodes)[..., :3]]).reshape(6 + 4, -1)
    basis = np.linalg.qr(shapes.T)[0]  # with equal masses a basis that is orthogonal in them too
    rest = np.eye(shapes.shape[1]) - basis @ basis.T
    own = basis[:, 6:] * (2.0 * np.pi * BEAM.frequencies)
    return (
        csr_matrix(mass * (own @ own.T + (2.0 * np.pi * 500.0) ** 2 * rest)),
        csr_matrix(mass * np.eye(len(rest))),
        nodes,
    )


def as_expected(found: PointModes) -> None:
    """The frequencies of the beam, and its shapes at the points and modal masses."""
    order = np.argsort(BEAM.frequencies)
    assert found.frequencies == pytest.approx(BEAM.frequencies[order], rel=1e-6)
    theory = BEAM.shapes(POINTS)[order]
    largest = np.abs(theory[..., :3]).max(axis=(1, 2))
    theory /= largest[:, None, None]
    sign = np.sign(np.sum(theory * found.values, axis=(1, 2)))[:, None, None]
    assert sign * found.values == pytest.approx(theory, rel=0.03, abs=0.01)
    for part in found.masses / BEAM.masses[order] * largest**2:
        assert part == pytest.approx(1.0, rel=0.05)  # sections 0.6 m wide turn


def test_modes_of_matrices_are_those_of_the_body_they_describe(tmp_path: Path) -> None:
    """From memory, from Matrix Market files, and back through the file that a vehicle names."""
    stiffness, mass, nodes = box()
    found = free_modes(stiffness, mass, nodes, POINTS, count=4, radius=0.1)
    as_expected(found)
    mmwrite(tmp_path / "K.mtx", stiffness)
    mmwrite(tmp_path / "M.mtx", mass)
    as_expected(free_modes(tmp_path / "K.mtx", str(tmp_path / "M.mtx"), nodes, POINTS, count=4, radius=0.1))
    again = read_modes(found.save(tmp_path / "modes.npz"), 0.5)
    assert again.values == pytest.approx(found.values)
    with pytest.raises(InputError, match="exists already"):
        found.save(tmp_path / "modes.npz")


def test_modes_of_exudyns_interface_are_found_within_its_basis() -> None:
    """Its own normal modes and the rigid motions span them."""
    stiffness, mass, nodes = box()
    fem = FEMinterface()
    fem.nodes, fem.massMatrix, fem.stiffnessMatrix = {"Position": nodes}, mass, stiffness
    fem.ComputeEigenmodes(12, excludeRigidBodyModes=0, useSparseSolver=True)
    matrices = fem.GetStiffnessMatrix(), fem.GetMassMatrix(), fem.GetNodePositionsAsArray()
    as_expected(free_modes(*matrices, POINTS, count=4, radius=0.1, basis=fem.modeBasis["matrix"]))


def test_matrices_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    stiffness, mass, nodes = box()
    held = stiffness + csr_matrix(np.diag(np.where(np.arange(stiffness.shape[0]) < 30, 1e6, 0.0)))
    for given, words in (
        ((stiffness, mass, nodes[1:], POINTS), "allowed: "),
        ((held, mass, nodes, POINTS), "not those of a free body"),
        ((stiffness, mass, nodes, [[0.0, 0.0, 5.0]]), "0 nodes within radius"),
        ((tmp_path / "none.mtx", mass, nodes, POINTS), "is no Matrix Market file"),
    ):
        with pytest.raises(InputError, match=words):
            free_modes(*given, count=4)
    with pytest.raises(InputError, match="count = 0"):
        free_modes(stiffness, mass, nodes, POINTS, count=0)
