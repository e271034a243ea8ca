"""Zones: select impacts, group them, state each zone's problem, judge an answer.

May import `base` alone. Start with `grouping.py` and `problem.py`.
"""
