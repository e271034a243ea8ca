"""The supernodes of a matrix without some of its rows and columns.

Leaving rows out of a matrix removes entries from its factor and adds none. So the supernodes of the
rest are those of the whole matrix without these rows: no new order of elimination is needed.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.arrays import Flags, Ints, Offsets
from izo_ref.base.compile import compiled


class Supernodes(NamedTuple):
    """The supernodes of a pattern, in the order of elimination; each is factored in one front."""

    firsts: Ints  # (n_fronts + 1,) i4, first pivot of each front, in blocks
    above: Ints  # (n_fronts,) i4, the front that takes what is left; -1 if nothing is left
    starts: Offsets  # (n_fronts + 1,) i8, where the rows and places of each front begin
    rows: Ints  # i4, rows of each front below its pivots, in blocks
    places: Ints  # i4, the places of these rows in the front above, in blocks
    entry_starts: Offsets  # (n_fronts + 1,) i8, where the entries of each front begin
    entries: Ints  # (n_entries, 3) i4, number of the value, and row and column in the front


@compiled
def restrict(whole: Supernodes, chosen: Flags) -> Supernodes:
    """Return the supernodes of the matrix of some rows and columns.

    Args:
        whole: The supernodes of the whole matrix.
        chosen: (n_blocks,) b1, the rows that stay, in the order of elimination.

    Returns:
        Its supernodes. Blocks are numbered anew, without those that are left out; the numbers of
        values stay. A front may lose all its pivots. It then passes on what the fronts below it
        left over.
    """
    n_fronts = whole.above.shape[0]
    numbers = np.zeros(chosen.shape[0] + 1, np.int32)  # of the blocks, after restriction
    for i in range(chosen.shape[0]):
        numbers[i + 1] = numbers[i] + chosen[i]
    counts = np.zeros(whole.rows.shape[0] + 1, np.int64)  # rows that stay before each row
    for p in range(whole.rows.shape[0]):
        counts[p + 1] = counts[p] + chosen[whole.rows[p]]
    firsts, starts = numbers[whole.firsts], counts[whole.starts]
    rows = np.empty(starts[n_fronts], np.int32)
    places = np.empty(starts[n_fronts], np.int32)
    above = whole.above.copy()
    entry_starts = np.zeros(n_fronts + 1, np.int64)
    entries = np.empty(whole.entries.shape, np.int32)
    n_entries = 0
    for s in range(n_fronts):
        if starts[s] == starts[s + 1]:
            above[s] = -1
        for p in range(whole.starts[s], whole.starts[s + 1]):
            if chosen[whole.rows[p]]:
                rows[counts[p]] = numbers[whole.rows[p]]
                places[counts[p]] = _place(
                    whole, firsts, starts, numbers, counts, whole.above[s], whole.places[p]
                )
        own = whole.firsts[s + 1] - whole.firsts[s]
        for e in range(whole.entry_starts[s], whole.entry_starts[s + 1]):
            row, column = whole.entries[e, 1], whole.entries[e, 2]
            if column < own:
                block = whole.firsts[s] + column
            else:
                block = whole.rows[whole.starts[s] + column - own]
            if chosen[whole.firsts[s] + row] and chosen[block]:
                entries[n_entries, 0] = whole.entries[e, 0]
                entries[n_entries, 1] = _place(whole, firsts, starts, numbers, counts, s, row)
                entries[n_entries, 2] = _place(whole, firsts, starts, numbers, counts, s, column)
                n_entries += 1
        entry_starts[s + 1] = n_entries
    return Supernodes(firsts, above, starts, rows, places, entry_starts, entries[:n_entries])


@compiled
def _place(
    whole: Supernodes,
    firsts: Ints,
    starts: Offsets,
    numbers: Ints,
    counts: Offsets,
    s: int,
    place: int,
) -> int:
    """Return the place of a block in front s after restriction, from its place before."""
    own = whole.firsts[s + 1] - whole.firsts[s]
    if place < own:
        return numbers[whole.firsts[s] + place] - firsts[s]
    own_left = firsts[s + 1] - firsts[s]
    return own_left + counts[whole.starts[s] + place - own] - starts[s]
