"""The command line. ``main`` is the entry point of the ``wrsim`` command."""

from wrsim.cli.commands import app, main

__all__ = ["app", "main"]
