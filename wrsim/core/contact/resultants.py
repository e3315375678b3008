"""From the strips of a lobe to forces, moments and the figures that people read."""

from math import atan, atan2, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import (
    ANGLE,
    ANGLE_MAX,
    ANGLE_MEAN,
    ANGLE_MIN,
    B_MAIN,
    CLOSING,
    DISSIPATION,
    ETA,
    ETA_MAIN,
    FORCE,
    FORCE_B,
    FORCE_O,
    FORCE_T,
    FX,
    FX_SUM,
    FY,
    FY_SUM,
    LEAST_SPEED,
    MOMENT_B,
    MOMENT_O,
    MOMENT_T,
    MZ,
    NB,
    NB_MAIN,
    NO,
    NO_MAIN,
    O_MAIN,
    PHI,
    PHI_MAIN,
    SPIN_MOMENT,
    WEAR,
    X_MAIN,
    XI,
    XI_MAIN,
    B,
    O,
    X,
)  # fmt: skip


@kernel
def set_creepages(pose, settings, lobe, strips, n):
    """Creepages of each strip and of the main point: velocity of the wheel's material over the rolling speed.

    The rail rests. v = v_origin + omega x r at the strip's centre, projected on the strip's (t, t_s); spin is
    omega . n(s). Writes XI, ETA, PHI of the strips, XI_MAIN, ETA_MAIN, PHI_MAIN and CLOSING (rate of approach) of
    the lobe. The speed is held above LEAST_SPEED.
    """
    vt, vo, vb = pose[6], pose[7], pose[8]
    wt, wo, wb = pose[9], pose[10], pose[11]
    inverse = 1.0 / sqrt(vt * vt + settings[LEAST_SPEED] * settings[LEAST_SPEED])
    n0o, n0b = lobe[NO_MAIN], lobe[NB_MAIN]
    rx, ro, rb = lobe[X_MAIN] - pose[0], lobe[O_MAIN] - pose[1], lobe[B_MAIN] - pose[2]
    uo = vo + wb * rx - wt * rb
    ub = vb + wt * ro - wo * rx
    lobe[CLOSING] = -(uo * n0o + ub * n0b)
    lobe[XI_MAIN] = (vt + wo * rb - wb * ro) * inverse
    lobe[ETA_MAIN] = (uo * n0b - ub * n0o) * inverse
    lobe[PHI_MAIN] = (wo * n0o + wb * n0b) * inverse
    for i in range(n):
        row = strips[i]
        rx, ro, rb = row[X] - pose[0], row[O] - pose[1], row[B] - pose[2]
        row[XI] = (vt + wo * rb - wb * ro) * inverse
        row[ETA] = ((vo + wb * rx - wt * rb) * row[NB] - (vb + wt * ro - wo * rx) * row[NO]) * inverse
        row[PHI] = (wo * row[NO] + wb * row[NB]) * inverse


@kernel
def add_lobe(pose, lobe, strips, n, total):
    """Sum the strips' forces at their centres: to the wheel's total and to the lobe's own figures [S 31]."""
    ft = fo = fb = mt = mo = mb = 0.0
    sum_x = sum_y = sum_no = sum_nb = wear = spin = 0.0
    least = 1e9
    most = -1e9
    n0o, n0b = lobe[NO_MAIN], lobe[NB_MAIN]
    for i in range(n):
        row = strips[i]
        f, fx, fy, mz, no, nb = row[FORCE], row[FX], row[FY], row[MZ], row[NO], row[NB]
        so = f * no + fy * nb
        sb = f * nb - fy * no
        rx, ro, rb = row[X] - pose[0], row[O] - pose[1], row[B] - pose[2]
        ft += fx
        fo += so
        fb += sb
        mt += ro * sb - rb * so
        mo += rb * fx - rx * sb + mz * no
        mb += rx * so - ro * fx + mz * nb
        sum_x += fx
        sum_y += fy
        wear -= fx * row[XI] + fy * row[ETA] + mz * row[PHI]
        # tan(angle / 2) rises with the angle and needs no arcus
        half_tangent = -no / (1.0 + nb)
        if f > 0.0:
            least = min(least, half_tangent)
            most = max(most, half_tangent)
        sum_no += f * no
        sum_nb += f * nb
        # moment of the creep forces about the main point, along its normal
        rx, ro, rb = row[X] - lobe[X_MAIN], row[O] - lobe[O_MAIN], row[B] - lobe[B_MAIN]
        spin += (rb * fx + rx * fy * no + mz * no) * n0o + (rx * fy * nb - ro * fx + mz * nb) * n0b
    lobe[FX_SUM] = sum_x
    lobe[FY_SUM] = sum_y
    lobe[SPIN_MOMENT] = spin
    lobe[ANGLE] = atan2(-n0o, n0b)
    lobe[ANGLE_MIN] = 2.0 * atan(least)
    lobe[ANGLE_MAX] = 2.0 * atan(most)
    lobe[ANGLE_MEAN] = atan2(-sum_no, sum_nb)
    lobe[DISSIPATION] = wear
    total[FORCE_T] += ft
    total[FORCE_O] += fo
    total[FORCE_B] += fb
    total[MOMENT_T] += mt
    total[MOMENT_O] += mo
    total[MOMENT_B] += mb
    total[WEAR] += wear
