"""Track from the recording car: what its systems measure, how that is undone, what was designed and what is left."""
