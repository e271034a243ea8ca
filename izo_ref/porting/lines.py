"""JSON with one record a line, so that differences and simple readers see records."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping


def one_a_line(head: Mapping[str, object], name: str, records: Iterable[str]) -> str:
    """Return an object of JSON whose last member is a list with one record a line.

    Args:
        head: The members before the list.
        name: Name of the list.
        records: The records, each as one line of JSON.
    """
    begin = json.dumps({**head, name: []}, separators=(",", ":"))
    return f"{begin[:-2]}\n" + ",\n".join(records) + "\n]}\n"
