"""Wheels that wear in operation: weighted cases, the depth they leave, a new profile, and again."""
