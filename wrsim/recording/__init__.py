"""Track from the recording car: from the table of a car to a track that vehicles run on.

The path of a recording: ``layout`` finds the table in its file, ``names`` what the columns hold, unless a map of them
(``columns``) says it; ``reading`` makes records in SI units at even distances, without ``dropouts`` and spikes.
``design`` fits straights, transitions and arcs to curvature and cant; ``systems`` has the transfer functions of the
car's measuring systems and their inverses; ``restoring`` inverts the records and lays the rails beside the design.
``tables`` and ``picture`` show the result, ``scenario_file`` writes it as a track, irregularities and a scenario.
"""
