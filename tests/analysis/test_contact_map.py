"""The table of many poses: every combination, with units, kept in a file."""

import numpy as np
import pytest
import xarray as xr
from support.contacts import RADIUS, rail_profile, wheel_profile

from wrsim import ContactSettings, InputError, contact_map
from wrsim.contact.batch import LOAD_TOLERANCE
from wrsim.contact.records import STATUS_NO_CONTACT

LOAD = 55e3


def test_the_table_holds_every_combination_with_units_and_comes_back_from_its_file(tmp_path):
    wheel, rail = wheel_profile("S1002"), rail_profile("60E1", 40)
    settings = ContactSettings(normal="kik-piotrowski")
    file = tmp_path / "map.nc"
    table = contact_map(
        wheel, rail, RADIUS, [0.0, 3e-3, 0.3], [0.0, 2e-3], 0.0, [40e3, LOAD], settings=settings, threads=1, file=file
    )
    assert dict(table["p0"].sizes) | {"patch": 0} == {"shift": 3, "yaw": 2, "roll": 1, "load": 2, "patch": 0}
    assert all(table[name].attrs["units"] for name in table.variables if name != "patch")
    on = table.isel(shift=slice(0, 2))
    assert on["Q"].values == pytest.approx(np.broadcast_to(table["load"].values, on["Q"].shape), rel=LOAD_TOLERANCE)
    beside = table.isel(shift=2)
    assert beside["Q"].isnull().all()
    assert (beside["status"].values & STATUS_NO_CONTACT).all()
    xr.testing.assert_identical(xr.load_dataset(file), table)
    with pytest.raises(InputError, match="shifts: must be"):
        contact_map(wheel, rail, RADIUS, [])
