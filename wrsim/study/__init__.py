"""Studies: one scenario run many times with some keys varied, on an existing engine (dask.distributed).

``spec`` is the study file, ``axes`` the values of its axes, ``plan`` the cases that come of it and their names;
``task`` is what a worker does with one case, ``outputs`` what is stored of its result; ``cluster`` finds workers and
``engine`` feeds them; ``collect`` makes one dataset of what lies in the folders of the cases.
"""
