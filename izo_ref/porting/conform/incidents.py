"""What can go wrong between the harness and a port, apart from wrong answers."""

from __future__ import annotations

CRASH = "crash"  # ended by a signal, or with an exit code, before it answered
HANG = "hang"  # no complete line within the time limit
GARBAGE = "garbage"  # a line that is no JSON object
SEVERAL = "several-lines"  # more than one line for a request
WRONG_ID = "wrong-id"  # the identifier of no case
ORDER = "wrong-order"  # the identifier of another case
CLOSED = "closed"  # closed its output and runs on
FLOOD = "flood"  # more output than any reply needs
MEMORY = "memory"  # out of memory
HELLO = "hello"  # a first line that does not introduce the port
MISSING = "no-reply"  # a folder without a line for a request

KINDS = (CRASH, HANG, GARBAGE, SEVERAL, WRONG_ID, ORDER, CLOSED, FLOOD, MEMORY, HELLO, MISSING)


class Incident(Exception):  # it is what a port did, not an error of this program
    """A port broke the protocol.

    Attributes:
        kind: One of KINDS; takes the place of the name of an output in reports.
        sentence: What happened, for a person.
        about_last: Whether the case before the one asked now is to blame.
        error_output: The last lines that the port wrote to its error output.
    """

    def __init__(self, kind: str, sentence: str, about_last: bool = False) -> None:
        """Keep what happened."""
        super().__init__(sentence)
        self.kind, self.sentence, self.about_last = kind, sentence, about_last
        self.error_output = ""
