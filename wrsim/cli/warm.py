"""``wrsim warm``: compile ahead."""

from __future__ import annotations

from wrsim.cli.ending import reporting_errors
from wrsim.cli.options import Quiet
from wrsim.cli.showing import say
from wrsim.errors import WrsimError


def warm(quiet: Quiet = False) -> None:
    """Compile ahead what runs and poses need, so that the first of them starts at once."""
    with reporting_errors(False):
        from wrsim.analysis.warming import warm_up
        from wrsim.core import CACHE

        if CACHE is None:
            raise WrsimError("there is no place to keep compiled kernels in")
        seconds = warm_up()
        if not quiet:
            say(f"kernels are compiled, in {CACHE} ({seconds:.0f} s)")
