"""The harness of `izo conform`: runs a port, survives what it does, and reports.

Start reading with `run.py`.
"""
