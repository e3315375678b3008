"""The shipped car on three-piece trucks: weights in balance, wedges that follow the load, side frames that equalise."""

import numpy as np
import pytest

from wrsim import Vehicle, load_vehicle
from wrsim.analysis.stationary.statics import static_state
from wrsim.vehicle.preload import preloads

POUND, KIP = 0.45359237, 4448.2216152605


@pytest.fixture(scope="module")
def car() -> Vehicle:
    return load_vehicle("vehicles/three_piece_100t.toml")


def test_the_empty_car_weighs_63_kip_on_eight_equal_wheels(car: Vehicle) -> None:
    assert car.mass == pytest.approx(63_000.0 * POUND, rel=1e-12)
    assert static_state(car).wheel_loads == pytest.approx(63.0 * KIP / 8.0, rel=1e-9)


def test_preloads_carry_body_and_bolster_and_the_wedges_have_their_share(car: Vehicle) -> None:
    """A nest has a quarter of the car body and half of a bolster; its control coils 4 of 23 kip/in of that. Friction at
    the columns, 0.4 / tan(37.5 degrees) of the control coils, is then 9 % of the load of a nest."""
    up = {
        e.name: float(np.atleast_1d(preload.force)[-1]) for e, preload in zip(car.elements, preloads(car), strict=True)
    }
    nest = (42.6 / 4.0 + 1.9 / 2.0) * KIP
    for side in ("lead.left", "lead.right", "trail.left", "trail.right"):
        assert up[f"{side}.control coils"] == pytest.approx(4.0 / 23.0 * nest, rel=1e-6)
        assert up[f"{side}.load coils"] == pytest.approx(19.0 / 23.0 * nest, rel=1e-6)
        assert up[f"{side}.adapter outer"] == pytest.approx(-0.5 * (nest + 1.15 * KIP), rel=1e-6)
    (wedge,) = (e for e in car.elements if e.name == "lead.left.wedge")
    assert wedge.slider is not None and wedge.slider.normal is not None
    bound = wedge.slider.friction * wedge.slider.normal.factor * up["lead.left.control coils"]
    assert bound / nest == pytest.approx(0.4 / np.tan(np.radians(37.5)) * 4.0 / 23.0, rel=0.01)


def test_a_side_frame_shares_its_load_between_its_wheels_on_twisted_track(car: Vehicle) -> None:
    """On 3 mm/m a side frame pitches against its columns, K = 400 kNm/rad, by the twist over b = 39.5 in, half of the
    distance of the journals: K pitch / 2 a goes from one journal to the other, b / s times as much from wheel to wheel.
    What yields in series (adapters, nests) takes some of the pitch. The body twists its trucks by far more."""
    a, b, s = 35.0 * 0.0254, 39.5 * 0.0254, 0.5 * car.wheelsets[0].wheelset.profile_spacing
    loads = static_state(car, 3e-3).wheel_loads
    within, between = loads[0, 0] - loads[1, 0], loads[:2, 0].mean() - loads[2:, 0].mean()
    assert 0.9 < within / (2.0 * 400e3 * 3e-3 * b / (2.0 * a) * b / s) < 1.0
    assert between > 10.0 * within
