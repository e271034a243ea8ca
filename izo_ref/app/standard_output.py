"""Reports of a command: written to a file, or to the standard output if the file is `-`."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from typing import Any, TextIO

from izo_ref.app.files import FilePath, check_outputs, replacing
from izo_ref.app.process import output_is_closed
from izo_ref.base.errors import OptionError

STANDARD_OUTPUT = "-"


def check_reports(inputs: Mapping[str, str | None], outputs: Mapping[str, str | None]) -> None:
    """Check that all reports can be written, and that at most one is the standard output.

    Args:
        inputs: The files that are read, by what the user calls them; None for one that is not
            given.
        outputs: The files that will be written, in the same way.

    Raises:
        FileFormatError: A file cannot be written, or two of the files are the same.
        OptionError: Two reports would go to the standard output, or one and it is closed.
    """
    names = [name for name, path in outputs.items() if path == STANDARD_OUTPUT]
    if len(names) > 1:
        raise OptionError(
            f"{' and '.join(names)}: only one report can go to the standard output; name a file "
            "for the other"
        )
    if names and output_is_closed():
        raise OptionError(f"{names[0]}: the standard output is closed; name a file")
    files: dict[str, FilePath | None] = {
        name: path for name, path in outputs.items() if name not in names
    }
    check_outputs(dict(inputs), files)


def json_text(record: Any) -> str:
    """Return a record as JSON."""
    return json.dumps(record, indent=1) + "\n"


def save_report(path: str, text: str) -> None:
    """Write a report to a file, which appears whole or not at all, or to the standard output.

    Args:
        path: The file, or `-`.
        text: The report.

    Raises:
        FileFormatError: The file cannot be written.
    """
    if path == STANDARD_OUTPUT:
        say(text)
        return
    with replacing(path) as file:
        file.write(text.encode("utf-8", "backslashreplace"))


def say(text: str, aside: bool = False) -> None:
    """Print text; what the terminal cannot show is written by its number.

    Args:
        text: The text.
        aside: Whether it goes to the standard error, because a report is on the standard output.
    """
    target: TextIO = sys.stderr if aside else sys.stdout
    encoding = target.encoding or "utf-8"
    print(text.encode(encoding, "backslashreplace").decode(encoding), end="", file=target)
