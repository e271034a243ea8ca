"""Programs: launches with fixed arguments that run one after the other, again and again.

The driver takes 0.7 us for a kernel of a CUDA graph on an H200, and Python some microseconds for a
launch. So the launches of a program are recorded once as a graph, and the graph is started by one
call. Where the driver does not record them, for example because it is old, the launches follow each
other; so they do in the simulator.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from numba.cuda.core import config
from numba.cuda.cudadrv.driver import CudaAPIError

from izo_ref.base.cuda.memory import call_driver, driver

NON_BLOCKING = 1  # flag of the driver: a stream that does not wait for the default stream


class Program:
    """Launches that run one after the other on the default stream.

    Args:
        launches: Launches of `Kernel.prepare`, at least one.

    Attributes:
        launches: The same launches.
    """

    def __init__(self, launches: Sequence[Callable[..., None]]) -> None:
        """Record the launches, if the driver can; nothing runs yet."""
        self.launches = tuple(launches)
        self._graph: Any = None
        if not config.ENABLE_CUDASIM:
            with suppress(CudaAPIError, AttributeError):
                self._graph = recorded(self.launches)

    def run(self) -> None:
        """Run all launches."""
        if self._graph is None:
            for launch in self.launches:
                launch()
        else:
            call_driver(driver.cuGraphLaunch, self._graph, 0)

    def __del__(self) -> None:
        """Give the graph back to the driver."""
        if getattr(self, "_graph", None) is not None:
            with suppress(Exception):  # the driver may be gone when Python ends
                call_driver(driver.cuGraphExecDestroy, self._graph)


def recorded(launches: Sequence[Callable[..., None]]) -> Any:
    """Return a graph of the driver that runs some launches one after the other.

    Raises:
        CudaAPIError: The driver cannot record them.
    """
    # the default stream cannot be recorded, so a stream is made for it
    # and one that does not wait for it, so that other threads may launch meanwhile
    stream = call_driver(driver.cuStreamCreate, NON_BLOCKING)
    try:
        mode = driver.CUstreamCaptureMode.CU_STREAM_CAPTURE_MODE_THREAD_LOCAL
        call_driver(driver.cuStreamBeginCapture, stream, mode)
        try:
            for launch in launches:
                launch(stream)
        finally:
            graph = call_driver(driver.cuStreamEndCapture, stream)
        try:
            return call_driver(driver.cuGraphInstantiate, graph, 0)
        finally:
            call_driver(driver.cuGraphDestroy, graph)
    finally:
        call_driver(driver.cuStreamDestroy, stream)
