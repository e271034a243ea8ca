"""How a zone problem becomes smaller and simpler, and the files of zones."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.app.files import replacing
from izo_ref.base.arrays import AnyArray
from izo_ref.base.errors import FileFormatError
from izo_ref.zones.problem import ZoneProblem
from validation.shrink import numbers
from validation.shrink.search import Search

ARRAYS = ("nodes", "weights", "normals", "proposed", "masses")
SIMPLE_WEIGHTS = ((1.0, -1.0, 0.0, 0.0), (1.0, 0.0, -1.0, 0.0), (1.0, -0.5, -0.5, 0.0))
EDGE_WEIGHTS = ((0.5, 0.5, -0.5, -0.5), (1.0, 0.0, -1.0, 0.0), (0.75, 0.25, -0.75, -0.25))
FEWEST_BITS = (2, 4, 8, 16)


def load_zone(path: str | Path) -> ZoneProblem:
    """Read a zone; its proposed positions are called `proposed` or `targets`.

    Raises:
        FileFormatError: An array is missing.
        IzoError: The arrays are no zone problem.
    """
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    if "targets" in arrays:
        arrays["proposed"] = arrays.pop("targets")
    missing = [name for name in (*ARRAYS, "thickness") if name not in arrays]
    if missing:
        raise FileFormatError(f"{path}: expected a zone problem, {missing} are missing")
    return ZoneProblem(*(arrays[name] for name in ARRAYS), thickness=float(arrays["thickness"]))


def save_zone(path: str | Path, problem: ZoneProblem) -> None:
    """Write a zone; the file appears whole or not at all.

    Raises:
        FileFormatError: The file cannot be written.
    """
    arrays: dict[str, Any] = {name: getattr(problem, name) for name in ARRAYS}
    arrays |= {"targets": arrays.pop("proposed"), "thickness": problem.thickness}
    with replacing(path) as file:
        np.savez_compressed(file, **arrays)


def key(problem: ZoneProblem) -> bytes:
    """Return bytes that are equal for equal problems."""
    parts = [getattr(problem, name).tobytes() for name in ARRAYS]
    return b"|".join([repr((len(problem.nodes), problem.thickness)).encode(), *parts])


def describe(problem: ZoneProblem) -> str:
    """Return the size of a zone in a line."""
    characters = sum(numbers.length(getattr(problem, name)) for name in ARRAYS[1:])
    n = len(problem.masses)
    return (
        f"{len(problem.nodes)} impacts, {n} vertices ({int(np.isinf(problem.masses).sum())} "
        f"pinned), {characters} characters of numbers"
    )


def shrink_zone(search: Search[ZoneProblem]) -> None:
    """Make the best zone of a search smaller until nothing more can be left out.

    Raises:
        OutOfTimeError: The time is used up; the best zone so far is in the search.
    """
    while True:
        before = key(search.best)
        search.keep_few(range(len(search.best.nodes)), _with_impacts)
        search.take(_changed(search.best, masses=np.ones(len(search.best.masses))))
        free = np.where(np.isinf(search.best.masses), np.inf, 1.0)
        search.take(_changed(search.best, masses=free))
        for name in ("masses", "proposed", "thickness"):
            _simpler(search, name)
        _simpler_rows(search)
        search.say(describe(search.best))
        if key(search.best) == before:
            return


def _with_impacts(problem: ZoneProblem, kept: list[int]) -> ZoneProblem | None:
    """Return a zone with some impacts, and the vertices of these."""
    if not kept:
        return None
    vertices, nodes = np.unique(problem.nodes[kept], return_inverse=True)
    return _changed(
        problem,
        nodes=nodes.reshape(-1, 4),
        weights=problem.weights[kept],
        normals=problem.normals[kept],
        proposed=problem.proposed[vertices],
        masses=problem.masses[vertices],
    )


def _changed(problem: ZoneProblem, **changed: Any) -> ZoneProblem:
    fields = {name: getattr(problem, name) for name in (*ARRAYS, "thickness")}
    return ZoneProblem(**(fields | changed))


def _simpler(search: Search[ZoneProblem], name: str) -> None:
    """Round all numbers of an array together, then each of them."""

    def values(problem: ZoneProblem) -> AnyArray:
        return np.atleast_1d(np.asarray(getattr(problem, name), float))

    def change(problem: ZoneProblem, array: AnyArray) -> ZoneProblem | None:
        if name == "thickness":
            return _changed(problem, thickness=float(array[0])) if array[0] > 0.0 else None
        if name == "masses" and not (array > 0.0).all():
            return None
        return _changed(problem, **{name: array})

    numbers.together(search, values, change)
    numbers.one_by_one(search, values, change)


def _simpler_rows(search: Search[ZoneProblem]) -> None:
    """Give impacts simple weights, whose sum is zero, and normals along an axis or nearly so."""
    for row in range(len(search.best.nodes)):
        for name, candidates in (("weights", _weights), ("normals", _normals)):
            array = getattr(search.best, name)
            made = []
            for simple in candidates(array[row]):
                other = array.copy()
                other[row] = simple
                if numbers.length(other[row]) < numbers.length(array[row]):
                    made.append(_changed(search.best, **{name: other}))
            search.take_first(made)


def _weights(row: AnyArray) -> Iterator[AnyArray]:
    positive = int((row > 0.0).sum())
    yield from map(np.array, EDGE_WEIGHTS if positive > 1 else SIMPLE_WEIGHTS)
    for bits in FEWEST_BITS:
        made = np.round(row * 2.0**bits) / 2.0**bits
        made[3] = -made[:3].sum()  # exact: multiples of 2^-bits
        yield made


def _normals(row: AnyArray) -> Iterator[AnyArray]:
    axis = int(np.argmax(np.abs(row)))
    along = np.zeros(3)
    along[axis] = np.sign(row[axis])
    yield along
    for digits in (1, 2, 3):
        made = np.round(row, digits)
        if made.any():
            yield made / np.linalg.norm(made)
