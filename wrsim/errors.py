"""The family of errors that wrsim raises for its users.

Every message is written for the person who meets it: it names the file, the key or the instant, the value found
and what is allowed. The command line prints the message alone, without a traceback.
"""

from __future__ import annotations

from difflib import get_close_matches


class WrsimError(Exception):
    """Base of all errors that wrsim raises on purpose."""

    exit_code = 1


class InputError(WrsimError):
    """Something the user wrote cannot be used: a file, a key, a value, a combination. Exit code 2."""

    exit_code = 2


class SimulationError(WrsimError):
    """A run had to stop: derailment, lost contact solution, not-a-number, no convergence. Exit code 3."""

    exit_code = 3


def suggest(word: str, allowed: list[str] | tuple[str, ...]) -> str:
    """Return `` (did you mean 'x'?)`` for the nearest allowed word, or an empty string."""
    near = get_close_matches(word, list(allowed), n=1, cutoff=0.6)
    return f" (did you mean '{near[0]}'?)" if near else ""
