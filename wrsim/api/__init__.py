"""What the commands do, as functions: each takes scenarios, results or files and returns an `Outcome`.

The command line calls these functions; `wrsim.run` is ``wrsim run`` of any analysis (curving, steady, stability ...).
Files are written where ``output`` names a folder; messages of errors name options as the command line writes them.
"""
