"""What a command does, part after part, and how long each takes: records of the logger ``wrsim.timing``, for ``-v``."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LOGGER = logging.getLogger("wrsim.timing")


@contextmanager
def timed(label: str | Callable[[], str]) -> Iterator[None]:
    """A part of the work, logged at its end with its time as ``seconds``; label: or what gives them then."""
    began = time.perf_counter()
    yield
    LOGGER.info(label if isinstance(label, str) else label(), extra={"seconds": time.perf_counter() - began})
