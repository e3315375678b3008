"""Quasi-static curving."""
