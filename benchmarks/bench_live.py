"""How long a frame of the live page of the contact takes. Run: python benchmarks/bench_live.py

S1002 on 60E1 1:40 in a headless Chromium with drawing on the processor, dragged by 0.05 mm a frame under 60 kN: all the
way, over the two patches, over the conformal patch; and at a height. Milliseconds, median and 95 % of the frames: of
the work in the page (both contacts and all drawing), of the contacts in it, of the work in the fastest of the passes
over each place, which other load on the machine leaves alone, and from one picture to the next.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from support.browser import browser

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

with tempfile.TemporaryDirectory() as folder, browser() as opened:
    file = Path(folder) / "contact.html"
    write_live(["contact", "wheels/S1002.toml", "rails/60E1.toml"], file)
    opened.open(file, width=1280, height=900)
    opened.run("return wrsim.ready")
    print(f"{'':22s}{'work':>14s}{'contacts':>14s}{'best':>14s}{'pictures':>14s}   [ms] median / 95 %")
    for name, way in WAYS.items():
        for at in ("load", "height"):
            rows = opened.run(f"return (async () => {{{FRAMES % str([*way, at])}}})()")
            print(f"{f'{name}, {at}':22s}" + "".join(f"{a:7.1f} /{b:5.1f}" for a, b in rows))
