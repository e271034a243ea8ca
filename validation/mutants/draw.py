"""Draw faults by operator, each group of files with its share, by a seed.

Each possible change of the sources has a key: its file, its function, its operator, and the lines
before and after it. The order is that of a digest of the seed and the key, so that an edit
elsewhere, or another place of a function in its file, leaves a drawn fault drawn. Within a group
the operators take turns, and the groups take turns by their shares.
"""

import hashlib
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from validation.mutants.operators import Change, changed, changes, is_equivalent

CERTIFICATE = (
    "izo_ref/certificate/**/*.py",
    "izo_ref/base/exact*.py",
    "izo_ref/base/algebraic.py",
    "izo_ref/base/polynomials.py",
    "izo_ref/base/certified.py",
)
# Groups of files, with their shares. A file is in the first group whose pattern it fits.
GROUPS: dict[str, tuple[int, tuple[str, ...]]] = {
    "certificate": (3, CERTIFICATE),
    "formulas": (3, ("izo_ref/*/formulas/*.py",)),
    "detection": (3, ("izo_ref/detection/*.py", "izo_ref/detection/serial/*.py")),
    "zones": (3, ("izo_ref/zones/*.py", "izo_ref/zones/serial/*.py")),
    "solvers": (4, ("izo_ref/solvers/*.py", "izo_ref/solvers/serial/**/*.py")),
    "loop": (2, ("izo_ref/loop/*.py", "izo_ref/loop/serial/*.py")),
    "base": (1, ("izo_ref/base/serial/*.py", "izo_ref/base/sizes.py", "izo_ref/base/units.py")),
}


class Drawn(NamedTuple):
    """A drawn fault.

    Attributes:
        group: The group of its file.
        file: Path from the root of the repository.
        line: Its first line, from 1.
        where: The function or constant that is changed.
        operator: Name of the operator.
        old: The lines that are changed, without their indentation.
        new: What they are then.
        names: Constants of the module that are changed; empty if a function is.
        text: The whole file with the fault.
    """

    group: str
    file: str
    line: int
    where: str
    operator: str
    old: str
    new: str
    names: tuple[str, ...]
    text: str

    @property
    def key(self) -> tuple[str, str, str, str]:
        """What identifies the fault: its file, its function, and the lines before and after."""
        return self.file, self.where, self.old, self.new


def draw(root: Path, n: int, seed: int) -> list[Drawn]:
    """Draw faults without replacement.

    Args:
        root: Root of the repository.
        n: How many faults are drawn; all that there are, if there are fewer.
        seed: The seed.

    Returns:
        The faults in the order in which they are tried; with a larger n, more follow.
    """
    queues = {group: _order(root, group, seed) for group in GROUPS}
    taken = dict.fromkeys(GROUPS, 0)
    drawn: list[Drawn] = []
    known: set[tuple[str, str, str, str]] = set()
    while len(drawn) < n and any(queues.values()):
        open_ = [group for group in GROUPS if queues[group]]
        group = min(open_, key=lambda one: (taken[one] + 1) / GROUPS[one][0])
        file, text, change = queues[group].pop()
        one = _drawn(group, file, text, change)
        if one.key not in known and not is_equivalent(text, change):
            known.add(one.key)
            drawn.append(one)
            taken[group] += 1
    return drawn


def group_of(file: str) -> str:
    """Return the group of a file, or an empty text if faults are not drawn from it.

    Args:
        file: Path from the root of the repository.
    """
    path = Path(file)
    if "gpu" in path.name or "cuda" in path.parts or path.name == "__init__.py":
        return ""
    for group, (_, patterns) in GROUPS.items():
        if any(_fits(path, pattern) for pattern in patterns):
            return group
    return ""


def _fits(path: Path, pattern: str) -> bool:
    """Return whether a path fits a pattern, in which ** stands for up to two folders."""
    return any(path.match(pattern.replace("/**/", inner)) for inner in ("/", "/*/", "/*/*/"))


def _order(root: Path, group: str, seed: int) -> list[tuple[str, str, Change]]:
    """Return the changes of a group, the first one to be taken last."""
    by_operator: dict[str, list[tuple[bytes, str, str, Change]]] = {}
    for path in sorted((root / "izo_ref").rglob("*.py")):
        file = path.relative_to(root).as_posix()
        if group_of(file) != group:
            continue
        text = path.read_text()
        for change in _changes_of(text):
            key = (seed, file, change.where, *_lines(text, change)[1:], change.operator)
            digest = hashlib.sha256(repr(key).encode()).digest()
            by_operator.setdefault(change.operator, []).append((digest, file, text, change))
    ranked: list[tuple[int, bytes, str, str, Change]] = []
    for found in by_operator.values():
        found.sort(key=lambda one: (one[0], one[3]))
        ranked += [(rank, *one) for rank, one in enumerate(found)]
    ranked.sort(key=lambda one: (one[0], one[1], one[4]), reverse=True)
    return [(file, text, change) for _, _, file, text, change in ranked]


_changes_of = lru_cache(maxsize=None)(changes)


def _lines(text: str, change: Change) -> tuple[int, str, str]:
    """Return the number of the first changed line, and the lines before and after the change."""
    begin = text.rfind("\n", 0, change.begin) + 1
    end = text.find("\n", change.end)
    end = len(text) if end < 0 else end
    after = text[begin : change.begin] + change.new + text[change.end : end]
    old, new = (" ".join(part.split()) for part in (text[begin:end], after))
    return text.count("\n", 0, begin) + 1, old, new


def _drawn(group: str, file: str, text: str, change: Change) -> Drawn:
    """Return a change as a drawn fault, with the lines around it."""
    line, old, new = _lines(text, change)
    whole = changed(text, change)
    return Drawn(group, file, line, change.where, change.operator, old, new, change.names, whole)
