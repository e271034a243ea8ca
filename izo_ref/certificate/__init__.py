"""The path certificate: each candidate pair is proved apart or proved to meet.

May import `scene.py` and the stages below it. Start with `certify.py`; the exact arithmetic is in
`exact_path.py`.
"""
