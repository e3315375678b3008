"""Scenarios: a TOML file, checked key by key, becomes everything an analysis needs in SI units.

``loading`` reads a file (``merging``: with the files it starts from) into a Scenario; ``schema`` and the modules of
``sections`` say which keys there are; ``build`` reads the models and makes the Setup; ``cases`` lists static poses;
``placement`` looks whether the wheels stand on the rails.
"""
