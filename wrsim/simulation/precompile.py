"""The large kernels of a run along the track, compiled ahead: needs nothing but numba and `wrsim.jit`.

``python -m wrsim.simulation.precompile strips`` compiles the strip model into the cache, without a word all the others:
two processes side by side, while a machine is set up (``.ci/setup``).
"""

import sys
from typing import Any

from wrsim.contact.records import CONTACT, CREEP_FORCES, FREE_STRIPS
from wrsim.contact.wheel_rail import compile_stages
from wrsim.jit.stages import ARGUMENTS
from wrsim.vehicle.dynamics import derivative, sampling, vehicle_forces, wheel_forces

LARGE: tuple[tuple[Any, Any], ...] = (
    (wheel_forces.one_wheel, ARGUMENTS),
    (vehicle_forces.vehicle_forces, "(float64, float64[::1], float64[::1], float64[::1], float64[::1], int64[:, ::1])"),
    (
        derivative.add_differences,
        "(float64, int64, boolean, int64[:, ::1], int64[:, :, ::1], float64[:, ::1], float64[:, ::1], float64[::1], "
        "int64[:, ::1])",
    ),
    (
        sampling.forces_in_turn,
        "(float64[::1], float64[:, ::1], float64[:, ::1], int64[::1], float64[:, ::1], int64[::1], float64[:, ::1], "
        "float64[:, ::1], float64[::1], int64[:, ::1])",
    ),
)
"""The large ones of the kernels that any run along the track calls, and the types of their arguments."""


def compile_others() -> None:
    """All but the normal model."""
    compile_stages(CONTACT, CREEP_FORCES)
    for kernel, types in LARGE:
        kernel.compile(types)


if __name__ == "__main__":
    compile_stages(FREE_STRIPS) if sys.argv[1:] == ["strips"] else compile_others()
