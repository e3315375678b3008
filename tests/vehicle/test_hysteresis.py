"""Leaf springs, rubber, air springs, nested springs and play: their loops against closed forms."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.boxes import AT, FIXED, HEIGHT, MASS, box, motion, on_springs, spring

from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.modes import natural_modes
from wrsim.simulation.placement import design_state
from wrsim.vehicle.element_tables import KINDS, VEHICLE_AXES, Joint
from wrsim.vehicle.elements import TRACK, BilinearSpring

Z, X = 6, 7
"""Places of the box in the state."""


def element(kind: str, **keys: Any) -> Any:
    """An element of the box as a file has it."""
    common = {"kind": kind, "name": kind, "body": "track", "to": ["box"], "at_mm": [0, 0, 1e3 * HEIGHT]}
    table = KINDS[kind].model_validate(common | {"direction": "x"} | keys)
    return table.element(Joint(kind, kind, TRACK, "box"), VEHICLE_AXES)


def driven(law: VehicleOnTrack, travel: Any, times: Any) -> Any:
    """Force of the element along x over a prescribed travel(t), its unknowns integrated by RK4."""
    q, q_t = design_state(law)
    place, inner, forces = q[X], np.zeros(law.dampers), []

    h = 1e-7

    def rates(t: float, unknowns: Any) -> tuple[Any, float]:
        out = np.zeros(law.size)
        q[X], q_t[X] = place + travel(t), (travel(t + h) - travel(t - h)) / (2.0 * h)
        q_t[12:] = unknowns
        law(0.0, q, q_t, out)
        return out[12:].copy(), -float(out[X])

    for t, step in zip(times, np.diff(times, append=times[-1]), strict=True):
        a, force = rates(t + 2.0 * h, inner)  # behind a return, not on it
        forces.append(force)
        b = rates(t + 0.5 * step, inner + 0.5 * step * a)[0]
        c = rates(t + 0.5 * step, inner + 0.5 * step * b)[0]
        d = rates(t + step - 2.0 * h, inner + step * c)[0]
        inner = inner + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return np.array(forces)


def zigzag(amplitude: float) -> Any:
    """Travel that goes evenly up and down with period 1 s, from 0."""
    return lambda t: amplitude * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * t))


def last_loop(law: VehicleOnTrack, amplitude: float, loops: int = 3, steps: int = 400) -> tuple[Any, Any]:
    """Travel and force of the last of some loops."""
    times = np.linspace(0.0, loops, loops * steps + 1)
    path = zigzag(amplitude)
    forces = driven(law, path, times)
    return path(times[-steps - 1 :]), forces[-steps - 1 :]


K, LIMIT, X2 = 2e5, 3e3, 4e-3


@pytest.mark.parametrize("amplitude", [2e-3, 4e-3, 20e-3])
def test_the_loops_of_rubber_are_those_of_berg(amplitude: float) -> None:
    """Between the returns at (-a, -f0) and (a, f0) his stroke f = -f0 + s (F + f0)/(x2 (1 + f0/F) + s) closes where
    f0 = F (sqrt(x2^2 + 6 a x2 + a^2) - x2 - a)/(2 x2); its area 2 F (2 a - x2 (1 + m)^2 ln(1 + 2 a/(x2 (1 + m)))) with
    m = f0/F, both by integration of the stroke. Stiffness K + f0/a falls with the amplitude."""
    rubber = element(
        "rubber-spring", stiffness_kN_per_m=1e-3 * K, friction_force_kN=1e-3 * LIMIT, friction_travel_mm=1e3 * X2
    )
    travel, force = last_loop(on_springs(box(FIXED, rubber)), amplitude, loops=12, steps=200)
    a, x2 = amplitude, X2
    f0 = LIMIT * (np.sqrt(x2**2 + 6.0 * a * x2 + a**2) - x2 - a) / (2.0 * x2)
    m = f0 / LIMIT
    area = 2.0 * LIMIT * (2.0 * a - x2 * (1.0 + m) ** 2 * np.log(1.0 + 2.0 * a / (x2 * (1.0 + m))))
    assert force.max() == pytest.approx(K * a + f0, rel=2e-3)
    assert force.min() == pytest.approx(-K * a - f0, rel=2e-3)
    assert np.trapezoid(force, travel) == pytest.approx(area, rel=1e-2)
    up = np.gradient(travel) > 0.0
    s = travel[up] + a
    stroke = K * travel[up] - f0 + s * (LIMIT + f0) / (x2 * (1.0 + m) + s)
    np.testing.assert_allclose(force[up], stroke, atol=5e-3 * LIMIT)


@pytest.mark.parametrize("share", [False, True])
def test_the_loops_of_a_leaf_spring_are_those_of_fancher(share: bool) -> None:
    """Every stroke ends at F (1 - exp(-s/b)) + f exp(-s/b) of where it began, so the loop between -a and a has its
    corners at F tanh(a/b). As a share of the load the same, where the load hardly changes."""
    amplitude, distance = 8e-3, 3e-3
    if share:
        amplitude = 0.8e-3  # of 98 mm of static travel
        law = on_springs(
            box(
                spring(stiffness=(4e6, 4e6, 0.0), turning_stiffness=(4e6,) * 3),
                element("leaf-spring", direction="z", stiffness_kN_per_m=400, friction_share=0.1,
                        friction_travel_mm=1e3 * distance),
            ),
            gravity=9.80665,
        )  # fmt: skip
        limit = 0.1 * MASS * 9.80665
        q, q_t = design_state(law)
        for lower, sign in ((amplitude, 1.0), (-amplitude, -1.0)):
            q[Z] -= lower
            out = np.zeros(law.size)
            law(0.0, q, law.settled_rates(q, q_t), out)
            bound = limit + sign * 0.1 * 4e5 * amplitude
            virgin = bound * (1.0 - np.exp(-amplitude / distance * limit / bound))
            assert out[Z] == pytest.approx(sign * (4e5 * amplitude + virgin), rel=1e-9)
            q[Z] += lower
        return
    leaf = element(
        "leaf-spring", stiffness_kN_per_m=1e-3 * K, friction_force_kN=1e-3 * LIMIT, friction_travel_mm=1e3 * distance
    )
    travel, force = last_loop(on_springs(box(FIXED, leaf)), amplitude)
    corner = LIMIT * np.tanh(amplitude / distance)
    assert force.max() == pytest.approx(K * amplitude + corner, rel=2e-3)
    up = np.gradient(travel) > 0.0
    s = travel[up] + amplitude
    np.testing.assert_allclose(
        force[up], K * travel[up] + LIMIT - (LIMIT + corner) * np.exp(-s / distance), atol=5e-3 * LIMIT
    )


def test_an_air_spring_is_soft_when_slow_stiff_when_fast_and_damps_in_between() -> None:
    """Between K and K + series; a Maxwell part with a linear orifice has its largest loss, series/2, at series/c."""
    series, c, amplitude = 3e5, 6e4, 5e-3
    air = element(
        "air-spring", stiffness_kN_per_m=1e-3 * K, series_stiffness_kN_per_m=1e-3 * series,
        orifice_damping=1e-3 * c, orifice_exponent=1.0,
    )  # fmt: skip
    law = on_springs(box(FIXED, air))
    for part, stiffness, loss in ((0.02, K, None), (1.0, K + 0.5 * series, 0.5 * series), (50.0, K + series, None)):
        w = part * series / c
        times = np.linspace(0.0, 4.0 * 2.0 * np.pi / w, 2401)
        force = driven(law, lambda t, w=w: amplitude * np.sin(w * t), times)
        late = slice(1800, None)  # the last period
        inphase = 2.0 * np.trapezoid(force[late] * np.sin(w * times[late]), w * times[late]) / (2.0 * np.pi)
        quadrature = 2.0 * np.trapezoid(force[late] * np.cos(w * times[late]), w * times[late]) / (2.0 * np.pi)
        assert inphase / amplitude == pytest.approx(stiffness, rel=5e-3)
        if loss is not None:
            assert quadrature / amplitude == pytest.approx(loss, rel=5e-3)


def test_an_orifice_has_the_force_of_its_power_law() -> None:
    air = element(
        "air-spring", stiffness_kN_per_m=100, series_stiffness_kN_per_m=300, orifice_damping=50, orifice_exponent=1.8
    )
    velocity, force = np.transpose(air.damper_table)
    for v in (-0.5, 2e-3, 0.03, 1.0):
        assert np.interp(v, velocity, force) == pytest.approx(np.sign(v) * 5e4 * abs(v) ** 1.8, rel=3e-3)


def test_a_nest_of_springs_stands_on_its_line_where_its_load_is_and_never_pulls() -> None:
    k, inner, inner_from = 1e6, 1.5e6, 0.6 * MASS * 9.81
    more = {"second_stiffness": inner, "second_from": inner_from}
    nest = BilinearSpring("nest", "bilinear-spring", TRACK, "box", (AT, AT), 2, k, **more)
    for load in (0.5, 1.0):  # below and beyond the bend
        gravity = 9.81 * load
        vehicle = box(spring(stiffness=(4e6, 4e6, 0.0), turning_stiffness=(4e6,) * 3), nest)
        law = on_springs(replace(vehicle, gravity=gravity), gravity=gravity)
        q, q_t = design_state(law)
        weight = MASS * gravity
        compressed = min(weight, inner_from) / k + max(0.0, weight - inner_from) / (k + inner)
        for lower in (0.0, 5e-3, -5e-3, -compressed - 1e-3):
            total = max(0.0, compressed + lower)
            expected = k * total + inner * max(0.0, total - inner_from / k)
            q[Z] -= lower
            law(0.0, q, q_t, out := np.zeros(law.size))
            assert out[Z] == pytest.approx(expected - weight, abs=1e-6 * weight)
            q[Z] += lower
        (bounce,) = (mode for mode in natural_modes(law.vehicle) if mode.name == "box vertical")
        stiffness = k if load == 0.5 else k + inner
        assert bounce.frequency == pytest.approx(np.sqrt(stiffness / MASS) / (2.0 * np.pi), rel=1e-6)


def test_a_mass_between_two_stops_with_play_swings_with_the_time_that_it_flies() -> None:
    """Half a swing against either stop and the play at its speed: T = 2 pi sqrt(m/k) + 4 c/v."""
    k, play, speed = 4e6, 0.02, 0.5
    rod = KINDS["traction-rod"].model_validate(
        {
            "kind": "traction-rod", "name": "rod", "body": "track", "to": ["box"], "stiffness_kN_per_m": 1e-3 * k,
            "clearance_mm": 1e3 * play, "body_mm": [-3000, 0, 1e3 * HEIGHT], "to_mm": [0, 0, 1e3 * HEIGHT],
        }
    )  # fmt: skip
    law = on_springs(box(FIXED, rod.element(Joint("rod", "traction-rod", TRACK, "box"), VEHICLE_AXES)))
    q, q_t = design_state(law)
    place = q[X]
    q_t[X] = speed
    found = motion(law, q, q_t, 1.3, 2e-4, "rk44")
    x = found.q[:, X] - place - 1e-6
    crossings = found.times[1:][(x[:-1] < 0.0) & (x[1:] >= 0.0)]
    assert len(crossings) >= 3
    period = 2.0 * np.pi * np.sqrt(MASS / k) + 4.0 * play / speed
    np.testing.assert_allclose(np.diff(crossings), period, rtol=3e-3)
