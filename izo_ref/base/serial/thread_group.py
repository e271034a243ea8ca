"""Who works on a zone: one thread, or the threads of one or several blocks of a device.

Loops over a zone's unknowns or rows go from `team.rank()` in steps of `team.size()`: whoever
writes an entry is the only one that writes it, and may read it at once. What others wrote may be
read after a `wait`, a sum or a maximum, which are waits too; all come to each of them, and all get
the same result, so all take the same branches.
"""

from typing import Any, NamedTuple

from numba import typeof, types
from numba.core import config
from numba.extending import intrinsic

from izo_ref.base.compile import compiled


class ThreadGroup(NamedTuple):
    """Functions; known when the code that calls them is compiled, so that one costs nothing."""

    rank: Any  # () -> own number, from 0
    size: Any  # () -> how many they are
    wait: Any  # () -> once all have come here
    sums: Any  # (parts, a, b, c) -> sums over all
    maxima: Any  # (parts, a, b) -> maxima over all
    parts: Any  # work space of these two, where several blocks need it


@compiled
def group_sum(group, a):
    """Sum over all."""
    return group.sums(group.parts, a, 0.0, 0.0)[0]


@compiled
def group_sums(group, a, b, c):
    """Sums over all."""
    return group.sums(group.parts, a, b, c)


@compiled
def group_maxima(group, a, b):
    """Maxima over all."""
    return group.maxima(group.parts, a, b)


@compiled
def _first():
    return 0


@compiled
def _one():
    return 1


@compiled
def _at_once():
    pass


@compiled
def _own_three(_parts, a, b, c):
    return a, b, c


@compiled
def _own_two(_parts, a, b):
    return a, b


ALONE = ThreadGroup(_first, _one, _at_once, _own_three, _own_two, None)


@intrinsic
def _alone_compiled(context):
    """ALONE; as a constant it would be addresses of this process, which none keeps on disk."""
    group = types.NamedTuple([typeof(function) for function in ALONE], ThreadGroup)

    def build(context, builder, signature, arguments):
        return context.get_constant_null(group)  # only its type is ever used

    return group(), build


def _alone_in_python():
    return ALONE


# the team of one thread, for a kernel
alone = _alone_in_python if config.DISABLE_JIT else _alone_compiled
