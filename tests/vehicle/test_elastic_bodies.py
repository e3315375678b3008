"""Elastic bodies: a beam on springs, energy, statics, files of modes and their faults."""

import itertools
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exudyn.FEM import FEMinterface
from scipy.io import mmwrite
from scipy.optimize import brentq
from scipy.sparse import csr_matrix
from support.rows import rows_of
from support.vehicle_texts import fault
from support.vehicles import ROOT, manchester, on_track, shipped

from wrsim import Arc, InputError, Vehicle, free_modes, load, stationary
from wrsim.analysis.motion.body_channels import bent_channels, point_accelerations
from wrsim.scenario.build import build
from wrsim.simulation.force_law import force_derivative
from wrsim.simulation.integrate import Integration, Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import linearise, natural_modes
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import steady_state
from wrsim.vehicle.axle import Axle, Disc, whirl
from wrsim.vehicle.elements import Spring
from wrsim.vehicle.flexible import BeamModes, Modes, PointModes, free_roots, read_modes
from wrsim.vehicle.vehicle import Body, MeasuringPoint

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
    roots = [brentq(law, a, b) for law in (even, odd) for a, b in itertools.pairwise(grid) if law(a) * law(b) < 0.0]
    theory = np.sort(np.array(roots) ** 2 * np.sqrt(bending * LENGTH / MASS) / (2.0 * np.pi))[:4]
    assert frequencies(on_two_springs(beam(), stiffness))[:4] == pytest.approx(theory, rel=5e-3)


def test_the_design_position_stays_that_of_rest_and_modes_are_slowed_by_their_share_of_critical_damping() -> None:
    """The preload bends the body into the shape of its file."""
    modes = beam(damping=0.02, lateral=12.0)
    vehicle = on_two_springs(modes, 2e6, 9.5)
    law = VehicleOnTrack(vehicle, on_track(manchester()).law.track, (), speed=0.0, start=50.0, drive="free")
    q, q_t = design_state(law)
    modal = slice(law.modes.start, law.modes.stop)
    law.on_bodies(0.0, q, q_t, out := np.zeros(law.size))
    assert np.max(np.abs(out[modal])) < 1e-9
    q_t[modal] = 1e-3
    law.on_bodies(0.0, q, q_t, out)
    assert out[modal] == pytest.approx(-2e-3 * 0.02 * 2.0 * np.pi * modes.frequencies, rel=1e-6)


def test_forces_on_modes_and_bodies_have_one_potential() -> None:
    """Their stiffness is symmetric (Maxwell and Betti), forces on modes taken with the modal masses."""
    vehicle = on_two_springs(beam(lateral=12.0), 2e6, 9.5)
    law = VehicleOnTrack(vehicle, on_track(manchester()).law.track, (), speed=0.0, start=50.0, drive="free")
    stiffness = linearise(law, law.bodies, *design_state(law)).stiffness
    masses = np.ones(law.size)
    masses[law.modes_of(2)] = vehicle.bodies[0].modes.masses  # type: ignore[union-attr]
    modal = (masses[:, None] * stiffness)[12:, 12:]
    assert np.max(np.abs(modal - modal.T)) < 1e-6 * np.max(np.abs(modal))


def test_a_rotational_spring_stiffens_a_mode_by_the_square_of_its_slope() -> None:
    plain, h = on_two_springs(beam(count=1), 2e6, 9.5), 1e-4
    turning = tuple(replace(spring, turning_stiffness=(0.0, 1e6, 0.0)) for spring in plain.elements)
    stiffnesses = []
    for vehicle in (plain, replace(plain, elements=turning)):
        law = VehicleOnTrack(vehicle, on_track(manchester()).law.track, (), speed=0.0, start=50.0, drive="free")
        stiffnesses.append(linearise(law, law.bodies, *design_state(law)).stiffness[law.modes.start, law.modes.start])
    modes = law.attachments.modes[2]
    lower, upper = modes.shapes(np.array([(9.5 - h, 0.0, 1.8), (9.5 + h, 0.0, 1.8)]))[0, :, 2]
    slope = (upper - lower) / (2.0 * h)
    assert modes.masses[0] * (stiffnesses[1] - stiffnesses[0]) == pytest.approx(4.0 * 1e6 * slope**2, rel=1e-4)


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
    modal = law.modes_of(2)
    value = law.attachments.modes[2].shapes(np.array([end.at]))[:, 0, 2]
    height = motion.q[:, 12] - 9.5 * motion.q[:, 17] + motion.q[:, modal] @ value
    k = 120
    seen = np.gradient(np.gradient(height, motion.times), motion.times)[k]
    law(motion.times[k], motion.q[k], motion.q_t[k], out := np.zeros(law.size))
    acceleration = point_accelerations(law, motion.q[k : k + 1], motion.q_t[k : k + 1], out[None], law.vehicle.points)[
        0, 0, 2
    ]
    assert abs(acceleration) > 1.0
    assert acceleration == pytest.approx(seen, rel=0.02)


PLACES = [(x, 0.0, 1.8) for x in (-12.0, -9.5, 0.0, 9.5, 12.0)]
TABLE = ("[bodies.body]", '[bodies.body.flexible]\nmodes = "modes.csv"\n\n[bodies.body]')


def write_modes(path: Path, modes: Modes, points: list[tuple[float, float, float]], scale: float = 1.0) -> None:
    """A file of modes, their shapes in another scale."""
    rows = ["mode,frequency_Hz,damping,modal_mass_kg,x_mm,y_mm,z_mm,ux,uy,uz,rx,ry,rz"]
    shapes = modes.shapes(np.array(points))
    for k, shape in enumerate(shapes):
        head = f"{k + 1},{modes.frequencies[k]},{modes.damping[k]},{modes.masses[k] * scale**2}"
        rows += [
            ",".join([head, *(f"{1e3 * c}" for c in point), *(f"{scale * v}" for v in values)])
            for point, values in zip(points, shape, strict=True)
        ]
    path.write_text("\n".join(rows), encoding="utf-8")


def test_modes_of_a_file_are_those_that_it_was_made_of(tmp_path: Path) -> None:
    """At any scale of the shapes; attachments beside the points hang on stiff arms."""
    modes = beam(damping=0.02, lateral=12.0)
    write_modes(tmp_path / "modes.csv", modes, PLACES, scale=-7.0)
    shapes = modes.shapes(np.array(PLACES))
    arrays = {"frequency_Hz": modes.frequencies, "damping": modes.damping, "modal_mass_kg": modes.masses}
    np.savez(tmp_path / "modes.npz", points_mm=1e3 * np.array(PLACES), shapes=shapes, **arrays)
    expected = frequencies(on_two_springs(modes, 2e6, 9.5))
    for name in ("modes.csv", "modes.npz"):
        stored = read_modes(tmp_path / name, 2.0)
        assert frequencies(on_two_springs(stored, 2e6, 9.5)) == pytest.approx(expected, rel=1e-9)


def test_a_part_turned_round_has_its_shapes_turned_round(tmp_path: Path) -> None:
    write_modes(tmp_path / "modes.csv", beam(count=2, lateral=12.0), PLACES)
    plain = read_modes(tmp_path / "modes.csv", 2.0)
    turned = replace(plain, origin=(30.0, 0.0, 0.0), signs=(-1.0, -1.0, 1.0))
    point = np.array([[9.5, 1.0, 0.8]])
    turned_point = np.array([[30.0 - 9.5, -1.0, 0.8]])
    x, y, z, a, b, c = plain.shapes(point)[:, 0].T
    assert turned.shapes(turned_point)[:, 0] == pytest.approx(np.stack([-x, -y, z, -a, -b, c], axis=-1), abs=1e-12)


@pytest.mark.parametrize(("change", "message"), table("a_wrong_file_of_modes_is_refused"))
def test_a_wrong_file_of_modes_is_refused(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    path = tmp_path / "modes.csv"
    write_modes(path, beam(count=2), PLACES)
    path.write_text(path.read_text().replace(*change, 1))
    with pytest.raises(InputError, match=message.replace("?", r"\?")):
        read_modes(path, 0.5)


@pytest.mark.parametrize(("name", "value", "message"), table("an_array_of_modes_is_refused"))
def test_an_array_of_modes_has_the_bounds_of_the_columns(tmp_path: Path, name: str, value: Any, message: str) -> None:
    """Its values, complex ones, more modes than a body may have."""
    modes = beam(count=2)
    arrays = {"frequency_Hz": modes.frequencies, "damping": modes.damping, "modal_mass_kg": modes.masses}
    arrays |= {"points_mm": 1e3 * np.array(PLACES), "shapes": modes.shapes(np.array(PLACES))}
    if name == "count":
        arrays = {key: np.concatenate([array] * value) for key, array in arrays.items()}
    else:
        arrays[name] = arrays[name].astype(complex if value == "complex" else float)
        arrays[name].flat[-1] = 1.0 if value == "complex" else value
    np.savez(tmp_path / "modes.npz", **arrays)
    with pytest.raises(InputError, match=message):
        read_modes(tmp_path / "modes.npz", 0.5)


@pytest.mark.parametrize("ending", ["csv", "npz"])
def test_a_cut_file_of_modes_is_refused_in_one_line_or_read(tmp_path: Path, ending: str) -> None:
    modes, whole, cut = beam(count=2), tmp_path / f"modes.{ending}", tmp_path / f"cut.{ending}"
    write_modes(tmp_path / "modes.csv", modes, PLACES)
    read_modes(tmp_path / "modes.csv", 0.5).save(tmp_path / "modes.npz")
    content = whole.read_bytes()
    for length in (0, 3, *range(20, len(content) - 10, 61)):
        cut.write_bytes(content[:length])
        with pytest.raises(InputError) as caught:
            read_modes(cut, 0.5)
        assert str(cut) in str(caught.value)


def test_modes_and_keys_of_an_elastic_body_are_checked(tmp_path: Path) -> None:
    """In the words of the file: where it is, how far the nearest point is, what is allowed."""
    assert "bodies.body.flexible.modes = 'modes.csv'" in fault(tmp_path, TABLE).replace('"', "'")
    write_modes(tmp_path / "modes.csv", beam(count=1), [(0.0, 0.0, 1.8), (1.0, 0.0, 1.8)])
    modes = read_modes(tmp_path / "modes.csv", 0.5)
    with pytest.raises(InputError, match=r"no point of the modes lies near the attachment at x = 9500.*reach_mm = 500"):
        frequencies(on_two_springs(modes, 2e6, 9.5))
    for text, message in (
        ("length_mm = 24000", "first_vertical_Hz"),
        ("first_vertical_Hz = 9", "modes"),
        ('modes = "a.csv"\nlength_mm = 24000', "cannot be given with modes"),
    ):
        change = ("[bodies.body]", f"[bodies.body.flexible]\n{text}\n\n[bodies.body]")
        assert message in fault(tmp_path, change)


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
    scaled = basis[:, 6:] * (2.0 * np.pi * BEAM.frequencies)
    return (
        csr_matrix(mass * (scaled @ scaled.T + (2.0 * np.pi * 500.0) ** 2 * rest)),
        csr_matrix(mass * np.eye(len(rest))),
        nodes,
    )


def as_expected(modes: PointModes) -> None:
    """The frequencies of the beam, and its shapes at the points and modal masses."""
    order = np.argsort(BEAM.frequencies)
    assert modes.frequencies == pytest.approx(BEAM.frequencies[order], rel=1e-6)
    theory = BEAM.shapes(POINTS)[order]
    largest = np.abs(theory[..., :3]).max(axis=(1, 2))
    theory /= largest[:, None, None]
    sign = np.sign(np.sum(theory * modes.values, axis=(1, 2)))[:, None, None]
    assert sign * modes.values == pytest.approx(theory, rel=0.03, abs=0.01)
    for part in modes.masses / BEAM.masses[order] * largest**2:
        assert part == pytest.approx(1.0, rel=0.05)  # sections 0.6 m wide turn


def test_modes_of_matrices_are_those_of_the_body_they_describe(tmp_path: Path) -> None:
    """From memory, from Matrix Market files, and back through the file that a vehicle names."""
    stiffness, mass, nodes = box()
    modes = free_modes(stiffness, mass, nodes, POINTS, count=4, radius=0.1)
    as_expected(modes)
    mmwrite(tmp_path / "K.mtx", stiffness)
    mmwrite(tmp_path / "M.mtx", mass)
    as_expected(free_modes(tmp_path / "K.mtx", str(tmp_path / "M.mtx"), nodes, POINTS, count=4, radius=0.1))
    again = read_modes(modes.save(tmp_path / "modes.npz"), 0.5)
    assert again.values == pytest.approx(modes.values)
    with pytest.raises(InputError, match="exists already"):
        modes.save(tmp_path / "modes.npz")


@pytest.mark.parametrize("excluded", [None, True, False])
def test_modes_of_exudyns_interface_are_found_within_its_basis(excluded: bool | None) -> None:
    """Normal modes, or modes of stiff ends (RBE2) and held ends; without the first end's they have no rigid motions."""
    stiffness, mass, nodes = box()
    fem = FEMinterface()
    fem.nodes, fem.massMatrix, fem.stiffnessMatrix = {"Position": nodes}, mass, stiffness
    if excluded is None:
        fem.ComputeEigenmodes(12, excludeRigidBodyModes=0, useSparseSolver=True)
    else:
        ends = [np.flatnonzero(nodes[:, 0] == end) for end in (nodes[:, 0].min(), nodes[:, 0].max())]
        fem.ComputeHurtyCraigBamptonModes(ends, 12, excludeRigidBodyMotion=excluded)
    matrices = fem.GetStiffnessMatrix(), fem.GetMassMatrix(), fem.GetNodePositionsAsArray()
    as_expected(free_modes(*matrices, POINTS, count=4, radius=0.1, basis=fem.modeBasis["matrix"]))


def huge(folder: Path, size: int) -> Path:
    """The header of a Matrix Market file that is larger than any memory."""
    path = folder / f"{size}.mtx"
    path.write_text(f"%%MatrixMarket matrix coordinate real general\n{size} {size} {9 * 10**17}\n1 1 1.0\n")
    return path


def test_matrices_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    stiffness, mass, nodes = box()
    held = stiffness + csr_matrix(np.diag(np.where(np.arange(stiffness.shape[0]) < 30, 1e6, 0.0)))
    for arguments, message in (
        ((stiffness, mass, nodes[1:], POINTS), "allowed: "),
        ((held, mass, nodes, POINTS), "not those of a free body"),
        ((stiffness, mass, nodes, [[0.0, 0.0, 5.0]]), "0 nodes within radius"),
        ((tmp_path / "none.mtx", mass, nodes, POINTS), "is no Matrix Market file"),
        ((huge(tmp_path, 10**6), mass, nodes, POINTS), r"stiffness: has the shape \(1000000, 1000000\)"),
        ((huge(tmp_path, stiffness.shape[0]), mass, nodes, POINTS), "too short for 900000000000000000 numbers"),
    ):
        with pytest.raises(InputError, match=message):
            free_modes(*arguments, count=4)
    with pytest.raises(InputError, match="count = 0"):
        free_modes(stiffness, mass, nodes, POINTS, count=0)


def test_a_uniform_shaft_has_the_frequencies_of_a_free_beam() -> None:
    axle = Axle(((LONG, THIN),))
    stiffness, mass = bending(axle, THIN)
    theory = (free_roots(4) / LONG) ** 2 * np.sqrt(stiffness / mass) / (2.0 * np.pi)
    assert axle.modes(()).frequencies == pytest.approx(np.tile(theory, 2), rel=5e-3)


def test_a_shaft_with_discs_at_its_ends_has_the_frequencies_of_theory() -> None:
    """Point masses m_e at both ends: E I w''' = m_e omega^2 w there, w'' = 0."""
    heavy = 40.0
    axle = Axle(((LONG, THIN),), tuple(Disc(y, heavy, 1e-9, 1e-9) for y in (0.5 * LONG, -0.5 * LONG)))
    stiffness, mass = bending(axle, THIN)

    def even(b: float) -> float:
        x = 0.5 * b * LONG
        turned = np.cosh(x) * np.sin(x) + np.cos(x) * np.sinh(x)
        return float(turned + 2.0 * heavy / mass * b * np.cos(x) * np.cosh(x))

    def odd(b: float) -> float:
        x = 0.5 * b * LONG
        turned = np.sin(x) * np.cosh(x) - np.sinh(x) * np.cos(x)
        return float(turned + 2.0 * heavy / mass * b * np.sinh(x) * np.sin(x))

    grid = np.linspace(0.2, 4.0, 1000)
    roots = [brentq(law, a, b) for law in (even, odd) for a, b in itertools.pairwise(grid) if law(a) * law(b) < 0.0]
    theory = np.sort(roots)[:4] ** 2 * np.sqrt(stiffness / mass) / (2.0 * np.pi)
    assert axle.modes(()).frequencies[:4] == pytest.approx(theory, rel=5e-3)


# Elastic axles: natural frequencies of shafts, whirl, and the axle bent by its load in a vehicle.
LONG, THIN = 4.0, 0.04
AXLE = Axle(((0.25, 0.13), (0.2, 0.19), (1.3, 0.165), (0.2, 0.19), (0.25, 0.13)))


def bending(axle: Axle, diameter: float) -> tuple[float, float]:
    """E I [N m2] and mass [kg/m] of a section."""
    return axle.young * np.pi / 64.0 * diameter**4, axle.density * np.pi / 4.0 * diameter**2


def test_a_stepped_shaft_has_the_frequencies_of_theory() -> None:
    """A thick middle between thin ends: deflection, slope, moment and shear agree at the step."""
    end, middle = (1.0, 0.04), (1.6, 0.06)
    axle = Axle((end, middle, end))
    (soft, light), (stiff, heavy) = (bending(axle, d) for _, d in (end, middle))

    def determinant(omega: float, even: bool) -> float:
        a, b = ((m * omega**2 / k) ** 0.25 for m, k in ((light, soft), (heavy, stiff)))
        x, y = a * end[0], 0.5 * b * middle[0]
        # from the free end: w = P (cos + cosh) + Q (sin + sinh)
        p = [np.cos(x) + np.cosh(x), a * (np.sinh(x) - np.sin(x)), soft * a**2 * (np.cosh(x) - np.cos(x))]
        q = [np.sin(x) + np.sinh(x), a * (np.cos(x) + np.cosh(x)), soft * a**2 * (np.sinh(x) - np.sin(x))]
        p.append(soft * a**3 * (np.sinh(x) + np.sin(x)))
        q.append(soft * a**3 * (np.cosh(x) - np.cos(x)))
        # from the middle, towards it
        if even:
            r = [np.cos(y), b * np.sin(y), -stiff * b**2 * np.cos(y), -stiff * b**3 * np.sin(y)]
            s = [np.cosh(y), -b * np.sinh(y), stiff * b**2 * np.cosh(y), -stiff * b**3 * np.sinh(y)]
        else:
            r = [np.sin(y), -b * np.cos(y), -stiff * b**2 * np.sin(y), stiff * b**3 * np.cos(y)]
            s = [np.sinh(y), -b * np.cosh(y), stiff * b**2 * np.sinh(y), -stiff * b**3 * np.cosh(y)]
        return float(np.linalg.det(np.array([p, q, r, s]).T / np.array([1.0, a, soft * a**2, soft * a**3])[:, None]))

    grid = np.linspace(10.0, 3000.0, 1500)
    roots = [
        brentq(determinant, lo, hi, args=(even,))
        for even in (True, False)
        for lo, hi in itertools.pairwise(grid)
        if determinant(lo, even) * determinant(hi, even) < 0.0
    ]
    theory = np.sort(roots)[:4] / (2.0 * np.pi)
    assert axle.modes(()).frequencies[:4] == pytest.approx(theory, rel=5e-3)


@pytest.mark.parametrize("spin", [0.0, 50.0, 150.0])
def test_discs_on_a_light_shaft_whirl_as_theory_says(spin: float) -> None:
    """Two discs that tilt against each other, J theta_tt - i J_p spin theta_t + 2 E I/l theta = 0."""
    length, across, polar = 1.5, 60.0, 40.0
    axle = Axle(((length, 0.06),), (Disc(0.75, 700.0, polar, across), Disc(-0.75, 700.0, polar, across)), density=1.0)
    stiffness = axle.young * np.pi / 64.0 * 0.06**4
    still, half = np.sqrt(2.0 * stiffness / (length * across)), 0.5 * polar * spin / across
    frequency, forward = whirl(axle.modes(()), spin)
    theory = (np.array([-half, half]) + np.hypot(still, half)) / (2.0 * np.pi)
    if not spin:
        assert frequency[:2] == pytest.approx(theory, rel=5e-3)
    else:
        assert frequency[~forward][0] == pytest.approx(theory[0], rel=5e-3)
        assert np.min(np.abs(frequency[forward] / theory[1] - 1.0)) < 5e-3


def test_wheels_shaft_and_discs_make_up_the_wheelset() -> None:
    mass, spin, across, half = 1813.0, 112.0, 1120.0, 0.75
    shaft, wheels = AXLE.inertia(), AXLE.wheels(mass, spin, across, half)
    assert shaft[0] + sum(w.mass for w in wheels) == pytest.approx(mass)
    assert shaft[1] + sum(w.polar for w in wheels) == pytest.approx(spin)
    assert shaft[2] + sum(w.across + w.mass * half**2 for w in wheels) == pytest.approx(across)
    with pytest.raises(InputError, match="leave a wheel the mass"):
        AXLE.wheels(300.0, spin, across, half)


def elastic(axle: Axle = AXLE) -> Vehicle:
    """A coach on elastic axles."""
    return shipped("manchester_1").with_wheelsets(lambda wheelset: replace(wheelset, axle=axle))


def test_an_axle_bends_under_its_load_as_a_beam_does() -> None:
    """Springs at +-b push it down outside of its wheels at +-h: between these the moment is P (b - h), and each wheel
    leans by P (b - h) h / (E I)."""
    axle = Axle(((2.3, 0.16),), count=6)
    vehicle = elastic(axle)
    law = on_track(vehicle).law
    rest = steady_state(law)
    half = 0.5 * vehicle.wheelsets[0].wheelset.profile_spacing
    ends = [abs(e.points[1][1]) for e in vehicle.elements if e.second == vehicle.wheelsets[0].name]
    outside = max(ends)
    modal = law.modes_of(0)
    turn = law.attachments.modes[0].shapes(np.array([(0.0, half, 0.0)]))[:, 0, 3]
    leaning = float(rest.q[modal] @ turn)
    load = 0.5 * (law.wheels[0][0].model.arrays.total.Fb + law.wheels[0][1].model.arrays.total.Fb)
    load -= 0.5 * vehicle.wheelsets[0].mass * vehicle.gravity
    stiffness, _ = bending(axle, 0.16)
    assert leaning == pytest.approx(-load * (outside - half) * half / stiffness, rel=0.03)
    forces = np.array([[[wheel.model.arrays.total.Fb for wheel in pair] for pair in law.wheels]])
    forces[0, 2, 1] += 1.0
    motion = Motion(np.zeros(1), rest.q[None], rest.q_t[None], 0.0, "completed")
    place = np.arange(4.0)[None]
    shape, bend_attributes = bent_channels(law, motion, {"Q": forces, "wheelset_distance": place})
    assert (bend_attributes["bent_by"], bend_attributes["bent_at_m"]) == (f"{vehicle.wheelsets[2].name} right", 2.0)
    y, up = shape["bent_axle_y"][0], shape["bent_axle_z"][0]
    hog = up[len(y) // 2] - np.interp(half, y, up)
    assert hog == pytest.approx(load * (outside - half) * (2.0 * half) ** 2 / (8.0 * stiffness), rel=0.03)
    assert up == pytest.approx(up[::-1], abs=1e-7) and np.abs(shape["bent_axle_x"][0]).max() < 0.05 * hog


def test_an_axle_without_deformation_is_a_rigid_one() -> None:
    """In a curve, shifted and yawed: the same forces on all bodies, to round-off."""
    curve = [Arc(400.0, 600.0, 0.1)]
    forces = []
    for vehicle in (shipped("manchester_1"), elastic()):
        law = on_track(vehicle, 20.0, curve).law
        q, q_t = design_state(law, lateral=3e-3)
        n = 6 * len(law.bodies)
        q[:24:6] -= 2e-4
        q[3:24:6] += 2e-3
        law(0.0, q, q_t, out := np.zeros(law.size))
        forces.append(out[:n])
    assert np.max(np.abs(forces[0])) > 1e5
    assert forces[1] == pytest.approx(forces[0], rel=1e-9, abs=1e-4)


def test_contacts_give_an_elastic_axle_the_power_that_they_have_at_its_wheels() -> None:
    """Bent, deforming and rolling: forces on coordinates times rates, and forces on wheels times their motions."""
    wheelset = shipped("wheelset_s1002").with_wheelsets(lambda rigid: replace(rigid, axle=AXLE))
    law = on_track(wheelset, 20.0).law
    q, q_t = design_state(law, lateral=2e-3)
    q[0] -= 2e-4
    q[3] += 3e-3
    modal = law.modes_of(0)
    q[modal], q_t[modal] = 2e-4 * np.cos(np.arange(8.0)), 0.05 * np.sin(1.0 + np.arange(8.0))
    law(0.0, q, q_t, whole := np.zeros(law.size))
    law.on_bodies(0.0, q, q_t, without := np.zeros(law.size))
    forces = whole - without
    forces[modal] *= law.attachments.modes[0].masses
    power = 0.0
    for wheel in law.wheel_records(0):
        for force, rate in ((wheel.force, wheel.body.velocity), (wheel.moment, wheel.body.omega)):
            power += sum(float(force[axis] * rate[axis]) for axis in "xyz")
    assert abs(power) > 1e3
    assert forces @ q_t == pytest.approx(power, rel=1e-4, abs=1.0)


def test_gyroscopic_forces_on_an_axle_do_no_work() -> None:
    """The part of the damping that grows with the speed is antisymmetric, with the modal masses."""
    wheelset = shipped("wheelset_s1002").with_wheelsets(lambda rigid: replace(rigid, axle=AXLE))
    masses = np.ones(6 + 8)
    dampings = []
    for speed in (1.0, 60.0):
        law = on_track(wheelset, speed).law
        masses[6:] = law.attachments.modes[0].masses
        q, q_t = design_state(law)
        blocks = law.blocks()[:1]  # without contacts
        law.blocks = lambda only=blocks: only  # type: ignore[method-assign, misc]
        dampings.append(masses[:, None] * force_derivative(law, q, q_t, 1, by_q=0.0, by_q_t=1.0))
    grown = dampings[1] - dampings[0]
    bending_part = np.delete(np.delete(grown, [0, 1, 2, 5], 0), [0, 1, 2, 5], 1)
    assert np.max(np.abs(bending_part)) > 1e3
    assert np.max(np.abs(bending_part + bending_part.T)) < 1e-6 * np.max(np.abs(bending_part))


def test_keys_of_an_axle_are_checked_and_the_exact_solver_takes_none(tmp_path: Path) -> None:
    for text, message in (
        ("sections_mm = []", "sections_mm"),
        ("sections_mm = [[2200, 160, 3]]", "two numbers"),
        ("sections_mm = [[2200, 600]]", "leave a wheel the mass"),
    ):
        change = ("[bodies.body]", f"[wheelset.axle]\n{text}\n\n[bodies.body]")
        assert message in fault(tmp_path, change)
    with pytest.raises(InputError, match=r"contact.normal.*cannot be \"half-space\" with elastic axles"):
        build(
            load(ROOT / "scenarios/manchester_r300.toml").with_values(
                {"contact.normal": "half-space", "vehicle.wheelset.axle": {"sections_mm": [[2200, 160]]}}
            )
        )


def test_campbells_diagram_splits_every_mode_of_every_kind_of_axle_once(tmp_path: Path) -> None:
    coach, picture = elastic(), tmp_path / "campbell.png"
    axles = stationary(coach, campbell=picture).numbers["axles"]
    assert [row["wheelset"] for row in axles] == [coach.wheelsets[0].name]
    assert picture.exists()
    backward, forward = np.array(axles[0]["backward_Hz"]), np.array(axles[0]["forward_Hz"])
    assert forward[0] == pytest.approx(backward[0], rel=1e-4)
    assert np.all(np.diff(forward[:, :2], axis=0) > 0.0) and np.all(np.diff(backward[:, :2], axis=0) < 0.0)
    with pytest.raises(InputError, match="this vehicle has none"):
        stationary(shipped("manchester_1"), campbell=picture)
