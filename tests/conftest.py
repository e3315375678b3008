"""Settings of the whole test suite."""

import sys

from hypothesis import settings

sys.exudynFast = False  # the module that checks ranges and lengths

# the first example of a test compiles kernels: no deadline; the same examples in every run
settings.register_profile("wrsim", deadline=None, derandomize=True)
settings.load_profile("wrsim")
