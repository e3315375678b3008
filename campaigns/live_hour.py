"""Memory of live pages in a Chromium over an hour. Run: python campaigns/live_hour.py [HOURS]

The wheelset of scenarios/curve_r300.toml runs on as fast as it can, without being started again, until the hours of its
own time are over; then the contact page is dragged to and fro over FRAMES. Each row: memory of the program
(WebAssembly), heap of the page's scripts after a collection, resident memory of the renderers (page, worker and
graphics), samples that the history holds. Ends with an error where one of the first two grows by more than GROWTH
between half and the end: histories and traces of a page have a length that they reach by then.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from support.browser import Browser, browser  # noqa: E402

from wrsim import write_live  # noqa: E402

FRAMES, PARTS = 60_000, 10
GROWTH = 1.0  # [MB], the heap differs by half of it from one collection to the next
DRAG = """
    const { page } = wrsim;
    for (let i = 0; i < %d; i++) {
        page.set({ shift: 5e-5 * ((page.turns = (page.turns ?? 0) + 1) %% 120) }); page.loop.now();
        if (i %% 100 === 0) await new Promise(requestAnimationFrame);
    }
"""


def resident(opened: Browser) -> float:
    """Memory of the browser's renderers [MB]."""
    pages = sum(int((process / "statm").read_text().split()[1]) for process in opened.renderers())
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def row(opened: Browser, name: str, memory: str, kept: str) -> list[float]:
    """Print and return memory of the program and heap of the page [MB]."""
    opened.driver.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
    program = opened.run(f"return {memory}") / 1e6
    heap = opened.driver.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"] / 1e6
    samples = opened.run(f"return {kept}")
    print(f"{name:>24s}{program:12.1f}{heap:12.1f}{resident(opened):12.0f}{samples:12d}", flush=True)
    return [program, heap]


def check(rows: list[list[float]]) -> None:
    """Raise SystemExit for memory that grows."""
    half = rows[len(rows) // 2 - 1]
    if any(last > first + GROWTH for first, last in zip(half, rows[-1], strict=True)):
        raise SystemExit(f"memory grows from {half} to {rows[-1]} MB")


def main(hours: float) -> None:
    """Both pages."""
    print(f"{'':24s}{'program MB':>12s}{'heap MB':>12s}{'renderers':>12s}{'samples':>12s}")
    with tempfile.TemporaryDirectory() as folder, browser() as opened:
        page, begun = Path(folder) / "live.html", time.monotonic()
        write_live(str(ROOT / "scenarios/curve_r300.toml"), page, step=1e-3)
        opened.open(page, 1000, 700)
        opened.run("return wrsim.ready.then(() => true)")
        opened.run("wrsim.live.worker.postMessage({ end: 1e9, rate: 1e6 }); wrsim.live.play(true)")
        rows = []
        for part in range(1, PARTS + 1):
            while (now := opened.run("return wrsim.live.frame.time")) < 3600.0 * hours * part / PARTS:
                assert opened.run("return wrsim.live.playing"), opened.run("return remark.textContent")
                time.sleep(1.0)
            name = f"{now:.0f} s in {time.monotonic() - begun:.0f} s"
            rows.append(row(opened, name, "wrsim.live.memory", "wrsim.live.count"))
        check(rows)
        write_live(["contact", "wheels/S1002.toml", "rails/60E1.toml"], page)
        opened.open(page, 1000, 700)
        opened.run("return wrsim.ready.then(() => true)")
        rows = []
        for part in range(1, PARTS + 1):
            opened.run(f"return (async () => {{{DRAG % (FRAMES // PARTS)}}})()")
            memory = "wrsim.page.program.call.memory.buffer.byteLength"
            rows.append(row(opened, f"{FRAMES // PARTS * part} frames", memory, "wrsim.page.record.rows.length"))
        check(rows)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 1.0)
