"""Resolve a step: detect, select, group, solve, until the path is free; then certify it.

May import all stages but `app`. Start with `resolve.py`, then `iterate.py`.
"""
