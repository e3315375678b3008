"""The register of channels: every name that a Result may carry, with its dimensions, unit and meaning.

One place for the whole of wrsim. ``docs/conventions.md`` prints the same list for readers; a test compares
the two. Values are in SI units in the dataset; the register also says in which unit people read them (mm, kN,
degrees, MPa).

Dimensions are written with two words that stand for another:

- ``sample``: ``time`` in runs, ``pose`` in static analyses;
- ``moment``: ``snapshot`` in runs (chosen instants), ``pose`` in static analyses (every pose).

Everything that belongs to a wheelset or its wheels has the dimension ``wheelset``, of size 1 for a single wheelset.
``wrsim.results.wheelsets`` takes one wheelset out.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

from wrsim.errors import suggest

Kind = Literal["number", "count", "text"]


@dataclass(frozen=True)
class Shown:
    """A unit for readers: ``value_in_si * factor`` is the number shown.

    ``symbol`` stands on axes, ``suffix`` at the end of column names and JSON keys (ASCII).
    """

    symbol: str
    suffix: str
    factor: float


PLAIN = Shown("1", "", 1.0)
SHOWN = {
    "s": Shown("s", "s", 1.0),
    "m": Shown("m", "m", 1.0),
    "mm": Shown("mm", "mm", 1e3),
    "um": Shown("µm", "um", 1e6),
    "mm2": Shown("mm²", "mm2", 1e6),
    "m/s": Shown("m/s", "m_s", 1.0),
    "km/h": Shown("km/h", "kmh", 3.6),
    "1/km": Shown("1/km", "per_km", 1e3),
    "1/m": Shown("1/m", "per_m", 1.0),
    "rad/s": Shown("rad/s", "rad_s", 1.0),
    "mrad": Shown("mrad", "mrad", 1e3),
    "deg": Shown("°", "deg", 180.0 / pi),
    "N": Shown("N", "N", 1.0),
    "kN": Shown("kN", "kN", 1e-3),
    "N m": Shown("N m", "Nm", 1.0),
    "t": Shown("t", "t", 1e-3),
    "m/s2": Shown("m/s²", "m_s2", 1.0),
    "MPa": Shown("MPa", "MPa", 1e-6),
    "permille": Shown("‰", "permille", 1e3),
    "Hz": Shown("Hz", "Hz", 1.0),
    "1/s": Shown("1/s", "per_s", 1.0),
    "1": PLAIN,
}


@dataclass(frozen=True)
class Channel:
    """One channel: name, dimensions (see the module), SI unit, meaning, unit for readers, symbol for axes.

    ``kind`` is ``"number"`` (float64, not-a-number where nothing is defined), ``"count"`` (int64, zero where
    nothing is) or ``"text"``. ``coordinate`` is true for values that label a dimension.
    """

    name: str
    dims: tuple[str, ...]
    unit: str
    long_name: str
    shown: Shown
    symbol: str = ""
    kind: Kind = "number"
    coordinate: bool = False

    @property
    def column(self) -> str:
        """Name with the unit for readers at the end, for column headers and JSON keys: ``p0_MPa``."""
        return f"{self.name}_{self.shown.suffix}" if self.shown.suffix else self.name

    @property
    def label(self) -> str:
        """Text for an axis: long name, symbol and unit for readers."""
        words = self.long_name[0].upper() + self.long_name[1:]
        if self.symbol:
            words += f" ${self.symbol}$"
        return words if self.shown is PLAIN else f"{words} [{self.shown.symbol}]"

    def dims_in(self, sample: str) -> tuple[str, ...]:
        """Dimensions in a dataset whose sample dimension is ``"time"`` or ``"pose"``."""
        moment = "snapshot" if sample == "time" else "pose"
        return tuple({"sample": sample, "moment": moment}.get(d, d) for d in self.dims)


def _of(
    name: str,
    dims: str,
    unit: str,
    shown: str,
    long_name: str,
    symbol: str = "",
    kind: Kind = "number",
    coordinate: bool = False,
) -> Channel:
    return Channel(name, tuple(dims.split()), unit, long_name, SHOWN[shown], symbol, kind, coordinate)


_WHEELSET = "sample wheelset"
_WHEEL = "sample wheelset wheel"
_PATCH = "sample wheelset wheel patch"
_STRIP = "moment wheelset wheel patch strip"
_ELEMENT = "moment wheelset wheel patch strip column"

_ALL = (
    # labels of the dimensions
    _of("time", "time", "s", "s", "time", "t", coordinate=True),
    _of("pose", "pose", "1", "1", "name of the pose", kind="text", coordinate=True),
    _of("wheel", "wheel", "1", "1", "side of the wheelset", kind="text", coordinate=True),
    _of("patch", "patch", "1", "1", "contact patch, largest force first", kind="count", coordinate=True),
    _of("amplitude", "amplitude", "m", "mm", "amplitude of the swing", r"\hat y", coordinate=True),
    _of("snapshot", "snapshot", "1", "1", "number of the snapshot", kind="count", coordinate=True),
    _of("wheelset", "wheelset", "1", "1", "name of the wheelset", kind="text", coordinate=True),
    _of("body", "body", "1", "1", "name of the body", kind="text", coordinate=True),
    _of("point", "point", "1", "1", "name of the point", kind="text", coordinate=True),
    _of("suspension", "suspension", "1", "1", "name of the suspension element", kind="text", coordinate=True),
    # the track under the wheelset
    _of("distance", "time", "m", "m", "distance along the track", coordinate=True),
    _of("speed", "time", "m/s", "km/h", "speed", "V"),
    _of("curvature", "time wheelset", "1/m", "1/km", "curvature", r"\kappa"),
    _of("cant", "time wheelset", "m", "mm", "cant"),
    _of("gauge", "time wheelset", "m", "mm", "track gauge"),
    _of("grade", "time wheelset", "1", "permille", "grade"),
    _of("wheelset_distance", "time wheelset", "m", "m", "distance of the wheelset along the track"),
    # the vehicle
    _of("drive_force", "time", "N", "kN", "force that holds the speed"),
    _of("guide_force_x", "time wheelset", "N", "kN", "longitudinal guide force", "F_{gx}"),
    _of("guide_force_y", "time wheelset", "N", "kN", "lateral guide force", "F_{gy}"),
    _of("guide_moment", "time wheelset", "N m", "N m", "yaw moment of the guide frame", "M_{gz}"),
    _of("body_lateral", "time body", "m", "mm", "lateral displacement of the body"),
    _of("body_vertical", "time body", "m", "mm", "vertical displacement of the body"),
    _of("body_yaw", "time body", "rad", "mrad", "yaw of the body"),
    _of("body_pitch", "time body", "rad", "mrad", "pitch of the body"),
    _of("body_roll", "time body", "rad", "mrad", "roll of the body"),
    _of("point_ax", "time point", "m/s2", "m/s2", "longitudinal acceleration"),
    _of("point_ay", "time point", "m/s2", "m/s2", "lateral acceleration"),
    _of("point_az", "time point", "m/s2", "m/s2", "vertical acceleration"),
    _of("point_level", "point", "1", "1", "what the point is on", kind="text"),
    _of("point_bogie_mass", "point", "kg", "t", "mass of the bogie that the point is on"),
    _of("suspension_fx", "time suspension", "N", "kN", "force of the element, forward or along its line"),
    _of("suspension_fy", "time suspension", "N", "kN", "force of the element, to the left"),
    _of("suspension_fz", "time suspension", "N", "kN", "force of the element, up"),
    _of("suspension_dx", "time suspension", "m", "mm", "travel of the element, forward or along its line"),
    _of("suspension_dy", "time suspension", "m", "mm", "travel of the element, to the left"),
    _of("suspension_dz", "time suspension", "m", "mm", "travel of the element, up"),
    _of("suspension_stop_min", "suspension", "m", "mm", "travel at the lower end of a bump stop's table"),
    _of("suspension_stop_max", "suspension", "m", "mm", "travel at the upper end of a bump stop's table"),
    _of("event_time", "event", "s", "s", "time of the event"),
    _of("event_distance", "event", "m", "m", "place of the event"),
    _of("event_label", "event", "1", "1", "what happened", kind="text"),
    # the prescribed pose
    _of("load", "pose", "N", "kN", "prescribed vertical load"),
    _of("pose_message", "pose", "1", "1", "why the pose has no solution; empty when it has one", kind="text"),
    # the speed, and the curve of a steady analysis
    _of("pose_speed", "pose", "m/s", "km/h", "speed", "V"),
    _of("pose_radius", "pose", "m", "m", "radius of the curve, positive to the left", "R"),
    _of("pose_cant", "pose", "m", "mm", "cant of the curve"),
    _of("cant_deficiency", "pose", "m", "mm", "cant deficiency"),
    _of("unbalanced", "pose", "1", "1", "largest force left over, as a part of the weight"),
    # stability: small motions about steady rolling, and limit cycles
    _of("growth_max", "pose", "1/s", "1/s", "growth rate of what grows fastest"),
    _of("mode_branch", "pose mode", "1", "1", "number by which a mode is followed from speed to speed", kind="count"),
    _of("mode_frequency", "pose mode", "Hz", "Hz", "frequency of the mode", "f"),
    _of("mode_damping", "pose mode", "1", "1", "damping ratio of the mode", r"\zeta"),
    _of("mode_growth", "pose mode", "1/s", "1/s", "growth rate of the mode", r"\sigma"),
    _of("mode_name", "pose mode", "1", "1", "what moves in the mode", kind="text"),
    _of("cycle_speed", "cycle", "m/s", "km/h", "speed held", "V"),
    _of("cycle_branch", "cycle", "1", "1", "from above or from below", kind="text"),
    _of("cycle_ending", "cycle", "1", "1", "what the motion came to", kind="text"),
    _of("cycle_time", "cycle", "s", "s", "time for which the speed was held"),
    _of("cycle_frequency", "cycle", "Hz", "Hz", "frequency of the limit cycle", "f"),
    _of("cycle_amplitude", "cycle wheelset", "m", "mm", "amplitude of the wheelset's lateral motion", r"\hat y"),
    # the wheelset
    _of("lateral_shift", _WHEELSET, "m", "mm", "lateral shift", r"\Delta y"),
    _of("vertical_shift", _WHEELSET, "m", "mm", "vertical shift", r"\Delta z"),
    _of("yaw", _WHEELSET, "rad", "mrad", "angle of attack", r"\psi"),
    _of("roll", _WHEELSET, "rad", "mrad", "roll", r"\varphi"),
    _of("spin_rate", _WHEELSET, "rad/s", "rad/s", "rotation about the axle", r"\omega"),
    # rolling of undeformed profiles
    _of("rolling_radius_difference", "pose wheelset", "m", "mm", "rolling radius difference", r"\Delta r"),
    _of("rolling_radius", "pose wheelset wheel", "m", "mm", "rolling radius", "r"),
    _of("equivalent_conicity", "amplitude wheelset", "1", "1", "equivalent conicity", r"\tan\gamma_e"),
    _of("conicity_wavelength", "amplitude wheelset", "m", "m", "wavelength of the swing", r"\lambda"),
    # a wheel
    _of("rail_lateral", _WHEEL, "m", "mm", "lateral irregularity of the rail"),
    _of("rail_vertical", _WHEEL, "m", "mm", "vertical irregularity of the rail"),
    _of("rail_displacement_y", _WHEEL, "m", "mm", "lateral displacement of the elastic rail"),
    _of("rail_displacement_z", _WHEEL, "m", "mm", "vertical displacement of the elastic rail"),
    _of("Y", _WHEEL, "N", "kN", "lateral force", "Y"),
    _of("Q", _WHEEL, "N", "kN", "vertical force", "Q"),
    _of("X", _WHEEL, "N", "kN", "longitudinal force", "X"),
    _of("Y_over_Q", _WHEEL, "1", "1", "derailment quotient", "Y/Q"),
    _of("T_gamma", _WHEEL, "N", "N", "wear number", r"T\gamma"),
    _of("n_patches", _WHEEL, "1", "1", "number of contact patches", kind="count"),
    # a patch
    _of("N", _PATCH, "N", "kN", "normal force", "N"),
    _of("Fx", _PATCH, "N", "kN", "longitudinal creep force", "F_x"),
    _of("Fy", _PATCH, "N", "kN", "lateral creep force", "F_y"),
    _of("spin_moment", _PATCH, "N m", "N m", "spin moment", "M_n"),
    _of("contact_angle", _PATCH, "rad", "deg", "contact angle", r"\gamma"),
    _of("contact_angle_min", _PATCH, "rad", "deg", "smallest contact angle", r"\gamma_{min}"),
    _of("contact_angle_max", _PATCH, "rad", "deg", "largest contact angle", r"\gamma_{max}"),
    _of("contact_angle_mean", _PATCH, "rad", "deg", "mean contact angle", r"\bar\gamma"),
    _of("contact_angle_variation", _PATCH, "rad", "deg", "variation of the contact angle", r"\Delta\gamma"),
    _of("p0", _PATCH, "Pa", "MPa", "largest pressure", "p_0"),
    _of("area", _PATCH, "m2", "mm2", "contact area", "A"),
    _of("approach", _PATCH, "m", "um", "approach", r"\delta"),
    _of("n_strips", _PATCH, "1", "1", "number of strips", "N_s", kind="count"),
    _of("length", _PATCH, "m", "mm", "length of the patch along the track"),
    _of("width", _PATCH, "m", "mm", "width of the patch along the curved axis"),
    _of("xi", _PATCH, "1", "permille", "longitudinal creepage", r"\xi"),
    _of("eta", _PATCH, "1", "permille", "lateral creepage", r"\eta"),
    _of("phi", _PATCH, "1/m", "1/m", "spin creepage", r"\phi"),
    _of("u_wheel", _PATCH, "m", "mm", "position on the wheel profile", "u_w"),
    _of("u_rail", _PATCH, "m", "mm", "position on the rail profile", "u_r"),
    _of("x_contact", _PATCH, "m", "mm", "contact point, forward", "x_c"),
    _of("y_contact", _PATCH, "m", "mm", "contact point, to the left", "y_c"),
    _of("z_contact", _PATCH, "m", "mm", "contact point, up", "z_c"),
    # chosen instants of a run
    _of("snapshot_time", "snapshot", "s", "s", "time of the snapshot"),
    _of("snapshot_distance", "snapshot", "m", "m", "distance of the snapshot"),
    _of("snapshot_label", "snapshot", "1", "1", "why this instant was kept", kind="text"),
    # the strips of a patch
    _of("strip_s", _STRIP, "m", "mm", "curved axis", "s"),
    _of("strip_ds", _STRIP, "m", "mm", "width of the strip"),
    _of("strip_x", _STRIP, "m", "mm", "along the track", "x"),
    _of("strip_a", _STRIP, "m", "mm", "half length of the strip", "a"),
    _of("strip_p", _STRIP, "Pa", "MPa", "pressure", "p"),
    _of("strip_angle", _STRIP, "rad", "deg", "contact angle", r"\gamma"),
    _of("strip_y", _STRIP, "m", "mm", "outward", "o"),
    _of("strip_z", _STRIP, "m", "mm", "up", "b"),
    _of("strip_N", _STRIP, "N", "N", "normal force of the strip"),
    _of("strip_Fx", _STRIP, "N", "N", "longitudinal creep force of the strip"),
    _of("strip_Fy", _STRIP, "N", "N", "lateral creep force of the strip"),
    _of("strip_xi", _STRIP, "1", "permille", "longitudinal creepage", r"\xi"),
    _of("strip_eta", _STRIP, "1", "permille", "lateral creepage", r"\eta"),
    _of("strip_phi", _STRIP, "1/m", "1/m", "spin creepage", r"\phi"),
    _of("strip_friction", _STRIP, "1", "1", "coefficient of friction of the strip", r"\mu"),
    # the elements of the exact solver, rows as the strips
    _of("element_x", "moment wheelset wheel patch column", "m", "mm", "along the track", "x"),
    _of("element_p", _ELEMENT, "Pa", "MPa", "pressure", "p"),
    _of("element_qx", _ELEMENT, "Pa", "MPa", "longitudinal traction", "q_x"),
    _of("element_qs", _ELEMENT, "Pa", "MPa", "lateral traction", "q_s"),
    # poses and motions of the wheels, for whoever looks at these contacts again
    _of("wheel_origin", "moment wheelset wheel axis", "m", "m", "wheel's profile origin"),
    _of("wheel_axle", "moment wheelset wheel axis", "1", "1", "direction of the axle, outward"),
    _of("wheel_velocity", "moment wheelset wheel axis", "m/s", "m/s", "velocity of the wheel's profile origin"),
    _of("wheel_rotation", "moment wheelset wheel axis", "rad/s", "rad/s", "angular velocity of the wheel"),
    # outlines for drawing
    _of("rail_profile_y", "wheel rail_point", "m", "mm", "rail profile, outward", "o"),
    _of("rail_profile_z", "wheel rail_point", "m", "mm", "rail profile, up", "b"),
    _of("wheel_profile_y", "moment wheelset wheel wheel_point", "m", "mm", "outline of the wheel, outward", "o"),
    _of("wheel_profile_z", "moment wheelset wheel wheel_point", "m", "mm", "outline of the wheel, up", "b"),
)

WHEELSET, BOGIE_FRAME, CAR_BODY = "wheelset", "bogie frame", "car body"
"""Values of the channel ``point_level``."""

CHANNELS: dict[str, Channel] = {channel.name: channel for channel in _ALL}
"""Every channel by its name, in the order in which tables print them."""

WHEELS = ("left", "right")
"""Values of the ``wheel`` coordinate; a static analysis of one wheel carries one of them."""


def channel(name: str) -> Channel:
    """Channel of that name. Raises ``KeyError`` with the nearest name when there is none."""
    try:
        return CHANNELS[name]
    except KeyError:
        raise KeyError(f"no channel is called {name!r}{suggest(name, list(CHANNELS))}") from None
