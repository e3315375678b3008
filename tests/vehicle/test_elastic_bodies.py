"""Elastic bodies: a beam on springs, energy, statics, files of modes and their faults."""

import itertools
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from exudyn.FEM import FEMinterface
from scipy.io import mmwrite
from scipy.optimize import brentq
from scipy.sparse import csr_matrix
from support.rows import rows_of
from support.vehicle_texts import fault
from support.vehicles import manchester, on_track

from wrsim import free_modes
from wrsim.analysis.motion.body_channels import point_accelerations
from wrsim.errors import InputError
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise, natural_modes
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import steady_state
from wrsim.vehicle.elements import Spring
from wrsim.vehicle.flexible import BeamModes, Modes, PointModes, read_modes
from wrsim.vehicle.vehicle import Body, MeasuringPoint, Vehicle

table = rows_of(__file__)


MASS, LENGTH, FIRST = 30e3, 24.0, 9.0
CENTRE = (0.0, 0.0, 1.8)


def beam(first: float = FIRST, count: int = 6, damping: float = 0.0, lateral: float | None = None) -> BeamModes:
    return BeamModes.of_body(MASS, CENTRE, LENGTH, (first, lateral), count, damping)


def on_two_springs(modes: Modes | None, stiffness: float, half: float = 0.5 * LENGTH) -> Vehicle:
    """A beam on vertical springs at either side of its middle, the axles beneath."""
    first = manchester().wheelsets[0]
    wheelsets = tuple(replace(first, name=name, x=x) for name, x in (("front", half), ("rear", -half)))
    inertia = MASS * LENGTH**2 / 12.0
    body = Body("body", MASS, (4e4, inertia, inertia), CENTRE, modes)
    springs = tuple(
        Spring(f"{w.name} {side}", "spring", "body", w.name, (w.x, y, w.height), stiffness=(0.0, 0.0, 0.5 * stiffness))
        for w in wheelsets
        for side, y in (("left", 1.0), ("right", -1.0))
    )
    return Vehicle("beam", wheelsets, (body,), springs, points=(MeasuringPoint("end", "body", (half, 0.0, 1.8)),))


def frequencies(vehicle: Vehicle) -> np.ndarray:
    """Of the modes that move the beam up and down [Hz]."""
    modes = [m for m in natural_modes(vehicle) if "bends" in m.name or m.name in ("body vertical", "body pitch")]
    return np.array([mode.frequency for mode in modes])


@pytest.mark.parametrize("stiffness", [2e5, 2e6, 1e7])
def test_a_beam_on_two_springs_has_the_frequencies_of_theory(stiffness: float) -> None:
    """Springs at its ends: E I w''' = k w there; even and odd modes, Euler and Bernoulli."""
    root = brentq(lambda x: np.cos(x) * np.cosh(x) - 1.0, 4.7, 4.8)
    bending = (2.0 * np.pi * FIRST) ** 2 * MASS / LENGTH * (LENGTH / root) ** 4

    def even(b: float) -> float:
        x = 0.5 * b * LENGTH
        turned = np.cosh(x) * np.sin(x) + np.cos(x) * np.sinh(x)
        return float(bending * b**3 * turned - 2.0 * stiffness * np.cos(x) * np.cosh(x))

    def odd(b: float) -> float:
        x = 0.5 * b * LENGTH
        turned = np.sin(x) * np.cosh(x) - np.sinh(x) * np.cos(x)
        return float(bending * b**3 * turned - 2.0 * stiffness * np.sinh(x) * np.sin(x))

    grid = np.linspace(0.02, 0.45, 1000)
    found = [brentq(law, a, b) for law in (even, odd) for a, b in itertools.pairwise(grid) if law(a) * law(b) < 0.0]
    theory = np.sort(np.array(found) ** 2 * np.sqrt(bending * LENGTH / MASS) / (2.0 * np.pi))[:4]
    assert frequencies(on_two_springs(beam(), stiffness))[:4] == pytest.approx(theory, rel=5e-3)


def test_the_design_position_stays_that_of_rest_and_modes_are_slowed_by_their_share_of_critical_damping() -> None:
    """The preload bends the body into the shape of its file."""
    modes = beam(damping=0.02, lateral=12.0)
    vehicle = on_two_springs(modes, 2e6, 9.5)
    law = VehicleOnTrack(vehicle, on_track(manchester()).law.track, (), speed=0.0, start=50.0, drive="free")
    q, q_t = design_state(law)
    own = slice(law.modes.start, law.modes.stop)
    law.on_bodies(0.0, q, q_t, out := np.zeros(law.size))
    assert np.max(np.abs(out[own])) < 1e-9
    q_t[own] = 1e-3
    law.on_bodies(0.0, q, q_t, out)
    assert out[own] == pytest.approx(-2e-3 * 0.02 * 2.0 * np.pi * modes.frequencies, rel=1e-6)


def test_forces_on_modes_and_bodies_have_one_potential() -> None:
    """Their stiffness is symmetric (Maxwell and Betti), forces on modes taken with the modal masses."""
    vehicle = on_two_springs(beam(lateral=12.0), 2e6, 9.5)
    law = VehicleOnTrack(vehicle, on_track(manchester()).law.track, (), speed=0.0, start=50.0, drive="free")
    stiffness = linearise(law, law.bodies, *design_state(law)).stiffness
    masses = np.ones(law.size)
    masses[law.modes_of(2)] = vehicle.bodies[0].modes.masses  # type: ignore[union-attr]
    own = (masses[:, None] * stiffness)[12:, 12:]
    assert np.max(np.abs(own - own.T)) < 1e-6 * np.max(np.abs(own))


def test_an_accelerometer_feels_the_modes() -> None:
    """The second difference of where a point has moved to, along a free vibration."""
    vehicle = on_two_springs(beam(count=2), 2e6, 9.5)
    train = on_track(vehicle)
    law = train.law
    rest = steady_state(law)
    q = rest.q.copy()
    q[law.modes.start] += 2e-3
    motion = Integration(train.system, duration=0.02, step=1e-4, weight=vehicle.weight).run(q, rest.q_t)
    end = vehicle.points[0]
    own = law.modes_of(2)
    value = law.attachments.modes[2].shapes(np.array([end.at]))[:, 0, 2]
    height = motion.q[:, 12] - 9.5 * motion.q[:, 17] + motion.q[:, own] @ value
    k = 120
    seen = np.gradient(np.gradient(height, motion.times), motion.times)[k]
    law(motion.times[k], motion.q[k], motion.q_t[k], out := np.zeros(law.size))
    found = point_accelerations(law, motion.q[k], motion.q_t[k], out, law.vehicle.points)[0, 2]
    assert abs(found) > 1.0
    assert found == pytest.approx(seen, rel=0.02)


# --- files ----------------------------------------------------------------------------------------------------------

PLACES = [(x, 0.0, 1.8) for x in (-12.0, -9.5, 0.0, 9.5, 12.0)]
TABLE = ("[bodies.body]", '[bodies.body.flexible]\nmodes = "modes.csv"\n\n[bodies.body]')


def write_modes(path: Path, modes: Modes, points: list[tuple[float, float, float]], scale: float = 1.0) -> None:
    """A file of modes, their shapes in another scale."""
    rows = ["mode,frequency_Hz,damping,modal_mass_kg,x_mm,y_mm,z_mm,ux,uy,uz,rx,ry,rz"]
    shapes = modes.shapes(np.array(points))
    for k, own in enumerate(shapes):
        head = f"{k + 1},{modes.frequencies[k]},{modes.damping[k]},{modes.masses[k] * scale**2}"
        rows += [
            ",".join([head, *(f"{1e3 * c}" for c in at), *(f"{scale * v}" for v in values)])
            for at, values in zip(points, own, strict=True)
        ]
    path.write_text("\n".join(rows))


def test_modes_of_a_file_are_those_that_it_was_made_of(tmp_path: Path) -> None:
    """At any scale of the shapes; attachments beside the points hang on stiff arms."""
    modes = beam(damping=0.02, lateral=12.0)
    write_modes(tmp_path / "modes.csv", modes, PLACES, scale=-7.0)
    shapes = modes.shapes(np.array(PLACES))
    arrays = {"frequency_Hz": modes.frequencies, "damping": modes.damping, "modal_mass_kg": modes.masses}
    np.savez(tmp_path / "modes.npz", points_mm=1e3 * np.array(PLACES), shapes=shapes, **arrays)
    expected = frequencies(on_two_springs(modes, 2e6, 9.5))
    for name in ("modes.csv", "modes.npz"):
        found = read_modes(tmp_path / name, 2.0)
        assert frequencies(on_two_springs(found, 2e6, 9.5)) == pytest.approx(expected, rel=1e-9)


def test_a_part_turned_round_has_its_shapes_turned_round(tmp_path: Path) -> None:
    write_modes(tmp_path / "modes.csv", beam(count=2, lateral=12.0), PLACES)
    plain = read_modes(tmp_path / "modes.csv", 2.0)
    turned = replace(plain, origin=(30.0, 0.0, 0.0), signs=(-1.0, -1.0, 1.0))
    at = np.array([[9.5, 1.0, 0.8]])
    there = np.array([[30.0 - 9.5, -1.0, 0.8]])
    x, y, z, a, b, c = plain.shapes(at)[:, 0].T
    assert turned.shapes(there)[:, 0] == pytest.approx(np.stack([-x, -y, z, -a, -b, c], axis=-1), abs=1e-12)


@pytest.mark.parametrize(("change", "words"), table("a_wrong_file_of_modes_is_refused"))
def test_a_wrong_file_of_modes_is_refused(tmp_path: Path, change: tuple[str, str], words: str) -> None:
    path = tmp_path / "modes.csv"
    write_modes(path, beam(count=2), PLACES)
    path.write_text(path.read_text().replace(*change, 1))
    with pytest.raises(InputError, match=words.replace("?", r"\?")):
        read_modes(path, 0.5)


def test_modes_without_a_point_of_attachment_are_refused(tmp_path: Path) -> None:
    """In the words of the file: where it is, how far the nearest point is, what is allowed."""
    write_modes(tmp_path / "modes.csv", beam(count=1), [(0.0, 0.0, 1.8), (1.0, 0.0, 1.8)])
    modes = read_modes(tmp_path / "modes.csv", 0.5)
    with pytest.raises(InputError, match=r"no point of the modes lies near the attachment at x = 9500.*reach_mm = 500"):
        frequencies(on_two_springs(modes, 2e6, 9.5))


def test_keys_of_an_elastic_body_are_checked(tmp_path: Path) -> None:
    assert "bodies.body.flexible.modes = 'modes.csv'" in fault(tmp_path, TABLE).replace('"', "'")
    for text, words in (
        ("length_mm = 24000", "first_vertical_Hz"),
        ("first_vertical_Hz = 9", "modes"),
        ('modes = "a.csv"\nlength_mm = 24000', "cannot be given with modes"),
    ):
        change = ("[bodies.body]", f"[bodies.body.flexible]\n{text}\n\n[bodies.body]")
        assert words in fault(tmp_path, change)


# Modes from the matrices of finite elements: through files, with a basis of shapes, from Exudyn's interface.
BOX_LENGTH, BOX_MASS = 24.0, 30e3
POINTS = np.array([(x, y, 0.0) for x in (-9.25, 9.25) for y in (-0.3, 0.3)])
BEAM = BeamModes.of_body(BOX_MASS, (0.0, 0.0, 0.0), BOX_LENGTH, (9.0, 12.0), 2, 0.01)


@cache
def box() -> tuple[csr_matrix, csr_matrix, np.ndarray]:
    """Stiffness and mass of point masses on a box that has the modes of a beam, and far above them all others."""
    places = ((np.arange(48) + 0.5) * BOX_LENGTH / 48 - 0.5 * BOX_LENGTH, (-0.35, -0.25, 0.25, 0.35), (-0.05, 0.05))
    nodes = np.array(np.meshgrid(*places, indexing="ij")).reshape(3, -1).T
    mass = BOX_MASS / len(nodes)
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
