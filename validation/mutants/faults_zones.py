"""Faults of selection, zones, masses, pinned vertices and numbering."""

from validation.mutants.fault import GPU_SIMULATOR, Fault

ZONES = "tests/zones/test_grouping.py"
SHEETS = "tests/loop/test_resolve.py::test_two_sheets_end_free"
BY_HAND = "tests/loop/test_resolve.py::test_a_falling_vertex_ends_at_the_thickness_above_the_face"
CALLERS = "tests/loop/test_numbering.py::test_impacts_come_in_the_callers_numbering"
RENUMBERED = "tests/loop/test_numbering.py::test_renumbering_changes_nothing_beyond_rounding"

ZONE = [
    Fault(
        "pinned-vertices-have-zones-on-the-device",
        "izo_ref/zones/cuda/grouping.py",
        "            if not pinned[nodes[j, k]]:\n                components_out[j] = ",
        "            if True:\n                components_out[j] = ",
        "On a GPU, an impact belongs to the zone of a pinned vertex.",
        ("tests/cuda/test_simulator.py",),
    ),
    Fault(
        "device-solves-new-zones-only",
        "izo_ref/loop/cuda/step.py",
        "        changed_out[zone] = impacts[impact_offsets[zone + 1] - 1] >= first_new\n",
        "        changed_out[zone] = impacts[impact_offsets[zone]] >= first_new\n",
        "On a GPU, only zones that consist of new impacts are solved.",
        ("tests/cuda/test_simulator.py",),
    ),
    Fault(
        "device-keeps-scaled-multipliers",
        "izo_ref/loop/cuda/step.py",
        "        multipliers_out[impacts[i]] = scaled[i] / lengths[i]\n",
        "        multipliers_out[impacts[i]] = scaled[i]\n",
        "A GPU returns the multipliers of constraints scaled to unit length.",
        ("tests/cuda/test_simulator.py",),
    ),
    Fault(
        "device-objective-without-masses",
        "izo_ref/loop/cuda/step.py",
        "        terms_out[i] = masses[i] * total\n",
        "        terms_out[i] = total if masses[i] > 0.0 else 0.0\n",
        "The objective that the loop uses on a GPU is not weighted by the masses.",
        ("tests/cuda/test_simulator.py",),
    ),
    Fault(
        "device-says-all-is-solved",
        "izo_ref/loop/gpu_step.py",
        "        kernels.negate_flags[len(zones)](solution.solved, left)\n",
        "        kernels.negate_flags[len(zones)](full(len(zones), True, np.bool_), left)\n",
        "Zones that a GPU did not solve are not left to the CPU.",
        ("tests/cuda/test_simulator.py",),
    ),
    Fault(
        "pinned-vertices-are-taken-once-on-the-device",
        "izo_ref/zones/cuda/selection.py",
        "UNDECIDED and seen[nodes[j, k]] and not pinned[nodes[j, k]]:",
        "UNDECIDED and seen[nodes[j, k]]:",
        "On a GPU, an impact waits for another impact at the same pinned vertex.",
        ("tests/cuda/test_simulator.py",),
    ),
    Fault(
        "one-own-vertex-is-enough-on-the-device",
        "izo_ref/zones/cuda/selection.py",
        "if (n_own == n_unpinned) if all_new else (n_own > 0):",
        "if n_own > 0:",
        "On a GPU, impacts that are selected together share a vertex.",
        ("tests/cuda/test_simulator.py",),
    ),
    Fault(
        "zones-merged-in-one-pass",
        "izo_ref/base/serial/components.py",
        "    a = find_root(parent, i)\n    b = find_root(parent, j)\n",
        "    a = parent[i]\n    b = parent[j]\n",
        "Zones are merged in one pass, so a chain of impacts falls apart.",
        (ZONES,),
        GPU_SIMULATOR,
    ),
    Fault(
        "a-hundred-zones",
        "izo_ref/zones/serial/grouping.py",
        "            if root == vertex:\n",
        "            if root == vertex and n_zones < 100:\n",
        "There is room for a hundred zones, and the others are dropped.",
        (ZONES,),
        GPU_SIMULATOR,
    ),
    Fault(
        "pinned-vertices-join-zones",
        "izo_ref/base/serial/components.py",
        "            if not pinned[vertex]:\n",
        "            if vertex >= 0:\n",
        "Impacts that share only a pinned vertex become one zone.",
        (ZONES,),
    ),
    Fault(
        "pinned-mask-of-other-vertices",
        "izo_ref/zones/system.py",
        "        np.where(scene.pinned[vertices], np.inf, scene.masses[vertices]),\n",
        "        np.where(scene.pinned[: len(vertices)], np.inf, scene.masses[vertices]),\n",
        "The mask of pinned vertices is read with indices of the zone.",
        (ZONES,),
        GPU_SIMULATOR,
    ),
    Fault(
        "pinned-mask-not-renumbered",
        "izo_ref/loop/numbering.py",
        '    for name in ("positions_t0", "positions_t1", "masses", "pinned"):\n',
        '    for name in ("positions_t0", "positions_t1", "masses"):\n',
        "Vertices are renumbered, but the mask of pinned ones is not, which mixes up obstacle and "
        "cloth.",
        (SHEETS, RENUMBERED),
        GPU_SIMULATOR,
    ),
    Fault(
        "inverse-masses-for-masses",
        "izo_ref/solvers/scaled_constraints.py",
        "        1.0 / np.sqrt(system.masses),\n",
        "        np.where(np.isinf(system.masses), 0.0, np.sqrt(system.masses)),\n",
        "Constraints are scaled with masses instead of inverse masses.",
        ("tests/solvers/test_solve.py::test_one_impact_has_a_closed_form",),
    ),
    Fault(
        "masses-ignored",
        "izo_ref/zones/system.py",
        "        np.where(scene.pinned[vertices], np.inf, scene.masses[vertices]),\n",
        "        np.where(scene.pinned[vertices], np.inf, 1.0),\n",
        "Every unpinned vertex has mass 1.",
        ("tests/loop/test_resolve.py::test_vertices_share_the_correction_by_inverse_mass",),
    ),
    Fault(
        "thickness-ignored",
        "izo_ref/solvers/serial/constraints.py",
        "    return (thickness - gap) / length, length, False\n",
        "    return -gap / length, length, False\n",
        "Zones are solved for a gap of zero.",
        (BY_HAND,),
    ),
    Fault(
        "proposal-by-displacement",
        "izo_ref/loop/cpu_step.py",
        "        self.positions = self.scene.positions_t1.copy()\n",
        "        self.positions = self.scene.positions_t0 + (\n"
        "            self.scene.positions_t1 - self.scene.positions_t0\n        )\n",
        "Pinned vertices and those that nothing pushes end a rounding away from their proposed "
        "positions.",
        (
            "tests/loop/test_resolve.py::test_without_impacts_the_proposed_positions_come_back_bit_for_bit",
        ),
    ),
    Fault(
        "renumbered-the-wrong-way",
        "izo_ref/loop/resolve.py",
        "    positions[order] = loop.step.positions\n",
        "    positions[:] = loop.step.positions[order]\n",
        "Positions are put back with the inverse of the numbering.",
        (BY_HAND, RENUMBERED),
    ),
    Fault(
        "corners-back-without-weights",
        "izo_ref/loop/serial/numbering.py",
        "                _swap(j, k, m, nodes_out, weights_out)\n",
        "                _swap(j, k, m, nodes_out, weights_out.copy())\n",
        "Corners are put back into the caller's order, but their weights are not.",
        (CALLERS, SHEETS),
    ),
    Fault(
        "sides-swapped-without-sign",
        "izo_ref/loop/serial/numbering.py",
        "            weights_out[j, k] = -weights_out[j, k]\n",
        "            weights_out[j, k] = weights_out[j, k]\n",
        "The two edges of a pair swap sides, but the signs of their weights do not.",
        (CALLERS, SHEETS),
    ),
    Fault(
        "ties-decided-by-index",
        "izo_ref/loop/numbering.py",
        "    codes = morton_codes_of(scene.positions_t0, vertices)\n",
        "    codes = np.arange(len(vertices))\n",
        "The numbering of the caller decides between impacts at equal times.",
        (
            "tests/loop/test_numbering.py::test_impacts_at_equal_times_are_resolved_alike_in_any_numbering",
        ),
    ),
    Fault(
        "tight-only-with-slack",
        "izo_ref/detection/serial/tight.py",
        "    return gap <= thickness * (1.0 + TIGHT)\n",
        "    return gap < thickness * (1.0 - TIGHT)\n",
        "Impacts at the thickness count as slack, so a round gives no impact a new normal.",
        (
            "tests/detection/test_frame.py::test_tight_impacts_alone_get_the_frame_at_their_closest_points",
        ),
    ),
    Fault(
        "selection-by-one-new-vertex",
        "izo_ref/zones/serial/selection.py",
        "            selected_out[j] = n_new == n_unpinned\n",
        "            selected_out[j] = n_new >= n_unpinned - 1\n",
        "`independent` selects impacts that share a vertex with one that was selected before.",
        ("tests/zones/test_selection.py",),
    ),
    Fault(
        "selection-forgets-first-side",
        "izo_ref/zones/serial/selection.py",
        "                seen[nodes[j, k]] = True\n",
        "                seen[nodes[j, k]] = k > 0 or seen[nodes[j, k]]\n",
        "The first vertex of a selected impact is not marked as seen.",
        ("tests/zones/test_selection.py",),
    ),
]
