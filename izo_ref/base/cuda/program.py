"""Programs: launches with fixed arguments that run one after the other, again and again.

A kernel of a CUDA graph takes the driver less time than Python takes to launch it
(`validation/study/gpu_machines.py` has what was measured). So the launches of a program are
recorded once as a graph, and one call starts the graph. If the driver cannot record them, for
example because it is old, and in the simulator, the launches follow each other.
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
    # The default stream cannot be recorded, so a stream is made. It does not wait for the default
    # stream, so that other threads may launch there meanwhile.
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
