"""Numba kernels: plain floats and arrays in, values and an integer status out.

Contract of every function below this package:

- arguments are floats, integers and C-contiguous float64 arrays; no Python objects, no strings, no globals that a
  user may change;
- nothing is allocated; results go to arrays of the caller or come back as tuples of numbers;
- nothing is raised; a status names what went wrong, and the shell above raises;
- lengths in metres, forces in newtons, angles in radians.

``core.jit`` compiles them and keeps the compiled code on disk.
"""
