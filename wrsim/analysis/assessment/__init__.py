"""Assessment of runs as a railway does it: EN 14363 and UIC 518, derailment, wear, section by section of track.

``assess_runs(result) -> Assessment`` is a pure function of a result.
"""

from wrsim.analysis.assessment.assess import assess_runs

__all__ = ["assess_runs"]
