"""Fuzz the door: everything that a user can hand in, from arrays to files.

`trial.py` says what one input is and runs it. `contract.py` says, slowly and with Python's numbers,
which inputs are valid; `tables.py` says what an array is, `start.py` whether a start is free.
`arrays.py`, `calls*.py`, `archives.py` and `readers.py` make inputs, and `families.py` lists them.
`run.py` runs them in batches, in processes with limits; start reading there. This folder imports
the package, the oracles and the rest of `validation/`.
"""
