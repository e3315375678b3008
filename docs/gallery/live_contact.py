"""
A wheel under your hand
=======================

.. image:: /figures/live_contact.png
   :alt: A wheel on its rail with a conformal patch, beside it the patches of two models
   :target: ../live/contact.html

`Open the page <../live/contact.html>`__: a program in one file, without an installation.
Drag the wheel 5 mm outward: a second patch appears on the gauge corner. At 6.6 mm the contact angle turns by 41 degrees
within one patch: the contact is conformal. See :doc:`/user/live`.
"""

# sphinx_gallery_thumbnail_path = 'figures/live_contact.png'
from wrsim import write_live

write_live(["contact", "wheels/S1002.toml", "rails/60E1.toml"], "../../build/pages/live/contact.html")
