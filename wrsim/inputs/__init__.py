"""Reading what users write: TOML files, their sections, and faults in the user's words.

``toml_files`` reads and writes TOML, ``lines`` finds the line of a key, ``values`` has the types of keys,
``section`` is the base of every table of a file, with its rules,
``checking`` turns all faults of a file into one InputError.
"""
