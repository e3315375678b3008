"""Surfaces of wheels and rails: profiles swept along the rail or turned about the axle, as tables and as kernels."""
