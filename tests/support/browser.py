"""A headless Chromium for pages, without network."""

import io
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from matplotlib.image import imread

from support.waiting import wait_until

FLAGS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    # only WebGL passes through the processor's imitation of a graphics card, not the page around it
    "--disable-gpu-compositing", "--disable-gpu-rasterization", "--disable-accelerated-2d-canvas",
)  # fmt: skip
NAMES = ("chromium", "chromium-browser", "google-chrome")


class Browser:
    """Opens pages from disk and says what happened in them."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def open(self, page: Path, width: int = 900, height: int = 600) -> None:
        """Open a page at that size and wait until it has its width; messages of pages before are forgotten."""
        # the size of the page itself: that of a window is only asked for, and an asked one may be lost; every second
        # point of it is drawn
        size = {"width": width, "height": height, "deviceScaleFactor": 0.5, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.driver.get_log("browser")
        self.driver.get(page.resolve().as_uri())
        wait_until(lambda: self.run(f"return innerWidth === {width}"))
        # what listens to the change of width has been called before the second frame
        self.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")

    def wait(self, condition: str) -> None:
        """Wait until an expression in JavaScript is true."""
        wait_until(lambda: self.run(f"return {condition}"))

    def run(self, script: str) -> Any:
        """What a piece of JavaScript returns; one that returns a promise is waited for."""
        return self.driver.execute_script(script)

    def renderers(self) -> list[Path]:
        """Folders in /proc of the processes that run pages."""
        renderers, parents = [], {self.driver.service.process.pid}
        processes = [process for process in Path("/proc").iterdir() if process.name.isdigit()]
        for process in sorted(processes, key=lambda p: int(p.name)):
            try:
                parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
                if parent in parents:
                    parents.add(int(process.name))
                    if "--type=renderer" in (process / "cmdline").read_text():
                        renderers.append(process)
            except OSError:
                continue  # it has ended
        return renderers

    def complaints(self) -> list[str]:
        """Messages in the console since the page was opened, but for those of a driver about its own speed."""
        told = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] != "INFO"]
        return [message for message in told if "GL Driver Message (OpenGL, Performance" not in message]

    def colours(self, selector: str = "") -> int:
        """How many colours are seen in the window or in one element."""
        seen = self.driver.find_element("css selector", selector) if selector else None
        content = seen.screenshot_as_png if seen is not None else self.driver.get_screenshot_as_png()
        picture = (255.0 * imread(io.BytesIO(content))[..., :3]).astype(int)
        return len({tuple(c) for c in picture[::2, ::2].reshape(-1, 3).tolist()})


@contextmanager
def browser() -> Iterator[Browser]:
    """A browser; the test is skipped where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    program, driver = next(filter(None, map(shutil.which, NAMES)), None), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no Chromium with its driver here: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for flag in FLAGS:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    opened = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    try:
        opened.set_script_timeout(1200)  # for promises; the driver's own half minute is too short for busy machines
        opened.set_network_conditions(offline=True, latency=0, throughput=1)
        yield Browser(opened)
    finally:
        opened.quit()


def unexplained(browser: Browser) -> list[str]:
    """Controls of a page without a name, a title of theirs or of their group, or out of the keyboard's reach."""
    controls: list[str] = browser.run(
        "return [...document.querySelectorAll('button, input, select')].filter((e) => {"
        " const name = e.ariaLabel || [...e.labels].map((l) => l.textContent.trim()).join('') || e.textContent.trim();"
        " return !name || !e.closest('[title]') || e.tabIndex < 0 }).map((e) => e.outerHTML)"
    )
    return controls
