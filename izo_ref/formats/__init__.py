"""Read and write animations in the formats that people have.

May import `base` alone; packages that not everybody has are imported when a file needs them. Start
with `animation.py`.
"""
