"""Algorithms over one zone, on one thread or on a group of threads."""
