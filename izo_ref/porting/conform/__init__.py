"""The harness of `izo conform`: runs a port, survives what it does, and reports.

May import the judge and the format of the vectors. Start reading with `run.py`.
"""
