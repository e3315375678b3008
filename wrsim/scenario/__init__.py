"""Scenarios: a TOML file, checked key by key, becomes everything an analysis needs in SI units.

``loading`` reads a file (``merging``: with the files it starts from) into a Scenario; ``schema`` and the modules of
``sections`` have the keys; ``build`` reads the models and makes the Setup; ``placement`` checks whether the wheels are
on the rails.
"""
