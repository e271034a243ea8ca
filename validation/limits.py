"""Run a judge in a process of its own, which ends when its time or its memory is used up.

A judge may be code of others that cannot be interrupted, or exact arithmetic without a bound of its
time. A limit makes every check end, and says which judges did not decide.
"""

import ctypes
import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, ParamSpec, TypeVar

Call = ParamSpec("Call")
Returned = TypeVar("Returned")

STANDARD_OUTPUT, STANDARD_ERROR = 1, 2
PR_SET_PDEATHSIG = 1  # of Linux: the signal that a process gets when its parent ends
# Without fork, as on Windows, a judge runs in this process, and nothing limits it.
CAN_LIMIT = "fork" in multiprocessing.get_all_start_methods() and sys.platform != "darwin"


class Limits(NamedTuple):
    """What one judge may use.

    Attributes:
        seconds: Largest time [s].
        bytes: Largest memory that it may take in addition to what is in use.
    """

    seconds: float = 60.0
    bytes: int = 2 << 30


DEFAULT = Limits()


class NotDecidedError(Exception):
    """A judge needs more than its limits allow; the message says more than what."""


def limited(
    limits: Limits, judge: Callable[Call, Returned], *args: Call.args, **named: Call.kwargs
) -> Returned:
    """Return what a judge answers, if it does so within its limits.

    Args:
        limits: The limits.
        judge: The judge; it and its answer are passed between processes.
        args: Its arguments.
        named: Its arguments by name.

    Raises:
        NotDecidedError: The judge needs more time or memory, or its process died.
        Exception: What the judge raises.
    """
    if not CAN_LIMIT:
        return judge(*args, **named)
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    # no daemon, because a judge may ask another one within limits of its own
    process = context.Process(target=_answer, args=(sender, limits.bytes, judge, args, named))
    with warnings.catch_warnings():
        # Python warns that threads of this process may hold locks. They wait for work here, and
        # the new process starts none.
        warnings.simplefilter("ignore", DeprecationWarning)
        process.start()
    sender.close()
    try:
        if not receiver.poll(limits.seconds):
            raise NotDecidedError(f"needs more than {limits.seconds:g} s")
        answered, content = receiver.recv()
    except EOFError:
        process.join()
        raise NotDecidedError(f"its process ended with {process.exitcode}") from None
    finally:
        process.kill()
        process.join()
        receiver.close()
    if answered:
        return content
    if isinstance(content, MemoryError):
        raise NotDecidedError(f"needs more than {limits.bytes / 2**30:g} GiB of memory")
    raise content


def _answer(
    sender: Connection,
    n_bytes: int,
    judge: Callable[..., Any],
    args: tuple[Any, ...],
    named: dict[str, Any],
) -> None:
    """Send what a judge answers or raises; this is the new process."""
    import faulthandler
    import resource

    import numba

    numba.set_num_threads(1)  # the threads of the first process are not in this one
    _end_with_parent()
    with open("/proc/self/statm") as file:
        in_use = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (in_use + n_bytes, resource.RLIM_INFINITY))
    # what libraries print before they give up belongs to no report; ipctk prints to the output
    faulthandler.disable()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for handle in (STANDARD_OUTPUT, STANDARD_ERROR):
        os.dup2(nowhere, handle)
    try:
        sender.send((True, judge(*args, **named)))
    except Exception as error:
        sender.send((False, error))
    sender.close()
    os._exit(0)


def _end_with_parent() -> None:
    """Let this process end when the one that started it does, where the system can do that."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
