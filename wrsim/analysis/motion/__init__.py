"""A vehicle at rest or running along the track."""
