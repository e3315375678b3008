"""Many poses of one wheel on one rail in one compiled call, and the search for the height that carries a load."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.contact import records as k
from wrsim.contact.arrays import Arrays
from wrsim.contact.patches import RawContacts, patch_channels
from wrsim.contact.prescribed_load import SEARCH, side_by_side, some_poses
from wrsim.contact.wheel_rail import compile_stages
from wrsim.contact.workspace import pack
from wrsim.errors import InputError
from wrsim.jit import Array, Records, stages
from wrsim.jit.compiling import cores, use_threads

LOAD_TOLERANCE = 1e-8  # of the vertical force: ten times what cold contacts of the strip model are solved to
DEEPEST = 5e-3  # approach at which the search for the load is given up [m]
LEAST_SCALE = 1e-9  # first approach, even for the smallest loads [m]


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts at n poses, copied out of the kernel; not-a-number where there is no patch.

    poses: (n, 12) as in `ContactModel.evaluate`, with the heights found; force, moment: (n, 3) on the wheel in rail
    axes, the moment about the wheel's profile origin [N, N m]; wear_number: (n,) [N]; closest: (n,) smallest distance
    between the profiles, negative in contact [m]; status: (n,) sums of bits (`wrsim.contact.status`), 0 where all is
    well.
    Of the patches, largest normal force first, (n, patches): N, Fx, Fy [N], p0 [Pa], area [m2], approach, length, width
    [m], contact_angle [rad]. raw: the kernel's records of lobes (n, lobes) and totals (n,).
    """

    poses: Array
    force: Array
    moment: Array
    wear_number: Array
    closest: Array
    status: NDArray[np.int64]
    N: Array
    Fx: Array
    Fy: Array
    p0: Array
    area: Array
    approach: Array
    length: Array
    width: Array
    contact_angle: Array
    raw: RawContacts


def search_for(
    load: ArrayLike, start: ArrayLike, radius: float, modulus: float, tolerance: float = LOAD_TOLERANCE,
    farthest: float = DEEPEST,
) -> Records:  # fmt: skip
    """Searches for loads (n,) [N] from heights (n,) [m] on, as records SEARCH.

    radius [m], modulus [Pa]: of the sphere whose approach is the first one; tolerance: of the load; farthest: from the
    first height with contact [m].
    """
    load, start = np.broadcast_arrays(np.asarray(load, dtype=float), np.asarray(start, dtype=float))
    searches = np.zeros(load.shape, SEARCH)
    searches["load"], searches["start"], searches["tolerance"], searches["farthest"] = load, start, tolerance, farthest
    searches["scale"] = np.maximum(np.cbrt(9.0 * load**2 / (16.0 * modulus**2 * radius)), LEAST_SCALE)
    return searches


def evaluate_poses(
    inputs: Arrays, poses: ArrayLike, load: ArrayLike | None, place: float, threads: int | None,
    wheel_angle: ArrayLike = 0.0,
) -> Contacts:  # fmt: skip
    """See `ContactModel.evaluate_many` and `ContactModel.solve_many`; without a load the heights are as they are."""
    rows = np.array(poses, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != k.POSE or not rows.size:
        raise InputError(f"poses: must be of shape (n, {k.POSE}) with n above 0, not {rows.shape}")
    if not np.isfinite(rows).all():
        raise InputError(f"poses: row {int(np.argmin(np.isfinite(rows).all(axis=1)))} has numbers that are not finite")
    n = len(rows)
    if load is None:
        wanted = np.zeros(n)
    else:
        try:
            wanted = np.broadcast_to(np.asarray(load, dtype=float), (n,))
        except ValueError:
            raise InputError(f"load: must be one number or {n} of them, one a pose, not {np.shape(load)}") from None
        bad = ~(np.isfinite(wanted) & (wanted > 0.0))
        if bad.any():
            i = int(np.argmax(bad))
            raise InputError(f"load = {wanted[i]:g} of pose {i}: must be a vertical force above 0 N")
    count = cores() if threads is None else threads
    use_threads(count)
    count = min(count, n)
    mine = [np.arange(t, n, count) for t in range(count)]
    share = len(mine[0])
    number = inputs.model[0]
    compile_stages(k.CONTACT)
    stages.make_ready(k.POSES, some_poses)
    lobes = len(inputs.patches)
    searches = search_for(-1.0, np.zeros(share), number.radius, number.E)
    parts = np.zeros((share, k.POSE)), searches, np.zeros(share, k.TOTAL), np.zeros((share, lobes), k.LOBE)
    packed = pack([*parts, *inputs])
    buffers = np.tile(packed.buffer, (count, 1))
    index = packed.index

    def view(i: int, like: NDArray[np.generic]) -> Records:
        begin = int(index[i, 0])
        return buffers[:, begin : begin + like.nbytes // 8].view(like.dtype).reshape(count, *like.shape)

    placed, asked, totals, lobes_of = (view(i, part) for i, part in enumerate(parts))
    view(len(parts) + inputs._fields.index("call"), inputs.call)["place"] = place
    asked_of_all = search_for(wanted, rows[:, 2], number.radius, number.E)
    try:
        asked_of_all["angle"] = np.asarray(wheel_angle, dtype=float)
    except ValueError:
        raise InputError(f"wheel_angle: must be one angle or {n}, one a pose, not {np.shape(wheel_angle)}") from None
    for t, part in enumerate(mine):
        placed[t, : len(part)], asked[t, : len(part)] = rows[part], asked_of_all[part]
    if count == 1:
        some_poses(buffers[0], index)
    else:
        side_by_side(buffers, index)
    raw = RawContacts(np.zeros((n, 1, lobes), k.LOBE), np.zeros((n, 1), k.TOTAL))
    for t, part in enumerate(mine):
        size = len(part)
        rows[part], raw.patches[part, 0], raw.totals[part, 0] = placed[t, :size], lobes_of[t, :size], totals[t, :size]
    total = raw.totals[:, 0]
    of = {name: values[:, 0] for name, values in patch_channels(raw).items()}
    force, moment = (np.stack([total[m + axis] for axis in "tob"], axis=-1) for m in "FM")
    return Contacts(
        rows, force, moment, total["wear"].copy(), total["closest"].copy(), total["status"].copy(),
        of["N"], of["Fx"], of["Fy"], of["p0"], of["area"], of["approach"], of["length"], of["width"],
        of["contact_angle"], raw,
    )  # fmt: skip
