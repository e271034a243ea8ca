"""Count what the host asks of a GPU: launches, programs, arrays, copies and arguments.

The counts hook into the places that every kernel, array and copy passes: `Launch`, `Program`,
`Block`, and `call_driver`. So they need no list of kernels.
"""

import ctypes
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from typing import Any, NamedTuple
from unittest.mock import patch
from weakref import WeakKeyDictionary

from izo_ref import Options
from izo_ref.loop.iterate import Iteration, Loop
from izo_ref.loop.numbering import geometric_order, renumber_scene
from izo_ref.loop.resolve import choose_thickness
from izo_ref.scene import Scene


class Counts(NamedTuple):
    """What the host asked of a GPU."""

    launches: int = 0  # kernels that Python launched one by one
    programs: int = 0  # starts of a program; each takes one call of the driver
    nodes: int = 0  # kernels that ran in programs
    prepared: int = 0  # launches that were prepared for programs
    recorded: int = 0  # programs that were made
    arrays: int = 0  # new arrays
    allocations: int = 0  # blocks of memory that the driver gave
    reads: int = 0  # copies to the host, which waits for each of them
    read_bytes: int = 0
    sends: int = 0  # copies to the GPU
    sent_bytes: int = 0
    copies: int = 0  # copies inside the memory of the GPU
    copied_bytes: int = 0
    numbers: int = 0  # arguments that Python packed for launches one by one
    most_numbers: int = 0  # arguments of the launch that has most of them

    @property
    def kernels(self) -> int:
        """Kernels that ran, launched one by one or in programs."""
        return self.launches + self.nodes

    def since(self, before: "Counts") -> "Counts":
        """Return what was counted since an earlier moment; `most_numbers` is that of all time."""
        differences = (new - old for new, old in zip(self, before, strict=True))
        return Counts(*differences)._replace(most_numbers=self.most_numbers)


COPIES = {
    "cuMemcpyDtoH": ("reads", "read_bytes"),
    "cuMemcpyHtoD": ("sends", "sent_bytes"),
    "cuMemcpyDtoD": ("copies", "copied_bytes"),
}


class Counter:
    """Counts what is asked of a GPU while `counting` runs.

    Attributes:
        counts: `Counts` so far.
        read: The bytes of each copy to the host, if they are kept.
    """

    def __init__(self, keeps_reads: bool = False) -> None:
        """Begin at zero."""
        self.counts, self.read = Counts(), list[bytes]()
        self._keeps_reads = keeps_reads
        self._in_program = False  # its launches are nodes
        self._in_recording = False  # its launches do not run

    def add(self, **amounts: int) -> None:
        """Add to some counts."""
        new = {name: getattr(self.counts, name) + amount for name, amount in amounts.items()}
        self.counts = self.counts._replace(**new)

    def pack(self, n_numbers: int) -> None:
        """Note that so many arguments are packed for a launch."""
        most = max(self.counts.most_numbers, n_numbers)
        self.counts = self.counts._replace(most_numbers=most)

    def launch(self, n_numbers: int) -> None:
        """Count a launch with so many arguments."""
        if not self._in_program and not self._in_recording:
            self.add(launches=1, numbers=n_numbers)

    def call(self, function: Any, arguments: tuple[Any, ...]) -> None:
        """Count a call of the driver that has returned."""
        name = function.__name__
        if name == "cuMemAlloc":
            self.add(allocations=1)
        for prefix, (times, n_bytes) in COPIES.items():
            if name.startswith(prefix):
                self.add(**{times: 1, n_bytes: int(arguments[2])})
        if self._keeps_reads and name.startswith("cuMemcpyDtoH"):
            self.read.append(ctypes.string_at(int(arguments[0]), int(arguments[2])))

    def run(self, program: Any, run: Any, *more: Any) -> None:
        """Run a program and count it."""
        from numba.cuda.core import config

        # without a graph, Python launches one kernel after the other; the simulator has no graphs
        is_graph = program._graph is not None or config.ENABLE_CUDASIM
        if is_graph:
            self.add(programs=1, nodes=len(program.launches))
        self._in_program = bool(is_graph)
        try:
            run(program, *more)
        finally:
            self._in_program = False

    def record(self, program: Any, make: Any, *more: Any) -> None:
        """Make a program and count it."""
        self.add(recorded=1)
        self._in_recording = True
        try:
            make(program, *more)
        finally:
            self._in_recording = False


@contextmanager
def counting(counter: Counter) -> Iterator[Counter]:
    """Let a counter count inside the block."""
    with ExitStack() as stack:
        for owner, name, hook in _hooks(counter):
            stack.enter_context(patch.object(owner, name, hook))
        yield counter


def _hooks(counter: Counter) -> list[tuple[Any, str, Any]]:
    """Return (owner, name, what takes its place) of all places that count."""
    from izo_ref.base.cuda import launch, memory, program
    from izo_ref.base.cuda.compile import Kernel, Launch

    call, take, prepare = memory.call_driver, memory.Block.__init__, Kernel.prepare
    make, run = program.Program.__init__, program.Program.run
    pack, start = Launch.__init__, Launch.__call__

    n_numbers: WeakKeyDictionary[Any, int] = WeakKeyDictionary()  # of each launch

    def counted_call(function: Any, *arguments: Any) -> Any:
        returned = call(function, *arguments)
        counter.call(function, arguments)
        return returned

    def counted_take(block: Any, n_bytes: int) -> None:
        counter.add(arrays=1)
        take(block, n_bytes)

    def counted_pack(own: Any, *more: Any) -> None:
        n_numbers[own] = sum(1 for _ in launch.numbers_of(more[-1]))
        counter.pack(n_numbers[own])
        pack(own, *more)

    def counted_prepare(*own: Any, **named: Any) -> Any:
        counter.add(prepared=1)
        return prepare(*own, **named)

    def counted_start(own: Any, *stream: Any) -> None:
        counter.launch(n_numbers.get(own, 0))
        start(own, *stream)

    return [
        *((module, "call_driver", counted_call) for module in (memory, launch, program)),
        (memory.Block, "__init__", counted_take),
        (Kernel, "prepare", counted_prepare),
        (Launch, "__init__", counted_pack),
        (Launch, "__call__", counted_start),
        (program.Program, "run", lambda own, *more: counter.run(own, run, *more)),
        (program.Program, "__init__", lambda own, *more: counter.record(own, make, *more)),
    ]


def iteration_counts(
    scene: Scene,
    options: Options,
    counter: Counter,
    on_iteration: Callable[[Iteration], object] | None = None,
) -> list[Counts]:
    """Run the main loop of a step on a GPU, and count each of its iterations.

    Args:
        scene: The step.
        options: Choices and tolerances.
        counter: A new counter.
        on_iteration: Is called with the record of each iteration, before it is counted.

    Returns:
        The counts of making the step, and then those of each iteration. The last iteration finds
        nothing that is new.
    """
    from izo_ref.loop.gpu_step import GpuStep

    def counted(iteration: Iteration) -> None:
        if on_iteration is not None:
            on_iteration(iteration)
        moments.append(counter.counts)

    moments = [counter.counts]
    own = renumber_scene(scene, geometric_order(scene))
    with counting(counter):
        step = GpuStep(own, choose_thickness(scene, None, options), options)
        moments.append(counter.counts)
        Loop(step, options.max_iterations, counted).run(0)
    return [new.since(old) for old, new in pairwise(moments)]


def typical(iterations: list[Counts]) -> Counts:
    """Return the largest of each count over the iterations after the first one.

    Args:
        iterations: What `iteration_counts` returns. The making of the step is left out, and so is
            the first iteration, which makes buffers and decides whether the proposed path is free.
    """
    return Counts(*map(max, zip(*iterations[2:], strict=True)))
