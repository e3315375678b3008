"""Optimisation: values of keys that make outputs of scenarios as small, as large or as near to a target as can be.

``reading`` is the file with objectives and constraints, ``search`` what chooses candidates (`wrsim.study.candidates`),
``outcome`` what is told about the best one, ``files`` what is written.
"""
