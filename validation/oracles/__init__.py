"""Oracles: slow, obvious programs that answer one question each, independently of `izo_ref`.

Nothing here imports `izo_ref`. Most oracles call a well-known library by other authors. Start
reading with `path.py`, which decides whether a pair meets, and with `rational.py`, which computes
the exact optimum of a zone.
"""
