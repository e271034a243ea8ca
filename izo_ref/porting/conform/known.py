"""The file of known failures: `case-id dtype output  # comment`, one a line."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import NamedTuple, TypeAlias

from izo_ref.base.errors import FileFormatError
from izo_ref.base.input_files import read_text
from izo_ref.porting.cases import DTYPES
from izo_ref.porting.conform.run import Row
from izo_ref.porting.conform.text import clean
from izo_ref.porting.judge.outcome import FAILED, PASSED

Key: TypeAlias = "tuple[str, str]"
HEADER = "# Known failures: case, type of floats, output (or kind of an incident), comment.\n"


class Compared(NamedTuple):
    """Failures of a run beside those that are known.

    Attributes:
        known: Case and type of floats of each row that fails only as known.
        problems: A sentence for each line of the file that is not true any more.
    """

    known: frozenset[Key]
    problems: tuple[str, ...]


def read_known(path: Path, ids: Collection[str]) -> dict[Key, set[str]]:
    """Return the outputs that are known to fail, by case and type of floats.

    Args:
        path: The file.
        ids: Identifiers of all cases of the vectors.

    Raises:
        FileFormatError: The file cannot be read, or a line is not of this format.
    """
    lines = read_text(path).splitlines()
    known: dict[Key, set[str]] = {}
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        if len(words) != 3 or words[1] not in DTYPES:
            raise FileFormatError(
                f"{path}, line {number}: expected 'case-id f8-or-f4 output  # comment', got "
                f"{clean(line, 80)!r}"
            )
        if words[0] not in ids:
            raise FileFormatError(f"{path}, line {number}: there is no case {clean(words[0], 80)}")
        known.setdefault((words[0], words[1]), set()).add(words[2])
    return known


def failing_outputs(row: Row) -> list[str]:
    """Return the outputs of a row that are wrong, each once."""
    if row.outcome.result != FAILED:
        return []
    return list(dict.fromkeys(_word(difference.output) for difference in row.outcome.differences))


def _word(output: str) -> str:
    """Return the name of an output as one word; a port may have given it any name."""
    return re.sub(r"[^\w-]", "_", output, flags=re.ASCII)[:60] or "_"


def compare(rows: Sequence[Row], known: dict[Key, set[str]]) -> Compared:
    """Compare the failures of a run with those that are known.

    A row is known if it fails in the outputs of the file and in no other. What passes, fails in
    another output, or fails in fewer outputs is a problem. Rows that were not asked or are not
    supported say nothing.
    """
    accepted, problems = set(), []
    for row in rows:
        listed, key = known.get(row.request.key), row.request.key
        if listed is None or row.outcome.result not in (PASSED, FAILED):
            continue
        name = " ".join(key)
        failing = set(failing_outputs(row))
        if row.outcome.result == PASSED:
            problems.append(f"{name}: is listed as a known failure and passes now; take it out")
            continue
        if failing == listed:
            accepted.add(key)
        if failing - listed:
            other, old = (", ".join(sorted(names)) for names in (failing - listed, listed))
            problems.append(f"{name}: fails in {other}; the list has {old} alone")
        elif listed - failing:
            gone = ", ".join(sorted(listed - failing))
            problems.append(f"{name}: {gone} does not fail any more; take it out")
    return Compared(frozenset(accepted), tuple(problems))


def known_text(rows: Sequence[Row]) -> str:
    """Return the file of the failures of a run, in the order of the vectors."""
    lines = []
    for row in rows:
        for output in failing_outputs(row):
            first = next(d for d in row.outcome.differences if _word(d.output) == output)
            lines.append(f"{' '.join(row.request.key)} {output}  # {clean(first.sentence, 120)}\n")
    return HEADER + "".join(lines)
