"""Make an input that fails smaller and simpler, while it keeps failing in the same way.

`search.py` keeps the best input so far, `steps.py` and `zones.py` say how a step and a zone become
smaller, `failing.py` says what failing is. Start reading at `command.py`. Nothing here imports a
study.
"""
