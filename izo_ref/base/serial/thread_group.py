"""Thread groups: one thread, or the threads of one or several blocks of a GPU, that share a zone.

Code that is written for a thread group loops over the unknowns or constraints of a zone from
`group.rank()` in steps of `group.size()`. Only one thread writes an entry, and that thread may read
the entry at once. Other threads may read the entry after the next `wait`, sum or maximum, because
sums and maxima wait, too. Each thread must call every wait, sum and maximum. All threads get the
same sums and maxima, so they all take the same branches.
"""

from typing import Any, NamedTuple

from numba import typeof, types
from numba.core import config
from numba.extending import intrinsic

from izo_ref.base.compile import compiled


class ThreadGroup(NamedTuple):
    """The functions of a thread group.

    They are known when the code that calls them is compiled. So a group of one thread costs
    nothing.
    """

    rank: Any  # () -> the number of this thread, from 0
    size: Any  # () -> the number of threads
    wait: Any  # () -> None, when all threads have come here
    sums: Any  # (parts, a, b, c) -> three sums over all threads
    maxima: Any  # (parts, a, b) -> two maxima over all threads
    parts: Any  # work space of `sums` and `maxima`, where several blocks need it; else None


@compiled
def group_sum(group: ThreadGroup, a: float) -> float:
    """Return the sum of a number over all threads of a group."""
    return group.sums(group.parts, a, 0.0, 0.0)[0]


@compiled
def group_sums(group: ThreadGroup, a: float, b: float, c: float) -> tuple[float, float, float]:
    """Return the sums of three numbers over all threads of a group."""
    return group.sums(group.parts, a, b, c)


@compiled
def group_maxima(group: ThreadGroup, a: float, b: float) -> tuple[float, float]:
    """Return the maxima of two numbers over all threads of a group."""
    return group.maxima(group.parts, a, b)


@compiled
def _first_rank() -> int:
    return 0


@compiled
def _size_of_one() -> int:
    return 1


@compiled
def _no_wait() -> None:
    pass


@compiled
def _own_sums(_parts: Any, a: float, b: float, c: float) -> tuple[float, float, float]:
    return a, b, c


@compiled
def _own_maxima(_parts: Any, a: float, b: float) -> tuple[float, float]:
    return a, b


ALONE = ThreadGroup(_first_rank, _size_of_one, _no_wait, _own_sums, _own_maxima, None)


@intrinsic
def _alone_compiled(context):
    """Return ALONE in compiled code.

    As a constant, ALONE would be addresses of this process, and the compiled code could not be kept
    on the disk.
    """
    group = types.NamedTuple([typeof(function) for function in ALONE], ThreadGroup)

    def build(context, builder, signature, arguments):
        return context.get_constant_null(group)  # only its type is ever used

    return group(), build


def _alone_in_python() -> ThreadGroup:
    return ALONE


# () -> the group of one thread; kernels of the CPU call it
alone = _alone_in_python if config.DISABLE_JIT else _alone_compiled
