"""The command line. ``main`` is the entry point of the ``wrsim`` command."""

from wrsim.system import limit_blas_threads

limit_blas_threads()
try:
    from wrsim.cli.commands import application, main
except KeyboardInterrupt:
    raise SystemExit(130) from None

__all__ = ["application", "main"]
