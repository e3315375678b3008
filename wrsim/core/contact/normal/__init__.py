"""Normal pressure."""
