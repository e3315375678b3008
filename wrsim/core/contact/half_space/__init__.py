"""Kernels of the exact half-space solver."""
