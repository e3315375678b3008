"""The command line. ``main`` is the entry point of the ``wrsim`` command."""

try:
    from wrsim.cli.commands import app, main
except KeyboardInterrupt:
    raise SystemExit(130) from None

__all__ = ["app", "main"]
