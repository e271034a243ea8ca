"""The judge: compares the reply of a port with a case, without numpy and without compiled code.

May import the format of the vectors; `free_path.py` asks the path certificate when it is used.
Start reading with `verdict.py`.
"""
