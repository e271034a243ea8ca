"""Faults of block pivoting by the threads of a GPU: factors, order, guess, exchanges and lists."""

from validation.mutants.fault import ON_GPU, Fault

SERIAL = "izo_ref/solvers/serial/"
ENVELOPE, ORDER, PIVOT = "envelope.py", "group_order.py", "group_pivot.py"
FACTORS, ZONES = "tests/solvers/test_envelope.py", "tests/solvers/test_group_pivot.py"
LISTS = "tests/solvers/test_listed_zones.py"


def _fault(name: str, file: str, old: str, new: str, what: str, test: str) -> Fault:
    """Return a fault that one thread of the CPU shows."""
    tests = (test,)
    return Fault(name, SERIAL + file, old, new, what, tests, flag="gpu-only", not_by_vectors=ON_GPU)


GROUP_PIVOT = [
    _fault(
        "tile-columns-end-too-early",
        ENVELOPE,
        "        while last + 1 < n and firsts[last + 1] <= i:\n",
        "        while last + 1 < n and firsts[last + 1] < i:\n",
        "The tile rows that begin at a tile column are no rows of it.",
        FACTORS,
    ),
    _fault(
        "products-of-the-wrong-tiles",
        ENVELOPE,
        "        left, above = tile_at(envelope, row, k), tile_at(envelope, column, k)\n",
        "        left, above = tile_at(envelope, column, k), tile_at(envelope, row, k)\n",
        "The products of two tiles are taken from the transpose of their tile.",
        FACTORS,
    ),
    _fault(
        "pivots-of-zero-are-divided-by",
        ENVELOPE,
        "        scale = 1.0 / math.sqrt(pivot) if pivot > 0.0 else 0.0\n",
        "        scale = 1.0 / math.sqrt(pivot) if pivot >= 0.0 else 0.0\n",
        "A redundant constraint makes its zone infinite.",
        FACTORS,
    ),
    _fault(
        "tile-rows-begin-too-late",
        "envelope_solve.py",
        "    column, own = group.team.rank() + SIDE * envelope.firsts[k], SIDE * k\n",
        "    column, own = group.team.rank() + SIDE * (envelope.firsts[k] + 1), SIDE * k\n",
        "The transposed solve leaves out the first tile of each tile row.",
        FACTORS,
    ),
    _fault(
        "factors-beyond-all-indices",
        ENVELOPE,
        "        n_before = min(n_before + i - firsts[i] + 1, MOST_TILES + 1)\n",
        "        n_before += i - firsts[i] + 1\n",
        "The size of a large factor overflows, so that it fits into any memory.",
        FACTORS,
    ),
    _fault(
        "order-of-the-numbers",
        ORDER,
        "        if high + negative_low > longest:\n",
        "        if high + negative_low < longest:\n",
        "The constraints are not ordered along the zone, so the factors are wide.",
        ZONES,
    ),
    _fault(
        "order-along-the-shortest-axis",
        ORDER,
        "        if high + negative_low > longest:\n",
        "        if longest < 0.0 or high + negative_low < longest:\n",
        "The constraints are ordered across the zone, so the factors are wide.",
        ZONES,
    ),
    _fault(
        "envelope-without-neighbours",
        ORDER,
        "            place = memory.places[memory.lowest[memory.active[a]]]\n",
        "            place = memory.places[memory.active[a]]\n",
        "The envelope has no room for products with the constraints before.",
        ZONES,
    ),
    _fault(
        "envelope-of-active-first-neighbours",
        ORDER,
        "            first = min(first, (place if place >= 0 else ~place) >> SHIFT)\n",
        "            first = min(first, (place if place >= 0 else a) >> SHIFT)\n",
        "The envelope has no room for a row whose first neighbour is not active.",
        ZONES,
    ),
    _fault(
        "guess-forgets-the-last-solution",
        "group_guess.py",
        "        u[j] = ahead[j] = memory.earlier[j]\n",
        "        u[j] = ahead[j] = 0.0\n",
        "A GPU begins each solve of a zone anew.",
        ZONES,
    ),
    _fault(
        "factor-of-the-set-before",
        PIVOT,
        "        if changed:\n            if step > 1:\n",
        "        if step == 1:\n            if step > 1:\n",
        "A GPU uses the first factor again after constraints have changed sides.",
        ZONES,
    ),
    _fault(
        "factor-in-near-memory-that-is-too-small",
        PIVOT,
        "            factor = near if fits(envelope, near) else far\n",
        "            factor = near if near.shape[0] > 0 else far\n",
        "A factor is written beyond the end of the shared memory.",
        ZONES,
    ),
    _fault(
        "gap-is-not-judged-on-the-device",
        PIVOT,
        "        if not gap / gap_tolerance <= off:  # a NaN",
        "        if off < 0.0:  # a NaN",
        "A GPU takes an answer that is feasible, but far from the optimum.",
        ZONES,
    ),
    _fault(
        "violation-is-not-judged-on-the-device",
        PIVOT,
        "        violation = max(violation, missing)\n",
        "        violation = max(violation, 0.0)\n",
        "A GPU takes an answer that violates active constraints.",
        ZONES,
    ),
    _fault(
        "pivoting-keeps-rho-on-the-device",
        PIVOT,
        "            memory.earlier[j] = memory.u[j]\n",
        "            memory.earlier[j] = memory.earlier[j]\n",
        "The term that makes redundant constraints solvable stays in the answer of a GPU.",
        ZONES,
    ),
    _fault(
        "every-wrong-constraint-changes-sides",
        "group_exchange.py",
        " and (not first_only or _comes_first(zone, memory, j)):\n",
        ":\n",
        "On a GPU, constraints at a vertex change sides together, and then back again.",
        "tests/solvers/test_group_exchange.py",
    ),
    _fault(
        "row-products-without-the-first-column",
        "group_zone.py",
        "                if 0 <= column <= own_place:\n",
        "                if 0 < column <= own_place:\n",
        "No constraint on a GPU has a product with the first one.",
        ZONES,
    ),
    _fault(
        "tiles-begin-in-the-list-of-neighbours",
        "group_memory.py",
        "    behind, rest = 3 * n + 2 * whole, indices[6 * n :]\n",
        "    behind, rest = 3 * n + 2 * whole, indices[5 * n :]\n",
        "Two arrays of the work space overlap.",
        "tests/solvers/test_group_memory.py",
    ),
    _fault(
        "last-solution-of-inactive-impacts",
        "zone_rows.py",
        "            last = inputs.multipliers[impact] if inputs.active[impact] else 0.0\n",
        "            last = inputs.multipliers[impact]\n",
        "A GPU begins at multipliers of impacts that were not active in the last solution.",
        LISTS,
    ),
    _fault(
        "last-solution-is-not-scaled",
        "zone_rows.py",
        "            answers_out.multipliers[i] = last * rows_out.lengths[i]\n",
        "            answers_out.multipliers[i] = last\n",
        "A GPU begins at the multipliers of constraints that are not scaled to unit length.",
        LISTS,
    ),
    _fault(
        "blocks-end-with-the-largest-zones",
        "listed_zones.py",
        "        if is_big == (taken < n):\n",
        "        if is_big == (taken >= n):\n",
        "Blocks take the largest zones last, and all others wait.",
        LISTS,
    ),
    _fault(
        "hopeless-only-if-the-first-is",
        "listed_zones.py",
        "    mine = _any_hopeless(begin + group.rank(), end, group.size(), hopeless)\n",
        "    mine = _any_hopeless(begin + group.rank(), begin + 1, group.size(), hopeless)\n",
        "A GPU solves a zone with a constraint that no vertex can satisfy.",
        LISTS,
    ),
]
