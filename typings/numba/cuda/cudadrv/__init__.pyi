"""Stub of `numba.cuda.cudadrv`; `typings/numba/__init__.pyi` says why."""

from typing import Any

def __getattr__(name: str) -> Any:
    """Return anything."""
    ...
