"""What the exact solver has to say beside the kernels' own status bits (core.contact)."""

from __future__ import annotations

from wrsim.contact.model import MOST_STRIPS
from wrsim.core.contact.records import STATUS_PROFILE_END, STATUS_TOO_DEEP
from wrsim.core.contact.wheel_rail import DEEPEST

MOST_ELEMENTS = 200_000
MOST_ROWS = MOST_STRIPS

TOO_MANY = 64  # elements
GRID_EDGE = 128  # contact reaches the edge of the grid
NOT_CONVERGED = 256
_WORDS = {
    TOO_MANY: (
        f"contact needs more than {MOST_ELEMENTS} elements or {MOST_ROWS} rows of them: give larger ones "
        "(contact.half_space)"
    ),
    GRID_EDGE: "contact reaches the edge of the grid of elements",
    NOT_CONVERGED: "pressures or tractions have not converged",
    STATUS_TOO_DEEP: f"wheel and rail overlap by more than {1e3 * DEEPEST:g} mm",
    STATUS_PROFILE_END: "contact reaches the end of a profile, which is continued straight there",
}


def status_words(status: int) -> str:
    """What a status has to say, empty when all is well."""
    return "; ".join(words for bit, words in _WORDS.items() if status & bit)
