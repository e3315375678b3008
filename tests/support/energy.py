"""Where the energy of a run goes, from the forces at its samples."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario
from wrsim.simulation.bodies import mass_matrix
from wrsim.simulation.integrate import Integration
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import BodySystem

Array = NDArray[np.float64]
Further = Callable[[VehicleOnTrack, Array, Array], float]


def balance(scenario: Scenario, further: Further | None = None) -> tuple[Array, Array, Array, Array]:
    """Times of a run on level track [s], and from its start on the change of kinetic energy, the work of the drive, and
    what creep has dissipated [J]. What weight and springs hold and dampers take is left out: when it is quiet they are
    as at the start.

    further: energy in a state (law, q, q_t) besides that of the bodies [J].
    """
    setup = build(scenario)
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    system = BodySystem(law.bodies, law)
    motion = Integration(
        system, duration=setup.plan.duration, step=1.25e-3, weight=law.vehicle.weight, sample_interval=5e-3
    ).run(q, q_t)
    assert motion.status == "completed"
    n = 6 * len(law.bodies)
    powers, losses, energies = [], [], []
    for t, state, rates in zip(motion.times, motion.q, motion.q_t, strict=True):
        law.at(t, state, rates)
        powers.append(float(np.sum(law.axles["power"])))
        arrays = [wheel.model.arrays for pair in law.wheels for wheel in pair]
        losses.append(sum(float(a.total["wear"]) * float(a.pose[6]) for a in arrays))
        more = 0.0 if further is None else further(law, state, rates)
        energies.append(0.5 * rates[:n] @ mass_matrix(law.bodies, state)[:n, :n] @ rates[:n] + more)
    work, loss = (cumulative_trapezoid(p, motion.times, initial=0.0) for p in (powers, losses))
    return motion.times, np.array(energies) - energies[0], work, loss
