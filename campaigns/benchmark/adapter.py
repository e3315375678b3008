"""What the yardstick asks a code for: one function a kind of comparison.

Another code enters as a subclass of `Code` that has some of the functions; what it does not have is "not offered".
Names of arguments and answers have their unit at the end; an answer may hold more than is compared. Angles of attack,
shifts and forces follow the sources: in the tables of CONTACT a right wheel, x forward, y to the right, z down, forces
on the rail. None in the place of an answer: the code finds no solution, which is as wrong as a figure can be.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Value = float | Sequence[float]
Answer = Mapping[str, Value] | None


class Code:
    """A code; ``reference``: the folder of tables that the command is given."""

    name = "code"

    def __init__(self, reference: Path) -> None:
        self.reference = reference

    def points(self, kind: str, name: str) -> NDArray[np.float64]:
        """Points (n, 2) [mm] of a profile that comparisons name: across, up. kind: "wheels" or "rails"."""
        from wrsim import load_profile

        profile = load_profile(f"{kind}/{name}.toml")
        return 1e3 * np.column_stack(profile.at(np.linspace(0.0, profile.length, 2001)))

    # --- contact --------------------------------------------------------------------------------------------------
    def hertz(
        self, *, along_per_m: float, across_per_m: float, load_N: float, G_GPa: float, nu: float, model: str
    ) -> Answer:
        """Elliptic contact of relative curvatures: ``p0_MPa``, ``approach_mm``, ``area_mm2``. model: "" (the code's
        best) or "kik-piotrowski"."""
        raise NotImplementedError

    def pose(
        self, *, wheel: str, rail: str, inclination: str, y_mm: float, roll_rad: float, yaw_rad: float,
        pitch_rad_per_s: float, load_N: float, friction: float, model: str, form: str = "",
    ) -> Answer:  # fmt: skip
        """A right wheel of 460 mm radius carries a load on a rail: flange backs 1360 mm apart, gauge 1435 mm, 2 m/s,
        steel of G 82 GPa and nu 0.28; model: "" (the code's best), "half-space", or "half-space, level", which pairs
        points of the same lateral place; form: "", or in disguise, as a wheel out of round by an axle beside its centre
        ("eccentric") or as sections of a rail that lies at an angle ("askew"). Of the patch with the largest force
        ``p0_MPa``, ``area_mm2``, ``approach_mm``, ``N_N``, contact angles at its edges ``angle_smin_rad``,
        ``angle_smax_rad`` (the latter nearer to the field side); of all patches ``X_N``, ``Y_N``, and ``x_mm`` of the
        normal force from the wheelset's centre along the track."""
        raise NotImplementedError

    def arcs(
        self, *, wheel_radius_mm: float, rail_radius_mm: float, rolling_radius_mm: float, y_mm: float, load_N: float,
        G_GPa: float, pitch_rad_per_s: float, turned: bool = False,
    ) -> Answer:  # fmt: skip
        """A wheel of one arc (above 0: hollow) on a rail of one arc (above 0: round), nu 0.28, rolling at 2 m/s with
        friction 0.3, or without friction at 0 pitch; turned: the influence of elements on each other turns with their
        normals, as far as these differ: ``p0_MPa``, ``approach_mm``, ``width_mm``, ``length_mm``,
        ``angle_range_deg``, ``direction_deg`` of the force."""
        raise NotImplementedError

    def rail_corner(self, *, penetration_mm: Sequence[float]) -> Answer:
        """The rail corner of CONTACT's guide: G 82 GPa, nu 0.28, friction 0.3, A 0.76859 1/m along, elements of 0.4 mm
        at which the penetration across is given, from the middle on and the same on the other side; creepages -0.004
        and -0.0098995, spin -1.5372 1/m. ``N_kN``, ``X_kN``, ``S_kN``, ``M_Nm``, ``p0_MPa``."""
        raise NotImplementedError

    def rounded_flat(self, *, pitch_rad: float, z_mm: float) -> Answer:
        """The wheel with a rounded flat of CONTACT's test bank under 10 kN: ``z_mm`` that it has sunk (near to the one
        given), ``x_mm`` of the force, ``approach_mm``, ``p0_MPa``."""
        raise NotImplementedError

    def crossing(self, *, s_mm: float, y_mm: float, load_N: float, near_mm: float) -> Answer:
        """S1002 on the crossing 56E1-R245-1:9.25: ``z_mm`` that it has sunk; of the patch nearest to y = near_mm
        ``N_N``, ``p0_MPa``, ``x_mm``, ``y_mm``."""
        raise NotImplementedError

    # --- creep forces ---------------------------------------------------------------------------------------------
    def kalker(self, *, a_over_b: float, nu: float) -> Answer:
        """Kalker's creep coefficients ``C11``, ``C22``, ``C23``."""
        raise NotImplementedError

    def creep_forces(
        self, *, a_mm: float, b_mm: float, N_N: float, xi: float, eta: float, phi_per_mm: float, friction: float,
        G_GPa: float, nu: float, model: str,
    ) -> Answer:  # fmt: skip
        """On an ellipse, over mu N and mu N sqrt(ab): ``fx``, ``fy``, ``mz``. model: "" (the code's best), "fastsim",
        "fastsim, parabolic", "fastrip", "polach", "shen-hedrick-elkins", "linear"."""
        raise NotImplementedError

    def traction(
        self, *, creepage: float, N_N: float, A_per_m: float, a_over_b: float, speed_m_per_s: float, law: str
    ) -> Answer:
        """``X_N`` on a locomotive's wheel; law: "coulomb" (0.33), or "polach": friction that falls from 0.36 to
        0.1368, by half every 0.99 m/s, slopes reduced with k_0 0.54, alpha_inf 0.02, beta 0.62."""
        raise NotImplementedError

    # --- geometry -------------------------------------------------------------------------------------------------
    def profile(self, *, kind: str, name: str, across_mm: Sequence[float]) -> Answer:
        """``down_mm`` of a standard profile over places across, positive to the field side; "wheels" or "rails"."""
        raise NotImplementedError

    def conicity(self, *, amplitude_mm: Sequence[float], right_radius_mm: float) -> Answer:
        """``tan_gamma_e`` of wheel A on rail A of EN 15302, gauge 1435.16 mm, left radius 460 mm."""
        raise NotImplementedError

    # --- vehicles -------------------------------------------------------------------------------------------------
    def wheelset_mode(self, *, speed_m_per_s: float, near_rad_per_s: float) -> Answer:
        """Hunting of the wheelset on knife-edge rails, the mode next to a frequency: ``growth_per_s``,
        ``frequency_rad_per_s``."""
        raise NotImplementedError

    def critical_speed(self, *, vehicle: str) -> Answer:
        """Linear one of "cooperrider": ``speed_m_per_s``, ``frequency_Hz``."""
        raise NotImplementedError

    def wheel_load(self, *, vehicle: str) -> Answer:
        """Mean ``Q_kN`` of the wheels of "gz18" or "irw" at rest."""
        raise NotImplementedError

    def steady_curve(self, *, line: str) -> Answer:
        """The leading wheelset of the metro car GZ18 in R 300 ("r300") or R 600 m: ``lateral_mm`` outward, ``yaw_mrad``
        nose outward; outer and inner wheel ``N_kN``, ``Tx_kN``, ``Ty_kN`` outward, as ``outer_N_kN`` ..."""
        raise NotImplementedError

    def momentum(self, *, seed: int) -> Answer:
        """A frame on the arms of two axle boxes, all displaced, turned and moving at random: what the changes of
        momentum and of angular momentum add up to, ``force`` over the largest force and ``moment_m`` over it."""
        raise NotImplementedError

    def friction_loop(self, *, kind: str, amplitude_mm: float) -> Answer:
        """The closed loop of a "rubber-spring" (Berg; x2 4 mm) or a "leaf-spring" (Fancher; 3 mm) with 0.2 MN/m and 3
        kN of friction: largest ``force_kN``, ``area_J``."""
        raise NotImplementedError

    def side_wind(self, *, force_kN: float) -> Answer:
        """The Manchester coach at rest, pushed to the left 2.2 m above the rails: ``y_mm`` to the left and
        ``roll_mrad`` of its body, negative to the left, and what a left wheel gains, ``gain_kN``."""
        raise NotImplementedError

    def climb(self, *, flange_angle_deg: float, flange_length_mm: float, attack_mrad: float) -> Answer:
        """``distance_m`` until a wheel has climbed at Y/Q 1.99, friction 0.5."""
        raise NotImplementedError

    def overturning(self, *, speed_km_per_h: float) -> Answer:
        """Whether a coach of usual figures ``falls`` (1) in a curve of 945 m with 163 mm of cant, or not (0)."""
        raise NotImplementedError

    # --- track ----------------------------------------------------------------------------------------------------
    def line(self, *, straight_m: float, clothoid_m: float, radius_m: float, s_m: float) -> Answer:
        """Where a line is after a straight, a clothoid and so much of a curve to the left: ``x_m``, ``y_m`` and
        ``heading_rad`` at a distance along it."""
        raise NotImplementedError

    def rail_mobility(self, *, track: str, frequency_Hz: Sequence[float]) -> Answer:
        """Point mobilities ``v_m_per_s_per_N`` of a rail; track: "foundation" or "sleepers", above one."""
        raise NotImplementedError

    def rail_in_time(self, *, frequency_Hz: float) -> Answer:
        """``amplitude_m`` of a rail above a sleeper under a harmonic force of 1 N, by steps in time: UIC60 without
        loss, pads of 200 MN/m and 30 kNs/m, sleepers of 324 kg every 0.6 m, ballast of 50 MN/m, 60 kNs/m an end."""
        raise NotImplementedError

    def rolling_load(self, *, speed_m_per_s: float, stiffness_MN_per_m2: float, damping_kNs_per_m2: float) -> Answer:
        """A wheel that rolls along a rail UIC60 without loss on a foundation: ``down_m_per_N`` of the rail under it,
        and ``slope_per_N`` uphill: over the wheel load the force along the track that the foundation takes."""
        raise NotImplementedError

    def rolling_aside(self, *, speed_m_per_s: float, stiffness_MN_per_m2: float, push_kN: float) -> Answer:
        """A wheelset that is pushed sideways rolls along rails UIC60 on a foundation, which bend
        but neither shear nor twist: ``aside_m_per_N``, of both rails together over the force on both."""
        raise NotImplementedError

    def bridge(self, *, speed_km_per_h: float) -> Answer:
        """Manchester coach over a span of 20 m: largest ``deflection_mm``, ``moment_kNm``, ``acceleration_m_per_s2``
        in its middle."""
        raise NotImplementedError

    def ride_weighting(self, *, weighting: str, frequency_Hz: float) -> Answer:
        """``factor`` of a frequency weighting of ISO 2631 or ISO 8041."""
        raise NotImplementedError
