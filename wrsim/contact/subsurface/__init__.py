"""Stress below the surface of a wheel or a rail, and fatigue by depth.

``loads``: tractions of a contact and the stresses below them (`SurfaceLoads`); ``rectangle``: the kernel;
``stress``: tensors and their measures; ``fatigue``: Dang Van and Crossland over a passage of the contact.
"""
