"""Resolve sequences of frames: each frame starts where the one before ends, rounded as a file is.

May import all stages but `app`. Start with `resolve.py`; `inspect.py` says what is wrong before.
"""
