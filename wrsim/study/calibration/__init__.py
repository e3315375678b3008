"""Calibration: values of keys with which a model is nearest to a measurement, and how well the measurement tells them.

`sections` and `reading` have the file and what is fitted, `fit` the least squares, `intervals` what they tell,
`outcome` tables, pictures and files.
"""
