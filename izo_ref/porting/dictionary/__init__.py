"""The texts of the flags, by the stages that own them. `flags.py` beside this folder has them all.

Every text says what a port does wrong, what that does to a user, and where it was seen. A source
is named only if it is known; everything else is a typical slip. `validation/mutants` has the
faults of each kind that the tests of this package have to notice.
"""
