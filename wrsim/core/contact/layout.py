"""Where each number stands in the arrays that go in and out of `core.contact.wheel_rail.wheel_rail`."""

# settings[...]
(
    MODULUS, SHEAR_MODULUS, EPSILON, PROJECTED, DAMPING, FRICTION, PARABOLIC, STRIPS, STRIP_WIDTH, TANGENTIAL,
    LEAST_SPEED, WHEEL_STEP, RADIUS, RAIL_STEP, FIELD_O, FIELD_B, FIELD_SPACING, STRIDE, HOLLOW,
    FRICTION_GAUGE, ZONE_START, ZONE_END, FALL_RATIO, FALL_DECAY, ADHESION_FACTOR, SLIP_FACTOR,
    BLENDED, STRIP_MODEL, WARM,
) = range(29)  # fmt: skip
SETTINGS = 29

# settings[TANGENTIAL]
NO_CREEP_FORCES, FASTSIM, FASTRIP, POLACH, LINEAR, SHEN_HEDRICK_ELKINS = range(6)

# pose[...]: profile origin on the axle (t, o, b), axle outward, velocity of the origin, angular velocity
POSE = 12

# a strip's row: centre s, width, shift along x, half length, pressure, normal (o, b), centre (o, b), normal force,
# creep forces, moment about the centre, creepages, radius of curvature along the rail,
# coefficient of friction, half length of the last call and penetration (strip model)
S, DS, X, A, P, NO, NB, O, B, FORCE, FX, FY, MZ, XI, ETA, PHI, RADIUS_T, MU, WARM_A, PENETRATION = range(20)  # noqa: E741 (O stands for outward)
STRIP_COLUMNS = 20

# a lobe's row; GROUP numbers the patch it belongs to
(
    N, FX_SUM, FY_SUM, SPIN_MOMENT, P0, AREA, APPROACH, ANGLE, ANGLE_MIN, ANGLE_MAX, ANGLE_MEAN, N_STRIPS, LENGTH,
    WIDTH, XI_MAIN, ETA_MAIN, PHI_MAIN, ARC_WHEEL, ARC_RAIL, X_MAIN, O_MAIN, B_MAIN, NO_MAIN, NB_MAIN, DISSIPATION,
    GROUP, COUPLING, PARTNER, HALF_LENGTH, CLOSING, START, END, RECESS, AMPLITUDE, WARM_STRIPS, WARM_ARC,
    WARM_START, WARM_END,
) = range(38)  # fmt: skip
PATCH_COLUMNS = 38

# total[...]: force and moment about the profile origin on the wheel (t, o, b), number of lobes, number of patches
# (lobes that share a patch count once), wear number, closest distance
FORCE_T, FORCE_O, FORCE_B, MOMENT_T, MOMENT_O, MOMENT_B, COUNT, PATCHES, WEAR, CLOSEST = range(10)
TOTAL = 10

STATUS_NOT_REFINED = 1
STATUS_PROFILE_END = 2
STATUS_TOO_DEEP = 4
STATUS_UNSETTLED = 8  # the strip model has met its conditions to 1e-4 at best
