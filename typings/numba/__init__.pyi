"""numba has no types: the type checker takes almost everything in it as `Any`.

Without these stubs it reads numba's sources, which describe what runs while functions are compiled,
and reports errors at every intrinsic and at everything that a kernel takes from `numba.cuda`.
"""

from typing import Any

prange = range  # so that what it counts is an index

def __getattr__(name: str) -> Any:
    """Return anything."""
    ...
