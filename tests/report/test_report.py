"""The report: what stands in it, that it needs nothing else, and what it does in a browser."""

import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from markupsafe import escape
from support.browser import Browser
from support.commands import call
from support.pictures import leave_unpainted
from support.synthetic_result import curve_run, static_poses
from support.synthetic_run import Q0, run
from support.synthetic_run import curve as bend

from wrsim.inputs.lookup import shipped_models
from wrsim.report.charts import envelope, interruptions, pieces_of
from wrsim.report.page import report_page
from wrsim.report.tables import contacts as contacts_of
from wrsim.report.view_data import needed
from wrsim.results import Result
from wrsim.results.summary import CUT_STEPS
from wrsim.results.wheelsets import wheelsets

EVIL = "</script><script>window.evil = 1</script><img src=x onerror='window.evil=1'>\"'&{{ 7*7 }}"


def page_of(*results: Result, sources: tuple[str, ...] = ()) -> str:
    names = sources or tuple(f"run{i}" for i in range(len(results)))
    return report_page(results, names)


@pytest.fixture(scope="module")
def curve() -> Result:
    return Result(curve_run())


@pytest.fixture(scope="module")
def page(coach: Result) -> str:
    with pytest.MonkeyPatch.context() as patch:
        leave_unpainted(patch)
        return page_of(coach)


@pytest.fixture(scope="module")
def few() -> Result:
    return Result(static_poses(shifts_mm=(0.0, 5.0), yaws_mrad=(0.0,)))


@pytest.fixture(scope="module")
def painted() -> str:
    """The report of single poses, with small pictures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wrsim.report.page.DOTS", 50)
        return page_of(Result(static_poses((0.0, 5.0), (0.0,), ("left",))))


class Structure(HTMLParser):
    """Ids, links, tables without heads, drawings without words."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.mute: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        own = dict(attrs)
        self.ids += [own["id"] or ""] if "id" in own else []
        self.links += [own["href"] or ""] if "href" in own else []
        if tag == "img" and not own.get("alt"):
            self.mute.append(self.get_starttag_text() or "")
        if tag == "svg" and own.get("role") == "img" and not own.get("aria-label"):
            self.mute.append(self.get_starttag_text() or "")


# --- envelopes ----------------------------------------------------------------------------------------------
@given(st.integers(1, 3000), st.integers(0, 2**32 - 1))
def test_every_piece_holds_its_least_and_its_largest_value(samples: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places, values = np.sort(rng.uniform(-3.0, 500.0, samples)), rng.normal(size=samples)
    pieces = pieces_of([places])
    for low, high, both in zip(pieces[:-1], pieces[1:], envelope(places, values, pieces).reshape(-1, 2), strict=True):
        inside = values[(places >= low) & ((places < high) | (high == pieces[-1]))]
        assert not inside.size or sorted(both) == [inside.min(), inside.max()]


def test_an_envelope_rises_and_falls_with_its_curve_and_has_no_values_where_that_has_none() -> None:
    places = np.linspace(0.0, 100.0, 5001)
    pieces = pieces_of([places])
    assert (np.diff(envelope(places, places, pieces)) > 0.0).all()
    assert (np.diff(envelope(places, -places, pieces)) < 0.0).all()
    places = np.linspace(0.0, 10.0, 101)
    values = np.where((places > 4.0) & (places < 6.0), np.nan, 1.0)
    pieces = pieces_of([places, np.linspace(0.0, 20.0, 101)])
    found = envelope(places, values, pieces).reshape(-1, 2)[:, 0]
    middles = 0.5 * (pieces[:-1] + pieces[1:])
    assert np.isnan(found[(middles > 4.3) & (middles < 5.7)]).all()
    assert np.isnan(found[middles > 10.5]).all() and np.isfinite(found[middles < 3.7]).all()


@given(st.lists(st.integers(1, 298), max_size=4, unique=True), st.lists(st.integers(1, 298), max_size=4, unique=True))
def test_lines_end_where_contact_jumps_or_is_lost(starts: list[int], lost: list[int]) -> None:
    places, values = np.linspace(0.0, 100.0, 300), np.ones(300)
    values[lost] = np.nan
    pieces = pieces_of([places])  # of two samples
    drawn = envelope(places, values, pieces)
    ends = interruptions(places, values, np.array(sorted(starts), dtype=np.intp), pieces)
    for k in range(0, 299, 2):  # both samples of a piece, with what may lie between them
        assert (k in ends) == (k + 1 in starts and np.isfinite(values[[k, k + 1]]).all())
    for k in range(1, 297, 2):  # the last of one piece and the first of the next
        one, two = (np.flatnonzero(np.isfinite(values[k - 1 + j : k + 1 + j])) + k - 1 + j for j in (0, 2))
        if one.size and two.size:
            between = range(one[-1] + 1, two[0] + 1)
            assert (k in ends) == (any(s in starts for s in between) or two[0] > one[-1] + 1)
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


# --- what stands in it --------------------------------------------------------------------------------------
def test_a_report_says_who_it_is_how_it_went_and_from_which_bytes_it_came(page: str, coach: Result) -> None:
    assert f"<h1>{coach.title}</h1>" in page
    assert re.search(r'class="verdict (good|bad)">[^<]*worst margin -?\d+ %', page)
    for section in ("summary", "appendix", "assessment", "track", "histories", "wheelsets", "contacts", "again"):
        assert f'<section id="{section}"' in page
    assert '<section id="wear"' not in page
    assert "wrsim run scenario.toml" in page and escape(coach.dataset.attrs["scenario_text"]) in page
    for name, digest in json.loads(coach.dataset.attrs["inputs"]).items():
        assert name in page and digest in page
    found = json.loads(coach.dataset.attrs["inputs"])
    wheel = shipped_models() / "wheels/S1002.toml"
    assert found["wheels/S1002.toml"] == hashlib.sha256(wheel.read_bytes()).hexdigest()
    assert {"manchester_r300.toml", "vehicles/manchester_1.toml", "rails/60E1.toml"} <= set(found)


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
    assert section.count("<figure>") == 2 and "rails and axles, magnified" in section
    assert "Vertical force" in section and "<td>250</td>" in section


@pytest.mark.usefixtures("unpainted")
def test_a_report_has_a_cover(curve: Result, tmp_path: Path) -> None:
    Result(curve_run(samples=40)).save(tmp_path / "run" / "result.nc")
    (tmp_path / "logo.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"/>')
    words = {"--title": EVIL, "--author": "A. Author", "--company": 'A "B" \\ </style> Ltd.', "--date": "today"}
    options = [part for pair in words.items() for part in pair]
    assert call("report", tmp_path / "run", "--logo", tmp_path / "logo.svg", *options).exit_code == 0
    text = (tmp_path / "run" / "report.html").read_text()
    assert "A. Author" in text and "data:image/svg+xml;base64" in text and "<script>window.evil" not in text
    style = text[text.index("<style>") : text.index("</style>")]
    assert "@page" in style and "Ltd" in style and text.count("</style>") == 1
    refused = call("report", tmp_path / "run", "--logo", tmp_path / "run" / "result.nc")
    assert refused.exit_code == 2 and "must end in" in refused.output


def test_nothing_comes_from_elsewhere_every_drawing_has_words_and_every_link_a_place(page: str) -> None:
    for address in re.findall(r"""(?:src|href|action|data|poster)\s*=\s*["']([^"']*)""", page):
        assert address.startswith(("#", "data:")), address
    assert not re.findall(r"url\((?!['\"]?(?:data:|#))|@import", page)
    addresses = set(re.findall(r"https?://[^\s\"'<>)]+", page))
    assert not {a for a in addresses if "www.w3.org" not in a}
    policy = re.findall(r'Content-Security-Policy" content="([^"]*)"', page)[0]
    assert "default-src 'none'" in policy and "script-src 'sha256-" in policy
    found = Structure(page)
    assert not found.mute
    assert len(found.ids) == len(set(found.ids))
    assert {link[1:] for link in found.links} <= set(found.ids)
    assert '<html lang="en">' in page


@pytest.mark.usefixtures("unpainted")
def test_texts_of_users_are_escaped(curve: Result) -> None:
    attributes = {"title": EVIL, "scenario_text": f"# {EVIL}", "inputs": '{"<b>x</b>": "00"}'}
    evil = replace(curve, dataset=curve.dataset.assign_attrs(attributes))
    text = page_of(evil, evil, sources=(f"{EVIL}/a", "b"))
    assert "<script>window.evil" not in text and "<img src=x" not in text and "<b>x</b>" not in text
    assert "{{ 7*7 }}" in text and "49" not in text[text.index("<h1>") : text.index("</h1>")]


@pytest.mark.usefixtures("unpainted")
def test_two_results_are_set_against_each_other_with_wheelsets_from_the_front(
    curve: Result, few: Result, page: str
) -> None:
    """The second has Q of the right wheel 10 % larger, another speed, and another name of its wheelset."""
    other = curve.dataset.copy(deep=True)
    other["Q"].loc[{"wheel": "right"}] *= 1.1
    text = other.attrs["scenario_text"] = other.attrs["scenario_text"] + "\n[asked]\nspeed_kmh = 99\n"
    other = other.assign_coords(wheelset=["lead"] if "wheelset" in other.dims else "lead")
    both = page_of(curve, Result(other))
    body = both[: both.index(str(escape(text)))]  # the scenarios themselves are below
    assert body.count("asked.speed_kmh: not given in A, 99 in B") == 1
    assert body.count("wheelsets are matched from the front: wheelset and lead") == 1
    assert body.count("<article") == 1  # one card, of both
    (largest,) = re.findall(r'<th scope="row">Q, largest \[kN\]</th>(.*?)</tr>', body, re.DOTALL)
    assert re.findall(r"<td>(.*?)</td>", largest)[-2:] == ["0.0", "10.0"]
    assert "<td>10</td>" in body[body.index('id="differences"') :]
    assert "both must be of one kind" in page_of(curve, few)
    assert 'id="differences"' in both and 'id="differences"' not in page


@pytest.mark.usefixtures("unpainted")
def test_results_of_one_wheel_and_of_two_stand_beside_each_other(curve: Result) -> None:
    one = Result(static_poses((0.0, 5.0), (0.0,), ("left",)))
    assert "change, left" in page_of(one, one) and "change, right" not in page_of(one, one)
    assert "change, left" not in page_of(curve, one)


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


# --- the command --------------------------------------------------------------------------------------------


# --- in a browser -------------------------------------------------------------------------------------------
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
    for s in (5.0, 31.7, 52.0, 64.0):
        found = opened.run(f"return wrsim.seek({s})")
        assert found["from"] <= s <= found["to"] + 1e-9
        for name in wheelsets(coach.dataset):
            own = coach.wheelset(name)
            inside = (own["distance"] >= found["from"]) & (own["distance"] < found["to"])
            if not inside.any():  # a value between two samples
                continue
            for key, factor in (("Y", 1e-3), ("Q", 1e-3), ("lateral_shift", 1e3), ("yaw", 1e3)):
                lines = [line for line in found["values"][key] if line["part"] == name]
                values = own[key].values[inside.values].reshape(int(inside.sum()), -1) * factor
                for line, of in zip(lines, values.T, strict=True):
                    assert line["low"] == pytest.approx(of.min(), rel=1e-4, abs=1e-6)
                    assert line["high"] == pytest.approx(of.max(), rel=1e-4, abs=1e-6)
    assert opened.run("return document.querySelectorAll('.uplot canvas').length") >= 6
    # one cursor over all charts: the legend of each tells the values there
    told = opened.run("return [...document.querySelectorAll('.panels > div')].map((panel) => panel.textContent)")
    places = [float(words.split("place")[1].lstrip(":").split(" m")[0]) for words in told]
    assert len(places) > 6 and all(found["from"] <= s <= found["to"] for s in places)
    assert any("1 front.outer" in words and "right" in words for words in told)
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


@pytest.mark.usefixtures("unpainted")
def test_texts_of_users_and_foreign_scripts_run_nothing_and_cards_of_wheelsets_fit_a_phone(
    chromium: Browser, curve: Result, tmp_path: Path
) -> None:
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
    assert len(told) >= 5 and all("Content Security Policy" in words for words in told), told
    widths = chromium.run(
        "return [...document.querySelectorAll('.card table')].map((t) => [t.offsetWidth, t.parentElement.clientWidth])"
    )
    assert widths and all(table <= card for table, card in widths)
    assert chromium.run("return document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.campaign  # in the suite: one page with pictures, opened
def test_pictures_in_a_page_keep_their_colours(chromium: Browser, painted: str, tmp_path: Path) -> None:
    file = tmp_path / "report.html"
    file.write_text(painted)
    chromium.open(file)
    assert chromium.colours("#pictures img") > 10 and chromium.colours("#contacts img") > 10
    assert chromium.complaints() == []
