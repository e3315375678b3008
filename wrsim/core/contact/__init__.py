"""One wheel on one rail, stage by stage: search, normal pressure, creep forces."""
