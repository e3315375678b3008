"""Creep forces over the strips of a patch."""
