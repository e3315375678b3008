"""How long a frame of the live page of the contact takes, how fast a coach runs in its page. Run:
python benchmarks/bench_live.py; four minutes, with nothing else on the machine

S1002 on 60E1 1:40 in a headless Chromium with drawing on the processor, dragged by 0.05 mm a frame under 60 kN: all the
way, over the two patches, over the conformal patch; and at a height. Milliseconds, median and 95 % of the frames: of
the work in the page (both contacts and all drawing), of the contacts in it, of the work in the fastest of the passes
over each place, which other load on the machine leaves alone, and from one picture to the next.

The Manchester coach in R 300 with strips, steps of 1 ms, from the start of the transition into the curve, drawn all the
while: simulated seconds a second as fast as it can, of every second of the run the best of three; processor time of the
thread that computes over simulated time, which other load leaves almost alone; frames a second at the speed of time 1,
for all that is drawn and without the vehicle in three dimensions. The load is the average number of programs at work in
the last minute, with the browser's own.
"""

import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import blas_threads  # noqa: F401 (before numpy)
from support.browser import Browser, browser

from wrsim.api.pages import write_live

WAYS = {"all the way": (-6.0, 8.0), "two patches": (4.9, 5.65), "conformal": (6.0, 6.7)}
FRAMES = """
    const [from, to, at] = %s, page = wrsim.page, times = { work: [], contacts: [], best: [], pictures: [] };
    page.hold('load'); page.set({ shift: 1e-3 * from }); page.loop.now();
    page.hold(at); if (at === 'height') page.set({ height: page.state.height - 5e-6 });
    const solve = page.solve;
    page.solve = function () { const begin = performance.now(), found = solve.call(this);
        times.contacts.push(performance.now() - begin); return found; };
    const count = Math.round((to - from) / 0.05), rounds = Math.max(4, 2 * Math.round(280 / count));
    let before = await new Promise(requestAnimationFrame);
    for (let i = 0; i < count * rounds; i++) {
        const k = i %% (2 * count), shift = from + 0.05 * Math.min(k, 2 * count - k);
        const begin = performance.now();
        page.set({ shift: 1e-3 * shift }); page.loop.now();
        times.work.push(performance.now() - begin);
        const place = Math.round(shift * 20 - from * 20);
        times.best[place] = Math.min(times.best[place] ?? Infinity, times.work.at(-1));
        const now = await new Promise(requestAnimationFrame);
        times.pictures.push(now - before); before = now;
    }
    page.solve = solve;
    const part = (t, share) => t.sort((a, b) => a - b)[Math.floor(share * t.length)];
    return Object.values(times).map((t) => [part(t, 0.5), part(t, 0.95)]);
"""

COACH = Path(__file__).parents[1] / "scenarios/manchester_r300.toml"
FAST = """
    const { live } = wrsim, best = [];
    for (let round = 0; round < 3; round++) {
        document.getElementById('again').click();
        await live.move(2000);
        live.worker.postMessage({ rate: 1e6 }); live.play(true);
        for (let k = 0; k < 9; k++) {
            const begin = performance.now(), time = live.frame.time;
            while (live.frame.time < time + 1) await new Promise((done) => setTimeout(done, 2));
            const rate = (live.frame.time - time) / (performance.now() - begin) * 1e3;
            best[k] = Math.max(best[k] ?? 0, rate);
        }
    }
    live.play(false);
    return [live.frame.time, best];
"""
SHOWN = """
    const { live } = wrsim;
    if (!%s) live.stage.render = () => {};
    document.getElementById('again').click();
    live.worker.postMessage({ rate: 1 }); live.play(true);
    await new Promise((done) => setTimeout(done, 2000));
    live.frames = [];
    const time = live.frame.time, begin = performance.now();
    await new Promise((done) => setTimeout(done, 8000));
    live.play(false);
    return [live.frames.length / 8, (live.frame.time - time) / (performance.now() - begin) * 1e3];
"""


def worker_time(opened: Browser) -> float:
    """Processor time of the threads in which programs of pages run [s]."""
    threads = [thread for process in opened.renderers() for thread in (process / "task").iterdir()]
    workers = [t for t in threads if (t / "comm").read_text().startswith("DedicatedWorker")]
    return sum(1e-9 * int((thread / "schedstat").read_text().split()[0]) for thread in workers)


def load() -> str:
    """The load now."""
    return f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"


with tempfile.TemporaryDirectory() as folder, browser() as opened:
    print(load())
    file = Path(folder) / "contact.html"
    write_live(["contact", "wheels/S1002.toml", "rails/60E1.toml"], file)
    opened.open(file, width=1280, height=900)
    opened.run("return wrsim.ready")
    print(f"{'':22s}{'work':>14s}{'contacts':>14s}{'best':>14s}{'pictures':>14s}   [ms] median / 95 %")
    for name, way in WAYS.items():
        for prescribed in ("load", "height"):
            rows = opened.run(f"return (async () => {{{FRAMES % str([*way, prescribed])}}})()")
            print(f"{f'{name}, {prescribed}':22s}" + "".join(f"{a:7.1f} /{b:5.1f}" for a, b in rows))
    print(load())
    write_live(str(COACH), file, step=1e-3)
    opened.open(file, width=1280, height=900)
    opened.run("return wrsim.ready.then(() => true)")
    begun = worker_time(opened)
    simulated, speeds = opened.run(f"return (async () => {{{FAST}}})()")
    used = (worker_time(opened) - begun) / (3 * simulated)
    speeds.sort()
    print(
        f"coach: {speeds[0]:.2f} to {speeds[-1]:.2f} simulated seconds a second, median {speeds[len(speeds) // 2]:.2f}"
    )
    print(f"coach: {used:.2f} s of processor time in a simulated second")
    for drawing, drawn in (("all that is drawn", "true"), ("without three dimensions", "false")):
        frames, rate = opened.run(f"return (async () => {{{SHOWN % drawn}}})()")
        print(f"coach, {drawing}: {frames:.1f} frames a second at {rate:.2f} times real time")
    print(load())
