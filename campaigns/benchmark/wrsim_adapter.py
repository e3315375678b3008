"""wrsim as a code of the yardstick: strips with FaStrip unless a comparison names another model."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ellipe, ellipk

from campaigns.benchmark.adapter import Code
from campaigns.benchmark.comparison import ROOT

sys.path[:0] = [str(ROOT / "campaigns"), str(ROOT / "tests")]

from reference_contact import HALF_SPACING, STEEL, Chosen, Place, bench_place, own_place, solve  # noqa: E402
from support.ellipse import roll, total  # noqa: E402

from wrsim.analysis.conicity.conicity import wheelset_conicity  # noqa: E402
from wrsim.contact.models import contact_model  # noqa: E402
from wrsim.contact.pose import Pose  # noqa: E402
from wrsim.contact.settings import ContactSettings, Material  # noqa: E402
from wrsim.contact.tables import creep_coefficients  # noqa: E402
from wrsim.core.contact.tangential.flexibility import kalker_coefficients  # noqa: E402
from wrsim.geometry.profile.models import load_profile  # noqa: E402
from wrsim.geometry.profile.sections import circle, cone  # noqa: E402
from wrsim.scenario.sections.conicity import ConicityPlan  # noqa: E402
from wrsim.vehicle.wheelset import Wheel, Wheelset  # noqa: E402

STRIPS = Chosen.parse("strips")
FALLING = {"fall_ratio": 0.1368 / 0.36, "fall_decay": np.log(2.0) / 0.99}
REDUCED = {"slope_k0": 0.54, "slope_alpha_inf": 0.02, "slope_beta": 0.62}


class Wrsim(Code):
    """Functions of the package; what it has no function for is made of its kernels as its tests do."""

    name = "wrsim"

    def __init__(self, reference: Path) -> None:
        super().__init__(reference)
        self.contact = reference / "contact"

    def hertz(self, *, along_per_m: float, across_per_m: float, load_N: float, G_GPa: float, nu: float, model: str):
        steel = Material(2.0e9 * G_GPa * (1.0 + nu), nu)
        settings = ContactSettings(normal=model or "strips", tangential="none", damping=0.0, wheel=steel, rail=steel)
        wheel, rail = cone("cylinder", "wheel", 0.0, -0.05, 0.05), circle("crown", "rail", 1.0 / across_per_m, 0.04)
        own = contact_model(wheel, rail, 1.0 / along_per_m, settings)
        pose = np.zeros(12)
        pose[2], pose[4] = own.radius + 1e-3, 1.0
        found = own.solve_many([pose], load_N, threads=1)
        p0, approach, area = (float(values[0, 0]) for values in (found.p0, found.approach, found.area))
        return {"p0_MPa": 1e-6 * p0, "approach_mm": 1e3 * approach, "area_mm2": 1e6 * area}

    def pose(self, *, wheel: str, rail: str, inclination: str, y_mm: float, roll_rad: float, yaw_rad: float,
             pitch_rad_per_s: float, load_N: float, friction: float):  # fmt: skip
        place = bench_place(self.contact)
        if "MBench" not in wheel:
            place = own_place(wheel, rail, inclination, friction > 0.0)
        answer = solve(
            STRIPS, place, Pose("", 1e-3 * y_mm, yaw_rad, load_N, -roll_rad), abs(pitch_rad_per_s), repeats=0
        )
        if answer is None:
            return None
        return {
            "p0_MPa": 1e-6 * answer.p0, "area_mm2": 1e6 * answer.area, "approach_mm": 1e3 * answer.approach,
            "N_N": answer.normal_force, "X_N": -float(answer.force[0]), "Y_N": -float(answer.force[1]),
            "angle_smin_rad": -max(answer.angles), "angle_smax_rad": -min(answer.angles),
        }  # fmt: skip

    def arcs(self, *, wheel_radius_mm: float, rail_radius_mm: float, rolling_radius_mm: float, y_mm: float,
             load_N: float, G_GPa: float, pitch_rad_per_s: float):  # fmt: skip
        across = circle("arc", "wheel", 1e-3 * wheel_radius_mm, 0.95e-3 * abs(wheel_radius_mm))
        rail = circle("arc", "rail", 1e-3 * rail_radius_mm, 0.98e-3 * abs(rail_radius_mm))
        rolling = pitch_rad_per_s > 0.0
        place = Place(across, rail, (HALF_SPACING, 0.0), 1e-3 * rolling_radius_mm, rolling)
        steel = Material(2.0e9 * G_GPa * 1.28, 0.28)
        own = replace(STRIPS, settings=replace(STRIPS.settings, wheel=steel, rail=steel))
        answer = solve(own, place, Pose("", 1e-3 * y_mm, 0.0, load_N), pitch_rad_per_s, repeats=0)
        if answer is None:
            return None
        angles, region = np.degrees(answer.angles), answer.regions[0]
        return {
            "p0_MPa": 1e-6 * answer.p0, "approach_mm": 1e3 * answer.approach, "length_mm": 1e3 * region.length,
            "width_mm": 1e3 * sum(r.width for r in answer.regions), "angle_range_deg": abs(angles[1] - angles[0]),
            "direction_deg": np.degrees(np.arctan2(-answer.force[1], answer.force[2])),
        }  # fmt: skip

    def kalker(self, *, a_over_b: float, nu: float):
        return dict(zip(("C11", "C22", "C23"), kalker_coefficients(creep_coefficients(nu), a_over_b), strict=True))

    def creep_forces(self, *, a_mm: float, b_mm: float, N_N: float, xi: float, eta: float, phi_per_mm: float,
                     friction: float, G_GPa: float, nu: float, model: str):  # fmt: skip
        if nu != 0.28:
            raise NotImplementedError
        radius = 1e-3 * np.sqrt(a_mm * b_mm)
        peak = 1.5 * N_N / (np.pi * radius**2)
        on = {"model": model or "fastrip", "friction": friction, "radius": radius, "peak": peak, "G": 1e9 * G_GPa}
        fx, fy, mz = total(roll(a_mm / b_mm, xi, eta, 1e3 * phi_per_mm, strips=60, cells=60, **on)) / (friction * N_N)
        return {"fx": fx, "fy": fy, "mz": mz / radius}

    def traction(self, *, creepage: float, N_N: float, A_per_m: float, a_over_b: float, speed_m_per_s: float, law: str):
        modulus, e2 = STEEL.shear_modulus / (1.0 - STEEL.poisson_ratio), 1.0 - a_over_b**2
        shape = (ellipe(e2) / a_over_b**2 - ellipk(e2)) * a_over_b**3 / e2  # Johnson, Contact Mechanics, (4.25)
        a = np.cbrt(1.5 * N_N * shape / (np.pi * modulus * A_per_m))
        on: dict[str, Any] = {"radius": a / np.sqrt(a_over_b), "peak": 1.5 * N_N * a_over_b / (np.pi * a * a)}
        model = {"model": "fastsim, parabolic", "friction": 0.36} | FALLING | REDUCED
        if law == "coulomb":
            model = {"model": "fastrip", "friction": 0.33}
        force = total(roll(a_over_b, xi=creepage, direction=speed_m_per_s, strips=60, cells=60, **on | model))
        return {"X_N": force[0]}

    def profile(self, *, kind: str, name: str, across_mm: Sequence[float]):
        own = load_profile(f"{kind}/{name}.toml")
        return {"up_mm": [1e3 * float(own.at(own.arclength_of(1e-3 * u))[1]) for u in across_mm]}

    def conicity(self, *, amplitude_mm: Sequence[float], right_radius_mm: float):
        wheel, rail = (load_profile(ROOT / f"tests/data/en15302_{kind}_A.csv", kind) for kind in ("wheel", "rail"))
        wheels = Wheel(wheel, 0.46), Wheel(wheel, 1e-3 * right_radius_mm)
        plan = ConicityPlan(tuple(1e-3 * a for a in amplitude_mm), "none")
        found = wheelset_conicity(Wheelset("w", 1.0, (1.0,) * 3, 1.5, *wheels), (rail, rail), 1.43516, plan, "A on A")
        return {"tan_gamma_e": found.wheelset()["equivalent_conicity"].values}
