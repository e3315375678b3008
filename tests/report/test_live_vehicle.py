"""The live page of a vehicle: its numbers are those of the stepper, what sliders change, keys, width, policy."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from selenium.webdriver import ActionChains, Keys
from support.browser import Browser, browser, unexplained
from support.objects import kept_objects
from support.vehicles import ROOT

from wrsim import SimulationError, WrsimError, load, stepper
from wrsim.analysis.motion.run import holding_stepper
from wrsim.api.pages import write_live
from wrsim.report.live_vehicle import Places
from wrsim.simulation.stepper import UNITS, Stepper

pytest.importorskip("ziglang")
pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing compiled")

FILE = ROOT / "scenarios/curve_r300.toml"
VALUES = {
    "track.structure": {"kind": "moving mass"}, "contact.strips": 12, "contact.cells": 8, "run.start_distance_m": 60.0,
    "run.distance_m": 50.0, "output.patches_at_m": [70.0],
}  # fmt: skip
SCENARIO = load(FILE).with_values(VALUES)
START, GONE = 60.0, 3000  # [m]; steps: from the transition into the curve
COACH_GONE = 9000  # from straight track into the curve
WIDTH = 640  # of the page


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wrsim.contact.library.build.emit_objects", kept_objects)
        written = write_live(str(FILE), tmp_path_factory.mktemp("live") / "live.html", values=VALUES)
    with browser() as opened:
        opened.open(Path(written.files[0]), WIDTH, 480)
        opened.run("return wrsim.ready.then(() => true)")
        yield opened


@pytest.fixture
def again(page: Browser) -> Browser:
    """The page at the start of the run, with the values that tests before have set."""
    page.run("wrsim.live.frame.time = -1; wrsim.live.play(false); document.getElementById('again').click()")
    page.wait("wrsim.live.frame.time === 0")
    return page


@pytest.fixture
def fresh(page: Browser) -> Browser:
    """The page loaded again: at the start of the run, with its own values."""
    page.run("location.reload()")
    page.wait("window.wrsim && wrsim.ready.then(() => true)")
    return page


def moved(page: Browser, steps: int) -> dict[str, Any]:
    return page.run(f"return wrsim.live.move({steps})")


def slide(page: Browser, label: str, value: float) -> None:
    page.run(
        f"const one = document.querySelector('[data-words=\"{label}\"] input'); one.value = {value};"
        "one.dispatchEvent(new Event('input'))"
    )


def differences(frame: dict[str, Any], bench: Stepper) -> dict[str, float]:
    """Largest difference from a stepper over the largest value, by kind of number."""
    pairs: dict[str, list[tuple[float, float]]] = {}
    for name, body in frame["bodies"].items():
        for key, value in body.items():
            view = bench.outputs[f"{name}.{key}_{UNITS[key]}"]
            pairs.setdefault(UNITS[key], []).append((value, float(view[0])))
    wheelsets = [mounted.name for mounted in bench.law.vehicle.wheelsets]
    for i, wheel in enumerate(frame["wheels"]):
        for key, value in wheel.items():
            of = f"{wheelsets[i // 2]}.{key}_{('left', 'right')[i % 2]}_N"
            pairs.setdefault("N", []).append((value, float(bench.outputs[of][0])))
    arrays = {unit: np.array(rows) for unit, rows in pairs.items()}
    return {unit: float(np.abs(a[:, 0] - a[:, 1]).max() / np.abs(a[:, 1]).max()) for unit, a in arrays.items()}


def test_a_page_has_the_numbers_of_the_stepper_into_the_curve(fresh: Browser) -> None:
    bench, memory = stepper(SCENARIO), fresh.run("return wrsim.live.memory")
    for _ in range(3):
        bench.step(GONE // 3)
        off = differences(moved(fresh, GONE // 3), bench)
    assert bench.outputs["wheelset.distance_m"] > 100.0
    assert max(off[unit] for unit in ("m", "m_s", "rad_s")) < 1e-9
    assert off["N"] < 1e-5 and off["rad"] < 1e-5
    assert fresh.complaints() == [] and fresh.run("return wrsim.live.memory") == memory


@pytest.mark.campaign
def test_a_coach_has_the_numbers_of_the_stepper_over_9_seconds(tmp_path: Path) -> None:
    """Into the curve, where the flange of the leading wheel begins to slide: forces magnify round-off there."""
    coach = ROOT / "scenarios/manchester_r300.toml"
    written, bench = write_live(str(coach), tmp_path / "coach.html", step=1e-3), stepper(coach)
    assert written.files[0].stat().st_size < 3e6
    with browser() as opened:
        opened.open(written.files[0], 1000, 700)
        opened.run("return wrsim.ready.then(() => true)")
        worst: dict[str, float] = {}
        for _ in range(3):  # the first on straight track, the others in the transition and in the curve
            bench.step(COACH_GONE // 3)
            for unit, off in differences(moved(opened, COACH_GONE // 3), bench).items():
                worst[unit] = max(off, worst.get(unit, 0.0))
        print({unit: f"{off:.1e}" for unit, off in worst.items()})
    assert bench.outputs["front.outer.Y_right_N"] > 2e4
    assert worst["m"] < 1e-9 and worst["m_s"] < 1e-7 and worst["rad"] < 1e-5
    assert worst["N"] < 1e-4


def test_friction_and_stiffness_act_as_in_the_workspace_of_a_stepper(fresh: Browser) -> None:
    bench = stepper(SCENARIO)
    places = Places(bench)
    friction = places.of_friction()
    assert len(friction["places"]) == 4 and friction["value"] == 0.35
    (stiff,) = (e for e in fresh.run("return wrsim.live.data.elements") if e["words"] == "stiffness of guide")
    moved(fresh, 1000)
    bench.step(1000)
    slide(fresh, "Friction of all rails", 0.1)
    slide(fresh, "stiffness of guide", 2.0)
    bench.memory.buffer[friction["places"]] = 0.1
    bench.memory.buffer[stiff["places"]] *= 2.0
    before = bench.outputs["wheelset.Y_left_N"].copy()
    bench.step(300)
    off = differences(moved(fresh, 300), bench)
    assert off["N"] < 1e-5
    plain = stepper(SCENARIO)
    plain.step(1300)
    assert abs(plain.outputs["wheelset.Y_left_N"] - bench.outputs["wheelset.Y_left_N"]) > 0.01 * abs(before)


def test_a_step_that_is_too_long_is_halved_until_the_forces_are_in_balance() -> None:
    """The guard face of a grooved rail meets the wheel after 1.2 s."""
    tram = load(ROOT / "scenarios/tram_r25.toml").with_values({"run.distance_m": 7.0})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wrsim.analysis.motion.run.HALVINGS", 0)
        with pytest.raises(SimulationError, match="no step down to 1 ms holds"):
            holding_stepper(tram)
    bench = holding_stepper(tram)
    assert bench.step_size == 0.5e-3 and bench.time == 0.0
    assert holding_stepper(load(FILE).with_values({"run.distance_m": 15.0})).step_size == 1e-3


def test_a_vehicle_that_diverges_is_stopped_and_told(fresh: Browser) -> None:
    fresh.run(
        "const { live } = wrsim, { elements } = live.data;"
        "const pairs = elements.flatMap((e) => e.places.map((p, k) => [p, 1e5 * e.values[k]]));"
        "live.worker.postMessage({ set: pairs }); live.play(true)"
    )
    fresh.wait("document.getElementById('remark').textContent.includes('The run has ended at')")
    told = fresh.run("return document.getElementById('remark').textContent")
    assert "without balance" in told or "left its track" in told
    assert "--step-ms 0.5" in told
    fresh.wait("!wrsim.live.playing")


def test_the_speed_changes_evenly_to_the_one_that_is_asked_for(fresh: Browser) -> None:
    slide(fresh, "Speed", 3.6 * 14.0)  # from 15 m/s, by 1 m/s2
    moved(fresh, 500)
    assert fresh.run("return wrsim.live.frame.speed") == pytest.approx(14.5, abs=1e-3)
    frame = moved(fresh, 1500)
    assert fresh.run("return wrsim.live.frame.speed") == pytest.approx(14.0, abs=1e-9)
    way = 15.0 * 1.0 - 0.5 * 1.0 + 14.0 * 1.0
    assert frame["bodies"]["wheelset"]["distance"] == pytest.approx(START + way, abs=0.05)


def test_keys_alone_run_step_and_begin_again(again: Browser) -> None:
    def press(key: str) -> None:
        again.run(f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }}))")

    press(" ")
    again.wait("wrsim.live.playing && wrsim.live.frame.time > 0.05")
    press(" ")
    again.wait("!wrsim.live.playing")
    moved(again, 1)
    time = again.run("return wrsim.live.frame.time")
    press(".")
    again.wait(f"Math.abs(wrsim.live.frame.time - {time} - 0.001) < 1e-9")
    press("Home")
    again.wait("wrsim.live.frame.time === 0")


def test_the_keyboard_alone_reaches_everything_that_acts(again: Browser) -> None:
    assert unexplained(again) == []
    again.run("document.querySelectorAll('details').forEach((d) => (d.open = true)); document.activeElement.blur()")
    wanted = again.run(
        "return [...document.querySelectorAll('button, select, input, summary')].filter((e) => e.offsetParent).length"
    )
    reached = []
    for _ in range(wanted):
        ActionChains(again.driver, duration=0).send_keys(Keys.TAB).perform()
        reached.append(again.run("return document.activeElement"))
    assert len({element.id for element in reached}) == wanted
    play = again.driver.find_element("id", "play")
    play.send_keys(Keys.SPACE)
    again.wait("wrsim.live.playing && wrsim.live.frame.time > 0.02")
    play.send_keys(Keys.SPACE)
    again.wait("!wrsim.live.playing")
    slider = again.driver.find_element("css selector", "[data-words^=Friction] input")
    before = float(slider.get_property("value"))
    slider.send_keys(Keys.ARROW_RIGHT)
    assert float(slider.get_property("value")) > before


def test_a_finger_runs_the_vehicle_and_turns_the_camera(again: Browser) -> None:
    size = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    again.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    again.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
    again.wait("innerWidth === 390")

    def touch(element: str, *by: int) -> None:
        x, y = again.run(
            f"const e = document.getElementById('{element}'); e.scrollIntoView({{ block: 'center' }});"
            "const b = e.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]"
        )
        steps = [("Start", [(x, y)]), *(("Move", [(x + way, y)]) for way in by), ("End", [])]
        for kind, points in steps:
            event = {"type": f"touch{kind}", "touchPoints": [{"x": a, "y": b} for a, b in points]}
            again.driver.execute_cdp_cmd("Input.dispatchTouchEvent", event)

    try:
        angle = "return wrsim.live.stage.controls.getAzimuthalAngle()"
        before = again.run(angle)
        touch("stage", 20, 40)
        assert abs(again.run(angle) - before) > 0.1
        touch("play")
        again.wait("wrsim.live.playing && wrsim.live.frame.time > 0.02")
    finally:
        again.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})
        again.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size | {"width": WIDTH, "mobile": False})


def test_two_pages_run_each_for_itself(fresh: Browser) -> None:
    first, address = fresh.driver.current_window_handle, fresh.driver.current_url
    fresh.driver.switch_to.new_window("window")
    try:
        fresh.driver.get(address)
        fresh.run("return wrsim.ready.then(() => true)")
        slide(fresh, "Friction of all rails", 0.1)
        assert moved(fresh, 400)["time"] == pytest.approx(0.4)
    finally:
        fresh.driver.close()
        fresh.driver.switch_to.window(first)
    bench = stepper(SCENARIO)
    bench.step(200)
    frame = moved(fresh, 200)
    assert frame["time"] == pytest.approx(0.2)
    assert differences(frame, bench)["N"] < 1e-9


def test_a_long_run_keeps_so_many_samples_and_is_saved_whole(again: Browser) -> None:
    moved(again, 300)
    head, *rows = again.run("return wrsim.live.csv().text()").strip().splitlines()
    assert head.startswith("time_s,distance_m,Y_over_Q_wheelset_left,")
    table = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    assert table[:, 0] == pytest.approx(np.arange(0.0, 0.305, 0.01))
    kept = again.run("""const live = wrsim.live, row = live.time.length * 3;
        const width = 1 + live.data.bodies.length * live.data.places.bodies.names.length
            + live.data.places.wheels.length * live.data.places.forces.names.length;
        for (let i = 0; i < row; i++) live.keep([Array.from({ length: width }, (_, k) => (k ? 1 : 100 + i))]);
        const times = live.time.subarray(0, live.count);
        return [live.count, live.time.length, times.every((t, i) => !i || t > times[i - 1]), times.at(-1) - row]""")
    assert kept[0] <= kept[1] and kept[2] and kept[3] > 90


def test_the_end_of_the_track_begins_the_run_again(again: Browser) -> None:
    again.run(f"wrsim.live.worker.postMessage({{ end: {START + 1.0} }}); wrsim.live.play(true)")
    again.wait("document.getElementById('remark').textContent.includes('Again from the start')")
    again.run("wrsim.live.play(false)")


def test_a_narrow_page_needs_no_scrolling_sideways_and_is_drawn(again: Browser) -> None:
    moved(again, 200)
    again.run("const w = document.getElementById('wheel'); w.value = 1; w.dispatchEvent(new Event('change'))")
    again.wait("wrsim.live.frame.wheel === 1")
    assert "N " in again.run("return document.getElementById('section').getAttribute('aria-label')")
    for name in ("section", "stage", "history"):
        assert again.colours(f"#{name}") > 10
    size = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    again.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    again.wait("innerWidth === 390")
    assert again.run("return document.documentElement.scrollWidth <= innerWidth")


def test_a_live_page_has_a_policy_of_its_own_and_needs_a_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wrsim.report.live_vehicle.unit_program", lambda *arguments: b"program")
    text = Path(write_live(str(FILE), tmp_path / "live.html", values=VALUES).files[0]).read_text(encoding="utf-8")
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert "default-src 'none'" in policy and "'wasm-unsafe-eval'" in policy and "worker-src blob:" in policy
    assert "http" not in policy and "unsafe-inline" not in policy and "connect-src" not in policy
    assert "This page contains a program" in text
    monkeypatch.undo()
    monkeypatch.setattr("wrsim.contact.library.build.find_spec", lambda name: None)
    with pytest.raises(WrsimError, match=r"^wasm: needs zig: pip install 'wrsim\[cross\]'$"):
        write_live(str(FILE), tmp_path / "another.html", values=VALUES)
    assert not (tmp_path / "another.html").exists()
