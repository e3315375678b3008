"""Wear and rolling contact fatigue of a wheel and its rail: laws, and what a run leaves on both profiles."""
