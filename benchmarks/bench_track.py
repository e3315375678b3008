"""How long tracks take to build, and what their tables weigh: with and without irregularities, by length.

python benchmarks/bench_track.py
"""

from time import perf_counter

import blas_threads  # noqa: F401 (before numpy)

from wrsim.track.segments import Arc, Segment, Straight, Transition
from wrsim.track.spectra import Realisation
from wrsim.track.track import Track


def line(length: float) -> list[Segment]:
    """Curves of both hands, 250 m each with what leads there."""
    row: list[Segment] = []
    for i in range(round(length / 250.0)):
        radius = (1.0 if i % 2 else -1.0) * (300.0 + 40.0 * (i % 7))
        row += [Straight(60.0), Transition(50.0), Arc(90.0, radius, cant=0.08), Transition(50.0)]
    return row


def main() -> None:
    print(f"{'km':>6} {'shortest wave m':>16} {'s':>7} {'rows':>8} {'MB':>6}")
    for kilometres in (1, 5, 10, 20, 40):
        for shortest in (None, 3.0, 1.0):
            began = perf_counter()
            length = 1e3 * kilometres
            drawn = Realisation("ERRI-low", 1, shortest, 100.0, 0.0, length).disturbances() if shortest else ()
            track = Track.build(line(length), irregularities=drawn)
            seconds = perf_counter() - began
            weight = sum(path.table.nbytes for path in (track.centre, track.left, track.right)) / 1e6
            wave = f"{shortest:g}" if shortest else "even"
            print(f"{kilometres:>6} {wave:>16} {seconds:>7.2f} {len(track.left.table):>8} {weight:>6.1f}")


if __name__ == "__main__":
    main()
