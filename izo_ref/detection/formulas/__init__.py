"""Formulas over numbers and tuples; every target calls the same object."""
