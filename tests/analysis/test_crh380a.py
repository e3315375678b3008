"""The CRH380A: weights, its yaw dampers, and two ends of one speed; on cones, for which no contact has to be solved."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.runs import SCENARIOS

from wrsim.analysis.stability.cycles import CycleSearch
from wrsim.analysis.stability.rolling import RollingVehicle
from wrsim.analysis.stability.run import run_stability
from wrsim.analysis.stationary.statics import static_state
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import load
from wrsim.scenario.sections.stability import StabilityPlan
from wrsim.vehicle.loads import Load
from wrsim.vehicle.preload import preloads

KMH = 1.0 / 3.6
BETWEEN = 480
"""Above 401 and 256, below 557 km/h, the linear critical speeds of docs/user/stability.md."""


@cache
def setup(conicity: float = 0.3, yaw_dampers: bool = True) -> Setup[StabilityPlan]:
    """The shipped scenario without its limit cycles."""
    values = {"contact.conical.conicity": conicity, "stability.nonlinear": False, "stability.speed_kmh": BETWEEN}
    found = build(load(SCENARIOS / "stability_crh380a.toml").with_values(values))
    if yaw_dampers:
        return found
    others = tuple(e for e in found.vehicle.elements if "yaw damper" not in e.name)
    assert len(others) == len(found.vehicle.elements) - 4
    return replace(found, vehicle=replace(found.vehicle, elements=others))


def growth(conicity: float = 0.3, yaw_dampers: bool = True) -> float:
    """Largest growth rate at that speed [1/s]."""
    return float(run_stability(setup(conicity, yaw_dampers)).dataset["growth_max"].item())


def test_its_springs_carry_the_masses_of_the_source():
    vehicle = setup().vehicle
    total = 40840.0 + 2.0 * 2280.0 + 4.0 * 1901.8
    loads = static_state(vehicle).wheel_loads
    assert loads == pytest.approx(np.full((4, 2), total * vehicle.gravity / 8.0), rel=1e-9)
    up = {e.name: own.force[-1] for e, own in zip(vehicle.elements, preloads(vehicle), strict=True)}
    air = [abs(force) for name, force in up.items() if "air spring" in name]
    assert air == pytest.approx([40840.0 * vehicle.gravity / 4.0] * 4, rel=1e-9)
    assert [force for name, force in up.items() if "bushing" in name] == pytest.approx([0.0] * 8, abs=1e-6)


def test_under_a_load_it_sinks_by_both_stages_in_series():
    """The arms swing: upright they leave the springs alone, 4 x 260 kN/m on 8 x 1176."""
    vehicle = setup().vehicle
    force = 10e3
    load = Load.constant("load", "carbody", (0.0, 0.0, -force), (0.0, 0.0, 1.52))
    places = [body.name for body in vehicle.bodies]
    sunk = static_state(replace(vehicle, loads=(load,))).moved[places.index("carbody")][1]
    assert -sunk == pytest.approx(force / (4 * 260e3) + force / (8 * 1176e3), rel=1e-3)


def test_steeper_wheels_and_missing_yaw_dampers_make_it_hunt():
    assert growth() < 0.0
    assert growth(conicity=0.5) > 0.0
    assert growth(yaw_dampers=False) > 0.0


@pytest.mark.parametrize(("speed", "shift", "ending"), [(400, 8.0, "cycle"), (400, 0.3, "rest"), (240, 8.0, "rest")])
def test_between_both_critical_speeds_the_disturbance_decides(speed, shift, ending):
    """Its yaw dampers hold small motions and blow off in large ones."""
    assert speed < BETWEEN
    whole = build(load(SCENARIOS / "stability_crh380a.toml").with_values({"stability.window_s": 1.5}))
    search = CycleSearch(RollingVehicle(whole, speed * KMH), whole.plan.cycles, [], lambda part: None)
    found, _ = search.hold(speed * KMH, "from above", search.kicked(speed * KMH, 1e-3 * shift))
    assert found.ending == ending
    if ending == "cycle":  # from flange to flange, which touch at 8.5 mm
        assert 7e-3 < found.amplitudes.max() < 12e-3
