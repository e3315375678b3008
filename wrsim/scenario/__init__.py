"""Scenarios: a TOML file, checked key by key, becomes everything an analysis needs in SI units.

``loading`` reads a file (``merging``: with the files it starts from) into a Scenario; ``schema`` and the modules of
``sections`` have the keys; ``build`` and its parts for vehicle and track read the models and make the Setup.
"""
