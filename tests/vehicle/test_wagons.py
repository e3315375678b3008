"""Vehicles of a train along the track alone: waves in closed form, energy, brakes, grades, forces in curves."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.special import jv
from support.vehicles import manchester

from wrsim import Arc, Straight, Track
from wrsim.errors import InputError
from wrsim.simulation.integrate import Integration, Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state
from wrsim.simulation.system import BodySystem
from wrsim.track.segments import Grade
from wrsim.vehicle.couplings import CentreCouplerTable, Gap
from wrsim.vehicle.dynamics.vehicle_forces import BODIES
from wrsim.vehicle.vehicle import Body, BrakePipe, Member, Vehicle, Wagon
from wrsim.vehicle.vehicle_files import load_vehicle

MASS, LENGTH, G = 90e3, 14.0, 9.81
GEAR: dict[str, Any] = {"stiffness_kN_per_m": 10_000.0, "stroke_mm": 200.0}
STIFF = 5e6
"""Of a coupling: two gears in series."""


def chain(
    count: int, gear: dict[str, Any] = GEAR, slack: float = 0.0, brake: float = 0.0, pipe: BrakePipe | None = None,
    **of_wagon: Any,
) -> Vehicle:  # fmt: skip
    """Wagons in a row behind a wheelset and a body, which nothing couples to them."""
    values = {"kind": "centre", "height_mm": 1000.0, "hinge_mm": 500.0, "slack_mm": slack, "draw": gear, "buff": gear}
    table = CentreCouplerTable.model_validate(values)
    wagons = [Wagon(f"w{k}", MASS, -LENGTH * (k + 1), 9.0, **of_wagon) for k in range(count)]
    delays = [0.0 if pipe is None else LENGTH * (k + 1) / pipe.propagation for k in range(count)]
    members = [Member(w.name, 0, 0, False, brake, d, w) for w, d in zip(wagons, delays, strict=True)]
    gaps = (Gap(f"{k}", f"w{k}", f"w{k + 1}", -LENGTH * (k + 1.5)) for k in range(count - 1))
    return replace(
        manchester(), wheelsets=manchester().wheelsets[:1], bodies=(Body("body", 1e3, (1e3,) * 3, (0.0, 0.0, 1.0)),),
        elements=(), points=(), loads=(), payloads=(), gravity=0.0, members=(Member("first", 1, 1, False), *members),
        chain=tuple(element for gap in gaps for element in table.along(gap)), brakes=pipe,
    )  # fmt: skip


def law_of(vehicle: Vehicle, track: Track | None = None, start: float = 700.0, gravity: float = 0.0) -> VehicleOnTrack:
    """Its forces, without rails."""
    track = track or Track.build([Straight(900.0)], 1.5)
    return VehicleOnTrack(vehicle, track, (), speed=0.0, start=start, drive="free", gravity=gravity)


def motion(law: VehicleOnTrack, speeds: Any, duration: float, step: float = 1e-3) -> Motion:
    """From the design position on with these speeds of the wagons [m/s]."""
    q, q_t = design_state(law)
    q_t[law.wagons] = MASS * np.broadcast_to(speeds, len(law.wagons))
    return Integration(BodySystem(law.bodies, law), duration=duration, step=step, weight=MASS * G).run(q, q_t)


@pytest.mark.parametrize("mode", [1, 5, 12])
def test_waves_in_a_chain_have_the_dispersion_of_masses_and_springs(mode: int) -> None:
    """The standing wave cos(k a (j + 1/2)), k a = pi mode / n, of n free wagons: omega = 2 sqrt(K/m) sin(k a / 2)."""
    count = 16
    shape = np.cos(np.pi * mode / count * (np.arange(count) + 0.5))
    law = law_of(chain(count))
    omega = 2.0 * np.sqrt(STIFF / MASS) * np.sin(0.5 * np.pi * mode / count)
    moved = motion(law, 0.1 * shape, 0.5 * np.pi / omega + 0.05)
    wave = moved.q_t[:, law.wagons] @ shape / (0.1 * MASS * shape @ shape)
    np.testing.assert_allclose(wave, np.cos(omega * moved.times), atol=1e-3)


def test_a_push_runs_along_a_chain_as_bessel_functions_do() -> None:
    """The first of 40 wagons is pushed: v_j = v (J_2j(2 w t) + J_2j+2(2 w t)) with w = sqrt(K/m), a chain with a free
    end (Schroedinger 1914), until the other end answers: nothing is ahead of the front at a w. Within 1e-3 of the push;
    the energy, kinetic and elastic, is kept within 1e-3."""
    omega, j = np.sqrt(STIFF / MASS), np.arange(40)
    law = law_of(chain(40))
    moved = motion(law, np.where(j == 0, -1.0, 0.0), 32.0 / omega)
    speeds = -moved.q_t[:, law.wagons] / MASS
    z = 2.0 * omega * moved.times[:, None]
    np.testing.assert_allclose(speeds, jv(2 * j, z) + jv(2 * j + 2, z), atol=1e-3)
    ahead = LENGTH * j > 1.25 * LENGTH * omega * moved.times[:, None] + 3.0 * LENGTH
    assert np.abs(speeds[ahead]).max() < 1e-3
    kinetic = 0.5 * (moved.q_t[:, law.wagons] ** 2).sum(axis=1) / MASS
    elastic = 0.5 * STIFF * (np.diff(moved.q[:, law.wagons] / MASS, axis=1) ** 2).sum(axis=1)
    np.testing.assert_allclose(kinetic + elastic, kinetic[0], rtol=1e-3)


def test_gears_with_friction_take_what_the_energy_loses() -> None:
    """20 wagons with play and friction, the rear half runs up: kinetic energy less what forces between them have taken
    is kept within 1e-3 of the loss; momentum to round-off."""
    law = law_of(chain(20, GEAR | {"friction_share": 0.3, "friction_travel_mm": 2.0}, slack=20.0))
    moved = motion(law, np.where(np.arange(20) < 10, 0.0, 1.0), 2.0)
    speeds, out, power = moved.q_t[:, law.wagons] / MASS, np.zeros(law.size), []
    for t, q, q_t in zip(moved.times, moved.q, moved.q_t, strict=True):
        law(t, q, q_t, out)
        power.append(
            law.readings[:, 0].reshape(-1, 2).sum(axis=1) @ (q_t[law.wagons][:-1] - q_t[law.wagons][1:]) / MASS
        )
    kinetic = 0.5 * MASS * (speeds**2).sum(axis=1)
    taken = cumulative_trapezoid(power, moved.times, initial=0.0)
    assert kinetic[-1] < 0.8 * kinetic[0]
    np.testing.assert_allclose(kinetic + taken, kinetic[0], atol=1e-3 * kinetic[0])
    np.testing.assert_allclose(speeds.sum(axis=1), 10.0, rtol=1e-9)


def test_a_brake_begins_when_the_command_arrives_and_fills_with_its_time_constant() -> None:
    """At rest against the couplings' zero, speed 20 m/s: B_0 (1 - exp(-(t - t_0 - x/c) / T)) to round-off, nothing
    before; the release of half of it a step of its own; the moments on a vehicle in full are the same within 2e-3."""
    pipe = BrakePipe(250.0, 4.0, ((3.0, 1.0), (10.0, 0.5)))
    vehicle = chain(30, brake=50e3, pipe=pipe)
    law = law_of(vehicle)
    (q, q_t), out = design_state(law), np.zeros(law.size)
    q_t[law.wagons] = 20.0 * MASS
    delays = np.array([member.delay for member in vehicle.members[1:]])
    np.testing.assert_allclose(delays, LENGTH * np.arange(1, 31) / 250.0)
    for t in (3.0, 3.0 + delays[9] - 1e-9, 5.0, 9.99, 12.0, 60.0):
        law(t, q, q_t, out)
        since, later = t - 3.0 - delays, t - 10.0 - delays
        share = np.where(since > 0.0, 1.0 - np.exp(-since / 4.0), 0.0)
        share -= 0.5 * np.where(later > 0.0, 1.0 - np.exp(-later / 4.0), 0.0)
        np.testing.assert_allclose(out[law.wagons], -50e3 * share, rtol=1e-12, atol=1e-9)
    front = replace(vehicle.members[0], brake=50e3, delay=delays[9])
    (effort,) = replace(vehicle, members=(front, *vehicle.members[1:])).braked_wheelsets
    radius = vehicle.wheelsets[0].wheelset.mean_radius
    for t in (2.9, 4.0, 6.3, 11.7, 50.0):
        assert effort.moment(t, 0.0) / radius == pytest.approx(-50e3 * pipe.share(np.array(t - delays[9])), abs=100.0)


def test_a_locomotive_on_a_grade_pulls_with_the_weight_of_the_train() -> None:
    """Held at its front on 20 per mille: between wagons k and k + 1 the force is the weight component and resistance of
    all behind it, and these are in balance; in a curve of R 300 curve resistance adds m g k / R, of the chord."""
    count, grade, resistance = 12, 0.02, (900.0, 0.0, 3.0)
    laid = {"grades": [Grade(0.0, grade)]}
    need = MASS * G * np.sin(np.arctan(grade)) + 900.0 + 3.0 * 25.0
    law = law_of(chain(count, resistance=resistance), Track.build([Straight(900.0)], 1.5, **laid), gravity=G)
    tension = need * np.arange(count - 1, 0, -1)
    (q, q_t), out = design_state(law), np.zeros(law.size)
    q_t[law.wagons] = 5.0 * MASS
    q[law.wagons[1:]] = -MASS * np.cumsum(tension) / STIFF
    law(0.0, q, q_t, out)
    np.testing.assert_allclose(law.readings[::2, 0] + law.readings[1::2, 0], tension, rtol=1e-9)
    np.testing.assert_allclose(out[law.wagons[1:]], 0.0, atol=1e-6 * tension[0])
    assert out[law.wagons[0]] == pytest.approx(-tension[0] - need, rel=1e-9)
    law = law_of(
        chain(1, resistance=resistance, curve_resistance=0.7), Track.build([Arc(900.0, 300.0)], 1.5, **laid), gravity=G
    )
    (q, q_t), out = design_state(law), np.zeros(law.size)
    q_t[law.wagons] = 5.0 * MASS
    law(0.0, q, q_t, out)
    assert out[law.wagons[0]] == pytest.approx(-need - MASS * G * 0.7 / 300.0, rel=1e-3)


def test_forces_along_the_track_are_the_slope_of_the_energy_in_a_curve_too() -> None:
    """Through straight, R 190 and a grade: the work of couplings and weight on each wagon is the loss of potential
    energy, elastic and of height, along every small way within 1e-5 of the forces: the tables of the track."""
    track = Track.build([Straight(540.0), Arc(60.0, 190.0), Arc(300.0, -190.0)], 1.5, grades=[Grade(0.0, 0.01)])
    law = law_of(chain(10), track, gravity=G)
    random = np.random.default_rng(3)
    (q, zero), out = design_state(law), np.zeros(law.size)
    q[law.wagons] = MASS * random.uniform(-0.05, 0.05, 10)

    def energy(q: np.ndarray) -> float:
        law(0.0, q, zero, np.zeros(law.size))
        heights = law.workspace.views[BODIES]["position"]["z"][-10:]
        return float(0.5 * STIFF * (law.readings[:, 3] ** 2)[::2].sum() + MASS * G * heights.sum())

    law(0.0, q, zero, out)
    slopes = []
    for c in law.wagons:
        ways = [q + s * 1e-5 * MASS * (np.arange(law.size) == c) for s in (1.0, -1.0)]
        slopes.append((energy(ways[0]) - energy(ways[1])) / 2e-5)
    np.testing.assert_allclose(out[law.wagons], np.negative(slopes), atol=1e-5 * np.abs(slopes).max())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mass_t = 84 ", 'mass_t = 84\nmodel = "vehicles/freight_y25.toml" #', "give one of them"),
        ("pivot_spacing_mm = 10000", "#", "goes with mass_t"),
        ("[brakes]\npropagation_m_per_s = 250", "[[points]]\n#", "points"),
    ],
)
def test_a_train_says_what_a_wagon_needs(old: str, new: str, message: str, tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "models/trains/freight_100.toml").read_text(encoding="utf-8")
    assert old in text
    file = tmp_path / "train.toml"
    file.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        load_vehicle(file)


def test_a_buff_force_presses_a_wagon_out_of_a_curve_by_its_length_over_the_radius(tmp_path: Path) -> None:
    """A wagon in full between four others in R 300, pressed together: the lines of action lie half of the angle l/R
    between neighbours off its axis at both of its ends, so what presses it more by F pushes its body outward by F l/R
    more. Within 3 %: the body lies 1.3 mm further inside than on its pivots, over 3 m between the centres
    of the buffers' spheres, which takes 2 %."""
    text = (Path(__file__).parents[2] / "models/trains/freight_100.toml").read_text(encoding="utf-8")
    text = text.replace("count = 56", "count = 2").replace("count = 43", "count = 2").replace("plate_friction", "#")
    (tmp_path / "train.toml").write_text(text, encoding="utf-8")
    vehicle, radius, length = load_vehicle(tmp_path / "train.toml"), 300.0, 14.04
    law = law_of(vehicle, Track.build([Arc(900.0, radius)], 1.5), gravity=vehicle.gravity)
    q, q_t = design_state(law)
    body, heading = 6 * vehicle.index("wagon.carbody"), q[6 * vehicle.index("wagon.carbody") + 3]
    lateral, force = [], []
    for stroke in (0.0, 0.04):
        q[law.wagons] = stroke * law.masses * np.array([-1.0, -1.0, -1.0, 1.0, 1.0])
        out = np.zeros(law.size)
        law.on_bodies(0.0, q, q_t, out)
        lateral.append(out[body + 2] * np.cos(heading) - out[body + 1] * np.sin(heading))
        at_ends = [i for i, e in enumerate(vehicle.elements) if "wagon-" in e.name or "-wagon" in e.name]
        force.append(-0.5 * law.records[at_ends, 0].sum())
    assert force[1] - force[0] > 100e3
    assert lateral[0] - lateral[1] == pytest.approx((force[1] - force[0]) * length / radius, rel=0.03)
