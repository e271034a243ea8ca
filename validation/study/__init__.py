"""Studies: each measures something and adds rows; `validation/report` makes pages of the rows.

`python -m validation` starts them. A study of several parts has them in its dictionary `PARTS`, and
all studies resume: they measure only the rows that are missing.
"""
