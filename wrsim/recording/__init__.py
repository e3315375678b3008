"""Track from the recording car: transfer functions of its systems, their inversion, designed track, irregularities."""
