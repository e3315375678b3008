"""The report: what stands in it, that it needs nothing else, and what it does in a browser."""

import base64
import hashlib
import json
import os
import re
import sys
import zlib
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from math import radians
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from markupsafe import escape
from support.browser import Browser, browser, unexplained
from support.commands import call
from support.pictures import leave_unpainted
from support.runs import FAST, SCENARIOS, arc, straight, transition
from support.synthetic_result import curve_run, static_poses
from support.synthetic_run import Q0, run
from support.synthetic_run import curve as bend

from wrsim import InputError, Result, analysis, load
from wrsim.analysis.motion.derailment import WatchedWheel
from wrsim.analysis.resolve import with_moments
from wrsim.assessment.assess import assess_runs
from wrsim.assessment.settings import AssessmentSettings
from wrsim.contact.records import STATUS_NOT_CONVERGED
from wrsim.contact.status import WORDS
from wrsim.inputs.lookup import shipped_models
from wrsim.report.charts import envelope, interruptions, pieces_of
from wrsim.report.document import find_browser, logo_address, printed
from wrsim.report.page import report_page
from wrsim.report.tables import chart_limits
from wrsim.report.tables import contacts as contacts_of
from wrsim.report.view_data import PATH_STEP, needed, setup_of, view_data, view_page
from wrsim.results import CHANNELS
from wrsim.results.moments import sample_of
from wrsim.results.summary import CUT_STEPS
from wrsim.results.wheelsets import wheelsets

EVIL = "</script><script>window.evil = 1</script><img src=x onerror='window.evil=1'>\"'&{{ 7*7 }}"


def page_of(*results: Result, sources: tuple[str, ...] = ()) -> str:
    names = sources or tuple(f"run{i}" for i in range(len(results)))
    return report_page(results, names)


SEGMENTS = [straight(20.0), transition(20.0), arc(15.0, 300.0, 100.0), transition(12.0), straight(10.0)]


@pytest.fixture(scope="module")
def coach() -> Result:
    """A coach through a short curve."""
    keys = {"track.segments": SEGMENTS, "run.distance_m": 54, "output.patches_at_m": [35]}
    scenario = load(SCENARIOS / "manchester_r300.toml")
    return analysis.run(scenario.with_values(FAST | {"contact.strips": 20} | keys))


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def curve() -> Result:
    return Result(curve_run())


@pytest.fixture(scope="module")
def page(coach: Result) -> str:
    with pytest.MonkeyPatch.context() as patch:
        leave_unpainted(patch)
        return page_of(coach)


class Structure(HTMLParser):
    """Ids, links, tables without heads, drawings without words."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.mute: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        attributes = dict(attrs)
        self.ids += [attributes["id"] or ""] if "id" in attributes else []
        self.links += [attributes["href"] or ""] if "href" in attributes else []
        if tag == "img" and not attributes.get("alt"):
            self.mute.append(self.get_starttag_text() or "")
        if tag == "svg" and attributes.get("role") == "img" and not attributes.get("aria-label"):
            self.mute.append(self.get_starttag_text() or "")


@given(st.integers(1, 3000), st.integers(0, 2**32 - 1))
def test_every_piece_holds_its_least_and_its_largest_value(samples: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places, values = np.sort(rng.uniform(-3.0, 500.0, samples)), rng.normal(size=samples)
    pieces = pieces_of([places])
    for low, high, extremes in zip(
        pieces[:-1], pieces[1:], envelope(places, values, pieces).reshape(-1, 2), strict=True
    ):
        inside = values[(places >= low) & ((places < high) | (high == pieces[-1]))]
        assert not inside.size or sorted(extremes) == [inside.min(), inside.max()]


def test_an_envelope_rises_and_falls_with_its_curve_and_has_no_values_where_that_has_none() -> None:
    places = np.linspace(0.0, 100.0, 5001)
    pieces = pieces_of([places])
    assert (np.diff(envelope(places, places, pieces)) > 0.0).all()
    assert (np.diff(envelope(places, -places, pieces)) < 0.0).all()
    places = np.linspace(0.0, 10.0, 101)
    values = np.where((places > 4.0) & (places < 6.0), np.nan, 1.0)
    pieces = pieces_of([places, np.linspace(0.0, 20.0, 101)])
    lower = envelope(places, values, pieces).reshape(-1, 2)[:, 0]
    middles = 0.5 * (pieces[:-1] + pieces[1:])
    assert np.isnan(lower[(middles > 4.3) & (middles < 5.7)]).all()
    assert np.isnan(lower[middles > 10.5]).all() and np.isfinite(lower[middles < 3.7]).all()


@given(st.lists(st.integers(1, 298), max_size=4, unique=True), st.lists(st.integers(1, 298), max_size=4, unique=True))
@example(starts=[], lost=[116, 117])  # a whole piece: what is not drawn may count as interrupted or not
def test_lines_end_where_contact_jumps_or_is_lost(starts: list[int], lost: list[int]) -> None:
    places, values = np.linspace(0.0, 100.0, 300), np.ones(300)
    values[lost] = np.nan
    pieces = pieces_of([places])  # of two samples
    drawn = envelope(places, values, pieces)
    ends = interruptions(places, values, np.array(sorted(starts), dtype=np.intp), pieces)
    for k in range(0, 299, 2):  # both samples of a piece, with what may lie between them
        if np.isnan(values[[k, k + 1]]).all():
            assert np.isnan(drawn[[k, k + 1]]).all()
        else:
            assert (k in ends) == (k + 1 in starts and np.isfinite(values[[k, k + 1]]).all())
    for k in range(1, 297, 2):  # the last of one piece and the first of the next
        before, after = (np.flatnonzero(np.isfinite(values[k - 1 + j : k + 1 + j])) + k - 1 + j for j in (0, 2))
        if before.size and after.size:
            between = range(before[-1] + 1, after[0] + 1)
            assert (k in ends) == (any(s in starts for s in between) or after[0] > before[-1] + 1)
        else:
            assert np.isnan(drawn[[k, k + 1]]).any()


@given(st.integers(2, 60), st.integers(0, 2**32 - 1))
def test_a_drawn_line_passes_all_its_points(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = np.sort(rng.uniform(0.0, 900.0, count)), rng.uniform(0.0, 200.0, count)
    drawn = np.column_stack((x, y))[needed(x, y, 0.15)]
    start, along = drawn[:-1], np.diff(drawn, axis=0)
    for point in np.column_stack((x, y)):
        share = ((point - start) * along).sum(1) / np.maximum((along**2).sum(1), 1e-12)
        nearest = start + np.clip(share, 0.0, 1.0)[:, None] * along
        assert np.hypot(*(point - nearest).T).min() <= 0.15 + 1e-9  # as far as a point left out may lie beside it


def test_a_report_says_who_it_is_how_it_went_and_from_which_bytes_it_came(page: str, coach: Result) -> None:
    assert f"<h1>{coach.title}</h1>" in page
    verdict = "Every quantity with a limit is within its limit; without a limit or a value here: "
    assert re.search(rf'class="verdict open">{verdict}[^<]*Y_qst[^<]*worst margin -?\d+ %', page), "no green"
    for section in ("summary", "appendix", "assessment", "track", "histories", "wheelsets", "contacts", "again"):
        assert f'<section id="{section}"' in page
    assert '<section id="wear"' not in page
    assert "wrsim run scenario.toml" in page and escape(coach.dataset.attrs["scenario_text"]) in page
    for name, digest in json.loads(coach.dataset.attrs["inputs"]).items():
        assert name in page and digest in page
    digests = json.loads(coach.dataset.attrs["inputs"])
    wheel = shipped_models() / "wheels/S1002.toml"
    assert digests["wheels/S1002.toml"] == hashlib.sha256(wheel.read_bytes()).hexdigest()
    assert {"manchester_r300.toml", "vehicles/manchester_1.toml", "rails/60E1.toml"} <= set(digests)


@pytest.mark.usefixtures("unpainted")
def test_a_lone_wheelset_gets_no_verdict() -> None:
    assessed = run(900.0, curvature=bend(300.0), y=lambda s: (0.2 * Q0 + 0.0 * s, 65e3 + 20.0 * s))
    text = page_of(assessed, sources=("/home/somebody/runs/first/result.nc",))
    assert 'id="assessment"' in text
    assert re.search(r'class="verdict open">No verdict: rules assess', text)
    assert "/home/somebody" not in text and "EXCEEDED" not in text


@pytest.mark.usefixtures("unpainted")
def test_a_stopped_run_says_so_first_and_steps_of_the_solver_are_no_events(curve: Result) -> None:
    result = Result(curve_run(stopped=True))
    text = page_of(result)
    assert re.search(r'class="verdict bad">Stopped early: derailment', text)
    assert "stopped: derailment" in text[text.index('id="events"') :]
    places = {f"event_{name}": ("event", [1.0, 2.0]) for name in ("time", "distance")}
    labels = ("event", [f"{CUT_STEPS} for 0.00 m, 0 ms", "bump stop x is beyond the end of its table"])
    text = page_of(Result(curve.dataset.assign(places | {"event_label": labels})))
    assert "bump stop x" in text and CUT_STEPS not in text


@pytest.mark.usefixtures("unpainted")
def test_what_bends_and_the_spectra_of_fast_channels_have_a_section(curve: Result) -> None:
    assert "Vibrations" not in page_of(curve)
    plain = run(100.0).dataset
    time = np.arange(0.0, 4.0, 5e-4)
    force = Q0 + 1e3 * np.sin(2.0 * np.pi * 250.0 * time[:, None, None]) * np.ones((1, 1, 2))
    fast = {"fast_Q": (("fast_time", "wheelset", "wheel"), force), "bent_place": ("rail_node", np.arange(5.0))}
    bent = fast | {"bent_rail": (("rail_node", "wheel"), np.zeros((5, 2)))}
    places = {"fast_time": time, "fast_distance": ("fast_time", 20.0 * time)}
    about = plain.attrs | {"bent_by": "wheelset left", "bent_at_m": 2.0}
    text = page_of(Result(plain.assign(bent).assign_coords(places).assign_attrs(about)))
    section = text[text.index('<section id="vibrations"') :].partition("</section>")[0]
    assert section.count("<figure>") == 3 and "rails and axles, magnified" in section
    assert "Vertical force" in section and "<td>250</td>" in section


@pytest.mark.usefixtures("unpainted")
def test_a_report_has_a_cover(curve: Result, tmp_path: Path) -> None:
    Result(curve_run(samples=40)).save(tmp_path / "run" / "result.nc")
    (tmp_path / "logo.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"/>')
    cover = {"--title": EVIL, "--author": "A. Author", "--company": 'A "B" \\ </style> Ltd.', "--date": "today"}
    options = [part for pair in cover.items() for part in pair]
    assert call("report", tmp_path / "run", "--logo", tmp_path / "logo.svg", *options).exit_code == 0
    text = (tmp_path / "run" / "report.html").read_text()
    assert "A. Author" in text and "data:image/svg+xml;base64" in text and "<script>window.evil" not in text
    style = text[text.index("<style>") : text.index("</style>")]
    assert "@page" in style and "Ltd" in style and text.count("</style>") == 1
    refused = call("report", tmp_path / "run", "--logo", tmp_path / "run" / "result.nc")
    assert refused.exit_code == 2 and "must end in" in refused.output


def test_limits_are_drawn_where_they_hold_with_that_of_nadal_beside_them() -> None:
    """That of EN 14363 from R 250 m on."""
    assessment = assess_runs(
        run(900.0, curvature=bend(200.0)),
        AssessmentSettings(axle_load=2.0 * Q0, friction=0.3, flange_angle=radians(70.0)),
    )
    limits = chart_limits([assessment])
    (standard,), (nadal,) = ([o for o in limits["Y_over_Q"] if o["label"].startswith(w)] for w in ("limit", "Nadal"))
    assert {start for start, _ in standard["spans"]} == {s.start for s in assessment.sections if abs(s.radius) >= 250.0}
    assert (
        {start for start, _ in nadal["spans"]}
        == {s.start for s in assessment.sections}
        > {s for s, _ in standard["spans"]}
    )
    assert {limit["value"] < 0.0 for limit in limits["sum_Y"]} == {True, False}
    assert "Y/Q" in assessment.unlimited and "ΣY" not in assessment.unlimited


PICTURES = {
    "a.png": b"\x89PNG\r\n\x1a\n", "a.jpg": b"\xff\xd8\xff\xe0", "a.JPEG": b"\xff\xd8\xff",
    "a.webp": b"RIFF\x04\x00\x00\x00WEBP",
    "a.svg": b"<?xml version='1.0'?>\n<!-- made -->\n<!DOCTYPE svg [<!ENTITY a 'b'>]>\n<svg/>",
}  # fmt: skip


def test_a_report_is_printed_by_the_browser_that_there_is(curve, tmp_path, monkeypatch) -> None:
    page = "<!doctype html><p>one</p><p style='break-before: page'>two</p>"
    document = printed(page, find_browser(tmp_path / "report.pdf"), tmp_path / "report.pdf")
    assert document.startswith(b"%PDF") and len(re.findall(rb"/Type ?/Page\b", document)) == 2
    curve.save(tmp_path / "result.nc")
    assert "--view" in call("report", tmp_path, "-o", tmp_path / "report.pdf", "--view").stderr
    monkeypatch.setenv("PATH", str(tmp_path))
    told = call("report", tmp_path, "-o", tmp_path / "report.pdf").stderr
    assert "needs Chromium" in told and "report.html" in told and not (tmp_path / "report.pdf").exists()
    (tmp_path / "chromium").write_text("#!/bin/sh\necho no display >&2\nexit 1\n")
    (tmp_path / "chromium").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    assert "did not print the page: no display" in call("report", tmp_path, "-o", tmp_path / "report.pdf").stderr


def test_a_logo_is_a_picture_of_the_kind_that_its_name_says_and_is_never_waited_for(tmp_path: Path) -> None:
    for name, content in PICTURES.items():
        (tmp_path / name).write_bytes(content)
        assert logo_address(tmp_path / name).startswith("data:image/")
    odd = dict.fromkeys(PICTURES, b"just text") | {"b.png": PICTURES["a.jpg"], "c.svg": b"<html><svg/></html>"}
    odd |= {"d.svg": b"<!---->" * 100_000, "e.png": b"", "f.png": PICTURES["a.png"].ljust(2_000_001)}
    for name, content in odd.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=rf"^--logo .*{name}: (is no \w+ picture|has \d+ bytes)"):
            logo_address(tmp_path / name)
    kinds = {"none": "no such picture"}
    if sys.platform != "win32":
        os.mkfifo(tmp_path / "pipe.png")
        (tmp_path / "zero.png").symlink_to("/dev/zero")
        kinds |= {"pipe": "a pipe", "zero": "a device"}
    for name, kind in kinds.items():
        with pytest.raises(InputError, match=rf"^--logo .*{name}\.png: (is )?{kind}"):
            logo_address(tmp_path / f"{name}.png")


def test_nothing_comes_from_elsewhere_every_drawing_has_words_and_every_link_a_place(page: str) -> None:
    for address in re.findall(r"""(?:src|href|action|data|poster)\s*=\s*["']([^"']*)""", page):
        assert address.startswith(("#", "data:")), address
    assert not re.findall(r"url\((?!['\"]?(?:data:|#))|@import", page)
    addresses = set(re.findall(r"https?://[^\s\"'<>)]+", page))
    assert not {a for a in addresses if "www.w3.org" not in a}
    policy = re.findall(r'Content-Security-Policy" content="([^"]*)"', page)[0]
    assert "default-src 'none'" in policy and "script-src 'sha256-" in policy
    structure = Structure(page)
    assert not structure.mute
    assert len(structure.ids) == len(set(structure.ids))
    assert {link[1:] for link in structure.links} <= set(structure.ids)
    assert '<html lang="en">' in page


@pytest.mark.usefixtures("unpainted")
def test_texts_of_users_are_escaped(curve: Result) -> None:
    attributes = {"title": EVIL, "scenario_text": f"# {EVIL}", "inputs": '{"<b>x</b>": "00"}'}
    evil = replace(curve, dataset=curve.dataset.assign_attrs(attributes))
    text = page_of(evil, evil, sources=(f"{EVIL}/a", "b"))
    assert "<script>window.evil" not in text and "<img src=x" not in text and "<b>x</b>" not in text
    assert "{{ 7*7 }}" in text and "49" not in text[text.index("<h1>") : text.index("</h1>")]


@pytest.mark.usefixtures("unpainted")
def test_two_results_are_set_against_each_other_with_wheelsets_from_the_front(curve: Result, page: str) -> None:
    """The second has Q of the right wheel 10 % larger, another speed, and another name of its wheelset."""
    compared = curve.dataset.copy(deep=True)
    compared["Q"].loc[{"wheel": "right"}] *= 1.1
    text = compared.attrs["scenario_text"] = compared.attrs["scenario_text"] + "\n[asked]\nspeed_kmh = 99\n"
    compared = compared.assign_coords(wheelset=["lead"] if "wheelset" in compared.dims else "lead")
    comparison = page_of(curve, Result(compared))
    body = comparison[: comparison.index(str(escape(text)))]  # the scenarios themselves are below
    assert body.count("asked.speed_kmh: not given in A, 99 in B") == 1
    assert body.count("wheelsets are matched from the front: wheelset and lead") == 1
    assert body.count("<article") == 1  # one card, of both
    (largest,) = re.findall(r'<th scope="row">max Q \[kN\]</th>(.*?)</tr>', body, re.DOTALL)
    assert re.findall(r"<td>(.*?)</td>", largest)[-2:] == ["0.0", "10.0"]
    assert "<td>10</td>" in body[body.index('id="differences"') :]
    assert 'id="differences"' in comparison and 'id="differences"' not in page


def test_contacts_have_a_picture_and_numbers_of_every_patch_in_contact(page: str, coach: Result) -> None:
    contacts = page[page.index('id="contacts"') : page.index('id="ride"')]
    in_contact = np.isfinite(coach.dataset["strip_p"].values).any(axis=-1).sum()
    assert len(re.findall(r"<td>(?:left|right), \w+ patch</td>", contacts)) == in_contact
    wheel = coach.wheelset("front.outer").sel(wheel="left")
    snapshot = int(np.argmin(np.abs(wheel["time"].values - wheel["snapshot_time"].values[0])))
    row = next(row for row in contacts_of(coach.wheelset("front.outer"), [0]).rows if row[1].startswith("left, "))
    assert row[2:4] == pytest.approx([1e-3 * wheel["N"].values[snapshot, 0], 1e-6 * wheel["p0"].values[snapshot, 0]])
    for label in ("1 front.outer", "4 rear.outer"):
        assert f'alt="{label} wheel on rail"' in contacts and f'alt="{label} patches from above"' in contacts


def test_the_bundles_can_stand_in_a_page() -> None:
    folder = Path(__file__).parents[2] / "wrsim/report/bundle"
    for file in folder.glob("*.js"):
        assert "</script" not in file.read_text(), file
    assert "MIT" in (folder / "licences.txt").read_text()


@pytest.fixture(scope="module")
def opened(chromium: Browser, page: str, tmp_path_factory: pytest.TempPathFactory) -> Browser:
    """The report of the run."""
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(page)
    chromium.open(file)
    return chromium


def test_paper_has_pictures_of_the_height_of_their_pages_and_the_screen_keeps_its_own(opened: Browser) -> None:
    """Pages begin where the layout says; between two of them lie at most the 259 mm between the margins of A4."""
    inline = "return [...document.querySelectorAll('figure img')].filter((img) => img.style.height).length"
    assert opened.run(inline) == 0
    opened.run("dispatchEvent(new Event('beforeprint'))")
    heights = opened.run(
        "return [...document.querySelectorAll('figure img')].map((img) => parseFloat(img.style.height) * 25.4 / 96)"
    )
    assert len(heights) > 6 and all(0.0 < height <= 259.0 for height in heights if height is not None)
    tops = opened.run("return document.querySelectorAll('.page-top').length")
    assert tops >= sum(filter(None, heights)) / 259.0 - 1.0
    opened.run("dispatchEvent(new Event('afterprint'))")
    assert opened.run(inline) == 0 and opened.run("return document.querySelectorAll('.page-top').length") == 0
    assert opened.complaints() == []


def test_the_charts_answer_with_the_envelope_of_the_dataset(opened: Browser, coach: Result) -> None:
    for s in (5.3, 33.1, 47.7):
        readings = opened.run(f"return wrsim.seek({s})")
        assert readings["from"] <= s <= readings["to"] + 1e-9
        for name in wheelsets(coach.dataset):
            wheelset = coach.wheelset(name)
            inside = (wheelset["distance"] >= readings["from"]) & (wheelset["distance"] < readings["to"])
            if not inside.any():  # a value between two samples
                continue
            for key, factor in (("Y", 1e-3), ("Q", 1e-3), ("lateral_shift", 1e3), ("yaw", 1e3)):
                lines = [line for line in readings["values"][key] if line["part"] == name]
                values = wheelset[key].values[inside.values].reshape(int(inside.sum()), -1) * factor
                for line, of in zip(lines, values.T, strict=True):
                    assert line["low"] == pytest.approx(of.min(), rel=1e-4, abs=1e-6)
                    assert line["high"] == pytest.approx(of.max(), rel=1e-4, abs=1e-6)
    assert opened.run("return document.querySelectorAll('.uplot canvas').length") >= 6
    # one cursor over all charts: the legend of each tells the values there
    told = opened.run("return [...document.querySelectorAll('.panels > div')].map((panel) => panel.textContent)")
    places = [float(legend.split("place")[1].lstrip(":").split(" m")[0]) for legend in told]
    assert len(places) > 6 and all(readings["from"] <= s <= readings["to"] for s in places)
    assert any("1 front.outer" in legend and "right" in legend for legend in told)
    assert opened.run("return document.documentElement.scrollWidth <= innerWidth")
    # ticks of an axis are all different, and none is a zero with a sign
    ticks = opened.run("return wrsim.ticks([-0.0025, -1e-18, 0.0025, 0.005], 0.0025)")
    assert ticks == ["\u22120.0025", "0.0000", "0.0025", "0.0050"]
    assert opened.run("return wrsim.ticks([0, 20, 40], 20)") == ["0", "20", "40"]
    opened.run("document.querySelector('.uplot').scrollIntoView()")
    assert opened.colours(".uplot") > 4
    assert opened.run("return document.querySelector('.drawn').offsetHeight") == 0
    # without scripts, and printed, histories are pictures
    opened.run("document.documentElement.classList.remove('live')")
    assert opened.run("return document.querySelector('.chart').offsetHeight") == 0
    assert opened.run("return document.querySelectorAll('.drawn img').length") > 6
    assert opened.complaints() == []


def test_every_control_of_a_report_says_what_it_does(opened: Browser) -> None:
    assert unexplained(opened) == []


@pytest.mark.usefixtures("unpainted")
def test_texts_of_users_and_foreign_scripts_run_nothing_and_cards_of_wheelsets_fit_a_phone(chromium, curve, tmp_path):
    evil = replace(curve, dataset=curve.dataset.assign_attrs(title=EVIL, scenario_text=EVIL))
    foreign = (
        "<script>window.evil = 1</script><script src='data:text/javascript,window.evil=1'></script>"
        "<img src='data:,x' onerror='window.evil = 1'><iframe srcdoc='<script>parent.evil = 1</script>'></iframe>"
        "<a id='foreign' href='javascript:window.evil = 1'>here</a>"
    )
    file = tmp_path / "report.html"
    file.write_text(page_of(evil, sources=(EVIL,)).replace("<header>", f"<header>{foreign}", 1))
    chromium.open(file, width=390)
    chromium.run("document.getElementById('foreign').click(); return new Promise((done) => setTimeout(done, 0, 1))")
    assert chromium.run("return window.evil === undefined && wrsim.data.charts.length > 0")
    told = chromium.complaints()
    assert len(told) >= 5 and all("Content Security Policy" in complaint for complaint in told), told
    widths = chromium.run(
        "return [...document.querySelectorAll('.card table')].map((t) => [t.offsetWidth, t.parentElement.clientWidth])"
    )
    assert widths and all(table <= card for table, card in widths)
    assert chromium.run("return document.documentElement.scrollWidth <= innerWidth")


# The viewer: its numbers are those of the dataset, its contacts those of the run, its pictures are not blank.
EVIL_TITLE = "</script><script>window.evil = 1</script><img src=x onerror='window.evil=1'>"


def unpacked(of: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(zlib.decompress(base64.b64decode(of["data"])), f"<{of['kind']}").reshape(of["shape"])


def summed(of: dict[str, Any]) -> np.ndarray:
    """Values of which the differences are stored in whole units."""
    steps = unpacked(of).astype(np.int64)
    return of["unit"] * ((np.cumsum(steps, axis=0) + 32768) % 65536 - 32768)


def data_in(viewed: Path) -> Any:
    return json.loads(re.findall(r'id="data">(.*?)</script>', viewed.read_text(encoding="utf-8"), re.DOTALL)[0])


@pytest.fixture(scope="module")
def stability() -> Result:
    values = {"stability.speed_kmh": [150, 260], "stability.nonlinear": False}
    return analysis.run(load(SCENARIOS / "stability_cooperrider.toml").with_values(values))


@pytest.fixture(scope="module")
def bent(coach: Result) -> Result:
    """The run, with rails and axles bent at its middle."""
    dataset = coach.dataset
    middle = float(dataset["wheelset_distance"][dataset.sizes["time"] // 2, 0])
    place, y = middle + np.linspace(-8.0, 8.0, 65), np.linspace(-1.1, 1.1, 9)
    dip = -1e-3 * np.exp(-((place - middle) ** 2))
    axles = np.full((3, 4, 9), np.nan)
    axles[:, 0] = y, 0.0 * y, 4e-4 - 4e-4 * (y / 0.75) ** 2
    shapes = {"bent_place": ("rail_node", place), "bent_rail": (("rail_node", "wheel"), np.stack([dip, 0.0 * dip], 1))}
    shapes |= {
        f"bent_axle_{axis}": (("wheelset", "axle_node"), shape) for axis, shape in zip("yxz", axles, strict=True)
    }
    about = dataset.attrs | {"bent_by": f"{wheelsets(dataset)[0]} left", "bent_at_m": middle}
    return Result(dataset.assign(shapes).assign_attrs(about))


@pytest.fixture(scope="module")
def viewed(bent: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With contacts every 2.4 m, .12 s."""
    file = tmp_path_factory.mktemp("view") / "view.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wrsim.report.view_data.SECTIONS", 30)
        file.write_text(view_page(bent, Path()))
    return file


@pytest.fixture(scope="module")
def modes_page(stability: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("modes") / "view.html"
    file.write_text(view_page(stability, Path()))
    return file


def test_contacts_solved_again_are_those_of_the_run(coach: Result) -> None:
    setup, why = setup_of(coach, Path())
    assert setup is not None, why
    dataset = coach.dataset
    samples = [sample_of(dataset, m) for m in range(dataset.sizes["snapshot"])]
    solved_again = with_moments(dataset, setup, samples)
    for name in ("strip_p", "strip_a", "strip_y", "strip_angle"):
        pressures = [np.nan_to_num(d[name].values) for d in (dataset, solved_again)]
        # rates of the pose act through the damping alone
        assert np.abs(pressures[0] - pressures[1]).max() < 3e-3 * np.abs(pressures[0]).max(), name
    assert np.nanmax(np.abs(solved_again["wheel_profile_z"].values - dataset["wheel_profile_z"].values)) < 1e-8


def test_pressures_between_the_kept_moments_are_those_of_the_samples(coach: Result) -> None:
    setup, _ = setup_of(coach, Path())
    assert setup is not None
    samples = [40, 180, 300]
    solved_again = with_moments(coach.dataset, setup, samples)
    p0 = coach.dataset["p0"].values[samples]
    again = np.nanmax(np.nan_to_num(solved_again["strip_p"].values), axis=-1)
    # p0 is the vertex between the middles of strips: up to 2.3 % above the largest of them
    ratio = again[np.isfinite(p0)] / p0[np.isfinite(p0)]
    assert ratio.min() > 0.975 and ratio.max() < 1.003


def test_what_contacts_solved_again_have_to_say_stands_among_the_notes(coach: Result, monkeypatch: pytest.MonkeyPatch):
    setup, _ = setup_of(coach, Path())
    assert setup is not None
    assert with_moments(coach.dataset, setup, [40]).attrs["contact_remark"] == ""
    monkeypatch.setattr(
        WatchedWheel, "status", property(lambda wheel: STATUS_NOT_CONVERGED * (wheel.wheelset == "front.outer"))
    )
    monkeypatch.setattr("wrsim.report.view_data.SECTIONS", 2)
    (note,) = view_data(coach, setup)["notes"]
    assert f"the left wheel of wheelset front.outer: {WORDS[STATUS_NOT_CONVERGED]} (at " in note
    assert re.fullmatch(r"Contacts that are drawn: .* places\)", note)
    assert "rear" not in note


def test_the_drawn_track_is_the_track_of_the_run(coach: Result, viewed: Path) -> None:
    setup, _ = setup_of(coach, Path())
    assert setup is not None
    track = data_in(viewed)["run"]["track"]
    line = unpacked(track["line"])
    s = track["start"] + PATH_STEP * np.arange(len(line))
    inside = (s > 1.0) & (s < 60.0)
    truth = setup.track.centre_line.position(s[inside])
    drawn = line[inside, :3]
    turn = setup.track.heading(s[inside])[0] - line[inside, 3][0]
    c, d = np.cos(turn), np.sin(turn)
    drawn = (drawn - drawn[0]) @ np.array([[c, d, 0.0], [-d, c, 0.0], [0.0, 0.0, 1.0]])
    assert np.abs(drawn - (truth - truth[0])).max() < 0.02
    # canted by 66 mrad; the cant of the run is that of its samples
    assert line[inside, 4] == pytest.approx(setup.track.left_curve.roll(s[inside])[0], abs=1e-3)
    assert line[inside, 3] - line[inside, 3][0] == pytest.approx(
        setup.track.heading(s[inside]) - setup.track.heading(s[inside])[0], abs=1e-3
    )


@pytest.mark.parametrize("base_mm", [1450.0, 1800.0])
def test_the_drawn_cant_lies_over_the_cant_base_of_the_track(coach: Result, base_mm: float, monkeypatch) -> None:
    monkeypatch.setattr("wrsim.report.view_data.SECTIONS", 2)
    text = coach.dataset.attrs["scenario_text"].replace("[track]", f"[track]\ncant_base_mm = {base_mm}")
    changed = Result(coach.dataset.assign_attrs(scenario_text=text))
    setup, why = setup_of(changed, Path())
    assert setup is not None, why
    track = view_data(changed, setup)["run"]["track"]
    roll = unpacked(track["line"])[:, 4]
    s = track["start"] + PATH_STEP * np.arange(len(roll))
    inside = (s > 1.0) & (s < 60.0)
    # in a left curve the right rail, on the side of -n, is higher by the cant
    assert -1e3 * np.sin(roll).min() * setup.track.cant_base == pytest.approx(100.0, rel=1e-3)
    assert -np.sin(roll).min() == pytest.approx(100.0 / base_mm, rel=1e-3)
    assert roll[inside] == pytest.approx(setup.track.left_curve.roll(s[inside])[0], abs=1e-3)


def test_contact_angles_of_the_viewer_are_slopes_of_the_rail_and_positive_on_the_flange() -> None:
    sections = view_data(Result(static_poses((-7.0, 7.0), (0.0,))), None)["sections"]
    for wheel, flange in ((0, 1), (1, 0)):
        of = sections["of"][wheel]
        patches, (_, means, _) = summed(of["patch"]), unpacked(of["patch_numbers"]).T
        assert of["patch_moment"] == [0, 1]
        for pose, (points, mean) in enumerate(zip(patches, means, strict=True)):
            o, b, turn = points[:, 0], points[:, 1], np.degrees(0.1 * points[:, 2])
            inner = slice(3, -3)  # ends of a patch are drawn straight
            slope = np.degrees(np.arctan2(np.gradient(b), np.gradient(o)))
            np.testing.assert_allclose(turn[inner], slope[inner], atol=2.0)
            assert turn.min() <= mean <= turn.max()
            assert mean > 60.0 if pose == flange else abs(mean) < 5.0


def test_modes_are_those_of_the_result(stability: Result, modes_page: Path) -> None:
    data = data_in(modes_page)["modes"]
    speeds = stability.dataset["pose_speed"].values * 3.6
    for of in data["speeds"]:
        if of["critical"]:
            assert min(abs(m["damping"]) for m in of["modes"]) < 1e-2
            continue
        i = int(np.argmin(np.abs(speeds - of["speed"])))
        frequencies = stability.dataset["mode_frequency"].values[i]
        assert [m["frequency"] for m in of["modes"]] == pytest.approx(
            frequencies[np.isfinite(frequencies)].tolist(), rel=1e-5
        )
        assert [m["name"] for m in of["modes"]] == stability.dataset["mode_name"].values[i][
            np.isfinite(frequencies)
        ].tolist()


def test_without_its_model_files_a_result_still_shows_its_contacts_but_there_must_be_something_to_see() -> None:
    result = Result(curve_run())
    assert setup_of(result, Path())[0] is None
    data = view_data(result, None, "why")
    assert data["notes"] == ["why"] and len(data["sections"]["at"]) == result.dataset.sizes["snapshot"]
    assert "vehicle" not in data
    dataset = curve_run().isel(time=[0]).drop_dims("strip")
    with pytest.raises(InputError, match="neither motion nor contacts"):
        view_data(Result(dataset), None)


@pytest.fixture(scope="module")
def viewer(chromium: Browser, viewed: Path) -> Browser:
    """The viewed of the run, opened once."""
    chromium.open(viewed)
    return chromium


def test_seek_gives_the_numbers_of_the_dataset(viewer: Browser, coach: Result) -> None:
    dataset = coach.dataset
    for s in (3.3, 44.9, 53.0):
        readings = viewer.run(f"return wrsim.ready.then(() => wrsim.seek({s}))")
        i = int(np.argmin(np.abs(dataset["distance"].values - s)))
        assert readings["s"] == dataset["distance"].values[i] and readings["time"] == dataset["time"].values[i]
        for w, name in enumerate(wheelsets(dataset)):
            for key, value in readings["wheelsets"][name].items():
                channel, _, patch = (key, "", "0") if key in dataset else key.rpartition("_")
                truth = dataset[channel].values[i, w]
                truth = truth[..., int(patch)] if "patch" in dataset[channel].dims else truth
                shown = [value[side] for side in ("left", "right")] if isinstance(value, dict) else value
                numbers = np.array([np.nan if v is None else v for v in np.atleast_1d(shown)], dtype=float)
                factor = CHANNELS[channel].shown.factor
                assert numbers == pytest.approx(factor * np.atleast_1d(truth), rel=1e-6, abs=1e-12, nan_ok=True)
        assert {"Y", "Q", "Y_over_Q", "lateral_shift", "yaw", "p0"} <= set(readings["wheelsets"]["front.outer"])
        section = readings["section"]
        near = int(np.argmin(np.abs(dataset["time"].values - section["time"])))
        wheel = coach.wheelset(section["wheelset"]).sel(wheel=section["wheel"])
        pressures = wheel["p0"].values[near] * 1e-6
        assert 0.98 < max(p["p0"] for p in section["patches"]) / np.nanmax(pressures) < 1.003  # of strips' middles
        assert abs(section["time"] - readings["time"]) < 0.1
    assert viewer.complaints() == []


def test_every_control_of_the_viewer_says_what_it_does(viewer: Browser) -> None:
    assert unexplained(viewer) == []


def test_exaggeration_moves_bodies_away_from_the_track(viewer: Browser) -> None:
    place = "return wrsim.viewer.stage.parts.get('front.outer').group.position.y"
    viewer.run("return wrsim.ready.then(() => wrsim.seek(45))")
    for id in ("wheel", "focus"):  # numbered from the front, as in terminal and folders
        assert "1 front.outer" in viewer.run(f"return document.getElementById('{id}').textContent")
    shifts = []
    for factor in (1, 10, 50):
        viewer.run(f"document.querySelector('[data-factor=\"{factor}\"]').click()")
        shifts.append(viewer.run(place))
    assert shifts[1] == pytest.approx(10.0 * shifts[0]) and shifts[2] == pytest.approx(50.0 * shifts[0])
    assert abs(shifts[0]) > 1e-4


def test_the_right_rail_of_the_scene_is_higher_by_the_cant_in_a_left_curve(viewer: Browser, coach: Result) -> None:
    viewer.run("return wrsim.ready.then(() => wrsim.seek(45))")
    stage = "const { rails, parts } = wrsim.viewer.stage;"
    heights = viewer.run(  # of the rail tops beside the vehicle's origin: the ring of rails that is nearest to x = 0
        f"{stage} return rails.map(({{ mesh, ring, nodes }}) => {{"
        " const p = mesh.geometry.attributes.position.array, n = ring.length;"
        " const at = (i) => Math.abs(p[3 * n * i]); let best = 0;"
        " for (let i = 0; i < nodes; i++) if (at(i) < at(best)) best = i;"
        " let top = [0, -9];"
        " for (let k = 0; k < n; k++) {"
        "  const [y, z] = [p[3 * (best * n + k) + 1], p[3 * (best * n + k) + 2]];"
        "  if (z > top[1]) top = [y, z];"
        " } return top; })"
    )
    (left, up_left), (right, up_right) = heights
    assert left > 0.0 > right
    cant = float(coach.dataset["cant"].sel(wheelset="front.outer").max())
    assert up_right - up_left == pytest.approx(cant, rel=0.03) and cant == pytest.approx(0.1, rel=1e-3)
    roll = viewer.run(f"{stage} return parts.get('front.outer').carrier.rotation.x")
    assert roll == pytest.approx(-cant / 1.5, rel=0.1)  # this wheelset is in the transition


def test_keys_and_the_history_go_along_the_run(viewer: Browser) -> None:
    viewer.run("return wrsim.ready.then(() => wrsim.seek(40))")
    current_sample = "return wrsim.viewer.at"
    before = viewer.run(current_sample)
    ends = viewer.run(f"""const at = (id) => document.getElementById(id), page = document.body;
        return [['ArrowRight', page], ['ArrowLeft', at('place')], ['Home', at('play')], ['End', at('place')]].map(
            ([key, target]) => {{ wrsim.viewer.go({before});
                target.dispatchEvent(new KeyboardEvent('keydown', {{ key, bubbles: true }}));
                return wrsim.viewer.at; }})""")
    assert ends == [before + 1, before - 1, 0, viewer.run("return wrsim.viewer.count - 1")]
    viewer.run("document.getElementById('rate').value = '0.1'; wrsim.seek(10)")
    for target, playing in (("body", True), ("#focus", False)):  # a list that has the keyboard plays too
        viewer.run(f"""document.querySelector('{target}').dispatchEvent(
            new KeyboardEvent('keydown', {{ key: ' ', bubbles: true }}))""")
        assert viewer.run("return wrsim.viewer.playing") == playing
    middle = viewer.run("const h = wrsim.viewer.history; return h.sampleAt(h.X(h.x[120]))")
    assert abs(middle - 120) <= 1
    # round-off of the start is no place behind it
    told = viewer.run("""const at = wrsim.viewer.run.distance.data, was = at[0]; at[0] = -1e-9; wrsim.viewer.go(0);
        at[0] = was; return document.getElementById('place-shown').textContent""")
    assert told.startswith("0.00 m, ")
    assert viewer.colours("#history") > 10 and viewer.complaints() == []


@pytest.mark.campaign
def test_pictures_and_a_video_are_saved(viewer: Browser) -> None:
    viewer.run("return wrsim.ready.then(() => wrsim.seek(45))")
    viewer.run("""window.saved = []; HTMLAnchorElement.prototype.click = () => {};
        URL.createObjectURL = (content) => (saved.push(content), 'blob:x');
        for (const button of document.querySelectorAll('[data-save]')) button.click();""")
    viewer.wait("saved.length === 5")
    kinds = sorted(viewer.run("return saved.map((content) => content.type)"))
    assert kinds == ["image/png"] * 3 + ["image/svg+xml"] * 2
    texts = viewer.run(
        "return Promise.all(saved.filter((content) => content.type.includes('svg')).map((content) => content.text()))"
    )
    assert all(len(ElementTree.fromstring(text)) > 20 for text in texts)  # well-formed, and drawn
    viewer.run("document.getElementById('rate').value = '0.1'; window.film = wrsim.viewer.record()")
    viewer.wait("wrsim.viewer.recording.parts.reduce((sum, part) => sum + part.size, 0) > 1000")
    assert viewer.run("wrsim.viewer.play(false); return film.then((film) => film.type)") == "video/webm"
    assert viewer.complaints() == []


def test_rails_and_axles_are_bent_at_the_largest_force_alone(viewer: Browser) -> None:
    lowest = """const z = wrsim.viewer.stage.rails[0].mesh.geometry.attributes.position.array;
        let low = 0; for (let i = 2; i < z.length; i += 3) low = Math.min(low, z[i]); return low"""
    event = "wrsim.viewer.run.events.find((e) => e.words.includes('bent')).s"
    viewer.run("document.querySelector('[data-factor=\"200\"]').click()")
    straight, down = (viewer.run(f"wrsim.seek({event} - {off}); {lowest}") for off in (5, 0))
    # the foot of the rail is bent with it; nodes of the drawing are 0.25 m apart
    assert down - straight == pytest.approx(-0.2, abs=0.01)
    axle = "const p = wrsim.viewer.stage.parts.get('front.outer'); return [p.axle.visible, Boolean(p.bent?.parent)]"
    assert viewer.run(axle) == [False, True]
    assert viewer.run(f"wrsim.seek({event} - 5); {axle}") == [True, False]
    assert viewer.complaints() == []


@pytest.mark.campaign
def test_a_script_that_gets_into_the_viewer_does_not_run(chromium: Browser, viewed: Path, tmp_path: Path) -> None:
    file = tmp_path / "view.html"
    foreign = "<script>window.evil = 1</script><style>h1 { display: none }</style>"
    file.write_text(viewed.read_text(encoding="utf-8").replace("</main>", f"{foreign}</main>", 1))
    chromium.open(file)
    chromium.run("return wrsim.ready")
    assert chromium.run("return window.evil === undefined && document.querySelector('h1').offsetHeight > 0")
    told = chromium.complaints()
    assert len(told) == 2 and all("Content Security Policy" in complaint for complaint in told), told


def test_modes_move(chromium: Browser, modes_page: Path) -> None:
    chromium.open(modes_page)
    script = """return wrsim.ready.then(() => {
        const v = wrsim.viewer, at = (phase) => { v.phase = phase; v.show();
            return [...v.stage.parts.values()].map((p) => [p.group.position.y, p.group.rotation.z]).flat(); };
        return [at(0), at(Math.PI / 2), at(Math.PI)]; })"""
    first, quarter, opposite = map(np.array, chromium.run(script))
    assert np.abs(first - quarter).max() > 1e-3
    # half a period later everything stands on the other side of its place
    assert first == pytest.approx(-opposite, abs=1e-9)
    assert chromium.colours("#stage") > 50 and chromium.complaints() == []


@pytest.mark.usefixtures("unpainted")
def test_a_report_takes_the_viewer_of_poses_inside(chromium: Browser, tmp_path: Path) -> None:
    result = Result(static_poses(shifts_mm=(0.0, 5.0), yaws_mrad=(0.0,)))
    evil = replace(result, dataset=result.dataset.assign_attrs(title=EVIL_TITLE))
    file = tmp_path / "report.html"
    file.write_text(report_page([evil], ["a"], viewers=[view_page(evil, Path())]))
    chromium.open(file)
    chromium.run("document.querySelector('iframe').scrollIntoView()")
    inside = "document.querySelector('iframe').contentWindow"
    readings = chromium.run(f"return {inside}.wrsim.ready.then(() => {inside}.wrsim.seek(1))")
    assert readings["pose"] == str(result.dataset["pose"].values[1])
    assert chromium.run(f"return window.evil === {inside}.evil && {inside}.document.title") == EVIL_TITLE
    assert chromium.colours("iframe") > 20 and chromium.complaints() == []
