"""Normal pressure by the strip model."""
