"""Deliberate faults, put into a copy of the package one at a time: does the test suite notice?

`faults.py` has the list and `run.py` runs the tests. `python -m validation mutants` starts it.
"""
