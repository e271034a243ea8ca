"""What people touch: the command `izo`, the demo, files, the compile cache, pictures.

May import every stage. Start with `cli.py`.
"""
