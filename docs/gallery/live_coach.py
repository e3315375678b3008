"""
A coach that runs, R 300
========================

.. image:: /figures/live_coach.png
   :alt: A coach in a curve, the conformal patch of its leading outer wheel and its Y/Q
   :target: ../live/coach.html

`Open the page <../live/coach.html>`__: a program in one file, without an installation.
The Manchester benchmark coach with the strip model. The patch of the leading outer wheel climbs from the tread to the
flange root in the transition; histories have Y, Q and Y/Q with their limits.
"""

# sphinx_gallery_thumbnail_path = 'figures/live_coach.png'
from wrsim import write_live

write_live("../../scenarios/manchester_r300.toml", "../../build/pages/live/coach.html")
