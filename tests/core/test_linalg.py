"""Vectors of the kernels against numpy's."""

import numpy as np
import pytest

from wrsim.core import linalg
from wrsim.core.compiling import kernel
from wrsim.core.linalg import Body, Vec, combined, components, point_velocity, read_body, write, write_body

A, B = (1.0, -2.0, 0.5), (0.3, 4.0, -1.5)


def test_vector_operations_are_those_of_numpy() -> None:
    a, b = np.array(A), np.array(B)
    u, v = Vec(*A), Vec(*B)
    for found, expected in (
        (linalg.add(u, v), a + b),
        (linalg.sub(u, v), a - b),
        (linalg.scale(3.0, u), 3.0 * a),
        (linalg.shifted(u, 3.0, v), a + 3.0 * b),
        (linalg.cross(u, v), np.cross(a, b)),
    ):
        assert found == pytest.approx(expected, rel=1e-15)
    assert linalg.dot(u, v) == pytest.approx(a @ b, rel=1e-15)
    assert linalg.norm(u) == pytest.approx(np.linalg.norm(a), rel=1e-15)


def test_components_along_orthonormal_axes_give_the_vector_back() -> None:
    axes = [Vec(*column) for column in np.linalg.qr(np.array([A, B, (0.1, 0.2, 0.7)]))[0].T.tolist()]
    assert combined(components(Vec(*A), *axes), *axes) == pytest.approx(A, rel=1e-14)


@kernel
def _turn(row, point, out):
    """Read a body, write it back and write the velocity of a point of it."""
    body = read_body(row)
    write_body(row, Body(body.position, body.velocity, body.up, body.forward, body.left, body.omega))
    write(out, 0, point_velocity(body, Vec(point[0], point[1], point[2])))


def test_a_compiled_kernel_reads_and_writes_bodies() -> None:
    row, out = np.random.default_rng(1).normal(size=18), np.zeros(3)
    before = row.copy()
    _turn(row, np.array(A), out)
    assert out == pytest.approx(before[3:6] + np.cross(before[15:], np.array(A) - before[:3]), rel=1e-14)
    assert row.reshape(6, 3) == pytest.approx(before.reshape(6, 3)[[0, 1, 4, 2, 3, 5]], abs=0.0)
