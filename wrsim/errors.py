"""The family of errors that wrsim raises for its users.

Every message is written for the person who meets it: it names the file, the key or the instant, the value found
and what is allowed. The command line prints the message alone, without a traceback.
"""

from collections.abc import Sequence
from difflib import get_close_matches
from functools import lru_cache

STOPPED, DIFFERENT, INTERRUPTED = 3, 4, 130
"""Exit codes: of runs that stop early and of studies with cases that did; of results that differ; after Ctrl-C."""


class WrsimError(Exception):
    """Base of all errors that wrsim raises on purpose."""

    exit_code = 1


class InputError(WrsimError):
    """A file, key, value or combination of the user that cannot be used. Exit code 2.

    unknown: dotted keys that no table has, where nothing else is wrong.
    """

    exit_code = 2

    def __init__(self, message: str, unknown: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.unknown = unknown


class SimulationError(WrsimError):
    """A run that stopped: derailment, no contact solution, not-a-number, no convergence. Exit code 3."""

    exit_code = 3


def in_one_line(error: InputError) -> str:
    """The first line of a message and the number of further lines."""
    first, *more = str(error).split("\n")
    return f"{first} (and {len(more)} more line{'s' * (len(more) > 1)})" if more else first


def nearest(word: str, allowed: Sequence[str]) -> str | None:
    """Return the allowed word most like ``word``, or the one that begins with it, regardless of capitals, or None."""
    return _nearest(word.lower(), tuple(allowed))


@lru_cache(maxsize=1024)
def _nearest(word: str, allowed: tuple[str, ...]) -> str | None:
    small = {a.lower(): a for a in allowed}
    near = get_close_matches(word, list(small), n=1, cutoff=0.6)
    begun = [a for a in small if a.startswith(word)]
    near = near or (begun if len(begun) == 1 and len(word) > 2 else [])
    return small[near[0]] if near else None


def suggest(word: str, allowed: Sequence[str]) -> str:
    """Return `` (did you mean 'x'?)`` for the nearest allowed word, or an empty string."""
    near = nearest(word, allowed)
    return f" (did you mean '{near}'?)" if near else ""


_CONTROLS = {*range(0x20), *range(0x7F, 0xA0), *range(0x202A, 0x202F), *range(0x2066, 0x206A)} - {0x09, 0x0A}
_PLAIN = dict.fromkeys(_CONTROLS, "\N{REPLACEMENT CHARACTER}")


def plain(text: str) -> str:
    """A text without control characters: titles, names and paths may come from anybody."""
    return text.translate(_PLAIN)
