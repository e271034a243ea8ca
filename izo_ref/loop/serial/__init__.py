"""Algorithms over one zone or one query, on one thread."""
