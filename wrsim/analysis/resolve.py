"""Contacts of a result solved again: its snapshots by another contact model, or a run at any of its samples.

By another model every wheel keeps its pose and motion but for its height, which follows from the vertical force that it
had: two models need different approaches for one force. With ``keep = "pose"`` the height stays and the force follows.

Strips and outlines are in a result at its snapshots only. At any other sample the normal contact follows from the pose
of the wheelset, by the model of the run. Rates of the pose are left out: they act through the contact damping alone,
some thousandths of the force.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.analysis.contacts import force_law, wheels_on_rails
from wrsim.analysis.motion.derailment import contact_words, wheels_of
from wrsim.analysis.motion.samples import RAIL_CHANNELS, stack_wheelsets
from wrsim.analysis.progress import Progress, Report
from wrsim.contact import channels
from wrsim.contact.channels import POSE_CHANNELS, ElementField, StripRecorder, WheelOnRail
from wrsim.contact.half_space.strips import element_fields, solve_into
from wrsim.contact.prescribed_load import approach_of
from wrsim.contact.status import status_words
from wrsim.contact.subsurface.fatigue import FatigueLimits
from wrsim.contact.subsurface.loads import Body, surface_loads
from wrsim.contact.subsurface.sections import Values, sections, subsurface_channels
from wrsim.errors import InputError, SimulationError
from wrsim.results import CHANNELS, Result, assemble
from wrsim.results.moments import sample_of
from wrsim.results.wheelsets import wheelsets
from wrsim.scenario.build import Setup, build
from wrsim.scenario.contact_choice import with_contact_model
from wrsim.scenario.kept import ATTRIBUTE
from wrsim.scenario.loading import Scenario
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.placement import design_state, state_on_track
from wrsim.simulation.pose_solver import Carried, LoadNotReached, height_for_load, lower

TOLERANCE = 1e-5  # of the vertical force, of the exact solver
DEEPEST = 1e-3  # farthest a wheel is moved [m]


@dataclass(frozen=True)
class Subsurface:
    """Stresses below the surface of a body; with limits also fatigue by depth."""

    body: Body = "rail"
    limits: FatigueLimits | None = None

    @property
    def attributes(self) -> dict[str, str | float]:
        """For the dataset."""
        limits = vars(self.limits) if self.limits else {}
        return {"subsurface_body": self.body} | {f"{name}_limit_MPa": 1e-6 * value for name, value in limits.items()}


def below_surface(asked: bool, body: str, bending: float | None, torsion: float | None) -> Subsurface | None:
    """What the options of the command mean; limits in MPa. Raises InputError for options that do not fit together."""
    limits = (bending, torsion)
    if not asked:
        if any(limit is not None for limit in limits) or body != "rail":
            raise InputError("--body, --bending-limit-MPa and --torsion-limit-MPa: need --subsurface")
        return None
    if body not in get_args(Body):
        raise InputError(f"--body {body}: must be rail or wheel")
    if bending is None and torsion is None:
        return Subsurface(cast(Body, body))
    if bending is None or torsion is None:
        raise InputError("--bending-limit-MPa and --torsion-limit-MPa: fatigue by depth needs both")
    return Subsurface(cast(Body, body), FatigueLimits(1e6 * bending, 1e6 * torsion))


def resolve_contacts(
    result: Result,
    scenario: Scenario,
    name: str = "half-space",
    *,
    keep: str = "load",
    moments: Sequence[int] | None = None,
    wheelset: str | None = None,
    subsurface: Subsurface | None = None,
    progress: Progress | None = None,
) -> Result:
    """Solve the contacts that a result keeps (poses, snapshots) with the contact model of that name.

    scenario: of the result, for profiles and friction (`scenario.loading.load_text` of its ``scenario_text``); name:
    see `scenario.contact_choice`; moments: indices of those wanted, default all; wheelset: the one wanted where there
    are several; subsurface: what is computed below the surface. Channels of track and wheelset are those of the result;
    those of wheels, patches and strips are new. Raises InputError for a result that keeps no poses of its wheels, and
    when one of several wheelsets has to be named.
    """
    if keep not in ("load", "pose"):
        raise InputError(f"--same {keep}: must be load or pose")
    chosen = with_contact_model(scenario, name)
    # no study runs with the exact solver, but its wheels can be looked at
    built = build(scenario)
    setup = replace(built, contact=replace(chosen.spec.contact.settings(), friction=built.contact.friction))
    kept = _kept_moments(result.wheelset(wheelset), setup, moments)
    new = _solve_moments(kept, setup, keep == "load", subsurface, Report(progress))
    stop = ("stop_reason", "stop_cause", "stop_time_s", "stop_distance_m")
    about = ("title", "analysis", "status", "inputs", "vehicle", ATTRIBUTE, "step_s", *stop)
    attributes = {key: kept.dataset.attrs[key] for key in about if key in kept.dataset.attrs}
    attributes |= {"scenario_text": chosen.text, "resolved_with": name, "resolved_at_same": keep}
    if subsurface is not None:
        attributes |= subsurface.attributes
    return Result(assemble(kept.coords(), kept.unchanged() | new, attributes))


@dataclass(frozen=True)
class _KeptMoments:
    """Moments of one wheelset of a result whose contacts are solved again."""

    dataset: xr.Dataset
    wheels: Sequence[WheelOnRail]
    moments: Sequence[int]
    samples: NDArray[np.intp]
    """Of the run or the poses, one for each moment."""
    poses: NDArray[np.float64]
    """Poses and motions (moment, wheel, 12) of the wheels."""
    places: NDArray[np.float64]
    """Distances (moment, wheel) along the rails [m]: they determine profile, friction and how the rail turns."""

    @property
    def sample_dim(self) -> str:
        return "time" if "time" in self.dataset.dims else "pose"

    def coords(self) -> dict[str, Any]:
        coords = {n: self._part[n].values for n in (self.sample_dim, "wheel")}
        return coords | {"wheelset": str(self.dataset["wheelset"].item())}

    def unchanged(self) -> dict[str, NDArray[Any]]:
        """Channels of track and wheelset."""
        dims = ((self.sample_dim,), ("snapshot",))
        return {
            n: self._part[n].values
            for n, channel in CHANNELS.items()
            if n in self._part.variables and self._part[n].dims in dims and (n == "distance" or not channel.coordinate)
        }

    @cached_property
    def _part(self) -> xr.Dataset:
        part = self.dataset.isel({self.sample_dim: self.samples})
        return part.isel(snapshot=list(self.moments), missing_dims="ignore")


def _kept_moments(dataset: xr.Dataset, setup: Setup, moments: Sequence[int] | None) -> _KeptMoments:
    """The moments of one wheelset with its wheels on the rails. Raises InputError where no poses are kept."""
    if not all(channel in dataset for channel in POSE_CHANNELS):
        raise InputError("the result keeps no moments whose contacts could be solved again; run its scenario anew")
    names, label = [m.name for m in setup.vehicle.wheelsets], str(dataset["wheelset"].item())
    mounted = setup.vehicle.wheelsets[names.index(label) if label in names else 0].wheelset
    pair = {wheel.name: wheel for wheel in wheels_on_rails(setup, mounted)}
    wheels = [pair[str(side)] for side in dataset["wheel"].values]
    poses = np.concatenate([dataset[channel].values for channel in POSE_CHANNELS], axis=-1)
    chosen = list(range(len(poses))) if moments is None else list(moments)
    samples = np.array([sample_of(dataset, m) for m in chosen], dtype=np.intp)
    places = np.zeros((len(chosen), len(wheels)))
    if "distance" in dataset:
        along = dataset["distance"].values[samples]
        on_rails = [setup.track.rail_distance("left" if w.side > 0 else "right", along) for w in wheels]
        places = np.stack(on_rails, axis=-1)
    return _KeptMoments(dataset, wheels, chosen, samples, poses[chosen], places)


def _solve_moments(
    kept: _KeptMoments, setup: Setup, same_load: bool, subsurface: Subsurface | None, report: Report
) -> dict[str, NDArray[Any]]:
    """Channels of contacts, strips, stresses and remarks; same_load: wheels keep their vertical forces, not their
    heights."""
    count, loads = len(kept.moments), kept.dataset["Q"].values[kept.samples]
    raw = channels.RawContacts.empty(count, len(kept.wheels), setup.contact.patch_count)
    strips, remarks = channels.StripRecorder(kept.wheels), []
    below: list[list[list[Values]]] = []
    for row in range(count):
        elements, remark = [], []
        below.append([[] for _ in kept.wheels])
        for j, wheel in enumerate(kept.wheels):
            fields: list[ElementField] = []
            if np.isfinite(pose := kept.poses[row, j]).all():
                _place(wheel, setup, pose, float(kept.places[row, j]))
                fields, message = _settle(wheel, float(loads[row, j]) if same_load else 0.0)
                raw.store(row, j, wheel.model.arrays)
                if subsurface is not None:
                    patches = surface_loads(wheel.model, subsurface.body, fields or None)
                    below[-1][j] = [sections(patch, subsurface.limits) for patch in patches]
                message = "; ".join(filter(None, (message, status_words(wheel.model.arrays.status))))
                remark += [f"the {wheel.name} wheel: {message}"] if message else []
            elements.append(fields)
        strips.store(elements)
        if not np.isfinite(kept.poses[row]).all():
            raw.clear(row)
            strips.clear_last()
        remarks.append("; ".join(remark))
        report((row + 1) / count)
    contacts = channels.contact_channels(raw, kept.wheels, *_moved_rails(kept, setup.track.nominal_gauge))
    stresses = subsurface_channels(below, len(kept.wheels), setup.contact.patch_count)
    return channels.remarks_channel(remarks) | contacts | strips.channels() | stresses


def _place(wheel: WheelOnRail, setup: Setup, pose: NDArray[np.float64], place: float) -> None:
    """Put a wheel in its pose at a place of its rail [m], which is turned there as the track has it."""
    rail = setup.track.left if wheel.side > 0 else setup.track.right
    place += wheel.half_spacing * pose[3]  # the end of a yawed axle is ahead
    twist, left, up = rail.turning(place)
    wheel.model.arrays.set_call(place, (wheel.side * twist, wheel.side * left, up))
    wheel.model.arrays.pose[:] = pose


def _moved_rails(kept: _KeptMoments, gauge: float) -> tuple[Any, Any]:
    """Widening of the gauge beyond the nominal one, and how far rails were pressed (moment, rail, 2) [m]."""
    dataset, samples = kept.dataset, kept.samples
    widening = dataset["gauge"].values[samples] - gauge if "gauge" in dataset else 0.0
    if "rail_lateral" not in dataset:
        return widening, 0.0
    rails = np.stack([dataset[f"rail_{axis}"].values[samples] for axis in ("lateral", "vertical")], axis=-1)
    return widening - (rails[:, 0, 0] - rails[:, 1, 0]), rails


def _settle(wheel: WheelOnRail, load: float) -> tuple[list[ElementField], str]:
    """Contact of one wheel at the height for a vertical force, or at its own height without one.

    Returns its elements, if any, and why the force is not met, if so.
    """
    model = wheel.model
    pose = model.arrays.pose
    if model.settings.normal != "half-space":
        if load > 0.0:
            lower(model, load, DEEPEST)  # the status has the reason where the load is not met
        else:
            model.solve()
        return [], ""
    elements: list[list[ElementField]] = [[]]

    def carried(height: float) -> Carried:
        pose[2] = height
        elements[0] = element_fields(solve_into(model), len(model.arrays.patches))
        return Carried(float(model.arrays.total["Fb"]), approach_of(model.arrays.patches, model.arrays.total))

    if load > 0.0:
        try:
            height_for_load(carried, model, load, float(pose[2]), tolerance=TOLERANCE, farthest=DEEPEST)
        except LoadNotReached as problem:
            return elements[0], str(problem)
    else:
        carried(float(pose[2]))
    return elements[0], ""


NEEDED = ("wheelset_distance", "lateral_shift", "vertical_shift", "yaw", "roll", "spin_rate")


def with_moments(dataset: xr.Dataset, setup: Setup[RunPlan], samples: Sequence[int]) -> xr.Dataset:
    """The dataset of a run with snapshots at these samples, all of them solved again.

    Its attribute ``contact_remark``: remarks on the contacts, and at how many of the samples; empty without any.
    Raises InputError for a result that lacks poses, of another vehicle, or of the exact solver, which takes too long.
    """
    names = [mounted.name for mounted in setup.vehicle.wheelsets]
    missing = [name for name in NEEDED if name not in dataset.variables]
    if missing or "time" not in dataset.dims or list(wheelsets(dataset)) != names:
        raise InputError("the result does not hold the poses of the wheelsets of its scenario")
    if setup.contact.normal == "half-space":
        raise InputError("contacts of the exact solver are drawn at snapshots only: anywhere else takes minutes")
    law = force_law(replace(setup, contact=replace(setup.contact, tangential="none")))
    recorders, wheels = [StripRecorder(pair) for pair in law.wheels], wheels_of(law)
    q, q_t = design_state(law)  # bodies stay there: contacts depend on the wheelsets alone
    out = np.zeros(law.size)
    columns = {name: dataset[name].transpose("time", "wheelset", ...).values for name in NEEDED}
    time, distance, speed = (dataset[name].values for name in ("time", "distance", "speed"))
    retained = []
    remark_counts: Counter[str] = Counter()
    for i in samples:
        for w, mounted in enumerate(setup.vehicle.wheelsets):
            pose = {name: float(values[i, w]) for name, values in columns.items()}
            q[6 * w : 6 * w + 6], q_t[6 * w : 6 * w + 6] = state_on_track(
                law.track.centre, pose["wheelset_distance"], speed=float(speed[i]),
                height=pose["vertical_shift"] + mounted.wheelset.mean_radius, spin_rate=pose["spin_rate"],
                lateral=pose["lateral_shift"], yaw=pose["yaw"], roll=pose["roll"],
            )  # fmt: skip
        for w, twist in law.twists.items():
            q_t[twist] = float(dataset["spin_difference"].values[i, w])
        if law.rails and all(name in dataset for name in RAIL_CHANNELS):
            moved = np.stack([dataset[name].values[i] for name in RAIL_CHANNELS], axis=-1)
            q[law.size - law.rails : law.size] = moved.ravel()
        try:
            law.set_search_start(law.places(columns["wheelset_distance"][i : i + 1])[0])
            law(float(time[i]), q, q_t, out)
        except SimulationError:  # a derailed wheelset may have no place on the track
            continue
        for recorder in recorders:
            recorder.store()
        for wheel in wheels:
            remark_counts.update(filter(None, [contact_words([wheel])]))
        retained.append(i)
    if not retained:
        raise InputError("no sample of the result has a place on the track of its scenario")
    snapshots = stack_wheelsets([recorder.channels() for recorder in recorders])
    coords = {"snapshot_time": time[retained], "snapshot_distance": distance[retained]}
    variables = {
        name: (CHANNELS[name].dims_in("time"), values, {"units": CHANNELS[name].unit})
        for name, values in (snapshots | coords).items()
    }
    dims = {"snapshot", "strip", "column", "axis", "rail_point", "wheel_point"}
    remarks = [f"{remark} (at {count} of {len(retained)} places)" for remark, count in remark_counts.items()]
    return dataset.drop_dims(dims & set(dataset.dims)).assign(variables).assign_attrs(contact_remark="; ".join(remarks))
