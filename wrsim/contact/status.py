"""Status bits of the kernels and of the exact solver, and their texts.

Every analysis reports them: static and steady poses in their message or remark, runs and states of rest as an event,
stability analyses as a remark at the speed; an overlap ends a run and is no steady motion.
"""

from wrsim.contact import records
from wrsim.contact.model import MOST_STRIPS
from wrsim.contact.wheel_rail import DEEPEST, LEAST_LEFT_OUT

MOST_ELEMENTS = 200_000
MOST_ROWS = MOST_STRIPS

TOO_MANY = 64  # elements
GRID_EDGE = 128  # contact reaches the edge of the grid
NOT_CONVERGED = 256
SUBSTITUTED = 1024  # a static pose of which the strip model has no solution, or one that leaves out a place

WORDS = {
    records.STATUS_NOT_REFINED: "a main point of contact was not found to round-off",
    records.STATUS_PROFILE_END: "contact reaches the end of a profile, which is continued straight there",
    records.STATUS_TOO_DEEP: f"wheel and rail overlap by more than {1e3 * DEEPEST:g} mm",
    records.STATUS_NOT_CONVERGED: "the strip model was not solved: the forces are those of Kik and Piotrowski's",
    records.STATUS_COARSE: "the budget of the strip model was spent: half as many strips, or a larger residual",
    records.STATUS_LEFT_OUT: (
        "a further place of contact along the rail is left out: the normal force is more than "
        f"{100.0 * LEAST_LEFT_OUT:g} % low"
    ),
    records.STATUS_NO_CONTACT: "no contact at any height: the wheel is beside its rail",
    records.STATUS_OUT_OF_REACH: "the load is not reached within the approach allowed",
    records.STATUS_DISCONTINUOUS: "no equilibrium: the contact force is discontinuous at this load",
    records.STATUS_LOAD_UNSOLVED: "the strip model does not meet this load in the residuals allowed",
    TOO_MANY: (
        f"contact needs more than {MOST_ELEMENTS} elements or {MOST_ROWS} rows of them: give larger ones "
        "(contact.half_space)"
    ),
    GRID_EDGE: "contact reaches the edge of the grid of elements",
    NOT_CONVERGED: "pressures or tractions have not converged",
    SUBSTITUTED: (
        "strips have no solution at this load, or leave out a place: the contact is that of the half-space solver"
    ),
}

UNSOLVED = records.STATUS_NOT_CONVERGED | records.STATUS_DISCONTINUOUS | records.STATUS_LOAD_UNSOLVED
"""Bits of a prescribed load at which the strip model has no solution."""

LEFT_TO_EXACT = UNSOLVED | records.STATUS_LEFT_OUT
"""Bits of a prescribed load with which a static pose is left to the half-space solver."""

UNMET = records.STATUS_NO_CONTACT | records.STATUS_OUT_OF_REACH | UNSOLVED
"""Bits of a prescribed load that is not met."""

REMARKS = records.STATUS_NOT_REFINED | records.STATUS_PROFILE_END | records.STATUS_LEFT_OUT | SUBSTITUTED
"""Bits of contacts that are solved nevertheless."""


def bits_of(status: int) -> list[int]:
    return [bit for bit in WORDS if status & bit] if status else []


def status_words(status: int) -> str:
    """The texts of a status, empty when all is well."""
    return "; ".join(WORDS[bit] for bit in bits_of(status))
