"""The normal models, by their numbers: pressures of all lobes whose strips are laid.

A model writes, with damping, the strips' N and p (and what it changes of their geometry), the creepages, and the lobes'
N, p0, area, length, amplitude and n_strips (0 out of contact). How the strips are laid for it say ``recess``,
``joint`` and ``fewest`` of the settings; `wrsim.contact.models` lists them.
"""

from wrsim.core.compiling import kernel
from wrsim.core.contact.normal.kik_piotrowski import press
from wrsim.core.contact.strips.pressure import press_strips

KIK_PIOTROWSKI, FREE_STRIPS = range(2)


@kernel
def press_lobes(a, pose, count):
    """Pressures of ``count`` lobes after the model of the settings; a: Arrays of core.contact.wheel_rail. Returns a
    status."""
    settings = a.settings[0]
    if settings.normal == FREE_STRIPS:
        return press_strips(a, pose, count)
    press(settings, pose, a.patches, a.strips, count, a.work)
    return 0
