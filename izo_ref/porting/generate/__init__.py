"""Generators of the vectors, one for each stage. Start reading with `build.py`."""
