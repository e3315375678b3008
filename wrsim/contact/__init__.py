"""The contact of wheel and rail, from profiles to forces and wear; it imports inputs, errors and jit only.

The room in the order of a computation:

1. ``profiles``: curves of wheels and rails, from files or shapes, smoothed, placed, worn (`load_profile`, `Profile`).
2. ``surfaces``: a profile swept along the rail or turned about the axle; sections along the rail, wheels out of round.
3. ``settings``: materials and choices (`ContactSettings`, `Friction`); ``tables``, ``workspace``: what kernels compute
   with, made once; ``records``, ``arrays``: its fields.
4. ``models``: the register of normal models; `contact_model` builds a ``model`` (`ContactModel`) of one wheel on one
   rail, ``batch`` takes many poses in one call.
5. ``wheel_rail``: the kernel, from a pose and a motion to forces. ``search``: outline of the yawed wheel, main points,
   lobes.
6. Normal pressure: ``kik_piotrowski`` (with ``overlap_patch``), ``strips``, or the exact solver ``half_space``.
7. ``creep``: coefficients of friction and creep forces over the strips.
8. ``resultants``, ``contact_angle``: forces, moments, figures of a lobe; ``patches``, ``channels``: what results show.
9. ``prescribed_load``: heights at which wheels carry a load. ``wear``: laws of wear and fatigue, losses of profiles.
10. ``subsurface``: stress and fatigue below the surface.
11. ``library``: all of it as a C library, with the files that it opens (``library_file``).

``__init__.pyi`` has the public names; they are imported when they are first used.
"""

from wrsim.inputs.lazy import homes_in, importer

_HOMES = homes_in(__file__)
__all__ = [*_HOMES]
__getattr__ = importer(__name__, _HOMES)
