"""Fuzz the door: everything that a user can hand in, from arrays to files.

`trial.py` says what one input is and runs it. `contract.py` says, slowly and with Python's numbers,
which inputs are valid. `arrays.py`, `calls.py`, `archives.py`, `readers.py` and `texts.py` make
inputs, and `families.py` lists them. `run.py` runs them in batches, in processes with limits; start
reading there. This folder imports the package, the oracles and the rest of `validation/`.
"""
