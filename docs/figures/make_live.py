"""Makes live_contact.png, live_wheelset.png, live_coach.png and live_tram.png, pictures of live pages in a Chromium.
Run: python docs/figures/make_live.py
"""

from __future__ import annotations

import io
import sys
import tempfile
from pathlib import Path

from PIL import Image

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "tests"))

from support.browser import Browser, browser  # noqa: E402

from wrsim import write_live  # noqa: E402

SIZE = {"width": 1280, "height": 940, "deviceScaleFactor": 1, "mobile": False}
DRAG = "for (let i = -60; i <= 132; i++) { wrsim.page.set({ shift: 5e-5 * i }); wrsim.page.loop.now(); }"
RUN = (
    "document.getElementById('wheel').value = 1; document.getElementById('wheel').dispatchEvent(new Event('change'));"
    "return wrsim.live.move(%d)"
)
SCENARIOS = HERE.parents[1] / "scenarios"
PICTURES: dict[str, tuple[str | list[str], str]] = {
    "live_contact": (["contact", "wheels/S1002.toml", "rails/60E1.toml"], DRAG),
    "live_wheelset": (str(SCENARIOS / "curve_r300.toml"), RUN % 8000),
    "live_coach": (str(SCENARIOS / "manchester_r300.toml"), RUN % 9000),
    "live_tram": (str(SCENARIOS / "tram_r25.toml"), RUN % 5600),
}
"""Of each page what it is made of, and what is done in it first."""
COLOURS = 256


def main() -> None:
    """Make the pages and take their pictures."""
    with tempfile.TemporaryDirectory() as folder, browser() as opened:
        for name, (files, act) in PICTURES.items():
            page = Path(folder) / f"{name}.html"
            write_live(files, page)
            print(picture(opened, page, act, HERE / f"{name}.png"))


def picture(opened: Browser, page: Path, act: str, target: Path) -> Path:
    """The picture of a page after an act."""
    opened.open(page, SIZE["width"], SIZE["height"])
    opened.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", SIZE)
    opened.run("return wrsim.ready.then(() => true)")
    opened.run(act)
    opened.run("return new Promise((done) => setTimeout(done, 1000))")
    seen = Image.open(io.BytesIO(opened.driver.get_screenshot_as_png())).convert("RGB")
    seen.quantize(COLOURS).save(target, optimize=True)
    return target


if __name__ == "__main__":
    main()
