"""Thread groups: one thread, or the threads of one or several blocks of a GPU, that share a zone.

Code that is written for a thread group loops over the unknowns or constraints of a zone from
`group.rank()` in steps of `group.size()`. Only one thread writes an entry, and that thread may read
the entry at once. Other threads may read the entry after the next `wait`, sum or maximum, because
sums and maxima wait, too. Each thread must call every wait, sum and maximum. All threads get the
same sums and maxima, so they all take the same branches.

The threads of a group belong to teams of the same size, which are the blocks of a GPU. The threads
of a team wait for each other in less time than all threads do. Team 0 has the first ranks.

Several threads may change one integer between two waits by `group_add` and `group_least` alone.
What `group_add` returns depends on the order of the threads, so results must not depend on it:
lists that are filled by it are sorted afterwards.
"""

from typing import Any, NamedTuple

from numba import typeof, types
from numba.core import config
from numba.extending import intrinsic

from izo_ref.base.arrays import Indices
from izo_ref.base.compile import compiled


class Team(NamedTuple):
    """The functions of the threads that share a team with the calling thread."""

    rank: Any  # () -> the number of this thread in its team, from 0
    size: Any  # () -> the number of threads in a team
    wait: Any  # () -> None, when all threads of the team have come here
    number: Any  # () -> the number of the team, from 0
    count: Any  # () -> the number of teams


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
    add: Any  # (values, i, amount) -> values[i] before the amount is added to it, at once
    least: Any  # (values, i, value) -> None, values[i] becomes the lesser of the two, at once
    team: Team  # the threads with which this thread shares a team
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
def group_add(group: ThreadGroup, values: Indices, i: int, amount: int) -> int:
    """Add to values[i] in one step that no other thread of the group comes between.

    Returns:
        values[i] as it was before.
    """
    return group.add(values, i, amount)


@compiled
def group_least(group: ThreadGroup, values: Indices, i: int, value: int) -> None:
    """Lower values[i] to a value, in one step that no other thread of the group comes between."""
    group.least(values, i, value)


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


@compiled
def _own_add(values: Indices, i: int, amount: int) -> int:
    before = values[i]
    values[i] = before + amount
    return before


@compiled
def _own_least(values: Indices, i: int, value: int) -> None:
    values[i] = min(values[i], value)


_ALONE_IN_TEAM = Team(_first_rank, _size_of_one, _no_wait, _first_rank, _size_of_one)
ALONE = ThreadGroup(
    _first_rank,
    _size_of_one,
    _no_wait,
    _own_sums,
    _own_maxima,
    _own_add,
    _own_least,
    _ALONE_IN_TEAM,
    None,
)


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
