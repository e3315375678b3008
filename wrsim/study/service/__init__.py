"""Wheels that wear in service: weighted cases, the depth they leave, a new profile, and again."""
