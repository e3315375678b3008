"""Rigid bodies, suspension and the forces on a whole vehicle."""
