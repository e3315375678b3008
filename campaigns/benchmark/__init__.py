"""The yardstick: comparisons with figures of others, for this code and for any other one. See ``adapter.py``."""
