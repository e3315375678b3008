"""One thread of BLAS, as commands have: imported before numpy."""

from wrsim.system import limit_blas_threads

limit_blas_threads()
