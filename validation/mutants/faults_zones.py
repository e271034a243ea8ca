"""Faults of selection, zones, masses, pinned vertices and numbering."""

from validation.mutants.fault import GPU_SIMULATOR, Fault

ZONES = "tests/test_zones.py"
SHEETS = "tests/test_resolve.py::test_two_sheets_end_free"
BY_HAND = "tests/test_resolve.py::test_one_vertex_by_hand"
CALLERS = "tests/test_resolve.py::test_impacts_come_in_the_callers_numbering"
RENUMBERED = "tests/test_resolve.py::test_renumbering_changes_nothing_beyond_rounding"

ZONE = [
    Fault(
        "pinned-vertices-have-zones-on-the-device",
        "izo_ref/cuda/zones.py",
        "            if not pinned[nodes[j, k]]:\n                components_out[j] = ",
        "            if True:\n                components_out[j] = ",
        "on a GPU an impact is in the zone of a pinned vertex",
        ("tests/test_simulator.py",),
    ),
    Fault(
        "pinned-vertices-are-taken-once-on-the-device",
        "izo_ref/cuda/selection.py",
        "UNDECIDED and seen[nodes[j, k]] and not pinned[nodes[j, k]]:",
        "UNDECIDED and seen[nodes[j, k]]:",
        "on a GPU an impact waits for another at the same pinned vertex",
        ("tests/test_simulator.py",),
    ),
    Fault(
        "one-own-vertex-is-enough-on-the-device",
        "izo_ref/cuda/selection.py",
        "if (n_own == n_free) if all_new else (n_own > 0):",
        "if n_own > 0:",
        "on a GPU impacts taken together share a vertex",
        ("tests/test_simulator.py",),
    ),
    Fault(
        "zones-merged-in-one-pass",
        "izo_ref/serial/components.py",
        "    a = find_root(parent, i)\n    b = find_root(parent, j)\n",
        "    a = parent[i]\n    b = parent[j]\n",
        "zones are merged in one pass, so a chain of impacts falls apart",
        (ZONES,),
        GPU_SIMULATOR,
    ),
    Fault(
        "a-hundred-zones",
        "izo_ref/zones.py",
        "    order = order[np.count_nonzero(component < 0) :]\n",
        "    order = order[np.count_nonzero(component < 0) :]\n"
        "    order = order[np.isin(component[order], np.unique(component[order])[:100])]\n",
        "there is room for a hundred zones, the others are dropped",
        (ZONES,),
        GPU_SIMULATOR,
    ),
    Fault(
        "pinned-vertices-join-zones",
        "izo_ref/serial/components.py",
        "            if not pinned[vertex]:\n",
        "            if vertex >= 0:\n",
        "impacts that share a pinned vertex only become one zone",
        (ZONES,),
    ),
    Fault(
        "pinned-mask-of-other-vertices",
        "izo_ref/zones.py",
        "        np.where(scene.pinned[vertices], np.inf, scene.masses[vertices]),\n",
        "        np.where(scene.pinned[: len(vertices)], np.inf, scene.masses[vertices]),\n",
        "the mask of pinned vertices is read with the index in the zone",
        (ZONES,),
        GPU_SIMULATOR,
    ),
    Fault(
        "pinned-mask-not-renumbered",
        "izo_ref/numbering.py",
        '    for name in ("positions_t0", "positions_t1", "masses", "pinned"):\n',
        '    for name in ("positions_t0", "positions_t1", "masses"):\n',
        "vertices are renumbered, the mask of pinned ones is not: obstacle and cloth confused",
        (SHEETS, RENUMBERED),
        GPU_SIMULATOR,
    ),
    Fault(
        "inverse-masses-for-masses",
        "izo_ref/rows.py",
        "        1.0 / np.sqrt(system.masses),\n",
        "        np.where(np.isinf(system.masses), 0.0, np.sqrt(system.masses)),\n",
        "rows are scaled with masses where inverse masses belong",
        ("tests/test_solve.py::test_one_impact_has_a_closed_form",),
    ),
    Fault(
        "masses-ignored",
        "izo_ref/zones.py",
        "        np.where(scene.pinned[vertices], np.inf, scene.masses[vertices]),\n",
        "        np.where(scene.pinned[vertices], np.inf, 1.0),\n",
        "every free vertex has mass 1",
        ("tests/test_resolve.py::test_masses_share_the_correction",),
    ),
    Fault(
        "thickness-ignored",
        "izo_ref/serial/rows.py",
        "    return (thickness - gap) / length, length, False\n",
        "    return -gap / length, length, False\n",
        "zones are solved for a gap of zero",
        (BY_HAND,),
    ),
    Fault(
        "proposal-by-displacement",
        "izo_ref/step.py",
        "        self.positions = self.scene.positions_t1.copy()\n",
        "        self.positions = self.scene.positions_t0 + (\n"
        "            self.scene.positions_t1 - self.scene.positions_t0\n        )\n",
        "pinned vertices and those that nothing pushes end a rounding off their target",
        ("tests/test_resolve.py::test_without_collisions_the_proposal_comes_back_bit_for_bit",),
    ),
    Fault(
        "renumbered-the-wrong-way",
        "izo_ref/resolving.py",
        "    positions[order] = step.positions\n",
        "    positions[:] = step.positions[order]\n",
        "positions are put back with the inverse of the numbering",
        (BY_HAND, RENUMBERED),
    ),
    Fault(
        "corners-back-without-weights",
        "izo_ref/numbering.py",
        "    weights[vf, 1:] = np.take_along_axis(weights[vf, 1:], corners, 1)\n",
        "",
        "corners come back in the caller's order, their weights do not",
        (CALLERS, SHEETS),
    ),
    Fault(
        "sides-swapped-without-sign",
        "izo_ref/numbering.py",
        "    weights[swap] = -weights[swap][:, [2, 3, 0, 1]]\n",
        "    weights[swap] = weights[swap][:, [2, 3, 0, 1]]\n",
        "the sides of two edges change places, the signs of their weights do not",
        (CALLERS, SHEETS),
    ),
    Fault(
        "ties-decided-by-index",
        "izo_ref/numbering.py",
        "    codes = morton_codes_of(scene.positions_t0, vertices)\n",
        "    codes = np.arange(len(vertices))\n",
        "the numbering of the caller decides between impacts at equal times",
        ("tests/test_resolve.py::test_a_regular_grid_with_ties_in_any_numbering",),
    ),
    Fault(
        "selection-by-one-new-vertex",
        "izo_ref/serial/selection.py",
        "            selected_out[j] = n_new == n_free\n",
        "            selected_out[j] = n_new >= n_free - 1\n",
        "`independent` takes impacts that share a vertex with one taken before",
        ("tests/test_selection.py",),
    ),
    Fault(
        "selection-forgets-first-side",
        "izo_ref/serial/selection.py",
        "                seen[nodes[j, k]] = True\n",
        "                seen[nodes[j, k]] = k > 0 or seen[nodes[j, k]]\n",
        "the first vertex of an impact that was taken is not marked as seen",
        ("tests/test_selection.py",),
    ),
]
