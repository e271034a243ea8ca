"""Limits of what an iteration may ask of a GPU, and the goal. A test holds the code to the limits.

This is the only place with these numbers. The limits are those of the code as it is, so that a
change which needs more has to say so here. Lower them when the code needs less.
"""

from typing import NamedTuple

from validation.study.gpu_counts import Counts


class Limit(NamedTuple):
    """The most that an iteration may ask for, what it shall ask for one day, and the reason."""

    most: int
    goal: int | None  # None where no goal is set
    reason: str


# By the name of a field or property of `Counts`. They hold for iterations after the first one.
LIMITS: dict[str, Limit] = {
    "launches": Limit(0, 0, "a launch takes 3 to 5 us of the driver, and more of Python"),
    "programs": Limit(1, 1, "all launches of an iteration are one graph, one call of the driver"),
    # 1 of selection, 1 of grouping, 4 of solvers, 1 that moves the vertices, 5 of the detection
    "kernels": Limit(12, 15, "a kernel of a program takes 0.7 us on an H200"),
    "prepared": Limit(0, 0, "launches are prepared when a buffer is made or has grown"),
    "recorded": Limit(0, 0, "programs are made when a buffer is made or has grown"),
    "arrays": Limit(0, 0, "a new array is a block of memory, which the driver has to give"),
    "allocations": Limit(0, 0, "the driver stops all launches to allocate"),
    "reads": Limit(1, 1, "the host waits 21 us for each read on an H200"),
    "read_bytes": Limit(384, 512, "16 counts of 8 bytes of each of three stages"),
    "sends": Limit(0, 0, "the topology is on the GPU; positions are sent once a step"),
    "sent_bytes": Limit(0, 0, "the topology is on the GPU; positions are sent once a step"),
    # the ends of the path, for the next count of what moved; and as those that were free longest
    "copies": Limit(2, None, "a copy inside the GPU is a launch, too"),
    "numbers": Limit(0, None, "Python packs every number of every launch outside of a program"),
    "most_numbers": Limit(354, None, "a launch takes at most 4096 bytes of arguments"),
}
ARGUMENT_BYTES = 4096  # of one launch; CUDA C++ Programming Guide, "Function Parameters"


def exceeded(counts: Counts) -> list[str]:
    """Return a sentence for each limit that the counts of an iteration exceed."""
    return [
        f"{name}: {getattr(counts, name)} an iteration, but at most {limit.most}: {limit.reason}"
        for name, limit in LIMITS.items()
        if getattr(counts, name) > limit.most
    ]
