"""Vectors of the kernels against numpy's."""

import numpy as np
import pytest

from wrsim.core import linalg
from wrsim.core.frames import BODY, VECTOR, BodyMotion, get_body, point_velocity, put, put_at, put_body
from wrsim.core.jit import kernel
from wrsim.core.linalg import Vec, components, from_components

A, B = (1.0, -2.0, 0.5), (0.3, 4.0, -1.5)


def test_vector_operations_are_those_of_numpy() -> None:
    a, b = np.array(A), np.array(B)
    u, v = Vec(*A), Vec(*B)
    for found, expected in (
        (linalg.add(u, v), a + b),
        (linalg.sub(u, v), a - b),
        (linalg.scale(3.0, u), 3.0 * a),
        (linalg.shifted(u, 3.0, v), a + 3.0 * b),
        (linalg.mixed(2.0, u, -3.0, v), 2.0 * a - 3.0 * b),
        (linalg.add(u, linalg.ZERO), a),
        (linalg.cross(u, v), np.cross(a, b)),
    ):
        assert found == pytest.approx(expected, rel=1e-15)
    assert linalg.dot(u, v) == pytest.approx(a @ b, rel=1e-15)
    assert linalg.norm(u) == pytest.approx(np.linalg.norm(a), rel=1e-15)


def test_a_vector_is_written_to_three_places_of_a_row() -> None:
    row = np.arange(6.0)
    put_at(row, 2, Vec(*A))
    assert row.tolist() == [0.0, 1.0, *A, 5.0]


def test_components_along_orthonormal_axes_give_the_vector_back() -> None:
    axes = [Vec(*column) for column in np.linalg.qr(np.array([A, B, (0.1, 0.2, 0.7)]))[0].T.tolist()]
    assert from_components(components(Vec(*A), *axes), *axes) == pytest.approx(A, rel=1e-14)


@kernel
def _turn(bodies, point, out):
    """Turn the axes of a body in its place and write the velocity of a point of it."""
    rows = bodies.view(BODY)
    body = get_body(rows[1])
    put_body(rows[1], BodyMotion(body.position, body.velocity, body.up, body.forward, body.left, body.omega))
    put(out.view(VECTOR)[0], point_velocity(body, Vec(point[0], point[1], point[2])))


@pytest.mark.parametrize("compiled", [True, False])
def test_kernels_read_and_write_bodies_with_and_without_the_compiler(compiled: bool) -> None:
    bodies, out = np.random.default_rng(1).normal(size=36), np.zeros(3)
    before = bodies.copy()
    (_turn if compiled else getattr(_turn, "py_func", _turn))(bodies, np.array(A), out)
    body = before[18:]
    assert out == pytest.approx(body[3:6] + np.cross(body[15:], np.array(A) - body[:3]), rel=1e-14)
    assert np.all(bodies[:18] == before[:18])
    assert np.all(bodies[18:].reshape(6, 3) == body.reshape(6, 3)[[0, 1, 4, 2, 3, 5]])
    assert bodies.view(BODY)["velocity"]["y"][1] == body[4]
