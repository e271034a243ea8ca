"""The judge of a dump: arrays that a port wrote of its own scene, compared stage by stage.

Start reading with `../dump.py`, which takes the stages in order; `arrays.py` reads the dump, and
`report.py` has what is said about it.
"""
