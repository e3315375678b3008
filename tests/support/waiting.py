"""Waiting for what happens in another process."""

import time
from collections.abc import Callable
from subprocess import Popen
from typing import Any


def wait_until(condition: Callable[[], object], process: Popen[Any] | None = None, seconds: float = 1200.0) -> None:
    """Wait until a condition holds; fails where the process that brings it about has ended before.

    The bound is for a condition that never holds, not for slow machines."""
    end = time.monotonic() + seconds
    while not condition():
        assert process is None or process.poll() is None, f"the process ended with {process.returncode}"
        assert time.monotonic() < end, f"not after {seconds:g} s"
        time.sleep(0.005)
