"""Wheel and rail profiles: curves, readers, smoothing, wear."""
