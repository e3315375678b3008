"""Paths and frames along them."""
