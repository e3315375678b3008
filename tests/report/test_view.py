"""The viewer: its numbers are those of the dataset, its contacts those of the run, its pictures are not blank."""

import base64
import json
import re
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from support.browser import Browser
from support.runs import SCENARIOS
from support.synthetic_result import curve_run, static_poses

from wrsim.analysis import run
from wrsim.analysis.motion.derailment import WatchedWheel
from wrsim.analysis.resolve import with_moments
from wrsim.contact.status import WORDS
from wrsim.core.contact.records import STATUS_NOT_CONVERGED
from wrsim.errors import InputError
from wrsim.report.page import report_page
from wrsim.report.view_data import PATH_STEP, setup_of, view_data, view_page
from wrsim.results import CHANNELS, Result
from wrsim.results.moments import sample_of
from wrsim.results.wheelsets import wheelsets
from wrsim.scenario.loading import load

EVIL = "</script><script>window.evil = 1</script><img src=x onerror='window.evil=1'>"


def unpacked(of: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(zlib.decompress(base64.b64decode(of["data"])), f"<{of['kind']}").reshape(of["shape"])


def data_in(page: Path) -> Any:
    return json.loads(re.findall(r'id="data">(.*?)</script>', page.read_text(), re.DOTALL)[0])


@pytest.fixture(scope="module")
def stability() -> Result:
    values = {"stability.speed_kmh": [150, 260], "stability.nonlinear": False}
    return run(load(SCENARIOS / "stability_cooperrider.toml").with_values(values))


@pytest.fixture(scope="module")
def page(coach: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With contacts every 1.2 m, .06 s."""
    file = tmp_path_factory.mktemp("view") / "view.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wrsim.report.view_data.SECTIONS", 60)
        file.write_text(view_page(coach, Path()))
    return file


@pytest.fixture(scope="module")
def modes_page(stability: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("modes") / "view.html"
    file.write_text(view_page(stability, Path()))
    return file


# --- numbers ------------------------------------------------------------------------------------------------
def test_contacts_solved_again_are_those_of_the_run(coach: Result) -> None:
    setup, why = setup_of(coach, Path())
    assert setup is not None, why
    own = coach.dataset
    samples = [sample_of(own, m) for m in range(own.sizes["snapshot"])]
    found = with_moments(own, setup, samples)
    for name in ("strip_p", "strip_a", "strip_y", "strip_angle"):
        both = [np.nan_to_num(d[name].values) for d in (own, found)]
        # rates of the pose act through the damping alone
        assert np.abs(both[0] - both[1]).max() < 3e-3 * np.abs(both[0]).max(), name
    assert np.nanmax(np.abs(found["wheel_profile_z"].values - own["wheel_profile_z"].values)) < 1e-8


def test_pressures_between_the_kept_moments_are_those_of_the_samples(coach: Result) -> None:
    setup, _ = setup_of(coach, Path())
    assert setup is not None
    samples = [40, 180, 300]
    found = with_moments(coach.dataset, setup, samples)
    p0 = coach.dataset["p0"].values[samples]
    again = np.nanmax(np.nan_to_num(found["strip_p"].values), axis=-1)
    # p0 is the vertex between the middles of strips: up to 2.3 % above the largest of them
    ratio = again[np.isfinite(p0)] / p0[np.isfinite(p0)]
    assert ratio.min() > 0.975 and ratio.max() < 1.003


def test_what_contacts_solved_again_have_to_say_stands_among_the_notes(
    coach: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_the_drawn_track_is_the_track_of_the_run(coach: Result, page: Path) -> None:
    setup, _ = setup_of(coach, Path())
    assert setup is not None
    track = data_in(page)["run"]["track"]
    line = unpacked(track["line"])
    s = track["start"] + PATH_STEP * np.arange(len(line))
    inside = (s > 1.0) & (s < 75.0)
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


def test_modes_are_those_of_the_result(stability: Result, modes_page: Path) -> None:
    data = data_in(modes_page)["modes"]
    speeds = stability.dataset["pose_speed"].values * 3.6
    for of in data["speeds"]:
        if of["critical"]:
            assert min(abs(m["damping"]) for m in of["modes"]) < 1e-2
            continue
        i = int(np.argmin(np.abs(speeds - of["speed"])))
        own = stability.dataset["mode_frequency"].values[i]
        assert [m["frequency"] for m in of["modes"]] == pytest.approx(own[np.isfinite(own)].tolist(), rel=1e-5)
        assert [m["name"] for m in of["modes"]] == stability.dataset["mode_name"].values[i][np.isfinite(own)].tolist()


def test_without_its_model_files_a_result_still_shows_its_contacts_but_there_must_be_something_to_see() -> None:
    result = Result(curve_run())
    assert setup_of(result, Path())[0] is None
    data = view_data(result, None, "why")
    assert data["notes"] == ["why"] and len(data["sections"]["at"]) == result.dataset.sizes["snapshot"]
    assert "vehicle" not in data
    dataset = curve_run().isel(time=[0]).drop_dims("strip")
    with pytest.raises(InputError, match="neither motion nor contacts"):
        view_data(Result(dataset), None)


# --- in a browser -------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def viewer(chromium: Browser, page: Path) -> Browser:
    """The page of the run, opened once."""
    chromium.open(page)
    return chromium


def test_seek_gives_the_numbers_of_the_dataset(viewer: Browser, coach: Result) -> None:
    own = coach.dataset
    for s in (3.3, 27.2, 44.9, 69.0):
        found = viewer.run(f"return wrsim.ready.then(() => wrsim.seek({s}))")
        i = int(np.argmin(np.abs(own["distance"].values - s)))
        assert found["s"] == own["distance"].values[i] and found["time"] == own["time"].values[i]
        for w, name in enumerate(wheelsets(own)):
            for key, value in found["wheelsets"][name].items():
                channel, _, patch = (key, "", "0") if key in own else key.rpartition("_")
                truth = own[channel].values[i, w]
                truth = truth[..., int(patch)] if "patch" in own[channel].dims else truth
                shown = [value[side] for side in ("left", "right")] if isinstance(value, dict) else value
                numbers = np.array([np.nan if v is None else v for v in np.atleast_1d(shown)], dtype=float)
                factor = CHANNELS[channel].shown.factor
                assert numbers == pytest.approx(factor * np.atleast_1d(truth), rel=1e-6, abs=1e-12, nan_ok=True)
        assert {"Y", "Q", "Y_over_Q", "lateral_shift", "yaw", "p0"} <= set(found["wheelsets"]["front.outer"])
        section = found["section"]
        near = int(np.argmin(np.abs(own["time"].values - section["time"])))
        one = coach.wheelset(section["wheelset"]).sel(wheel=section["wheel"])
        pressures = one["p0"].values[near] * 1e-6
        assert 0.98 < max(p["p0"] for p in section["patches"]) / np.nanmax(pressures) < 1.003  # of strips' middles
        assert abs(section["time"] - found["time"]) < 0.1
    assert viewer.complaints() == []


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


def test_keys_and_the_history_go_along_the_run(viewer: Browser) -> None:
    viewer.run("return wrsim.ready.then(() => wrsim.seek(40))")
    at = "return wrsim.viewer.at"
    before = viewer.run(at)
    ends = viewer.run(f"""return ['ArrowRight', 'ArrowLeft', 'Home', 'End'].map((key) =>
        [document.body, document.getElementById('place'), document.getElementById('play')].map((target) => {{
            wrsim.viewer.go({before});
            target.dispatchEvent(new KeyboardEvent('keydown', {{ key, bubbles: true }}));
            return wrsim.viewer.at; }}))""")
    last = viewer.run("return wrsim.viewer.count - 1")
    assert ends == [[end] * 3 for end in (before + 1, before - 1, 0, last)]
    viewer.run("document.getElementById('rate').value = '0.1'; wrsim.seek(10)")
    viewer.run("document.body.dispatchEvent(new KeyboardEvent('keydown', { key: ' ', bubbles: true }))")
    assert viewer.run("return wrsim.viewer.playing")
    viewer.run("document.body.dispatchEvent(new KeyboardEvent('keydown', { key: ' ', bubbles: true }))")
    assert not viewer.run("return wrsim.viewer.playing")
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


@pytest.mark.campaign
def test_a_script_that_gets_into_the_viewer_does_not_run(chromium: Browser, page: Path, tmp_path: Path) -> None:
    file = tmp_path / "view.html"
    foreign = "<script>window.evil = 1</script><style>h1 { display: none }</style>"
    file.write_text(page.read_text().replace("</main>", f"{foreign}</main>", 1))
    chromium.open(file)
    chromium.run("return wrsim.ready")
    assert chromium.run("return window.evil === undefined && document.querySelector('h1').offsetHeight > 0")
    told = chromium.complaints()
    assert len(told) == 2 and all("Content Security Policy" in words for words in told), told


def test_rails_and_axles_are_bent_at_the_largest_force_alone(chromium: Browser, coach: Result, tmp_path: Path) -> None:
    own = coach.dataset
    at = float(own["wheelset_distance"][own.sizes["time"] // 2, 0])
    place, y = at + np.linspace(-8.0, 8.0, 65), np.linspace(-1.1, 1.1, 9)
    dip = -1e-3 * np.exp(-((place - at) ** 2))
    axles = np.full((3, 4, 9), np.nan)
    axles[:, 0] = y, 0.0 * y, 4e-4 - 4e-4 * (y / 0.75) ** 2
    bent = {"bent_place": ("rail_node", place), "bent_rail": (("rail_node", "wheel"), np.stack([dip, 0.0 * dip], 1))}
    bent |= {
        f"bent_axle_{axis}": (("wheelset", "axle_node"), values) for axis, values in zip("yxz", axles, strict=True)
    }
    name = f"{wheelsets(own)[0]} left"
    whole = Result(own.assign(bent).assign_attrs(own.attrs | {"bent_by": name, "bent_at_m": at}))
    page = tmp_path / "bent.html"
    page.write_text(view_page(whole, tmp_path))
    chromium.open(page)
    chromium.run("return wrsim.ready.then(() => document.querySelector('[data-factor=\"200\"]').click())")
    lowest = """const z = wrsim.viewer.stage.rails[0].mesh.geometry.attributes.position.array;
        let low = 0; for (let i = 2; i < z.length; i += 3) low = Math.min(low, z[i]); return low"""
    event = "wrsim.viewer.run.events.find((e) => e.words.includes('bent')).s"
    straight = chromium.run(f"wrsim.seek({event} - 5); {lowest}")
    down = chromium.run(f"wrsim.seek({event}); {lowest}")
    # the foot of the rail is bent with it; nodes of the drawing are 0.25 m apart
    assert down - straight == pytest.approx(-0.2, abs=0.01)
    axle = "const p = wrsim.viewer.stage.parts.get('front.outer');"
    assert chromium.run(f"{axle} return [p.axle.visible, Boolean(p.bent?.parent)]") == [False, True]
    assert chromium.run(f"wrsim.seek({event} - 5); {axle} return [p.axle.visible, Boolean(p.bent?.parent)]") == [
        True,
        False,
    ]
    assert chromium.complaints() == []


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
    evil = replace(result, dataset=result.dataset.assign_attrs(title=EVIL))
    file = tmp_path / "report.html"
    file.write_text(report_page([evil], ["a"], viewers=[view_page(evil, Path())]))
    chromium.open(file)
    chromium.run("document.querySelector('iframe').scrollIntoView()")
    inside = "document.querySelector('iframe').contentWindow"
    found = chromium.run(f"return {inside}.wrsim.ready.then(() => {inside}.wrsim.seek(1))")
    assert found["pose"] == str(result.dataset["pose"].values[1])
    assert chromium.run(f"return window.evil === {inside}.evil && {inside}.document.title") == EVIL
    assert chromium.colours("iframe") > 20 and chromium.complaints() == []
