"""What makes a report a document: its cover, one paragraph in words, and what its verdict rests on."""

from __future__ import annotations

import base64
import datetime
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees
from pathlib import Path

import xarray as xr
from markupsafe import Markup

from wrsim.assessment.outcome import TRANSITION, Assessment
from wrsim.contact.creep.laws import CREEP_LAWS
from wrsim.contact.settings import DRY, TURNED, USUAL, ContactSettings, Heating
from wrsim.errors import InputError, WrsimError
from wrsim.inputs.toml_files import read_bytes
from wrsim.results import Result
from wrsim.results.dataset import table_of_scenario
from wrsim.results.summary_tables import Summary, extent_text
from wrsim.results.table import join_names, quantity
from wrsim.results.wheelsets import wheelsets

LOGOS = {
    ".png": ("png", rb"\x89PNG\r\n\x1a\n"),
    ".svg": ("svg+xml", rb"(\xef\xbb\xbf)?\s*(?>(<\?[^>]*>|<!--.*?-->|<!DOCTYPE[^>\[]*(\[.*?\]\s*)?>)\s*)*+<svg[\s/>]"),
    ".jpg": ("jpeg", rb"\xff\xd8\xff"),
    ".jpeg": ("jpeg", rb"\xff\xd8\xff"),
    ".webp": ("webp", rb"RIFF....WEBP"),
}
"""Kinds of pictures that a logo may be, by the ending of its file, and how such a file begins."""
LARGEST_LOGO = 2_000_000  # bytes

ASKED = {
    "curving": "forces, contacts and motions of the run along the track",
    "ride": "accelerations, spectra and comfort of the run along the track",
    "static": "contacts at given poses of a wheelset",
    "equilibrium": "the state of balance and its contacts",
    "conicity": "equivalent conicity of the wheelset on its rails (EN 15302)",
    "stability": "stability of the running vehicle and its critical speed",
    "steady": "steady curving: balance of all forces in full curves",
    "climb": "the way that a wheel rolls until it has climbed its flange",
    "overturning": "the speed at which the vehicle overturns in a curve",
}
"""What an analysis finds."""


BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
"""Programs that print a page without a window."""
PRINT_SECONDS = 120.0


def find_browser(file: Path) -> str:
    """The first of ``BROWSERS`` on the path. Raises InputError without one."""
    for name in BROWSERS:
        if (program := shutil.which(name)) is not None:
            return program
    page = file.with_suffix(".html").name
    raise InputError(
        f"{file}: needs Chromium, Chrome or Edge on the path (Debian: apt install chromium); or write {page} and print "
        "it from a browser"
    )


def printed(page: str, browser: str, file: Path) -> bytes:
    """A page as PDF, for ``file``; without network. Raises WrsimError where the browser fails."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        source, target = Path(folder, "page.html"), Path(folder, "page.pdf")
        source.write_text(page, encoding="utf-8")
        command = [
            browser, "--headless", "--disable-gpu", "--no-first-run", "--disable-background-networking",
            f"--user-data-dir={folder}/profile", "--no-pdf-header-footer", f"--print-to-pdf={target}", source.as_uri(),
        ]  # fmt: skip
        if hasattr(os, "geteuid") and os.geteuid() == 0:  # Chromium runs for root without its sandbox alone
            command.insert(1, "--no-sandbox")
        try:
            done = subprocess.run(command, capture_output=True, timeout=PRINT_SECONDS, stdin=subprocess.DEVNULL)
        except (OSError, subprocess.TimeoutExpired) as problem:
            raise WrsimError(f"{file}: {browser} did not print the page: {problem}") from None
        if not target.is_file():
            lines = done.stderr.decode(errors="replace").strip().splitlines()
            raise WrsimError(f"{file}: {browser} did not print the page{': ' + lines[-1] if lines else ''}")
        return target.read_bytes()


@dataclass(frozen=True)
class Cover:
    """What a report says of itself; empty: title of the results, today's date. logo: a picture as a data address."""

    title: str = ""
    author: str = ""
    company: str = ""
    date: str = ""
    logo: str = ""

    def of(self, title: str) -> Cover:
        """The cover of a report on something of that title."""
        today = datetime.date.today()
        return replace(self, title=self.title or title, date=self.date or f"{today.day} {today:%B %Y}")


NO_COVER = Cover()


def logo_address(path: Path) -> str:
    """A picture as a data address. Raises InputError for a file that cannot be read or is no picture of ``LOGOS``."""
    ending = path.suffix.lower()
    if ending not in LOGOS:
        raise InputError(f"--logo {path}: must end in {', '.join(LOGOS)}")
    try:
        content = read_bytes(path, "picture")
    except InputError as error:
        raise InputError(f"--logo {error}") from None
    kind, begin = LOGOS[ending]
    if not 0 < len(content) <= LARGEST_LOGO:
        raise InputError(f"--logo {path}: has {len(content)} bytes; from 1 to {LARGEST_LOGO} are allowed")
    if not re.match(begin, content, re.DOTALL):
        raise InputError(f"--logo {path}: is no {ending[1:]} picture: such a file begins with other bytes")
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def is_lone(dataset: xr.Dataset) -> bool:
    """True for a single wheelset without any body: no vehicle that EN 14363 could assess."""
    return "body" not in dataset.dims and len(wheelsets(dataset)) == 1


def paragraph(result: Result, summary: Summary, assessment: Assessment | None) -> str:
    """Vehicle, track, speed, contact and what was asked, in sentences."""
    with_contact = "wheel" in result.dataset.dims or "resolved_with" in result.dataset.attrs
    contact = contact_sentence(result.dataset) if with_contact else ""
    return " ".join(filter(None, (_motion(result, summary, assessment), contact, _asked(result))))


def vehicle_name(dataset: xr.Dataset) -> str:
    """The name of the vehicle; of results without one that of its file, "of the scenario" where there is none."""
    if name := dataset.attrs.get("vehicle"):
        return str(name)
    model = (table_of_scenario(dataset, "vehicle") or {}).get("model")
    return Path(str(model)).stem if model else "of the scenario"


def _motion(result: Result, summary: Summary, assessment: Assessment | None) -> str:
    dataset = result.dataset
    count, name = len(wheelsets(dataset)), vehicle_name(dataset)
    subject = f"Wheelset {name}" if is_lone(dataset) else f"Vehicle {name} ({count} wheelset{'s' * (count != 1)})"
    if "time" not in dataset.dims:
        return f"{subject}: {extent_text(dataset)}."
    if assessment:
        subject += f" with {_loads(assessment)}"
    kmh = 3.6 * float(dataset["speed"].mean()) if "speed" in dataset and dataset["speed"].size else None
    if kmh is None or "distance" not in dataset.coords or kmh < 1e-6:
        return f"{subject}: {extent_text(dataset)}."
    length = quantity(float(dataset["distance"].max() - dataset["distance"].min()), "m", ".0f")
    kind = "uneven" if "rail_lateral" in dataset else "smooth"
    curves = _curves(summary, assessment)
    return f"{subject} runs at {quantity(kmh, 'km/h', '.3g')} over {length} of {kind} track{curves}."


def _loads(assessment: Assessment) -> str:
    loads = [v for k, v in assessment.settings.items() if k.startswith("axle_load") and isinstance(v, float)]
    low, high = min(loads), max(loads)
    span = quantity(low, "kN", ".3g") if high < 1.005 * low else f"{low:.3g} to {quantity(high, 'kN', '.3g')}"
    return f"an axle load of {span}"


def _curves(summary: Summary, assessment: Assessment | None) -> str:
    """The full curves of a run: radius, hand, cant, and the cant deficiency of their sections."""
    first: Summary = next(iter(summary.get("wheelsets", {}).values()), {})
    texts = []
    for curve in first.get("full_curves", ()):
        hand = "left" if curve["radius_m"] > 0.0 else "right"
        texts.append(f"R {quantity(abs(curve['radius_m']), 'm', '.0f')} to the {hand}")
        if cant := abs(curve.get("cant_mm", 0.0)):
            texts[-1] += f" with {quantity(cant, 'mm', '.0f')} of cant"
        middle = 0.5 * (curve["from_m"] + curve["to_m"])
        inside = [s for s in (assessment.sections if assessment else ()) if s.start <= middle <= s.end]
        if inside and abs(missing := 1e3 * inside[0].cant_deficiency) >= 0.5:
            texts[-1] += f" ({quantity(abs(missing), 'mm', '.0f')} of cant {'deficiency' if missing > 0 else 'excess'})"
    return f" with {'a full curve' if len(texts) == 1 else 'full curves'} of {join_names(texts, 3)}" if texts else ""


def contact_sentence(dataset: xr.Dataset, origin: str = "") -> str:
    """Contact model, creep forces and friction of a scenario, in a sentence; origin: which one it is."""
    if "resolved_with" in dataset.attrs:
        return f"Contacts are solved again with {dataset.attrs['resolved_with']}."
    section = table_of_scenario(dataset, "contact")
    if section is None:
        return ""
    normal = section.get("normal", ContactSettings().normal)
    creep = section.get("tangential", USUAL[normal].tangential if normal in USUAL else "")
    about = f"Wheel-rail contact{origin}: {USUAL[normal].text if normal in USUAL else normal}"
    if creep in CREEP_LAWS and CREEP_LAWS[creep].text and dataset.attrs.get("analysis") != "conicity":
        friction = section.get("friction", DRY)
        how = f"coefficient of friction {friction:g}" if isinstance(friction, int | float) else "friction by its law"
        about += f"; creep forces by {CREEP_LAWS[creep].text}, {how}"
        heat = section.get("temperature", {})
        if change := heat.get("friction_change"):
            start = heat.get("friction_from_C", Heating().friction_from)
            about += f", which changes by {change:+g} over {heat['friction_over_K']:g} K from {start:g} °C on"
        if layer := section.get("layer"):
            kinds = {"thickness_mm": "shears elastically", "yield_stress_MPa": "yields"}
            about += f"; a layer between them that {' and '.join(text for key, text in kinds.items() if key in layer)}"
    turn = float(dataset["contact_angle_variation"].max()) if "contact_angle_variation" in dataset else 0.0
    if turn > TURNED and normal == "strips" and section.get("half_space", {}).get("influence") != "angle-corrected":
        about += (
            f". Normals turn by up to {degrees(turn):.0f} degrees over a patch, which the influence of pressures "
            "leaves out; wrsim resolve --contact strips+half_space.influence=angle-corrected tells what it would change"
        )
    return f"{about}."


def _asked(result: Result) -> str:
    asked = f"Analysis: {ASKED.get(result.analysis, result.analysis)}."
    return (
        asked if result.status == "completed" else f"{asked} The analysis {result.status} early: {result.stop_reason}."
    )


def basis(dataset: xr.Dataset, assessment: Assessment) -> str:
    """Basis of a verdict: smooth or uneven track, the sections of every class of track beside those that the standard
    asks, limits that are to be confirmed."""
    grounds = [f"simulation on {'uneven' if 'rail_lateral' in dataset else 'smooth'} track"]
    for zone in dict.fromkeys(s.zone for s in assessment.sections if s.zone != TRANSITION):
        sections = [s for s in assessment.sections if s.zone == zone]
        radii = sorted(abs(s.radius) for s in sections)
        span = f"{radii[0]:.0f}" if radii[-1] < 1.005 * radii[0] else f"{radii[0]:.0f} to {radii[-1]:.0f}"
        where = "straight" if zone == "straight" else f"R {span} m"
        needed = assessment.rules.needed.get(zone)
        count = f"{len(sections)} of {needed}*" if needed else str(len(sections))
        grounds.append(f"{count} section{'s' * (len(sections) != 1)} {where}")
    if any(v.limit is not None and v.limit.mark == "mem" for v in assessment.values):
        grounds.append("limits marked * to be confirmed")
    return f"Basis: {'; '.join(grounds)}."


def css_text(text: str) -> Markup:
    """A text as a string of a style sheet: all but letters and digits of ASCII as numbers, so that it ends nothing."""
    return Markup('"{}"').format("".join(c if c.isascii() and c.isalnum() else f"\\{ord(c):06x}" for c in text))


def together(parts: Sequence[str]) -> str:
    """Those of the texts that are not empty, with points between."""
    return " \N{MIDDLE DOT} ".join(filter(None, parts))
