"""The stages of a contact: kernels that are called by their numbers in core.contact.records (core.jit.stages).

All but the whole contact take the lobes that the search has found, as many as ``total`` says, and return status bits.
"""

import sys
from pathlib import Path

import numpy as np

from wrsim.core.contact.arrays import arrays, bodies
from wrsim.core.contact.normal.kik_piotrowski import bound_lobe, lay_lobe, press_lobes
from wrsim.core.contact.records import CONTACT, CREEP_FORCES, FREE_STRIPS, KIK_PIOTROWSKI, read_pose
from wrsim.core.contact.search.lobes import room_beside
from wrsim.core.contact.strips.model import press_strips
from wrsim.core.contact.tangential.creep_forces import creep_forces
from wrsim.core.contact.wheel_rail import wheel_rail
from wrsim.core.jit import stages
from wrsim.core.jit.arena import Array, Ints
from wrsim.core.jit.cache import CONTACT as STORED
from wrsim.core.jit.compiling import kernel


@kernel
def kik_piotrowski(buffer: Array, index: Ints) -> int:
    """Strips and pressures by Kik and Piotrowski's model."""
    a = arrays(buffer, index)
    settings, lobes, count = a.settings[0], a.patches, a.total[0].lobes
    wheel, rail, pose = bodies(a)
    status = 0
    for i in range(count):
        left, right = room_beside(a.found, i, count)
        status |= bound_lobe(wheel, rail, settings, a.found, i, left, right, lobes)
    for i in range(count):
        lay_lobe(wheel, rail, settings, lobes, count, i, a.strips[i])
    press_lobes(settings, pose, lobes, a.strips, count, a.work)
    return status


@kernel
def free_strips(buffer: Array, index: Ints) -> int:
    """Strips and pressures by the strip model."""
    a = arrays(buffer, index)
    wheel, rail, pose = bodies(a)
    return press_strips(a, wheel, rail, pose, a.total[0].lobes)


@kernel
def all_creep_forces(buffer: Array, index: Ints) -> int:
    """Creep forces; the pressures are known."""
    a = arrays(buffer, index)
    speed, count = read_pose(a.pose).velocity.x, a.total[0].lobes
    for i in range(count):
        creep_forces(a.creep, a.shape, a.settings[0], speed, a.patches, a.strips, count, i, a.work)
    return 0


STAGES = {
    KIK_PIOTROWSKI: kik_piotrowski,
    FREE_STRIPS: free_strips,
    CREEP_FORCES: all_creep_forces,
    CONTACT: wheel_rail,
}


def compile_stages(*numbers: int) -> None:
    """See `core.jit.stages.make_ready`."""
    for number in numbers:
        stages.make_ready(number, STAGES[number])


def repeat_contacts(folder: str) -> None:
    """End the process with 0 if the contacts that came with shipped kernels come out of them again, to the bit."""
    paths = sorted(Path(folder).glob(STORED.format("*")))
    for path in paths:
        with np.load(path) as stored:
            compile_stages(*stored["stages"].tolist())
            buffer, index = stored["before"].copy(), stored["index"].copy()
            status = wheel_rail(buffer, index)
            if status != stored["status"] or buffer.tobytes() != stored["after"].tobytes():
                sys.exit(1)
    sys.exit(0 if paths else 1)
