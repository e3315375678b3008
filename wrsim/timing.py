"""What a command does, part after part, and how long each takes: records of the logger ``wrsim.timing``, for ``-v``."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LOGGER = logging.getLogger("wrsim.timing")


@contextmanager
def timed(words: str | Callable[[], str]) -> Iterator[None]:
    """A part of the work, logged at its end with its time as ``seconds``; words: or what gives them then."""
    began = time.perf_counter()
    yield
    LOGGER.info(words if isinstance(words, str) else words(), extra={"seconds": time.perf_counter() - began})
