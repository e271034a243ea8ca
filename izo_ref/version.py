"""The version, where it can be read without importing numba."""

__version__ = "0.1.0"
