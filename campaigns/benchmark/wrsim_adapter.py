"""wrsim as a code of the yardstick: strips with FaStrip unless a comparison names another model."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from campaigns.benchmark.adapter import Code
from campaigns.benchmark.comparison import ROOT

sys.path[:0] = [str(ROOT / "campaigns"), str(ROOT / "tests")]

import gz18
from climb import WHEEL
from out_of_round import CROWN, carrying
from out_of_round import RADIUS as OF_FLAT
from out_of_round import table as flat_table
from reference_contact import FRICTION, HALF_SPACING, STEEL, Chosen, Place, bench_place, own_place, solve
from support import crossings
from support.boxes import FIXED, box, displaced, element, last_loop, on_springs, rows
from support.contacts import RADIUS
from support.ellipse import roll, total
from support.knife_edge import KnifeEdge, KnifeEdgeForces, example_wheelset
from support.pushed_rails import TRACK, response, rolled, rolling, standing
from support.vehicles import manchester, on_track, shipped

from campaigns.benchmark.moved import moved
from wrsim.analysis import run
from wrsim.analysis.conicity.conicity import wheelset_conicity
from wrsim.analysis.overturning import stopped_at
from wrsim.analysis.ride import WEIGHTINGS
from wrsim.analysis.stationary.statics import static_state
from wrsim.contact.creep.flexibility import kalker_coefficients
from wrsim.contact.half_space.influence import Compliance, Operator
from wrsim.contact.half_space.normal import solve_normal
from wrsim.contact.half_space.rolling import solve_rolling
from wrsim.contact.model import Contact, ContactModel
from wrsim.contact.models import contact_model
from wrsim.contact.pose import Pose
from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.sections import circle, cone
from wrsim.contact.settings import ContactSettings, HalfSpaceSettings, Material
from wrsim.contact.tables import creep_coefficients
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.simulation.modes import linearise
from wrsim.track.segments import Arc, Straight, Transition
from wrsim.track.sleepers import Layer, RailBeam, SleeperTrack
from wrsim.track.track import Track
from wrsim.vehicle.dynamics import vehicle_forces
from wrsim.vehicle.elements import Spring
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import AxleBox, Body, Vehicle
from wrsim.vehicle.wheelset import Wheel, Wheelset


@cache
def _flat_wheel() -> ContactModel:
    """The wheel of CONTACT's test bank at all places across."""
    settings = ContactSettings(tangential="none", wheel=STEEL, rail=STEEL, damping=0.0)
    wheel, rail = cone("cylinder", "wheel", 0.0, -0.0302, 0.0302), circle("crown", "rail", CROWN, 0.05)
    return contact_model(wheel, rail, OF_FLAT, settings, out_of_round=[flat_table("all places")])


@cache
def _on_crossing(folder: Path) -> ContactModel:
    """S1002 on the wing and the nose, with creep forces."""
    surface = crossings.crossing(folder, 0.1, 0.33)
    return crossings.on(surface, "strips", load_profile("wheels/S1002.toml"), tangential="fastrip", friction=FRICTION)


STRIPS = Chosen.parse("strips")
TURNED = replace(STRIPS, settings=replace(STRIPS.settings, half_space=HalfSpaceSettings(influence="angle-corrected")))
MODELS = {"": STRIPS, "half-space": Chosen.parse("half-space"), "half-space, level": Chosen.parse("half-space/level")}
SCENARIOS = ROOT / "scenarios"
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
        contact = contact_model(wheel, rail, 1.0 / along_per_m, settings)
        pose = np.zeros(12)
        pose[2], pose[4] = contact.radius + 1e-3, 1.0
        loaded = contact.solve_many([pose], load_N, threads=1)
        p0, approach, area = (float(values[0, 0]) for values in (loaded.p0, loaded.approach, loaded.area))
        return {"p0_MPa": 1e-6 * p0, "approach_mm": 1e3 * approach, "area_mm2": 1e6 * area}

    def pose(self, *, wheel: str, rail: str, inclination: str, y_mm: float, roll_rad: float, yaw_rad: float,
             pitch_rad_per_s: float, load_N: float, friction: float, model: str, form: str = ""):  # fmt: skip
        place = bench_place(self.contact)
        if "MBench" not in wheel:
            place = own_place(wheel, rail, inclination, friction > 0.0)
        pose = Pose("", 1e-3 * y_mm, yaw_rad, load_N, -roll_rad)
        chosen, spin = MODELS[model], abs(pitch_rad_per_s)
        answer = moved(chosen, form, place, pose, spin) if form else solve(chosen, place, pose, spin, repeats=0)
        if answer is None:
            return None
        return {
            "p0_MPa": 1e-6 * answer.p0, "area_mm2": 1e6 * answer.area, "approach_mm": 1e3 * answer.approach,
            "N_N": answer.normal_force, "X_N": -float(answer.force[0]), "Y_N": -float(answer.force[1]),
            "angle_smin_rad": -max(answer.angles), "angle_smax_rad": -min(answer.angles),
            "x_mm": 1e3 * (answer.along - HALF_SPACING * np.sin(yaw_rad)),
        }  # fmt: skip

    def arcs(self, *, wheel_radius_mm: float, rail_radius_mm: float, rolling_radius_mm: float, y_mm: float,
             load_N: float, G_GPa: float, pitch_rad_per_s: float, turned: bool = False):  # fmt: skip
        across = circle("arc", "wheel", 1e-3 * wheel_radius_mm, 0.95e-3 * abs(wheel_radius_mm))
        rail = circle("arc", "rail", 1e-3 * rail_radius_mm, 0.98e-3 * abs(rail_radius_mm))
        rolling = pitch_rad_per_s > 0.0
        place = Place(across, rail, (HALF_SPACING, 0.0), 1e-3 * rolling_radius_mm, rolling)
        steel = Material(2.0e9 * G_GPa * 1.28, 0.28)
        chosen = TURNED if turned else STRIPS
        model_of_steel = replace(chosen, settings=replace(chosen.settings, wheel=steel, rail=steel))
        answer = solve(model_of_steel, place, Pose("", 1e-3 * y_mm, 0.0, load_N), pitch_rad_per_s, repeats=0)
        if answer is None:
            return None
        angles, region = np.degrees(answer.angles), answer.regions[0]
        return {
            "p0_MPa": 1e-6 * answer.p0, "approach_mm": 1e3 * answer.approach, "length_mm": 1e3 * region.length,
            "width_mm": 1e3 * sum(r.width for r in answer.regions), "angle_range_deg": abs(angles[1] - angles[0]),
            "direction_deg": np.degrees(np.arctan2(-answer.force[1], answer.force[2])),
        }  # fmt: skip

    def rail_corner(self, *, penetration_mm: Sequence[float]):
        side, columns = 4e-4, 51
        across = 1e-3 * np.array([*penetration_mm[:0:-1], *penetration_mm])[:, None]
        x = (np.arange(columns) - columns // 2) * side
        s = ((np.arange(len(across)) - len(across) // 2) * side)[:, None]
        operator = Operator(len(across), columns, side, side, Compliance.of(STEEL, STEEL))
        p = solve_normal(operator, across - 0.76859 * x**2, 1e-6).p
        slip = np.stack(np.broadcast_arrays(-4e-3 + 1.5372 * s, -9.8995e-3 - 1.5372 * (x + side / 6.0)))
        q = solve_rolling(operator, FRICTION * p, np.ascontiguousarray(slip)).q
        normal, along, aside, moment = side**2 * np.array([p, q[0], q[1], x * q[1] - s * q[0]]).sum(axis=(1, 2))
        kilo = {"N_kN": 1e-3 * normal, "X_kN": 1e-3 * along, "S_kN": 1e-3 * aside}
        return kilo | {"M_Nm": moment, "p0_MPa": 1e-6 * p.max()}

    def rounded_flat(self, *, pitch_rad: float, z_mm: float):
        model = _flat_wheel()
        sunk, contact = carrying(model, 1e-3 * z_mm, -pitch_rad)
        strips = np.concatenate(contact.strips)
        middle = strips[np.argmin(np.abs(strips["o"]))]
        place = 1e3 * float(strips["N"] @ strips["x"] / strips["N"].sum())
        p0 = 1e-6 * float(contact.patches["p0"].max())
        return {"z_mm": 1e3 * sunk, "x_mm": place, "approach_mm": 1e3 * float(middle["penetration"]), "p0_MPa": p0}

    def crossing(self, *, s_mm: float, y_mm: float, load_N: float, near_mm: float):
        model = _on_crossing(self.reference / "crossing_56e1")

        def lowered(sunk: float) -> Contact:
            origin = (0.0, 1e-3 * y_mm, RADIUS - sunk)
            return model.evaluate(origin, velocity=(1.0, 0, 0), omega=(0, 1.0 / RADIUS, 0), place=1e-3 * s_mm)

        sunk = brentq(lambda z: float(lowered(z).force[2]) - load_N, -2e-3, 2e-3, xtol=1e-9)
        outward = 1e-3 * near_mm - HALF_SPACING
        patch = min(lowered(sunk).patches, key=lambda p: abs(p["o"] - outward))
        figures = {"N_N": patch["N"], "p0_MPa": 1e-6 * patch["p0"], "x_mm": 1e3 * patch["x"]}
        return figures | {"z_mm": 1e3 * sunk, "y_mm": 1e3 * (patch["o"] + HALF_SPACING)}

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
        shape = load_profile(f"{kind}/{name}.toml")
        return {"down_mm": [-1e3 * float(shape.at(shape.arclength_of(1e-3 * y))[1]) for y in across_mm]}

    def conicity(self, *, amplitude_mm: Sequence[float], right_radius_mm: float):
        wheel, rail = (load_profile(ROOT / f"tests/data/en15302_{kind}_A.csv", kind) for kind in ("wheel", "rail"))
        wheels = Wheel(wheel, 0.46), Wheel(wheel, 1e-3 * right_radius_mm)
        plan = ConicityPlan(tuple(1e-3 * a for a in amplitude_mm), "none")
        result = wheelset_conicity(Wheelset("w", 1.0, (1.0,) * 3, 1.5, *wheels), (rail, rail), 1.43516, plan, "A on A")
        return {"tan_gamma_e": result.wheelset()["equivalent_conicity"].values}

    def wheelset_mode(self, *, speed_m_per_s: float, near_rad_per_s: float):
        law = KnifeEdge()
        forces = KnifeEdgeForces(example_wheelset(), speed_m_per_s, law=law)
        rest = forces.rolling({"z": law.radius - law.approach(50e3)}, ("z",))
        values = np.linalg.eigvals(linearise(forces, forces.bodies, rest.q, rest.q_t).state_matrix)
        hunting = values[np.argmin(np.abs(values - 1j * near_rad_per_s))]
        return {"growth_per_s": hunting.real, "frequency_rad_per_s": hunting.imag}

    def critical_speed(self, *, vehicle: str):
        linear = {"stability.nonlinear": False, "stability.speed_kmh": [180, 240, 260]}
        attributes = run(load(SCENARIOS / f"stability_{vehicle}.toml").with_values(linear)).dataset.attrs
        return {"speed_m_per_s": attributes["critical_speed_m_s"], "frequency_Hz": attributes["critical_frequency_Hz"]}

    def wheel_load(self, *, vehicle: str):
        with TemporaryDirectory() as folder:
            loads = static_state(build(gz18.scenario(self.reference, Path(folder), car=vehicle)).vehicle).wheel_loads
        return {"Q_kN": 1e-3 * loads.mean(), "spread": np.ptp(loads) / loads.mean()}

    def steady_curve(self, *, line: str):
        with TemporaryDirectory() as folder:
            sample = run(gz18.steady(self.reference, Path(folder), line)).dataset.isel(pose=0, wheelset=0)
        figures = {"lateral_mm": 1e3 * sample["lateral_shift"].item(), "yaw_mrad": 1e3 * sample["yaw"].item()}
        for wheel, name in enumerate(("outer", "inner")):
            wheel_sample = sample.isel(wheel=wheel)
            angle = wheel_sample["contact_angle"].values[np.nanargmax(wheel_sample["N"].values)]
            c, s, x, y, q = np.cos(angle), np.sin(angle), *(1e-3 * wheel_sample[key].item() for key in "XYQ")
            figures |= {f"{name}_N_kN": q * c + y * s, f"{name}_Tx_kN": -x, f"{name}_Ty_kN": y * c - q * s}
        return figures

    def momentum(self, *, seed: int):
        first, inertia = manchester().wheelsets[0], 3.0
        boxes = tuple(AxleBox(f"box {y}", y, 5.0, (1.0, inertia, 1.0)) for y in (1.0, -1.0))
        arms = [Spring(b.name, "spring", "frame", b.name, (0.5, b.y, 0.56), stiffness=(2e7, 9e6, 1e7)) for b in boxes]
        frame = Body("frame", 4000.0, (1000.0, 3000.0, 3500.0), (0.3, 0.0, 0.7))
        axle = replace(first, x=0.0, height=0.46, boxes=boxes)
        law = on_springs(Vehicle("on arms", (axle,), (frame,), tuple(arms), gravity=0.0))
        out = np.zeros(law.size)
        law(0.0, *displaced(law, int(seed)), out)
        bodies, wrenches = (law.workspace.views[k] for k in (vehicle_forces.BODIES, vehicle_forces.WRENCHES))
        place, force, moment = (rows(a[:2]) for a in (bodies["position"], wrenches["force"], wrenches["moment"]))
        turning = (np.cross(place, force) + moment).sum(axis=0) + inertia * out[12:].sum() * rows(bodies["left"])[0]
        left = np.abs(force.sum(axis=0)).max(), np.abs(turning).max()
        return dict(zip(("force", "moment_m"), left / np.abs(force).max(), strict=True))

    def friction_loop(self, *, kind: str, amplitude_mm: float):
        travel = {"rubber-spring": 4.0, "leaf-spring": 3.0}[kind]
        rubber_or_leaf = element(kind, stiffness_kN_per_m=200.0, friction_force_kN=3.0, friction_travel_mm=travel)
        rubber = kind == "rubber-spring"  # forgets its first strokes slowly
        loops, steps = (12, 200) if rubber else (3, 400)
        x, force = last_loop(on_springs(box(FIXED, rubber_or_leaf)), 1e-3 * amplitude_mm, loops, steps)
        return {"force_kN": 1e-3 * force.max(), "area_J": float(np.trapezoid(force, x))}

    def side_wind(self, *, force_kN: float):
        load = Load.constant("wind", "carbody", (0.0, 1e3 * force_kN, 0.0), (0.0, 0.0, 2.2))
        rest = static_state(replace(manchester(), loads=(load,)))
        gain = rest.wheel_loads[:, 0] - rest.wheel_loads.mean(axis=1)
        y, _, roll = rest.moved[0]
        return {"y_mm": 1e3 * y, "roll_mrad": 1e3 * roll, "gain_kN": 1e-3 * float(gain.mean())}

    def climb(self, *, flange_angle_deg: float, flange_length_mm: float, attack_mrad: float):
        with TemporaryDirectory() as folder:
            wheel = Path(folder, "wheel.toml")
            wheel.write_text(WHEEL.format(flange_angle_deg, flange_length_mm, 9.5), encoding="utf-8")
            values = {"vehicle.wheel": str(wheel), "climb.angle_of_attack_mrad": [attack_mrad]}
            values |= {"climb.Y_over_Q": [1.99], "climb.longest_m": 40.0}
            climbs = run(load(SCENARIOS / "climb.toml").with_values(values)).dataset
        return {"distance_m": climbs["climb_distance"].item()}

    def overturning(self, *, speed_km_per_h: float):
        setup = build(load(SCENARIOS / "overturning.toml").with_values({"overturning.run": True}))
        return {"falls": float(bool(stopped_at(setup, speed_km_per_h / 3.6)))}

    def line(self, *, straight_m: float, clothoid_m: float, radius_m: float, s_m: float):
        pieces = Straight(straight_m), Transition(clothoid_m), Arc(1e3, radius_m)
        track = Track.build(pieces, 1.5)
        x, y, _z = track.centre.position(s_m)
        return {"x_m": x, "y_m": y, "heading_rad": float(track.heading(s_m))}

    def rail_mobility(self, *, track: str, frequency_Hz: Sequence[float]):
        frequency, ground = np.array(frequency_Hz), Layer((50e6, 50e6), loss_factor=1.0)
        if track == "sleepers":
            # the source's shear stiffness is 2.06 % above its shear coefficient of 0.393: its closed form shows it
            rail = RailBeam(shear_vertical=1.0206 * 0.393)
            sleeper_track = SleeperTrack(rail, Layer((50e6, 300e6), loss_factor=0.25), ground, sleeper_mass=324.0)
            receptance = sleeper_track.receptance(frequency, 72.0)
        else:
            spacing = 0.05
            pads = Layer((300e6 * spacing,) * 2, (30e3 * spacing,) * 2)
            rail = RailBeam(shear_vertical=None, shear_lateral=None)
            sleeper_track = SleeperTrack(rail, pads, pads, None, spacing=spacing, sleeper_width=0.01)
            receptance = sleeper_track.receptance(frequency, 45.0, bays=1800, elements=1)
        return {"v_m_per_s_per_N": 2.0 * np.pi * frequency * np.abs(receptance)}

    def rail_in_time(self, *, frequency_Hz: float):
        rails = standing(replace(TRACK, elements=12), 60.0)
        return {"amplitude_m": abs(response(rails, frequency_Hz, "vertical"))}

    def rolling_load(self, *, speed_m_per_s: float, stiffness_MN_per_m2: float, damping_kNs_per_m2: float):
        spacing = 0.05
        pads = Layer((1e6 * stiffness_MN_per_m2 * spacing,) * 2, (1e3 * damping_kNs_per_m2 * spacing,) * 2)
        track = replace(
            TRACK, pad=pads, ballast=pads, sleeper_mass=None, spacing=spacing, sleeper_width=0.01, elements=1
        )
        return rolled(track, speed_m_per_s)

    def rolling_aside(self, *, speed_m_per_s: float, stiffness_MN_per_m2: float, push_kN: float):
        spacing = 0.05
        pads = Layer((1e6 * stiffness_MN_per_m2 * spacing,) * 2, (60e3 * spacing,) * 2)
        rail = RailBeam(torsion=1.0, shear_lateral=None, loss_factor=0.0)
        track = replace(
            TRACK, rail=rail, pad=pads, ballast=pads, sleeper_mass=None, spacing=spacing, sleeper_width=0.01, elements=1
        )
        plain, seen = shipped("wheelset_s1002"), list[tuple[float, float]]()
        push = Load.constant("push", plain.wheelsets[0].name, (0.0, 1e3 * push_kN, 0.0), (0.0, 0.0, 0.0))
        law = on_track(replace(plain, loads=(push,)), speed_m_per_s, structure=track).law
        rails = law.on_sleepers
        assert rails is not None
        rolling(law, 0.1, 2e-4, lambda t, q, q_t: seen.append((q[-4::2].sum(), rails.wheels["last_n"].sum())))
        aside, force = np.mean(seen[len(seen) // 2 :], axis=0)
        return {"aside_m_per_N": aside / force}

    def bridge(self, *, speed_km_per_h: float):
        values = {"contact.normal": "kik-piotrowski", "run.distance_m": 62.0, "vehicle.speed_kmh": speed_km_per_h}
        dataset = run(load(SCENARIOS / "bridge.toml").with_values(values)).dataset
        largest = {
            name: float(np.abs(dataset[f"deck_{name}"]).max()) for name in ("deflection", "moment", "acceleration")
        }
        return {
            "deflection_mm": 1e3 * largest["deflection"], "moment_kNm": 1e-3 * largest["moment"],
            "acceleration_m_per_s2": largest["acceleration"],
        }  # fmt: skip

    def ride_weighting(self, *, weighting: str, frequency_Hz: float):
        return {"factor": abs(WEIGHTINGS[weighting].response(np.array([frequency_Hz])))[0]}
