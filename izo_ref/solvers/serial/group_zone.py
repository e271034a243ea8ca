"""The constraints of one zone in scaled variables, for a thread group.

`solvers/serial/constraints.py` says what the arrays are. A thread computes the coordinates of some
vertices from all constraints there, or the products of some constraints. So an entry has one
writer, its sum is always in the same order, and no thread has to lock anything.

Entry 4 j + k stands for node k of constraint j. The entries of each vertex are a linked list.
"""

from typing import NamedTuple

from izo_ref.base.arrays import AnyInt, Floats, Ints, Normals
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup
from izo_ref.base.serial.views import ONE, TWO, place


class Zone(NamedTuple):
    """The constraints of one zone, and the threads that share it."""

    group: ThreadGroup
    first: int  # the zone's first unknown
    nodes: Ints  # (n, 4) i4, unknowns; < 0 for pinned vertices
    coefficients: Floats  # (n, 4) f8
    normals: Normals  # (n, 3) f8
    rhs: Floats  # (n,) f8, s
    heads: Ints  # (n_vertices,) i4, the last entry of each vertex, or -1
    chain: Ints  # (4 n,) i4, the entry before each entry at the same vertex, or -1


@compiled
def link_entries(zone: Zone) -> None:
    """Write the linked lists; each thread reads all nodes, and links those of some vertices.

    All threads have to wait before they read the lists.
    """
    n_vertices, group = zone.heads.shape[0], zone.group
    share = (n_vertices + group.size() - 1) // group.size()
    low = min(group.rank() * share, n_vertices)
    high = min(low + share, n_vertices)
    if low == high:
        return
    for i in range(low, high):
        zone.heads[i] = -1
    for j in range(zone.nodes.shape[0]):
        for k in range(4):
            at = zone.nodes[j, k] - zone.first
            if low <= at < high:
                zone.chain[4 * j + k] = zone.heads[at]
                zone.heads[at] = 4 * j + k


@compiled
def pull(zone: Zone, u: Floats, z: Floats) -> None:
    """Compute z = C^T u; all threads have to see u before, and z after."""
    i, size = zone.group.rank(), zone.group.size()
    while i < zone.heads.shape[0]:
        x, y, w = 0.0, 0.0, 0.0
        entry = zone.heads[place(i)]
        while entry >= 0:
            j = place(entry >> 2)
            value = u[j] * zone.coefficients[j, place(entry & 3)]
            x += value * zone.normals[j, 0]
            y += value * zone.normals[j, 1]
            w += value * zone.normals[j, 2]
            entry = zone.chain[place(entry)]
        at = place(3 * i)
        z[at], z[at + ONE], z[at + TWO] = x, y, w
        i += size


@compiled
def product(zone: Zone, j: AnyInt, z: Floats) -> float:
    """Return c_j . z."""
    j, value = place(j), 0.0
    for k in range(4):
        node = zone.nodes[j, k]
        if node >= 0:
            at = place(3 * (node - zone.first))
            along = zone.normals[j, 0] * z[at]
            along += zone.normals[j, 1] * z[at + ONE]
            along += zone.normals[j, 2] * z[at + TWO]
            value += zone.coefficients[j, k] * along
    return value


@compiled
def cosine(zone: Zone, i: AnyInt, j: AnyInt) -> float:
    """Return the scalar product of the normals of two constraints."""
    a, i, j = zone.normals, place(i), place(j)
    return a[i, 0] * a[j, 0] + a[i, 1] * a[j, 1] + a[i, 2] * a[j, 2]


@compiled
def row_sum(zone: Zone, i: AnyInt) -> float:
    """Return a bound of the sum of |K_ij| over all constraints j, with K = C C^T."""
    total = 0.0
    for k in range(4):
        node = zone.nodes[place(i), k]
        if node >= 0:
            entry, own = zone.heads[place(node - zone.first)], zone.coefficients[place(i), k]
            while entry >= 0:
                j = place(entry >> 2)
                total += abs(own * zone.coefficients[j, place(entry & 3)] * cosine(zone, i, j))
                entry = zone.chain[place(entry)]
    return total


@compiled
def add_gram_row(zone: Zone, i: AnyInt, places: Ints, row: Floats, stride: AnyInt) -> None:
    """Add row i of K = C C^T to numbers, up to its own place.

    Args:
        zone: The zone.
        i: The constraint.
        places: (n,) i4, the place of each constraint in the row; < 0 for those without one.
        row: f8, the numbers of the row, `stride` apart, up to places[i]; those that K has are
            added to.
        stride: Distance of two numbers of the row.
    """
    own_place = places[place(i)]
    for k in range(4):
        node = zone.nodes[place(i), k]
        if node >= 0:
            entry, own = zone.heads[place(node - zone.first)], zone.coefficients[place(i), k]
            while entry >= 0:
                j = place(entry >> 2)
                column = places[j]
                if 0 <= column <= own_place:
                    share = own * zone.coefficients[j, place(entry & 3)]
                    row[place(stride * column)] += share * cosine(zone, i, j)
                entry = zone.chain[place(entry)]
