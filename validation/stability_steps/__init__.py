"""Small steps full of trouble: how they are drawn, and how what comes out is judged.

`families.py` draws meshes and motions, `kinds.py` adds one kind of trouble, `judge.py` says which
claims of a result are not true. Start reading at `case.py`. `validation/study/random_steps.py` runs
them by the thousand. Nothing here imports a study.
"""
