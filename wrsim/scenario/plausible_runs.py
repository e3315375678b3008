"""Plausibility of what a scenario asks for besides its vehicle: curves, friction, step, profiles of rails."""

from collections.abc import Iterator
from itertools import chain

import numpy as np

from wrsim.contact.profiles.profile import Profile
from wrsim.contact.settings import Friction, FrictionAlong
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.steady import SteadyPlan
from wrsim.vehicle.speed import SpeedProfile

MOST_DEFICIENCY = 0.3
"""Cant deficiency over 1.5 m [m], of trains that tilt (EN 13803 [mem]); others run at 0.15 m."""
LEAST_CANT, LEAST_CURVATURE = 5e-3, 1.0 / 5000.0
"""What counts as cant [m] and as a curve [1/m]: tamping leaves errors of some 5 mm."""
MOST_FRICTION = 1.0
"""Coefficient of friction: dry steel on steel has 0.5 to 0.7, sanded up to 0.8."""
SHORTEST_STEP = 20e-6
"""Step [s] below that of rk44 in its hardest case, 26 us at 1 m/s (``simulation.step_size``)."""
PEAK, PEAK_REACH, WIDE = 1.3e-3, 10e-3, 90e-3
"""How far a flange falls from its tip within 10 mm to both sides, on a profile wider than 90 mm [m]: with its radius of
12 to 20 mm 2.7 mm and more, the crown of a rail (80 mm and more) up to 0.63 mm; 1.3 mm is their geometric mean."""


def run_doubts(setup: Setup) -> Iterator[str]:
    """One sentence for every implausible value."""
    yield from _curve_doubts(setup)
    laws = [each.laws if isinstance(each, FrictionAlong) else [each] for each in setup.contact.friction]
    largest = max(max(law.static, law.at_corner) for law in map(Friction.of, chain(*laws)))
    if largest > MOST_FRICTION and setup.conical is None:
        yield f"contact.friction = {largest:g}: plausible is up to {MOST_FRICTION:g}; dry steel on steel has 0.5 to 0.7"
    step = getattr(setup.plan, "step", None)
    if step is not None and step < SHORTEST_STEP * (1.0 - 1e-9):
        message = f"run.step_us = {1e6 * step:g}: plausible is {1e6 * SHORTEST_STEP:g} and more"
        yield f"{message}; without it a good one is chosen"
    for name in dict.fromkeys(rail.name for rail in setup.rails if _peaks(rail)):
        yield f"profile '{name}' of a rail is shaped like a wheel: the scan of another body?"


def _curve_doubts(setup: Setup) -> Iterator[str]:
    """The largest cant deficiency, and the largest cant that leans outward."""
    plan = setup.plan
    if isinstance(plan, RunPlan) and plan.speed > 0.0:
        profile = plan.profile or SpeedProfile.constant(plan.speed)
        times = np.linspace(0.0, min(plan.duration, 1e6), 20_001)
        places = np.clip(plan.start + profile.way(times), 0.0, setup.track.length)
        speeds, curvatures = profile.speed(times), setup.track.curvature(places)
        cants = setup.track.cant(places) * np.sign(curvatures)
        where = [f", at {place:.5g} m" for place in places]
    elif isinstance(plan, SteadyPlan):
        speeds, curvatures, cants = np.transpose([(p.speed, 1.0 / p.radius, p.cant) for p in plan.points])
        where = [""] * len(plan.points)
    else:
        return
    curved = np.abs(curvatures) > LEAST_CURVATURE
    deficiencies = np.where(curved, 1.5 * speeds**2 * np.abs(curvatures) / 9.81 - cants, 0.0)
    outward = np.where(curved, -cants, 0.0)
    for what, values, most, hint in (
        ("cant deficiency", deficiencies, MOST_DEFICIENCY, "plausible is up to 300 mm, of trains that tilt"),
        ("cant that leans outward", outward, LEAST_CANT, "positive cant_mm leans inside, in curves to either side"),
    ):
        k = int(np.argmax(values))
        if values[k] > most:
            curve = f"R {abs(1.0 / curvatures[k]):.4g} m, {3.6 * speeds[k]:.4g} km/h{where[k]}"
            yield f"track: {1e3 * values[k]:.4g} mm of {what} ({curve}); {hint}"


def _peaks(rail: Profile) -> bool:
    """Whether a rail's top is the tip of a flange."""
    u, w = rail.at(np.linspace(0.0, rail.length, 2001))
    top = int(np.argmax(w))
    beside = [w[int(np.argmin(np.abs(u - u[top] - reach)))] for reach in (-PEAK_REACH, PEAK_REACH)]
    return bool(np.ptp(u) > WIDE and w[top] - max(beside) > PEAK)
