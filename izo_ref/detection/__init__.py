"""Find every vertex-face and edge-edge pair that meets on a path.

May import `base` alone. Start with `find.py`, then `detector.py`; the proof that nothing is missed
is in `formulas/advance.py`.
"""
