"""Rails on discrete sleepers: what they are made of, and their matrices.

Each rail is a beam with bending and shear in the vertical and in the lateral direction, and torsion about its shear
centre. At every sleeper it rests on a pad; the sleeper rests on ballast. Up and down each end of a sleeper moves with
half of its mass: this is exact for a stiff sleeper whose length is sqrt(3) times the distance of its rail seats, 2.6 m
for 1.5 m. Sideways a sleeper is one mass under both rails, so they are taken apart into the sum and the difference of
their motions: u_sum = (u_left + u_right)/sqrt(2), u_difference = (u_left - u_right)/sqrt(2). The sum moves half a
sleeper, the difference none. The pad holds the foot of the rail sideways, and against roll by its width.

Four systems of one form, then: left and right rail vertically, sum and difference laterally. The unknowns of a system
go sleeper by sleeper, so its matrices are bands: at a sleeper those of the rail, then the displacement of the sleeper;
at the nodes up to the next sleeper those of the rail; at the end of the last bay those of the rail. Those of a rail are
deflection and turn, laterally also the twist.
"""

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from wrsim.errors import InputError
from wrsim.track.beams import STIFF, bending_mass, bending_stiffness, torsion_mass, torsion_stiffness
from wrsim.track.bridge import Bridge
from wrsim.track.piecewise import Array

Direction = Literal["vertical", "lateral"]
SIDES = ("left", "right")

BLOCK = 4096
"""Random shifts of so many sleepers are drawn at once."""

ENDS = 0.01
"""Part of a wave that comes back from the end of a window."""


@dataclass(frozen=True)
class RailBeam:
    """A rail as a beam. Defaults: 60E1.

    young, shear_modulus [Pa]; mass [kg/m]; area [m2]; vertical, lateral: second moments of area for bending in these
    directions [m4]; torsion: torsion constant [m4]; shear_vertical, shear_lateral: shear coefficients, None without
    shear and rotary inertia; height of the rail and of its shear centre above the foot [m]; loss_factor: of the
    stiffness, in the frequency domain.
    """

    young: float = 210e9
    shear_modulus: float = 80.769e9
    mass: float = 60.2
    area: float = 76.7e-4
    vertical: float = 3.037e-5
    lateral: float = 5.12e-6
    torsion: float = 2.2e-6
    shear_vertical: float | None = 0.393
    shear_lateral: float | None = 0.54
    height: float = 0.172
    shear_centre: float = 0.04
    loss_factor: float = 0.02

    def bending(self, direction: Direction) -> float:
        """Bending stiffness [N m2]."""
        return self.young * (self.vertical if direction == "vertical" else self.lateral)

    def shear(self, direction: Direction) -> float:
        """Shear stiffness [N]."""
        coefficient = self.shear_vertical if direction == "vertical" else self.shear_lateral
        return STIFF * self.bending(direction) if coefficient is None else coefficient * self.shear_modulus * self.area

    def rotary(self, direction: Direction) -> float:
        """Moment of inertia of the section's mass about the axis of bending [kg m]."""
        area = self.vertical if direction == "vertical" else self.lateral
        coefficient = self.shear_vertical if direction == "vertical" else self.shear_lateral
        return 0.0 if coefficient is None else self.mass * area / self.area

    @property
    def polar(self) -> float:
        """Moment of inertia of the section's mass about its long axis [kg m]."""
        return self.mass * (self.vertical + self.lateral) / self.area


@dataclass(frozen=True)
class Layer:
    """A pad under one rail, or the ballast under half a sleeper; lateral, then vertical.

    stiffness [N/m], damping [N s/m]; loss_factor: in the frequency domain, in place of nothing but beside the damping.
    """

    stiffness: tuple[float, float]
    damping: tuple[float, float] = (0.0, 0.0)
    loss_factor: float = 0.0


@dataclass(frozen=True)
class SupportRow:
    """Factors of the stiffness and damping of pads and ballast at a place along the track [m], of one rail or both."""

    s: float
    pad: float
    ballast: float
    side: Literal["left", "right", "both"] = "both"


@dataclass(frozen=True)
class RailJoint:
    """A joint of a rail at a place [m]: over the length [m] its bending stiffness is this part of the rail's."""

    s: float
    part: float
    length: float
    side: Literal["left", "right", "both"] = "both"


class Bays(NamedTuple):
    """A row of bays of one system.

    places (b + 1,): of the sleepers [m]; length, bending (b e,): of the elements [m, N m2]; pad, ballast (b,): factors.
    """

    places: Array
    length: Array
    bending: Array
    pad: Array
    ballast: Array

    @property
    def along(self) -> Array:
        """Places of the nodes, from the first sleeper on (b e + 1,) [m]."""
        return np.append(0.0, np.cumsum(self.length))


class Bands(NamedTuple):
    """Lower bands (n, k + 1) of the symmetric matrices of a system: number (i, j) stands at [i, k - i + j]. damping:
    of the viscous dampers; stiffness: of the rail, of the pads, of the ballast, each (n, k + 1)."""

    mass: Array
    damping: Array
    stiffness: tuple[Array, Array, Array]


class BayLayout(NamedTuple):
    """Places of the unknowns of a system: ``per_node`` of them (2 or 3), ``elements`` a bay, ``bays`` in a row."""

    per_node: int
    elements: int
    bays: int

    @property
    def bay(self) -> int:
        """Unknowns from one sleeper to the next."""
        return self.per_node * self.elements + 1

    @property
    def size(self) -> int:
        return self.bays * self.bay + self.per_node

    @property
    def width(self) -> int:
        """Diagonals beside the main one."""
        return 2 * self.per_node

    @property
    def nodes(self) -> NDArray[np.intp]:
        """Places of the unknowns of every node (bays elements + 1, per_node)."""
        bay, node = np.divmod(np.arange(self.bays * self.elements + 1), self.elements)
        first = bay * self.bay + np.where(node == 0, 0, 1 + node * self.per_node)
        return first[:, None] + np.arange(self.per_node)

    @property
    def sleepers(self) -> NDArray[np.intp]:
        """Places of the sleepers (bays,)."""
        return np.arange(self.bays) * self.bay + self.per_node

    def band(self, *terms: tuple[NDArray[np.intp], Array]) -> Array:
        """Sum of small symmetric matrices (m, i, i) that stand at places (m, i) as a lower band."""
        k = self.width
        diagonals = np.zeros(self.size * (k + 1))
        for places, matrices in terms:
            row, column = np.broadcast_arrays(places[:, :, None], places[:, None, :])
            low = row >= column
            positions = (row * (k + 1) + k - row + column)[low]
            diagonals += np.bincount(positions, matrices[low], len(diagonals))
        return diagonals.reshape(self.size, k + 1)


@dataclass(frozen=True, eq=False)
class SleeperTrack:
    """Rails on discrete sleepers; see the module.

    spacing of the sleepers [m], scatter: largest shift of one from its place [m], by a seed; width of a sleeper and of
    a pad along and across the rail [m]; sleeper_mass: of a whole one [kg], None: pads on rigid ground. offset: place of
    one of the sleepers [m]. supports: factors of pads and ballast along the track, linear in between; unsupported:
    places of sleepers without ballast, by side; joints. elements: of the beam in a bay. margin: length of rail beyond
    the first and the last wheel [m], ``end`` of it damped. bridge: what the ballast lies on.
    """

    rail: RailBeam
    pad: Layer
    ballast: Layer
    sleeper_mass: float | None
    spacing: float = 0.6
    offset: float = 0.0
    scatter: float = 0.0
    seed: int = 0
    sleeper_width: float = 0.26
    pad_width: float = 0.15
    supports: tuple[SupportRow, ...] = ()
    unsupported: tuple[tuple[float, Literal["left", "right", "both"]], ...] = ()
    joints: tuple[RailJoint, ...] = ()
    elements: int = 4
    margin: float = 10.0
    end: float = 4.0
    bridge: Bridge | None = None

    def __post_init__(self) -> None:
        if self.spacing - 2.0 * self.scatter < self.sleeper_width:
            least = f"at least sleeper width + 2 scatter = {1e3 * (self.sleeper_width + 2.0 * self.scatter):g} mm"
            raise InputError(f"sleepers overlap: spacing {1e3 * self.spacing:g} mm; allowed: {least}")
        if self.margin - self.end < self.wave:
            raise InputError(
                f"window of {self.margin:g} m beyond the wheels, {self.end:g} m of it damped, is shorter than the wave "
                f"of the rail on its supports; allowed: margin_m of at least {self.wave + self.end:.3g}"
            )

    @property
    def wave(self) -> float:
        """Length of the static wave of a rail on its supports [m]: 2 pi times its elastic length (4 B / k)^(1/4),
        laterally or vertically the longer one, with the stiffness k of pad and ballast per metre."""
        lengths = []
        ways: tuple[Direction, Direction] = ("lateral", "vertical")
        for i, direction in enumerate(ways):
            k = self.pad.stiffness[i]
            if self.sleeper_mass is not None:
                k = 1.0 / (1.0 / k + 1.0 / self.ballast.stiffness[i])
            lengths.append((4.0 * self.rail.bending(direction) * self.spacing / k) ** 0.25)
        return float(2.0 * np.pi * max(lengths))

    @property
    def uniform(self) -> bool:
        """Whether all bays are alike."""
        return not (self.scatter or self.supports or self.unsupported or self.joints)

    def places(self, first: int, count: int) -> Array:
        """Places of sleepers along the track [m], from the number ``first`` on: one and the same at any call."""
        numbers = np.arange(first, first + count)
        shift = self.scatter * _uniform(numbers, self.seed) if self.scatter else 0.0
        return np.asarray(self.offset + self.spacing * numbers + shift)

    def number_at(self, place: float) -> int:
        """Number of the last sleeper at or ahead of a place [m], but for its scatter."""
        return int(np.floor((place - self.offset) / self.spacing))

    def bays(self, first: int, count: int, system: int) -> Bays:
        """Bays from a sleeper on; system: 0 and 1 left and right vertically, 2 and 3 sum and difference laterally."""
        places = self.places(first, count + 1)
        direction: Direction = "vertical" if system < 2 else "lateral"
        length = np.repeat(np.diff(places) / self.elements, self.elements).reshape(count, -1)
        softer = np.zeros_like(length)
        sides = [SIDES[system]] if system < 2 else list(SIDES)
        pad = np.mean([self._factor(places[:-1], side, "pad") for side in sides], axis=0)
        ballast = np.mean([self._factor(places[:-1], side, "ballast") for side in sides], axis=0)
        for sleeper, rail in self.unsupported:
            hanging = round((sleeper - self.offset) / self.spacing) - first
            if 0 <= hanging < count:
                ballast[hanging] *= 1.0 - np.mean([rail in (side, "both") for side in sides])
        begin = (places[:-1, None] + length * np.arange(self.elements)).ravel()
        end = begin + length.ravel()
        for joint in self.joints:
            share = np.mean([joint.side in (side, "both") for side in sides])
            covered = np.minimum(end, joint.s + 0.5 * joint.length) - np.maximum(begin, joint.s - 0.5 * joint.length)
            softer += (share * np.maximum(covered, 0.0) / length.ravel()).reshape(length.shape) * (1.0 / joint.part - 1)
        bending = self.rail.bending(direction) / (1.0 + softer)
        return Bays(places, length.ravel(), bending.ravel(), pad, ballast)

    def _factor(self, places: Array, side: str, layer: str) -> Array:
        rows = sorted((r.s, getattr(r, layer)) for r in self.supports if r.side in (side, "both"))
        return np.interp(places, *np.array(rows).T) if rows else np.ones(len(places))

    def layout(self, count: int, system: int) -> BayLayout:
        return BayLayout(2 if system < 2 else 3, self.elements, count)

    def bands(self, first: int, count: int, system: int) -> Bands:
        """Matrices of a row of bays from a sleeper on, with free ends."""
        bays, layout, rail = self.bays(first, count, system), self.layout(count, system), self.rail
        direction: Direction = "vertical" if system < 2 else "lateral"
        way = 1 if system < 2 else 0
        ahead = np.hstack([layout.nodes[:-1], layout.nodes[1:]])
        bending = ahead[:, [0, 1, layout.per_node, layout.per_node + 1]]
        shear = rail.shear(direction)
        mass = [(bending, bending_mass(bays.length, bays.bending, shear, rail.mass, rail.rotary(direction)))]
        elastic = [(bending, bending_stiffness(bays.length, bays.bending, shear))]
        if system >= 2:
            twist = ahead[:, [2, 5]]
            mass.append((twist, torsion_mass(bays.length, rail.polar)))
            elastic.append((twist, torsion_stiffness(bays.length, rail.shear_modulus * rail.torsion)))
        sleeper = layout.sleepers[:, None]
        moves = self.sleeper_mass is not None and system != 3
        of_sleeper = 0.5 * (self.sleeper_mass or 0.0) if moves else 1.0
        mass.append((sleeper, np.full((count, 1, 1), of_sleeper)))

        def pads(stiffness: tuple[float, float]) -> tuple[NDArray[np.intp], Array]:
            spring = np.array([[1.0, 0.0, -1.0]] if system < 2 else [[1.0, 0.0, rail.shear_centre, -1.0]])
            if not moves:
                spring[0, -1] = 0.0
            pad = stiffness[way] * spring.T @ spring
            if system >= 2:
                pad[2, 2] += stiffness[1] * self.pad_width**2 / 12.0
            places = np.hstack([layout.nodes[: -1 : self.elements], sleeper])
            return places, bays.pad[:, None, None] * pad

        def grounds(stiffness: float) -> tuple[NDArray[np.intp], Array]:
            return sleeper, (stiffness * bays.ballast if moves else np.ones(count))[:, None, None]

        damping = layout.band(pads(self.pad.damping), grounds(self.ballast.damping[way] if moves else 0.0))
        stiffness = (
            layout.band(*elastic),
            layout.band(pads(self.pad.stiffness)),
            layout.band(grounds(self.ballast.stiffness[way])),
        )
        return Bands(layout.band(*mass), damping, stiffness)

    def end_zones(self, bays: Bays, mass: Array, system: int) -> Array:
        """Dampers to ground (n,) on the rail in the end zones of a window [N s/m, N m s].

        Their rate over the mass grows with the square of the part x/L of the zone up to r. A wave of group speed c that
        goes through the zone and back decays by the exponent 2 (r/2) L / (3 c); r makes it ``ENDS`` for the fastest
        waves in bending, those of the speed sqrt(S/m) with the shear stiffness S.
        """
        layout = self.layout(len(bays.pad), system)
        speed = np.sqrt(self.rail.shear("vertical" if system < 2 else "lateral") / self.rail.mass)
        rate = 3.0 * np.log(1.0 / ENDS) * speed / self.end
        nodes = bays.places[0] + bays.along
        deep = np.maximum(nodes[0] + self.end - nodes, nodes - nodes[-1] + self.end) / self.end
        damping = np.zeros(layout.size)
        damping[layout.nodes] = rate * np.maximum(deep, 0.0)[:, None] ** 2 * mass[:, -1][layout.nodes]
        return damping

    def following(self, first: int, count: int, bridge: Bridge) -> Array:
        """How the unknowns of a vertical system follow a unit of each mode of the bridge (n, modes)."""
        layout, along = self.layout(count, 0), self.bays(first, count, 0).along
        values, slopes = bridge.at(self.places(first, 1)[0] + along)
        motions = np.zeros((layout.size, values.shape[1]))
        motions[layout.nodes[:, 0]], motions[layout.nodes[:, 1]] = values, slopes
        motions[layout.sleepers] = values[: -1 : self.elements]
        return motions

    def receptance(
        self,
        frequencies: ArrayLike,
        place: float,
        direction: Direction = "vertical",
        *,
        bays: int = 240,
        elements: int = 12,
    ) -> NDArray[np.complex128]:
        """Receptance of the left rail at its head under a harmonic force there [m/N], (n,), with the loss factors.

        Parameters
        ----------
        frequencies : array_like
            Frequencies [Hz], (n,).
        place : float
            Along the track [m]; the nearest node of the elements.
        direction : {"vertical", "lateral"}
            Of force and motion.
        bays : int
            Length of the rail, with the place in the middle; its ends are free.
        elements : int
            Of the beam in a bay: 12 of 0.05 m are within 0.6 % of the closed form up to 1.5 kHz.

        Returns
        -------
        ndarray
            Complex; velocity per force is 2 pi i f times it.
        """
        track, values = replace(self, elements=elements), np.zeros(np.shape(frequencies), dtype=complex)
        first = self.number_at(place) - bays // 2
        factors = 1.0 + 1j * np.array([self.rail.loss_factor, self.pad.loss_factor, self.ballast.loss_factor])
        for system, share in ((0, 1.0),) if direction == "vertical" else ((2, 0.5), (3, 0.5)):
            layout, bands = track.layout(bays, system), track.bands(first, bays, system)
            window, load = track.bays(first, bays, system), np.zeros(layout.size)
            unknowns = layout.nodes[np.argmin(np.abs(window.places[0] + window.along - place))]
            load[unknowns[0]] = 1.0
            if system >= 2:
                load[unknowns[2]] = self.rail.shear_centre - self.rail.height
            elastic = sum(f * part for f, part in zip(factors, bands.stiffness, strict=True))
            k, n = layout.width, layout.size
            whole = np.zeros((2 * k + 1, n), dtype=complex)
            for i, w in enumerate(2.0 * np.pi * np.asarray(frequencies, dtype=float)):
                lower = elastic + 1j * w * bands.damping - w**2 * bands.mass
                for j in range(k + 1):  # diagonal number j below the main one
                    whole[k + j, : n - j] = whole[k - j, j:] = lower[j:, k - j]
                values[i] += share * load @ scipy.linalg.solve_banded((k, k), whole, load)
        return np.asarray(values)


def _uniform(numbers: NDArray[np.int_], seed: int) -> Array:
    """Random numbers between -1 and 1 that belong to whole numbers and a seed."""
    first = int(numbers[0])
    blocks = [
        np.random.default_rng((seed, block + BLOCK)).uniform(-1.0, 1.0, BLOCK)
        for block in range(first // BLOCK, int(numbers[-1]) // BLOCK + 1)
    ]
    return np.concatenate(blocks)[numbers - first // BLOCK * BLOCK]
