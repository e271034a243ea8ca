"""The evidence: scenes, oracles, deliberate faults, studies that measure, reports that show.

The package never imports it. Start with `__main__.py`, the command `python -m validation`.
"""
