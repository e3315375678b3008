"""Progress of an analysis whose steps take about as long as each other."""

import time
from collections.abc import Callable

Progress = Callable[[float, float], None]
"""progress(fraction done, seconds left)"""


class Report:
    """Calls a progress function, if there is one, at most once in an ``interval`` [s] and always at the end."""

    def __init__(self, progress: Progress | None, interval: float = 0.0) -> None:
        self.progress, self.interval = progress, interval
        self.began = self.last = time.perf_counter()

    def __call__(self, fraction: float) -> None:
        now = time.perf_counter()
        if self.progress is not None and fraction > 0.0 and (fraction == 1.0 or now - self.last >= self.interval):
            self.last = now
            self.progress(fraction, (now - self.began) * (1.0 - fraction) / fraction)
