"""Assessment of runs by a rule set, section by section of track: forces, derailment, wear, ride.

``assess_runs(result) -> Assessment`` is a pure function of a result.
"""

from wrsim.analysis.assessment.assess import assess_runs

__all__ = ["assess_runs"]
