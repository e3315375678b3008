"""The stages of a contact: kernels that are called by their numbers in core.contact.records (core.stages).

All but the whole contact take the lobes that the search has found, as many as ``total`` says, and return status bits.
"""

from wrsim.core import stages
from wrsim.core.compiling import kernel
from wrsim.core.contact.arrays import arrays, bodies
from wrsim.core.contact.normal.kik_piotrowski import press
from wrsim.core.contact.normal.lobes import bound_lobe, lay_lobe
from wrsim.core.contact.records import CONTACT, CREEP_FORCES, FREE_STRIPS, KIK_PIOTROWSKI, read_pose
from wrsim.core.contact.search.lobes import room_beside
from wrsim.core.contact.strips.model import press_strips
from wrsim.core.contact.tangential.creep_forces import creep_forces
from wrsim.core.contact.wheel_rail import wheel_rail


@kernel
def kik_piotrowski(buffer, index):
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
    press(settings, pose, lobes, a.strips, count, a.work)
    return status


@kernel
def free_strips(buffer, index):
    """Strips and pressures by the strip model."""
    a = arrays(buffer, index)
    wheel, rail, pose = bodies(a)
    return press_strips(a, wheel, rail, pose, a.total[0].lobes)


@kernel
def all_creep_forces(buffer, index):
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


def make_ready(*numbers):
    """See `core.stages.make_ready`."""
    for number in numbers:
        stages.make_ready(number, STAGES[number])
