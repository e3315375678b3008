"""What knows numba: compiling, the cache of compiled kernels, arrays in one buffer, kernels called by number.

Nothing else imports numba or llvmlite (import contract in pyproject.toml).
"""
