"""Compare a folder of vectors with what the generators make, byte by byte."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

from izo_ref.porting.generate.build import Contents

CASE = re.compile(rb'\{"(?:id|name)":"([^"]*)"')


def differences(files: Contents, folder: Path) -> list[str]:
    """Return a line for each file that differs; it names the first case that does.

    Args:
        files: The content of each file that is to be there, by its name.
        folder: The folder that is compared with it.
    """
    there = {path.name for path in folder.iterdir()}
    lines = []
    for name, content in files.items():
        if name not in there:
            lines.append(f"{name}: is missing; the generators make it")
            continue
        found = (folder / name).read_bytes()
        if found != content:
            lines.append(f"{name}: differs from what the generators make, {_first(found, content)}")
    others = sorted(there - files.keys())
    return lines + [f"{name}: is not made by the generators" for name in others]


def _first(found: bytes, content: bytes) -> str:
    """Return where two files differ first: the line, and the case or flag in it."""
    if b"\x93NUMPY" in (found[:6], content[:6]):
        pairs = itertools.zip_longest(found, content)
        return f"first at byte {next(i for i, (a, b) in enumerate(pairs) if a != b)}"
    pairs = itertools.zip_longest(found.splitlines(), content.splitlines(), fillvalue=b"")
    for number, (a, b) in enumerate(pairs, 1):
        if a != b:
            named = CASE.match(b) or CASE.match(a)
            case = f", {named[1].decode()}" if named else ""
            return f"first in line {number}{case}"
    return "at the ends of lines"
