"""Detection: find every vertex-face and edge-edge pair that meets on a path.

May import `base` alone. Start with `find.py`, then read `detector.py`. The proof that no pair is
missed is in `formulas/advance.py`.
"""
