"""A mesh welded by hand: vertices with equal paths are merged one by one, and renumbered."""

import numpy as np


def weld_by_hand(start, end, faces, masses, pinned):
    """Merge the vertices that start and end at the same places.

    Args:
        start: (n, 3) positions at the start.
        end: (n, 3) positions at the end.
        faces: (m, 3) vertices.
        masses: (n,), or None for masses of 1.
        pinned: (n,) bool.

    Returns:
        The arguments of the merged mesh by name, and (n,) which of its vertices each vertex is.
        Merged vertices are numbered in the order in which they first occur. Faces with a repeated
        vertex, and all but the first of those with the same vertices, are left out.
    """
    numbers, of = {}, []
    for path in zip(start.tolist(), end.tolist(), strict=True):
        key = tuple(tuple(x + 0.0 for x in point) for point in path)
        of.append(numbers.setdefault(key, len(numbers)))
    firsts = [of.index(number) for number in range(len(numbers))]
    total, is_pinned = [0.0] * len(numbers), [False] * len(numbers)
    for vertex, number in enumerate(of):
        total[number] += 1.0 if masses is None else float(masses[vertex])
        is_pinned[number] |= bool(pinned[vertex])
    kept, seen = [], set()
    for face in np.asarray(faces).tolist():
        corners = [of[vertex] for vertex in face]
        if len(set(corners)) == 3 and frozenset(corners) not in seen:
            seen.add(frozenset(corners))
            kept.append(corners)
    mesh = {
        "positions_t0": start[firsts],
        "positions_t1": end[firsts],
        "faces": np.array(kept, np.int32).reshape(-1, 3),
        "masses": np.array(total),
        "pinned": np.array(is_pinned),
    }
    return mesh, np.array(of)
