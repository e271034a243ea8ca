"""The judge: compares the reply of a port with a case. Start reading with `verdict.py`."""
