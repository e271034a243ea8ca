"""Small steps with known answers, and the commands that make them; see `data/README.md`.

`recipes.py` and `shapes.py` need numpy alone, `truth.py` asks the exact oracle and izo_ref,
`make.py` is the command. Start reading in `recipes.py`.
"""
