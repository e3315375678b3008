"""The track: segments, rails, irregularities, measured tables."""
