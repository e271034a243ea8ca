"""Solve zone problems: one method a file, with the sparse algebra they need.

May import `zones` and `base`. Start with `solve.py`.
"""
