"""Assessment of runs by a rule set, section by section of track: forces, derailment, wear, ride."""
