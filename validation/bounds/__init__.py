"""Derived bounds of rounding: a directed search for the input that comes closest to each of them.

`search.py` searches, `proofs.py` and `zones.py` list the bounds. A ratio above 1 refutes a bound.
One far below 1 says that the bound is wider than it has to be, or that the search does not find
the worst input. The folder may import the package and flint.
"""
