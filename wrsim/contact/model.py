"""The contact model of one wheel on one rail: names the choices, runs the kernel, labels the results.

`wrsim.contact.models` builds them and lists the normal models.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from wrsim.contact import records as k
from wrsim.contact import tables
from wrsim.contact.arrays import SCRATCH, Arrays
from wrsim.contact.batch import Contacts, evaluate_poses
from wrsim.contact.creep.laws import CREEP_LAWS, KERNEL_LAWS
from wrsim.contact.library_file import library_bytes, save_library
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import ContactSettings, Friction, FrictionAlong, Layer
from wrsim.contact.strips.equations import block_of
from wrsim.contact.strips.records import GRID, MEMO, PLACE, ROW, ROWS, VECTORS
from wrsim.contact.surfaces.out_of_round import Part, shape_tables
from wrsim.contact.surfaces.rolled_rail import RolledRail
from wrsim.contact.wheel_rail import compile_stages
from wrsim.contact.workspace import WARM_TOLERANCE, KernelArrays, Workspace, pack
from wrsim.errors import InputError
from wrsim.jit import Array, Records

SEARCH_REACH = 0.75e-3  # distance of the search's samples near the rail [m]
EPSILON = 0.55  # [S 23]
MOST_STRIPS = 2000
SHOULDERS = 2  # grids of the strip model beyond one for each lobe
FRICTION = ("mu", "mu_gauge", "zone_start", "zone_end", "fall_ratio", "fall_decay")
LEAST_SPEED = 0.05  # rolling speed below which creepages are regularised [m/s]


@dataclass(frozen=True)
class NormalModel:
    """What sets one normal model apart.

    kernel: its number in contact.records; recess: of a lobe's depth, where its strips begin; joint: whether
    the lobes of a patch share recess and strips; fewest, most: bounds of their number on one lobe;
    solves_for_strips: whether every strip is solved for: few, with a projected approach, from the contact of the
    last call in a run; solve: another way to find the contact at the pose set in a model's arrays, writes it there and
    returns the status.
    """

    kernel: int
    recess: float
    joint: bool
    fewest: int
    most: int
    solves_for_strips: bool = False
    solve: Callable[["ContactModel"], int] | None = None

    def rows(self, strips: int | None) -> int:
        """Rows to keep for the strips of one lobe, of which the user wants so many (None: as many as it takes)."""
        return self.most if strips is None or self.solve is not None else min(max(strips, self.fewest), self.most)


@dataclass(frozen=True)
class ContactModel:
    """One wheel profile on one (inclined) rail profile with the chosen settings, ready for the kernel.

    wheel, rail: profiles, the rail already inclined; radius: of the wheel at the tape circle [m]; friction: of this
    rail, everywhere or along it; rolled: the effective profile of a rail that changes along the track, in whose place
    ``rail`` is drawn; out_of_round: what the wheel's radius deviates by; roller: radius of a roller of that profile, in
    place of a rail [m]. The arrays are what the kernel takes; scratch
    arrays belong to the model, so one model serves one thread."""

    wheel: Profile
    rail: Profile
    radius: float
    settings: ContactSettings
    friction: Friction | FrictionAlong
    normal: NormalModel
    rolled: RolledRail | None = None
    out_of_round: tuple[Part, ...] = ()
    roller: float | None = None
    workspace: Workspace | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        models = f"{self.settings.normal} and {self.settings.creep_forces}"
        return f"ContactModel({self.wheel.name} on {self.rail.name}, radius {1e3 * self.radius:g} mm, {models})"

    @cached_property
    def inputs(self) -> Arrays:
        """What the kernel's workspace is packed from. From now on its stages can be run."""
        compile_stages(k.CONTACT, self.normal.kernel)
        if self.settings.creep_forces in KERNEL_LAWS:
            compile_stages(k.CREEP_FORCES)
        return _inputs(self)

    @cached_property
    def arrays(self) -> KernelArrays:
        """The kernel's arrays, in a workspace of their own unless one was given."""
        return KernelArrays(self.workspace or pack(self.inputs), self.normal.solves_for_strips)

    def within(self, workspace: Workspace) -> "ContactModel":
        """The same computing in a part of a larger workspace that was packed from ``inputs``."""
        return replace(self, workspace=workspace)

    def evaluate(
        self,
        origin: ArrayLike,
        axle: ArrayLike = (0.0, 1.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        omega: ArrayLike = (0.0, 0.0, 0.0),
        place: float = 0.0,
        turning: tuple[float, float, float] = (0.0, 0.0, 0.0),
        wheel_angle: float = 0.0,
    ) -> "Contact":
        """Contact for one pose.

        Vectors (3,) in the axes of the rail on this side: along the track, outward, up (docs/reference/conventions.md).

        Parameters
        ----------
        origin : array_like
            Origin of the wheel's profile on the axle [m].
        axle : array_like
            Direction of the axle, outward, of length 1.
        velocity : array_like
            Of that origin [m/s].
        omega : array_like
            Angular velocity of the wheel [rad/s].
        place : float
            Distance along a rail that changes along the track [m].
        turning : tuple
            How the rail's section turns along the track, positive where its outer side rises [rad/m], and how the rail
            bends outward and up [1/m].
        wheel_angle : float
            By which a wheel out of round has rolled [rad].

        Returns
        -------
        Contact

        Raises
        ------
        InputError
            For vectors of another shape.
        """
        self.arrays.set_call(place, turning, wheel_angle)
        vectors = [np.asarray(x, dtype=float) for x in (origin, axle, velocity, omega)]
        if any(x.shape != (3,) for x in vectors):
            raise InputError(f"origin, axle, velocity, omega: must be of shape (3,), not {[x.shape for x in vectors]}")
        self.arrays.pose[:] = np.concatenate(vectors)
        return Contact.copy_from(self.arrays, self.solve())

    def evaluate_many(
        self, poses: ArrayLike, *, place: float = 0.0, threads: int | None = None, wheel_angle: ArrayLike = 0.0
    ) -> Contacts:
        """Contacts at many poses, each to the bit as from `evaluate`, whatever their order and the threads.

        Parameters
        ----------
        poses : array_like
            (n, 12), a row for every pose: origin, axle, velocity and omega as in `evaluate` [m, 1, m/s, rad/s].
        place : float
            Distance along a rail that changes along the track [m].
        threads : int, optional
            That compute poses side by side; default all cores of the machine.
        wheel_angle : array_like
            By which a wheel out of round has rolled, one for all or (n,) [rad].

        Returns
        -------
        Contacts
            Arrays (n,), (n, 3) and, of the patches, (n, patches).

        Raises
        ------
        InputError
            For another shape, numbers that are not finite, more threads than cores, the exact half-space solver.
        """
        return evaluate_poses(self._batch_inputs, poses, None, place, threads, wheel_angle)

    def solve_many(
        self, poses: ArrayLike, load: ArrayLike, *, place: float = 0.0, threads: int | None = None,
        wheel_angle: ArrayLike = 0.0,
    ) -> Contacts:  # fmt: skip
        """Contacts of many poses, each at the height at which its vertical force is the load to 1e-8 of it.

        The search begins at the height of the pose, in contact or above its rail. Neither the order of poses nor the
        threads change a bit. ``evaluate_many(contacts.poses)`` gives the same contacts within that tolerance.

        Parameters
        ----------
        poses : array_like
            (n, 12) as in `evaluate_many`.
        load : array_like
            Vertical force of the rail on the wheel, of all or (n,) [N].
        place, threads, wheel_angle
            As in `evaluate_many`.

        Returns
        -------
        Contacts
            ``poses`` with the heights found. Where a load is not met (no contact at any height; not within 5 mm of
            approach; a force that jumps over it), ``status`` has a bit for it (`wrsim.contact.status`), and height and
            contact are the last ones of the search.

        Raises
        ------
        InputError
            As `evaluate_many`, and for loads of another shape or not above 0.
        """
        return evaluate_poses(self._batch_inputs, poses, load, place, threads, wheel_angle)

    def save_for_library(self, path: str | Path, *, tractions: bool = False) -> None:
        """Write the file that the C library opens (docs/user/library.md).

        Parameters
        ----------
        path : str or Path
            A file there is replaced.
        tractions : bool
            Whether contacts from this file give tractions in the cells of strips (FASTSIM and FaStrip).

        Raises
        ------
        InputError
            For the exact half-space solver.
        WrsimError
            Where the file cannot be written.
        """
        save_library(self.library_file(tractions), path)

    def library_file(self, tractions: bool = False) -> bytes:
        """The bytes of that file."""
        self._check_compiled()
        return library_bytes(_inputs(self, 1 if tractions else 0), repr(self))

    def _check_compiled(self) -> None:
        if self.normal.solve is not None:
            raise InputError(f'normal = "{self.settings.normal}": is not compiled; solve_poses solves its poses')

    def with_tractions(self) -> "ContactModel":
        """The same with tractions in the cells of its strips, solved at the pose set in its arrays."""
        compile_stages(k.CONTACT, self.normal.kernel)
        solved = self.within(pack(_inputs(self, 3)))
        solved.arrays.rows.call[:], solved.arrays.pose[:] = self.arrays.rows.call, self.arrays.pose
        solved.solve()
        return solved

    def tractions_in_cells(self, lobe: int) -> Array | None:
        """Tractions on the wheel along x and across in the cells of strips, (2, strips, cells) by rising x [Pa]; None
        where they are not stored."""
        a, cells = self.arrays, self.settings.cells
        first = SCRATCH + (len(a.patches) + 2 * lobe) * cells
        if len(a.rows.work) < first + 2 * cells:
            return None
        count = a.patches[lobe].n_strips
        values = a.rows.work[first : first + 2 * cells, :count].reshape(2, cells, count).swapaxes(1, 2)
        return np.ascontiguousarray(values[..., :: -1 if a.pose[6] >= 0.0 else 1])

    @property
    def _batch_inputs(self) -> Arrays:
        self._check_compiled()
        return self.inputs

    @property
    def friction_here(self) -> Friction:
        """The law of friction at the place set in the arrays."""
        law = self.friction
        return law if isinstance(law, Friction) else law.at(self.arrays.inputs.place + self.arrays.pose[0])

    def solve(self) -> int:
        """Contact at the pose set in the arrays, written into them; returns the status."""
        return self.arrays.evaluate() if self.normal.solve is None else self.normal.solve(self)


@dataclass(frozen=True)
class Contact:
    """What one evaluation gave, copied out of the kernel.

    force, moment: on the wheel, (3,) in rail axes, the moment about the wheel's profile origin [N, N m];
    patches: (n,) LOBE records along the profile; strips: one (n_strips,) array of STRIP records per lobe;
    wear_number: T-gamma [N]; closest: smallest distance between the profiles met, negative in contact [m].
    """

    force: Array
    moment: Array
    patches: Records
    strips: tuple[Records, ...]
    wear_number: float
    closest: float
    status: int

    def __repr__(self) -> str:
        count = len(self.patches)
        patches = f"{count} patch{'es' * (count != 1)}" if count else f"none, {1e3 * self.closest:.4g} mm apart"
        return f"Contact({patches}, normal force {self.normal_force / 1e3:.4g} kN)"

    @classmethod
    def copy_from(cls, a: KernelArrays, status: int) -> "Contact":
        """Copy the present results out of the kernel's arrays."""
        t = a.total
        strips = tuple(a.strips[i, : a.patches[i].n_strips].copy() for i in range(t.lobes))
        return cls(a.force, a.moment, a.patches[: t.lobes].copy(), strips, float(t.wear), float(t.closest), status)

    @property
    def normal_force(self) -> float:
        """Sum of the strips' normal forces over all patches [N]."""
        return float(self.patches["N"].sum())


def _inputs(model: ContactModel, of_cells: int = 0) -> Arrays:
    """of_cells: numbers of every cell that are stored: 0, 1 (see ``save_for_library``) or 3, with its tractions."""
    settings, friction, normal = model.settings, model.friction, model.normal
    along = np.zeros((0, 0)) if isinstance(friction, Friction) else friction.table
    wheel_table, wheel_step = tables.profile_table(model.wheel)
    rail = tables.plain_rail(model.rail) if model.rolled is None else tables.changing_rail(model.rolled)
    field_ = rail.field
    law = CREEP_LAWS[settings.creep_forces]
    parabolic = law.bound and settings.traction_bound == "parabolic"
    # Kalker's combined elastic constants: means of the compliances
    shear_compliance = 0.5 * sum(1.0 / m.shear_modulus for m in (settings.wheel, settings.rail))
    poisson = 0.5 * sum(m.poisson_ratio / m.shear_modulus for m in (settings.wheel, settings.rail)) / shear_compliance
    # yaw makes the outline a little more hollow than the profile, distance the rail's curves of equal distance
    hollows = max(float(-wheel_table[:, 4].min()), 0.0) + rail.hollow
    numbers, call, state = np.zeros(1, k.MODEL), np.zeros(1, k.CALL), np.zeros(1, k.STATE)
    n: Any = numbers[0]
    n.E, n.G = tables.combined_modulus(settings), 1.0 / shear_compliance
    n.eps, n.damping, n.least_speed = EPSILON, settings.damping, LEAST_SPEED
    n.normal, n.recess, n.joint, n.fewest = normal.kernel, normal.recess, normal.joint, normal.fewest
    n.projected = settings.approach == "projected"
    n.strips = normal.rows(settings.strip_count) if normal.solves_for_strips else settings.strip_count or 0
    n.together, n.apart = settings.half_space.together, settings.half_space.apart
    state["tolerance"] = WARM_TOLERANCE
    n.curved = normal.solves_for_strips and settings.half_space.influence == "angle-corrected"
    n.strip_width = settings.strip_width or 0.0
    n.tangential = law.kernel
    n.parabolic, n.blended = parabolic, settings.flexibility == "blended"
    n.kA, n.kS = settings.polach_adhesion, settings.polach_slip
    n.slope_k0, n.slope_alpha_inf, n.slope_beta = settings.slope_k0, settings.slope_alpha_inf, settings.slope_beta
    layer, heat = settings.layer or Layer(), settings.temperature
    n.layer, n.yield_stress, n.hardening = layer.flexibility, layer.yield_stress, layer.hardening
    n.history = heat is not None or layer.yield_stress < np.inf
    if heat:
        n.warming, n.bulk, n.heat_from = heat.warming, heat.bulk, heat.friction_from
        n.heat_slope, n.heat_change = heat.friction_change / heat.friction_over, heat.friction_change
    first = friction if isinstance(friction, Friction) else friction.laws[0]
    for name, number in zip(FRICTION, first.numbers, strict=True):
        call[name] = number
    n.wheel_step, n.radius, n.rail_step = wheel_step, model.radius, rail.step
    n.rows, n.field_rows, n.slack = rail.rows, rail.field_rows, rail.slack
    (n.field_o, n.field_b), n.field_spacing = field_.origin, field_.spacing
    n.roller = 0.0 if model.roller is None else 1.0 / model.roller
    n.stride = max(1, round(SEARCH_REACH / wheel_step))
    depth = branches = np.zeros((0, 0))
    if model.out_of_round:
        shape = shape_tables(model.out_of_round, model.wheel, model.radius)
        depth, branches = shape.depth, shape.branches.copy()
        n.depth_rows, n.depth_first, n.depth_step, n.depth_least = shape.rows, shape.first, shape.step, shape.least
        hollows += shape.hollow
    n.hollow = max(1.5 * hollows, 1.0)
    lobes, most = settings.patch_count, normal.rows(settings.strip_count)
    grids = lobes + SHOULDERS if normal.solves_for_strips else 0
    of_a_lobe = most * max(grids, 1)
    unknowns = grids * block_of(most)
    columns = max(of_a_lobe, 8, settings.cells if n.history else 0)
    memo = np.zeros(1, MEMO)
    memo["budget"] = np.inf
    return Arrays(
        wheel=wheel_table,
        rail=rail.table,
        rates=rail.rates,
        stations=rail.stations,
        field=field_.values,
        creep=tables.creep_coefficients(poisson),
        shape=tables.bound_over_cells(settings.cells, parabolic),
        model=numbers,
        call=call,
        pose=np.zeros(k.POSE),
        state=state,
        contacts=np.zeros(8, k.MAIN_POINT),
        patches=np.zeros(lobes, k.LOBE),
        strips=np.zeros((lobes, of_a_lobe), k.STRIP),
        work=np.zeros((SCRATCH + of_cells * lobes * settings.cells * law.cells, columns)),
        influence=tables.influence_table() if grids else np.zeros((0, 0)),
        rows=np.zeros((grids, ROWS), ROW),
        places=np.zeros(grids * most, PLACE),
        grids=np.zeros(grids, GRID),
        vectors=np.zeros((VECTORS, max(unknowns, ROWS * bool(grids)))),
        matrix=np.zeros((unknowns, unknowns)),
        memo=memo,
        friction=along,
        depth=depth,
        branches=branches,
        total=np.zeros(1, k.TOTAL),
    )
