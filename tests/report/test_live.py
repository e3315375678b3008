"""The live page of the contact: the numbers of Python in a browser, what hands, keys and fingers do, what it may do."""

import json
import re
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from selenium.webdriver import ActionChains, Keys
from support.browser import Browser, browser, unexplained
from support.commands import refusal

from wrsim import InputError, WrsimError
from wrsim.api.pages import write_live
from wrsim.contact.batch import LOAD_TOLERANCE
from wrsim.contact.library.build import contact_wasm
from wrsim.contact.model import Contact
from wrsim.contact.models import contact_model
from wrsim.jit.cache import digest_of_sources
from wrsim.report.live_contact import MOST_PAIRS, LivePair

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing compiled")

ROOT = Path(__file__).parents[2]
PROFILES = ["wheels/S1002.toml", "rails/60E1.toml"]
SAME = 1e-9  # relative: the strip model is solved to that
POSES = 200
CLOSE = {"angle_min": 1.0, "angle_max": 1.0, "xi": 1e-3, "eta": 1e-3, "phi": 0.1}
"""Scales of numbers that may vanish; of forces that of the whole one."""


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, LivePair]:
    """The page of a new wheel on a new rail, and the pair."""
    file = tmp_path_factory.mktemp("live") / "contact.html"
    outcome = write_live(["contact", *PROFILES], file)
    assert outcome.files == [file] and file.stat().st_size < 2.5e6
    return file, outcome.value[0]


@pytest.fixture
def page(chromium: Browser, made: tuple[Path, LivePair]) -> Browser:
    """The page opened anew."""
    chromium.open(made[0], width=1280, height=900)
    chromium.run("return wrsim.ready")
    return chromium


def state(page: Browser) -> dict[str, float]:
    page_state: dict[str, float] = page.run("wrsim.page.loop.now(); return wrsim.page.state")
    return page_state


def show(page: Browser, **change: float) -> list[dict[str, float]]:
    """Numbers of both models at a state."""
    numbers: list[dict[str, float]] = page.run(
        f"wrsim.page.set({json.dumps(change)}); wrsim.page.loop.now(); return wrsim.page.numbers"
    )
    return numbers


def test_the_page_has_the_numbers_of_python_at_200_poses(page: Browser, made: tuple[Path, LivePair]) -> None:
    random = np.random.default_rng(57)
    least = dict(shift=-6e-3, yaw=-0.01, roll=-0.005, mu=0.0, xi=-5e-3, eta=-5e-3, phi=-0.5, load=2e4)
    most = dict(shift=8e-3, yaw=0.01, roll=0.005, mu=0.5, xi=5e-3, eta=5e-3, phi=0.5, load=1.2e5)
    drawn = random.uniform(list(least.values()), list(most.values()), (POSES // 2, len(least)))
    states = [dict(zip(least, row, strict=True)) for row in drawn.tolist()]
    # each at its load, then as an element of the same state 5 um deeper at a height
    contacts = json.loads(
        page.run(
            f"""const p = wrsim.page, told = [];
            for (const state of {json.dumps(states)}) {{
                p.at = 'load'; p.set(state); told.push(p.solve());
                p.at = 'height'; p.state.height = told.at(-1)[0].pose[2] - p.pair.radius - 5e-6; told.push(p.solve());
            }}
            return JSON.stringify(told, (name, value) => (name === 'cells' ? undefined : value))"""
        )
    )
    assert len(contacts) == POSES
    for m, settings in enumerate(made[1].settings.values()):
        model = contact_model(made[1].wheel, made[1].rail, made[1].radius, settings)
        touching = 0
        for i, solved in enumerate(contacts):
            told, numbers = solved[m], model.arrays.inputs
            numbers.mu = numbers.mu_gauge = states[i // 2]["mu"]
            contact = model.evaluate(*np.reshape(told["pose"], (4, 3)))
            assert told["status"] == contact.status
            assert_same(told, contact, SAME if i % 2 else LOAD_TOLERANCE)  # contacts at loads follow earlier ones
            if i % 2 == 0:
                assert told["Fb"] == pytest.approx(states[i // 2]["load"], rel=1.01e-8)  # as solve_many
            touching += bool(len(contact.patches))
        assert touching == POSES


def assert_same(told: dict[str, Any], contact: Contact, same: float = SAME) -> None:
    """Forces, lobes and strips within a relative tolerance."""
    force, moment = (float(np.linalg.norm(v)) for v in (contact.force, contact.moment))
    assert [told[n] for n in ("Ft", "Fo", "Fb")] == pytest.approx(contact.force, abs=same * force)
    assert [told[n] for n in ("Mt", "Mo", "Mb")] == pytest.approx(contact.moment, abs=same * moment)
    assert len(told["patches"]) == len(contact.patches)
    scales = CLOSE | dict.fromkeys(("N", "Fx", "Fy", "wear"), force)
    for lobe, patch, rows in zip(told["patches"], contact.patches, contact.strips, strict=True):
        if not patch["N"] > 0.0:
            assert lobe["N"] == patch["N"]
            continue
        for name in ("N", "Fx", "Fy", "p0", "area", "length", "width", "approach", "wear", *CLOSE):
            assert lobe[name] == pytest.approx(float(patch[name]), rel=same, abs=same * scales.get(name, 0.0)), name
        for name, scale in (("s", 1e-2), ("a", 1e-2), ("p", patch["p0"]), ("no", 1.0), ("N", force), ("Fy", force)):
            assert [row[name] for row in lobe["rows"]] == pytest.approx(rows[name], abs=10 * same * scale), name


def test_sliders_of_creepage_move_the_wheel_as_they_say(page: Browser) -> None:
    change = dict(xi=2e-3, eta=-3e-3, phi=0.4, shift=1e-3, yaw=4e-3, roll=1e-3)
    show(page, **change)
    pose, pair = page.run(
        "return [wrsim.page.contacts[0].pose, { ...wrsim.page.pair, wheel: 0, rail: 0, contacts: 0 }]"
    )
    origin, axle, velocity, omega = np.reshape(pose, (4, 3))
    assert np.linalg.norm(axle) == pytest.approx(1.0, abs=1e-15) and origin[1] == pytest.approx(pair["place"] + 1e-3)
    assert np.arctan2(-axle[0], axle[1]) == pytest.approx(4e-3) and np.arcsin(axle[2]) == pytest.approx(1e-3)
    speed = velocity[0]
    # the rim at the tape circle, beneath the axle, without the turning about the vertical
    spin = omega - [0.0, 0.0, 0.4 * speed]
    rim = pair["radius"] * np.linalg.norm(spin)
    assert spin / np.linalg.norm(spin) == pytest.approx(axle)
    assert (speed - rim) / speed == pytest.approx(2e-3) and velocity[1] / speed == pytest.approx(-3e-3)


def test_both_models_have_the_four_cases_of_the_paper(page: Browser) -> None:
    table = (ROOT / "docs/developers/static_paper.md").read_text()
    rows = [line for line in table.splitlines() if line.startswith("| with the stand-in wheel")]
    _, pressures, ranges = ([float(cell) for cell in row.split("|")[2:6]] for row in rows)
    for i, (p0, turn) in enumerate(zip(pressures, ranges, strict=True)):
        strips, paper = page.run(
            f"document.querySelectorAll('#cases button')[{i}].click(); wrsim.page.loop.now(); return wrsim.page.numbers"
        )
        assert paper["p0"] == pytest.approx(p0, abs=0.6) and paper["range"] == pytest.approx(turn, abs=0.006)
        assert paper["Q"] == pytest.approx(24.0) == strips["Q"]


def test_a_second_patch_appears_at_5_mm_and_turns_by_40_degrees_at_6_6(page: Browser) -> None:
    """The manual says so."""
    told = {shift: show(page, shift=1e-3 * shift)[0] for shift in (4.8, 4.9, 5.0, 5.6, 5.7, 6.0, 6.6, 7.0)}
    assert [numbers["patches"] for numbers in told.values()] == [1, 2, 2, 2, 1, 1, 1, 1]
    assert told[6.0]["range"] == pytest.approx(10, abs=0.5) and told[6.6]["range"] == pytest.approx(41, abs=0.5)
    assert told[6.0]["p0"] == pytest.approx(2550, abs=5) and told[6.6]["p0"] == pytest.approx(1360, abs=6)
    assert told[7.0]["p0"] > 4000.0


def test_all_slides_under_large_creepage_and_nothing_without(page: Browser) -> None:
    cells = "return wrsim.page.contacts.map((c) => c.patches.flatMap((p) => [...p.cells]))"
    show(page, shift=1e-3, xi=0.02)
    assert all(min(of) > 1.0 - 1e-9 for of in page.run(cells))
    show(page, shift=1e-3, xi=0.0, yaw=0.0)
    assert all(0.0 < np.mean(np.array(of) < 0.999) < 1.0 for of in page.run(cells))


def test_dragging_moves_loads_turns_and_lifts_the_wheel(page: Browser) -> None:
    section = page.driver.find_element("css selector", "#section")
    before = state(page)

    def drag(x: int, y: int, *, near: bool = False, turn: bool = False) -> dict[str, float]:
        chain = ActionChains(page.driver, duration=0)
        chain.move_to_element_with_offset(section, 0, 60 if near else -120)
        if turn:
            chain.key_down(Keys.SHIFT)
        chain.click_and_hold().move_by_offset(x, y).release()
        if turn:
            chain.key_up(Keys.SHIFT)
        chain.perform()
        return state(page)

    scales = "return wrsim.page.section.panels.map((panel) => panel.per)"
    far = page.run(scales)[0]
    after = drag(12, 8)
    assert after["shift"] - before["shift"] == pytest.approx(12e-3 / far)
    assert after["load"] - before["load"] == pytest.approx(250.0 * 8)
    page.run(f"wrsim.page.set({{ shift: {before['shift']} }}); wrsim.page.loop.now()")
    close = page.run(scales)[1]
    assert drag(10, 0, near=True)["shift"] - before["shift"] == pytest.approx(10e-3 / close)
    turned = drag(20, -10, turn=True)
    assert (turned["yaw"], turned["roll"]) == pytest.approx((2e-3, 1e-3))
    page.run("document.querySelector('[data-at=height]').click()")
    height = state(page)["height"]
    assert drag(0, -7)["height"] - height == pytest.approx(7e-6)
    assert len(page.run("return wrsim.page.record.rows")) > 4
    assert page.complaints() == []


def test_a_finger_moves_the_wheel_on_a_phone(chromium: Browser, made: tuple[Path, LivePair]) -> None:
    chromium.open(made[0], width=390, height=844)
    chromium.run("return wrsim.ready")
    assert chromium.run("return document.documentElement.scrollWidth <= innerWidth")
    assert unexplained(chromium) == []
    x, y = chromium.run(
        "const s = document.getElementById('section'); s.scrollIntoView();"
        " const b = s.getBoundingClientRect(); return [b.left + b.width / 2, b.top + 40]"
    )
    before, per = state(chromium)["shift"], chromium.run("return wrsim.page.section.panels[0].per")
    for kind, points in (("Start", [(x, y)]), ("Move", [(x + 20, y)]), ("End", [])):
        event = {"type": f"touch{kind}", "touchPoints": [{"x": a, "y": b} for a, b in points]}
        chromium.driver.execute_cdp_cmd("Input.dispatchTouchEvent", event)
    assert state(chromium)["shift"] - before == pytest.approx(20e-3 / per)
    assert chromium.complaints() == []


def test_the_keyboard_alone_reaches_and_moves_everything(page: Browser) -> None:
    assert unexplained(page) == []
    page.run("document.activeElement.blur()")
    reached = []
    for _ in range(40):
        ActionChains(page.driver, duration=0).send_keys(Keys.TAB).perform()
        reached.append(page.run("const e = document.activeElement; return e.id || e.ariaLabel || e.textContent"))
        if reached[-1] == "section":
            break
    assert {"pair", "shift", "load", "yaw", "roll", "mu", "xi", "eta", "phi", "a height", "turn", "10 mm"} <= set(
        reached
    )
    before = state(page)
    keys = ActionChains(page.driver, duration=0)
    keys.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_UP)
    keys.key_down(Keys.ALT).send_keys(Keys.ARROW_RIGHT).key_up(Keys.ALT).perform()
    after = state(page)
    assert after["shift"] - before["shift"] == pytest.approx(2e-4)
    assert after["load"] - before["load"] == pytest.approx(-1000.0) and after["yaw"] == pytest.approx(5e-4)
    page.wait("document.getElementById('said').textContent.startsWith('Shift 0.2 mm')")


def test_two_pages_compute_each_for_itself_and_keep_their_memory(page: Browser, made: tuple[Path, LivePair]) -> None:
    first, size = page.driver.current_window_handle, "return wrsim.page.program.call.memory.buffer.byteLength"
    alone = show(page, shift=5.2e-3)
    many = (
        "const { page } = wrsim; for (let i = 0; i < 200; i++) { page.state.shift = 3e-5 * i; page.solve(); }"
        " const { pose } = page.contacts[1]; for (let i = 0; i < 5000; i++) page.wheels[1].contact(pose);"
    )
    page.driver.switch_to.new_window("window")
    try:
        page.driver.get(made[0].resolve().as_uri())
        page.run("return wrsim.ready")
        before = page.run(size)
        page.run(many)
        assert page.run(size) == before
        second_page = show(page, shift=5.2e-3)
    finally:
        page.driver.close()
        page.driver.switch_to.window(first)
    assert show(page, shift=5.2e-3)[0]["p0"] == pytest.approx(alone[0]["p0"], rel=1e-7)
    assert second_page[0]["p0"] == pytest.approx(alone[0]["p0"], rel=1e-7)


def test_the_trace_is_saved_as_a_table(page: Browser) -> None:
    page.run("wrsim.page.record.rows = []")
    for shift in (1e-3, 2e-3, 3e-3):
        show(page, shift=shift)
    head, *rows = page.run("return wrsim.page.record.text").strip().split("\r\n")
    names = head.split(",")
    assert [float(row.split(",")[names.index("shift_mm") - len(names)]) for row in rows] == [1.0, 2.0, 3.0]
    assert {"p0_1", "p0_2", "range_1", "Q_2", "friction", "spin_per_m"} <= set(names)


def test_a_live_page_runs_its_own_program_alone_and_other_pages_none(
    chromium: Browser, made: tuple[Path, LivePair], tmp_path: Path
) -> None:
    text = made[0].read_text()
    assert "This page contains a program" in text
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy is not None and policy[1].startswith("default-src 'none'; base-uri 'none'; form-action 'none'")
    assert "connect-src" not in policy[1] and "unsafe-inline" not in policy[1]
    file = tmp_path / "contact.html"
    file.write_text(text.replace("</main>", "<script>window.evil = 1</script></main>", 1))
    chromium.open(file)
    chromium.run("return wrsim.ready")
    assert chromium.run("return window.evil === undefined && wrsim.page.numbers.length === 2")
    assert chromium.run("return fetch('data:,x').then(() => 'open', () => 'shut')") == "shut"
    assert all("Content Security Policy" in complaint for complaint in chromium.complaints())
    templates = files("wrsim.report").joinpath("templates")
    allowing = [part.name for part in templates.iterdir() if "wasm" in part.read_text().lower()]
    assert allowing == ["live.html"]


def test_files_of_another_kernel_are_refused_in_words(
    chromium: Browser, made: tuple[Path, LivePair], tmp_path: Path
) -> None:
    file = tmp_path / "contact.html"
    text = made[0].read_text()
    data = json.loads(re.search(r'id="data">(.*?)</script>', text, re.S)[1])  # type: ignore[index]
    first = data["pairs"][0]["contacts"][0]
    data["pairs"][0]["contacts"][0] = first[:-1]  # no checksum
    file.write_text(re.sub(r'(id="data">).*?(</script>)', lambda m: m[1] + json.dumps(data) + m[2], text, flags=re.S))
    chromium.open(file)
    chromium.wait("document.getElementById('remark').textContent.includes('the file is damaged')")
    chromium.complaints()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([PROFILES[0]], "no such scenario file"),
        (["contact", PROFILES[0]], "at least one wheel and one rail"),
        (["contact", "nothing.toml"], "nothing.toml"),
        (["contact", *PROFILES, "--inclination", "steep"], "--inclination"),
        ([str(ROOT / "scenarios/static_s1002.toml")], "only runs along the track"),
    ],
)
def test_what_is_no_page_is_told_in_one_line(arguments: list[str], expected: str, tmp_path: Path) -> None:
    message = refusal("live", *arguments, "-o", tmp_path / "x.html")
    assert expected in message and len(message.strip().splitlines()) == 1


def test_the_program_comes_with_the_package_and_else_needs_zig(
    made: tuple[Path, LivePair], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = contact_wasm()
    monkeypatch.setattr("wrsim.contact.library.build.CACHE", None)
    monkeypatch.setattr("wrsim.contact.library.build.find_spec", lambda name: None)
    with pytest.raises(WrsimError, match=r"^wasm: needs zig: pip install 'wrsim\[cross\]'$"):
        write_live(["contact", *PROFILES], tmp_path / "x.html")
    monkeypatch.setattr("wrsim.contact.library.build.SHIPPED", tmp_path)
    (tmp_path / "wasm").mkdir()
    shipped = tmp_path / "wasm/libwrsim_contact.wasm"
    shipped.write_bytes(program.replace(digest_of_sources().encode(), b"of other kernels"))
    with pytest.raises(WrsimError, match="needs zig"):
        write_live(["contact", *PROFILES], tmp_path / "x.html")
    shipped.write_bytes(program)
    write_live(["contact", *PROFILES], tmp_path / "x.html")
    assert (tmp_path / "x.html").read_bytes() == made[0].read_bytes()


def test_a_page_takes_so_many_pairs_and_no_more() -> None:
    wheels = ["S1002", "S1002_worn", "cone_1in20", "lrv_standin", "tram"]
    names = [
        *(f"wheels/{name}.toml" for name in wheels),
        *(f"rails/{name}.toml" for name in ("60E1", "54E1", "60E1_worn")),
    ]
    with pytest.raises(InputError, match=f"at most {MOST_PAIRS} pairs"):
        write_live(["contact", *names])
