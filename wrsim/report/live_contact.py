"""The live page of the contact: wheels on rails, by the strip model and by Kik and Piotrowski's beside each other."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import to_hex

from wrsim.contact.creep.laws import CREEP_LAWS
from wrsim.contact.library.build import PUBLIC, contact_wasm
from wrsim.contact.library_file import pieces_of
from wrsim.contact.models import contact_model
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import USUAL, ContactSettings, Material, Normal
from wrsim.inputs.lookup import model_file
from wrsim.plots.theme import pressure_map
from wrsim.report.live import Segments, live_page
from wrsim.report.view_data import outline_points
from wrsim.simulation.pose_solver import ROLLING_SPEED

MOST_PAIRS = 12  # in one page: each wheel, rail and pair takes 0.3 to 0.5 MB
NAMES: dict[Normal, str] = {"strips": "Strips", "kik-piotrowski": "Kik-Piotrowski"}
PAPER = Material(208e9, 0.3)
PAPER_SHIFTS_MM = (0, 8, 9, 10)
PAPER_CASE = {"mu": 0.0, "load": 24e3}
"""The four cases of Marques et al.: docs/developers/static_paper.md."""


@dataclass(frozen=True)
class LivePair:
    """A wheel on a rail, inclined already.

    radius: at the tape circle [m]; place: outward from the rail's origin to that of the wheel at no shift [m];
    settings: of both models, by their names.
    """

    name: str
    wheel: Profile
    rail: Profile
    radius: float
    place: float
    settings: Mapping[Normal, ContactSettings]

    @classmethod
    def usual(cls, name: str, wheel: Profile, rail: Profile, radius: float, gauge: float, spacing: float) -> "LivePair":
        """With the models as they are without other choices, without damping. gauge, spacing of the profiles [m]."""
        settings: dict[Normal, ContactSettings] = {
            normal: ContactSettings(normal=normal, damping=0.0) for normal in NAMES
        }
        return cls(name, wheel, rail, radius, _place(rail, gauge, spacing), settings)

    @property
    def about(self) -> str:
        """What is assumed, in one line."""
        strips = self.settings["strips"]
        laws = ", ".join(f"{USUAL[n].text} with {CREEP_LAWS[c.creep_forces].text}" for n, c in self.settings.items())
        return (
            f"Linear elastic, E {strips.wheel.youngs_modulus / 1e9:g} GPa, Poisson {strips.wheel.poisson_ratio:g}; one"
            f" coefficient of friction; {laws}; R {1e3 * self.radius:g} mm, rolling at {ROLLING_SPEED:g} m/s, without"
            " damping. Lengths in mm, forces on the rail in kN, pressures in MPa; outward and the contact angle of a"
            " flange are positive."
        )


def _place(rail: Profile, gauge: float, spacing: float) -> float:
    """Outward from the rail's origin to that of the wheel at no shift [m]."""
    return 0.5 * (spacing - gauge) + float(rail.gauge_point()[0])


def _paper_pair() -> LivePair:
    """The wheel of the paper's stand-in on UIC54."""
    wheel = load_profile(model_file("wheels/lrv_standin.toml", ()))
    rail = load_profile(model_file("rails/54E1.toml", ())).inclined(1 / 20)
    common: dict[str, Any] = dict(damping=0.0, wheel=PAPER, rail=PAPER)
    settings: dict[Normal, ContactSettings] = {
        "strips": ContactSettings(normal="strips", **common),
        "kik-piotrowski": ContactSettings(normal="kik-piotrowski", approach="constant", strip_width=1e-4, **common),
    }
    name = "Paper: LRV stand-in on 54E1 1:20"
    return LivePair(name, wheel, rail, 0.375, _place(rail, 1.0, 1.055), settings)


def contact_page(pairs: list[LivePair], title: str, friction: float, load: float) -> str:
    """The page. friction, load [N]: to begin with."""
    segments, every = Segments(), [*pairs, _paper_pair()]
    cases = [
        {"words": f"{shift} mm", "pair": len(pairs), "shift": 1e-3 * shift} | PAPER_CASE for shift in PAPER_SHIFTS_MM
    ]
    data = {
        "models": list(NAMES.values()),
        "pairs": [_packed_pair(pair, segments) for pair in every],
        "segments": segments.packed,
        "layout": {
            part.lower(): [(name, kind[name].kind) for name in names.split()] for part, (kind, names) in PUBLIC.items()
        },
        "cases": cases,
        "start": {"mu": friction, "load": load},
        "colours": [to_hex(c) for c in pressure_map()(np.linspace(0.0, 1.0, 32))],
    }
    return live_page("live_contact.html", title, contact_wasm(), data)


def _packed_pair(pair: LivePair, segments: Segments) -> dict[str, Any]:
    models = (contact_model(pair.wheel, pair.rail, pair.radius, pair.settings[name]) for name in NAMES)
    (u, w), (o, b) = (outline_points(p, 400, 0.01) for p in (pair.wheel, pair.rail))
    return {
        "name": pair.name,
        "about": pair.about,
        "radius": pair.radius,
        "place": pair.place,
        "speed": ROLLING_SPEED,
        "wheel": np.stack((u, pair.radius - w), axis=1).round(7).tolist(),
        "rail": np.stack((1e3 * o, 1e3 * b), axis=1).round(4).tolist(),
        "contacts": [segments.add(pieces_of(model.library_file(tractions=True))) for model in models],
    }
