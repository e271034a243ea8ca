"""Ladders from mild to absurd: how far the method holds, where it ends, what it says beyond.

Each family is a file with a list LADDERS. Start reading with `ladder.py`; `judge_zone.py` and
`judge_step.py` run one rung and compare it with what is known. The folder may import the package,
`validation/scenes/`, `validation/oracles/` and `validation/limits.py`.
"""
