"""Faults of the machine: commands are killed at random moments, and what they leave is looked at.

`python -m validation study stability --only kills` runs it. Start with `kills.py`.
"""
