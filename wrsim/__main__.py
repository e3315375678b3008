"""``python -m wrsim`` is ``wrsim``."""

from wrsim.cli import main

main()
