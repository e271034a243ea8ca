"""The porting kit: vectors of each stage, the judge of a port's answers, traces of a run.

It may import every stage; only `app` imports it. Start reading with `stages.py`, which says what
goes into each stage and what comes out, and `cases.py`, which is the format of the vectors.
"""
