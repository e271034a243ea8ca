"""Text that came from a port, made safe for a terminal and short enough to read."""

from __future__ import annotations

LONGEST = 300  # characters
MOST_LINES = 20  # of an error output


def clean(text: object, longest: int = LONGEST) -> str:
    """Return text on one line, without control characters, shortened.

    A port may write anything: escape sequences of a terminal, halves of surrogate pairs, megabytes.
    """
    text = str(text)
    short = text[:longest]
    safe = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in short)
    return safe if len(text) <= longest else f"{safe}... ({len(text)} characters)"


def clean_bytes(data: bytes, longest: int = LONGEST) -> str:
    """Return bytes as text in the same way; a byte that is no UTF-8 becomes its number."""
    text = clean(data[: 4 * longest].decode("utf-8", "backslashreplace"), longest)
    return text if len(data) <= 4 * longest else f"{text} ({len(data)} bytes)"


def last_lines(data: bytes, cut: bool = False) -> str:
    """Return the last lines of an output as they are, each made safe in the same way.

    Args:
        data: The end of the output.
        cut: Whether there was more before it, so that its first line is not whole.
    """
    lines = data.decode("utf-8", "backslashreplace").expandtabs().splitlines()
    lines = lines[1:] if cut and len(lines) > 1 else lines
    while lines and not lines[-1].strip():
        lines.pop()
    shown = [clean(line.rstrip()) for line in lines[-MOST_LINES:]]
    return "\n".join(["...", *shown] if cut or len(lines) > MOST_LINES else shown)
