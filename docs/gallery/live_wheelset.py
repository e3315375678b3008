"""
A wheelset that runs, R 300
===========================

.. image:: /figures/live_wheelset.png
   :alt: A wheelset in a curve, its contact patch and its Y/Q
   :target: ../live/wheelset.html

`Open the page <../live/wheelset.html>`__: a program in one file, without an installation.
Press Run: a free wheelset enters a curve of 300 m. Change the friction or the speed as it runs.
"""

# sphinx_gallery_thumbnail_path = 'figures/live_wheelset.png'
from wrsim import write_live

write_live("../../scenarios/curve_r300.toml", "../../build/pages/live/wheelset.html")
