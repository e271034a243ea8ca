"""Faults of the machine: commands are killed at random moments, and what they leave is looked at.

`python -m validation.machine` runs it. Start with `kills.py`.
"""
