"""End the process of a command with its exit code."""

import os
import sys
from collections.abc import Callable
from typing import NoReturn

BROKEN_PIPE = 141  # the exit code of a program that the signal SIGPIPE ends


def run_and_exit(main: Callable[[], int]) -> NoReturn:
    """Run a command, and end the process with its exit code.

    If the program that reads the output ends first, as `head` does, nothing is left to say.

    Args:
        main: Runs the command and returns its exit code.
    """
    try:
        code = main()
        sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes the output once more when it ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = BROKEN_PIPE
    sys.exit(code)
