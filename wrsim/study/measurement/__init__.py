"""Measured series beside a model: their files, what they are of, and where along the run they belong.

`sections` has the tables of a file, `reading` the series in SI units, `alignment` the series on the samples of a run.
"""
