"""Ground of all stages: records, options, errors, checks, compiling, the door to a GPU.

Imports no other stage. Start with `records.py` and `options.py`.
"""
