"""
A tram wheelset that runs, R 25
===============================

.. image:: /figures/live_tram.png
   :alt: A tram wheelset on grooved rails, guided by the back of its flange
   :target: ../live/tram.html

`Open the page <../live/tram.html>`__: a program in one file, without an installation.
After 1.2 s the back of the inner wheel's flange meets the guard face of the grooved rail and guides alone. The
motion is fast there: the page takes steps of 0.5 ms.
"""

# sphinx_gallery_thumbnail_path = 'figures/live_tram.png'
from wrsim import write_live

write_live("../../scenarios/tram_r25.toml", "../../build/pages/live/tram.html")
