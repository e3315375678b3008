"""The exact half-space solver: slow and trusted."""
