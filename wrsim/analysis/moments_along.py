"""The contacts of a run at any of its samples, from the poses that its result holds.

Strips and outlines are in a result at its snapshots only. The normal contact follows from the pose of the wheelset at
any other sample, by the model of the run. Rates of the pose are left out: they act through the contact damping alone,
some thousandths of the force.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.derailment import contact_words, wheels_of
from wrsim.analysis.motion.result import stack_wheelsets
from wrsim.contact.channels import StripRecorder
from wrsim.errors import InputError, SimulationError
from wrsim.results import CHANNELS
from wrsim.results.wheelsets import wheelsets
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.placement import design_state, state_on_track

NEEDED = ("wheelset_distance", "lateral_shift", "vertical_shift", "yaw", "roll", "spin_rate")
RAILS = ("rail_displacement_y", "rail_displacement_z")


def with_moments(dataset: xr.Dataset, setup: Setup[RunPlan], samples: Sequence[int]) -> xr.Dataset:
    """The dataset of a run with snapshots at these samples, all of them solved again.

    Its attribute ``contact_remark``: remarks on the contacts, and at how many of the samples; empty without any.
    Raises InputError when the result does not hold what is needed, belongs to another vehicle, or was solved by the
    exact solver, which takes too long for this.
    """
    names = [mounted.name for mounted in setup.vehicle.wheelsets]
    missing = [name for name in NEEDED if name not in dataset.variables]
    if missing or "time" not in dataset.dims or list(wheelsets(dataset)) != names:
        raise InputError("the result does not hold the poses of the wheelsets of its scenario")
    if setup.contact.normal == "half-space":
        raise InputError("contacts of the exact solver are drawn at kept moments only: anywhere else takes minutes")
    law = force_law(replace(setup, contact=replace(setup.contact, tangential="none")))
    recorders = [StripRecorder(pair) for pair in law.wheels]
    q, q_t = design_state(law)  # bodies stay there: contacts depend on the wheelsets alone
    out = np.zeros(law.size)
    columns = {name: dataset[name].transpose("time", "wheelset", ...).values for name in NEEDED}
    time, distance, speed = (dataset[name].values for name in ("time", "distance", "speed"))
    kept = []
    found_remarks: Counter[str] = Counter()
    for i in samples:
        for w, mounted in enumerate(setup.vehicle.wheelsets):
            own = {name: float(values[i, w]) for name, values in columns.items()}
            q[6 * w : 6 * w + 6], q_t[6 * w : 6 * w + 6] = state_on_track(
                law.track.centre, own["wheelset_distance"], speed=float(speed[i]),
                height=own["vertical_shift"] + mounted.wheelset.mean_radius, spin_rate=own["spin_rate"],
                lateral=own["lateral_shift"], yaw=own["yaw"], roll=own["roll"],
            )  # fmt: skip
        for w, twist in law.twists.items():
            q_t[twist] = float(dataset["spin_difference"].values[i, w])
        if law.rails and all(name in dataset for name in RAILS):
            moved = np.stack([dataset[name].values[i] for name in RAILS], axis=-1)
            q[law.size - law.rails : law.size] = moved.ravel()
        try:
            law.look_near(law.places(columns["wheelset_distance"][i : i + 1])[0])
            law(float(time[i]), q, q_t, out)
        except SimulationError:  # a derailed wheelset may have no place on the track
            continue
        for recorder in recorders:
            recorder.store()
        for wheel in wheels_of(law):
            found_remarks.update(filter(None, [contact_words([wheel])]))
        kept.append(i)
    if not kept:
        raise InputError("no sample of the result has a place on the track of its scenario")
    found = stack_wheelsets([recorder.channels() for recorder in recorders])
    coords = {"snapshot_time": time[kept], "snapshot_distance": distance[kept]}
    variables = {
        name: (CHANNELS[name].dims_in("time"), values, {"units": CHANNELS[name].unit})
        for name, values in (found | coords).items()
    }
    dims = {"snapshot", "strip", "column", "axis", "rail_point", "wheel_point"}
    remarks = [f"{words} (at {count} of {len(kept)} places)" for words, count in found_remarks.items()]
    return dataset.drop_dims(dims & set(dataset.dims)).assign(variables).assign_attrs(contact_remark="; ".join(remarks))
