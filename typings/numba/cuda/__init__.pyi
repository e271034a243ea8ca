"""Stub of `numba.cuda`; `typings/numba/__init__.pyi` says why."""

from typing import Any

class Dim3:
    """Place or size along three axes."""

    x: int
    y: int
    z: int

blockDim: Dim3
blockIdx: Dim3
gridDim: Dim3
threadIdx: Dim3

def grid(ndim: int) -> int:
    """Return the number of a thread in a launch along one axis; no kernel here has more."""
    ...

def __getattr__(name: str) -> Any:
    """Return anything."""
    ...
