"""A plane coach over rails on sleepers over a bridge, on its own: beside TTB-2D and beside wrsim's runs over bridges.

    python campaigns/plane_bridge.py [--span 20.1] [--no-ballast] [--rail-elements 1 2 4] [--steps-us 2000 1000 250]

Vertical and pitching motion of the Manchester coach at 100 km/h. Rails and bridge are Euler-Bernoulli beams of finite
elements, both rails in one; sleepers 0.6 m apart on pads; ballast with a mass below them, on subsoil beside the bridge.
Wheels are masses on the rail: of a wheel with the displacement w = N(x) u at x = v t the acceleration is
N u_tt + 2 v N' u_t + v^2 N'' u. Newmark's method of constant mean acceleration, Rayleigh damping of the bridge by its
first two frequencies. Numbers of the track: Zhai, Wang and Lin, Journal of Sound and Vibration 270 (2004) 673, those of
TTB-2D (D. Cantero, SoftwareX 20 (2022) 101253), whose bridges are whole numbers of elements of 0.3 m long: 20.1 m.

Prints mid-span deflection, bending moment and acceleration, largest values, and how far they are from TTB-2D's.
"""

import argparse
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

Array = NDArray[Any]
SPEED, GRAVITY, SPACING, AHEAD, BEHIND = 100.0 / 3.6, 9.81, 0.6, 52.2, 30.6
RAIL = 2 * 205.9e9 * 3.217e-5, 2 * 60.64
BRIDGE, DAMPING, ELEMENT = (35e9 * 0.52, 16587.0), 0.02, 0.3
PAD, SLEEPER, BALLAST, SUBSOIL, ON_BRIDGE = (65e6, 75e3), 251.0, (137.75e6, 58.8e3), (77.5e6, 31.15e3), (120e6, 600e3)
BALLAST_MASS = 531.4
BODY, FRAME, WHEELSET = (32000.0, 1.97e6), (2615.0, 1476.0), 1813.0
PRIMARY, SECONDARY, PIVOT, AXLE = (2.4e6, 8e3), (860e3, 40e3), 9.5, 1.28
PUBLISHED = 2.0576e-3, 989771.0, 0.1807


def shapes(x: float, a: float) -> Array:
    """Shape functions of an element of the length a at x, and their first two derivatives (3, 4)."""
    r = x / a
    value = [1 - 3 * r**2 + 2 * r**3, x * (1 - r) ** 2, 3 * r**2 - 2 * r**3, x * (r**2 - r)]
    slope = [6 * (r**2 - r) / a, 1 - 4 * r + 3 * r**2, 6 * (r - r**2) / a, 3 * r**2 - 2 * r]
    return np.array([value, slope, [(12 * r - 6) / a**2, (6 * r - 4) / a, (6 - 12 * r) / a**2, (6 * r - 2) / a]])


class Model:
    """Unknowns: body and frames (up, nose up), then rail, sleepers, bridge, ballast beside it."""

    def __init__(self, span: float, ballast: bool, rail_elements: int) -> None:
        before, on, after = round(AHEAD / SPACING), int(span / SPACING + 1e-9) + 1, round(BEHIND / SPACING)
        self.start, self.span, self.rail_step = before * SPACING, span, SPACING / rail_elements
        sleepers, rails = before + on + after, rail_elements * (before + on + after - 1) + 1
        elements = round(span / ELEMENT)
        first = np.cumsum([6, 2 * rails, sleepers, 2 * elements + 2])
        self.rail, self.bridge, self.size = int(first[0]), int(first[2]), int(first[3]) + before + after
        self.matrices = [sparse.lil_matrix((self.size, self.size)) for _ in range(3)]
        self._beam(self.rail, rails, self.rail_step, *RAIL)
        self._beam(self.bridge, elements + 1, ELEMENT, *BRIDGE)
        deck = slice(self.bridge, self.bridge + 2 * elements + 2)
        mass, damping, stiffness = self.matrices
        first_two = (np.pi * np.array([1, 2]) / span) ** 2 * np.sqrt(BRIDGE[0] / BRIDGE[1])
        of_mass, of_stiffness = np.linalg.solve(0.5 * np.array([1 / first_two, first_two]).T, [DAMPING, DAMPING])
        damping[deck, deck] = of_mass * mass[deck, deck] + of_stiffness * stiffness[deck, deck]
        for k in range(sleepers):
            sleeper, beside = int(first[1]) + k, int(first[3]) + (k if k < before else k - on)
            self._spring([self.rail + 2 * rail_elements * k, sleeper], [1, -1], PAD)
            mass[sleeper, sleeper] += SLEEPER
            if before <= k < before + on:
                below = self.bridge + 2 * round((k - before) * SPACING / ELEMENT)
                self._spring([sleeper, below], [1, -1], BALLAST if ballast else ON_BRIDGE)
            else:
                self._spring([sleeper, beside], [1, -1], BALLAST)
                self._spring([beside], [1], SUBSOIL)
                mass[beside, beside] += BALLAST_MASS
        for i in range(elements + 1 if ballast else 0):
            mass[self.bridge + 2 * i, self.bridge + 2 * i] += BALLAST_MASS * ELEMENT / SPACING
        for i, inertia in enumerate((*BODY, *FRAME, *FRAME)):
            mass[i, i] += inertia
        for i, way in ((2, 1.0), (4, -1.0)):
            self._spring([0, 1, i], [1.0, way * PIVOT, -1.0], SECONDARY)
        self.matrices = [m.tocsr() for m in self.matrices]
        self.free = np.setdiff1d(np.arange(self.size), [self.bridge, deck.stop - 2])

    def _beam(self, first: int, nodes: int, a: float, bending: float, mass: float) -> None:
        k = [[12, 6 * a, -12, 6 * a], [6 * a, 4 * a**2, -6 * a, 2 * a**2]]
        k += [[-12, -6 * a, 12, -6 * a], [6 * a, 2 * a**2, -6 * a, 4 * a**2]]
        m = [[156, 22 * a, 54, -13 * a], [22 * a, 4 * a**2, 13 * a, -3 * a**2]]
        m += [[54, 13 * a, 156, -22 * a], [-13 * a, -3 * a**2, -22 * a, 4 * a**2]]
        for i in range(first, first + 2 * nodes - 2, 2):
            self.matrices[0][i : i + 4, i : i + 4] += mass * a / 420 * np.array(m)
            self.matrices[2][i : i + 4, i : i + 4] += bending / a**3 * np.array(k)

    def _spring(self, places: list[int], way: list[float], of: tuple[float, float]) -> None:
        for matrix, number in zip(self.matrices[:0:-1], of, strict=True):
            matrix[np.ix_(places, places)] += number * np.outer(way, way)

    def matrices_at(self, time: float) -> tuple[list[Any], Array]:
        """Matrices and forces with the wheels at their places."""
        force, matrices = np.zeros(self.size), [m.copy() for m in self.matrices]
        force[[0, 2, 4]] = -GRAVITY * np.array([BODY[0], FRAME[0], FRAME[0]])
        terms: list[list[Array]] = [[], [], []]
        rows, columns = [], []
        for frame, pivot in ((2, PIVOT), (4, -PIVOT)):
            for way in (1.0, -1.0):
                x = 21.6 + SPEED * time + pivot + way * AXLE - PIVOT - AXLE
                e = int(x / self.rail_step)
                value, slope, bend = shapes(x - e * self.rail_step, self.rail_step)
                unknowns = np.append([frame, frame + 1], self.rail + 2 * e + np.arange(4))
                n, n_x, n_xx = (np.append([0, 0], shape) for shape in (value, slope, bend))
                travel = np.append([1.0, way * AXLE], np.zeros(4)) - n
                terms[0].append(WHEELSET * np.outer(n, n))
                terms[1].append(PRIMARY[1] * np.outer(travel, travel) + 2 * WHEELSET * SPEED * np.outer(n, n_x))
                moving = WHEELSET * SPEED**2 * np.outer(n, n_xx) - PRIMARY[1] * SPEED * np.outer(travel, n_x)
                terms[2].append(PRIMARY[0] * np.outer(travel, travel) + moving)
                rows.append(np.repeat(unknowns, 6))
                columns.append(np.tile(unknowns, 6))
                force[unknowns[2:]] -= WHEELSET * GRAVITY * value
        places = np.concatenate(rows), np.concatenate(columns)
        more = (sparse.csr_matrix((np.ravel(t), places), shape=matrices[0].shape) for t in terms)
        matrices = [(a + b)[self.free][:, self.free] for a, b in zip(matrices, more, strict=True)]
        return matrices, force[self.free]

    def mid_span(self, u: Array) -> tuple[float, float]:
        """Value there, and bending moment, from both sides, linear between the nodes beside it."""
        whole = np.zeros(self.size)
        whole[self.free] = u
        e = int(self.span / 2 / ELEMENT + 1e-9)
        part = self.span / 2 / ELEMENT - e
        nodes = [whole[self.bridge + 2 * i : self.bridge + 2 * i + 4] for i in (e - 1, e, e + 1)]
        ends = [BRIDGE[0] * np.array([shapes(x, ELEMENT)[2] @ n for x in (0.0, ELEMENT)]) for n in nodes]
        moments = [0.5 * (ends[i][1] + ends[i + 1][0]) for i in (0, 1)]
        value = shapes(part * ELEMENT, ELEMENT)[0] @ nodes[1]
        return float(value), float((1 - part) * moments[0] + part * moments[1])

    def run(self, step: float) -> Array:
        """Largest deflection [m], bending moment [N m] and acceleration [m/s2] at mid-span."""
        (_, _, stiffness), force = self.matrices_at(0.0)
        u = splu(stiffness.tocsc()).solve(force)
        u_t, u_tt, rows = np.zeros_like(u), np.zeros_like(u), []
        for k in range(1, int((self.start + self.span + 30.0 - 21.6) / SPEED / step)):
            (mass, damping, stiffness), force = self.matrices_at(k * step)
            of_mass, of_damping = 4 / step**2 * u + 4 / step * u_t + u_tt, 2 / step * u + u_t
            whole = stiffness + 2 / step * damping + 4 / step**2 * mass
            u = splu(whole.tocsc()).solve(force + mass @ of_mass + damping @ of_damping)
            u_t, u_tt = 2 / step * u - of_damping, 4 / step**2 * u - of_mass
            rows.append((*self.mid_span(u), self.mid_span(u_tt)[0]))
        return np.asarray(np.abs(rows).max(axis=0))


def main() -> None:
    """Print a line a case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--span", type=float, default=20.1, help="m, a whole number of elements")
    parser.add_argument("--no-ballast", action="store_true", help="sleepers of the bridge on pads of their own")
    parser.add_argument("--rail-elements", type=int, nargs="+", default=[2], help="from sleeper to sleeper")
    parser.add_argument("--steps-us", type=float, nargs="+", default=[1000.0])
    arguments = parser.parse_args()
    for elements in arguments.rail_elements:
        for step in arguments.steps_us:
            peaks = Model(arguments.span, not arguments.no_ballast, elements).run(1e-6 * step)
            off = ", ".join(f"{100 * part:+.2f} %" for part in peaks / PUBLISHED - 1.0)
            numbers = f"{1e3 * peaks[0]:.4f} mm, {peaks[1]:.0f} N m, {peaks[2]:.4f} m/s2"
            print(f"{elements} elements, {step:g} us: {numbers}; {off}")


if __name__ == "__main__":
    main()
