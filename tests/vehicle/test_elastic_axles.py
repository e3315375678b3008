"""Elastic axles: natural frequencies of shafts, whirl, and the axle bent by its load in a vehicle."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from support.vehicle_texts import fault
from support.vehicles import ROOT, on_track, shipped

from wrsim.api.analyses import stationary
from wrsim.errors import InputError
from wrsim.geometry.track.segments import Arc
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.force_law import force_derivative
from wrsim.simulation.placement import design_state
from wrsim.simulation.steady_state import steady_state
from wrsim.vehicle.axle import Axle, Disc, whirl
from wrsim.vehicle.flexible import free_roots
from wrsim.vehicle.vehicle import Vehicle

LONG, THIN = 4.0, 0.04
AXLE = Axle(((0.25, 0.13), (0.2, 0.19), (1.3, 0.165), (0.2, 0.19), (0.25, 0.13)))


def bending(axle: Axle, diameter: float) -> tuple[float, float]:
    """E I [N m2] and mass [kg/m] of a section."""
    return axle.young * np.pi / 64.0 * diameter**4, axle.density * np.pi / 4.0 * diameter**2


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
    found = [brentq(law, a, b) for law in (even, odd) for a, b in itertools.pairwise(grid) if law(a) * law(b) < 0.0]
    theory = np.sort(found)[:4] ** 2 * np.sqrt(stiffness / mass) / (2.0 * np.pi)
    assert axle.modes(()).frequencies[:4] == pytest.approx(theory, rel=5e-3)


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
    found = [
        brentq(determinant, lo, hi, args=(even,))
        for even in (True, False)
        for lo, hi in itertools.pairwise(grid)
        if determinant(lo, even) * determinant(hi, even) < 0.0
    ]
    theory = np.sort(found)[:4] / (2.0 * np.pi)
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
    own, wheels = AXLE.inertia(), AXLE.wheels(mass, spin, across, half)
    assert own[0] + sum(w.mass for w in wheels) == pytest.approx(mass)
    assert own[1] + sum(w.polar for w in wheels) == pytest.approx(spin)
    assert own[2] + sum(w.across + w.mass * half**2 for w in wheels) == pytest.approx(across)
    with pytest.raises(InputError, match="leave a wheel the mass"):
        AXLE.wheels(300.0, spin, across, half)


# --- in a vehicle ---------------------------------------------------------------------------------------------------


def elastic(axle: Axle = AXLE) -> Vehicle:
    """A coach on elastic axles."""
    return shipped("manchester_1").with_wheelsets(lambda own: replace(own, axle=axle))


def test_an_axle_bends_under_its_load_as_a_beam_does() -> None:
    """Springs at +-b push it down outside of its wheels at +-h: between these the moment is P (b - h), and each wheel
    leans by P (b - h) h / (E I)."""
    axle = Axle(((2.3, 0.16),), count=6)
    vehicle = elastic(axle)
    law = on_track(vehicle).law
    found = steady_state(law)
    half = 0.5 * vehicle.wheelsets[0].wheelset.profile_spacing
    ends = [abs(e.points[1][1]) for e in vehicle.elements if e.second == vehicle.wheelsets[0].name]
    outside = max(ends)
    own = law.modes_of(0)
    turn = law.attachments.modes[0].shapes(np.array([(0.0, half, 0.0)]))[:, 0, 3]
    leaning = float(found.q[own] @ turn)
    load = 0.5 * (law.wheels[0][0].model.arrays.total.Fb + law.wheels[0][1].model.arrays.total.Fb)
    load -= 0.5 * vehicle.wheelsets[0].mass * vehicle.gravity
    stiffness, _ = bending(axle, 0.16)
    assert leaning == pytest.approx(-load * (outside - half) * half / stiffness, rel=0.03)


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
    wheelset = shipped("wheelset_s1002").with_wheelsets(lambda own: replace(own, axle=AXLE))
    law = on_track(wheelset, 20.0).law
    q, q_t = design_state(law, lateral=2e-3)
    q[0] -= 2e-4
    q[3] += 3e-3
    own = law.modes_of(0)
    q[own], q_t[own] = 2e-4 * np.cos(np.arange(8.0)), 0.05 * np.sin(1.0 + np.arange(8.0))
    law(0.0, q, q_t, whole := np.zeros(law.size))
    law.on_bodies(0.0, q, q_t, without := np.zeros(law.size))
    forces = whole - without
    forces[own] *= law.attachments.modes[0].masses
    found = 0.0
    for wheel in law.own(0):
        for force, rate in ((wheel.force, wheel.body.velocity), (wheel.moment, wheel.body.omega)):
            found += sum(float(force[axis] * rate[axis]) for axis in "xyz")
    assert abs(found) > 1e3
    assert forces @ q_t == pytest.approx(found, rel=1e-4, abs=1.0)


def test_gyroscopic_forces_on_an_axle_do_no_work() -> None:
    """The part of the damping that grows with the speed is antisymmetric, with the modal masses."""
    wheelset = shipped("wheelset_s1002").with_wheelsets(lambda own: replace(own, axle=AXLE))
    masses = np.ones(6 + 8)
    found = []
    for speed in (1.0, 60.0):
        law = on_track(wheelset, speed).law
        masses[6:] = law.attachments.modes[0].masses
        q, q_t = design_state(law)
        blocks = law.blocks()[:1]  # without contacts
        law.blocks = lambda only=blocks: only  # type: ignore[method-assign, misc]
        found.append(masses[:, None] * force_derivative(law, q, q_t, 1, by_q=0.0, by_q_t=1.0))
    grown = found[1] - found[0]
    own = np.delete(np.delete(grown, [0, 1, 2, 5], 0), [0, 1, 2, 5], 1)
    assert np.max(np.abs(own)) > 1e3
    assert np.max(np.abs(own + own.T)) < 1e-6 * np.max(np.abs(own))


def test_keys_of_an_axle_are_checked(tmp_path: Path) -> None:
    for text, words in (
        ("sections_mm = []", "sections_mm"),
        ("sections_mm = [[2200, 160, 3]]", "two numbers"),
        ("sections_mm = [[2200, 600]]", "leave a wheel the mass"),
    ):
        change = ("[bodies.body]", f"[wheelset.axle]\n{text}\n\n[bodies.body]")
        assert words in fault(tmp_path, change)


def test_campbells_diagram_splits_every_mode_of_every_kind_of_axle_once(tmp_path: Path) -> None:
    coach, picture = elastic(), tmp_path / "campbell.png"
    found = stationary(coach, campbell=picture).numbers["axles"]
    assert [own["wheelset"] for own in found] == [coach.wheelsets[0].name]
    assert picture.exists()
    backward, forward = np.array(found[0]["backward_Hz"]), np.array(found[0]["forward_Hz"])
    assert forward[0] == pytest.approx(backward[0], rel=1e-4)
    assert np.all(np.diff(forward[:, :2], axis=0) > 0.0) and np.all(np.diff(backward[:, :2], axis=0) < 0.0)
    with pytest.raises(InputError, match="this vehicle has none"):
        stationary(shipped("manchester_1"), campbell=picture)


def test_the_exact_solver_does_not_go_with_elastic_axles() -> None:
    with pytest.raises(InputError, match=r"contact.normal.*cannot be \"half-space\" with elastic axles"):
        build(
            load(ROOT / "scenarios/manchester_r300.toml").with_values(
                {"contact.normal": "half-space", "vehicle.wheelset.axle": {"sections_mm": [[2200, 160]]}}
            )
        )
