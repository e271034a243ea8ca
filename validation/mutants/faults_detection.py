"""Faults of the detection: boxes, candidates, proofs, frames of impacts."""

from validation.mutants.fault import CPU_SIMULATOR, ELSEWHERE, GPU_SIMULATOR, Fault

ADVANCE = "tests/detection/test_advance.py"
CASES = f"{ADVANCE}::test_degenerate_cases_meet_at_the_known_times"
CONSTRUCTED = f"{ADVANCE}::test_no_exact_meeting_is_missed_and_no_time_comes_late"
INTEGERS = f"{ADVANCE}::test_small_integer_pairs_are_decided_as_in_exact_arithmetic"
RANDOM = f"{ADVANCE}::test_random_pairs_are_decided_as_in_exact_arithmetic"
QUERIES = f"{ADVANCE}::test_no_published_query_is_missed_and_every_false_alarm_touches"
REACH = f"{ADVANCE}::test_a_proof_with_reach_holds_for_every_end_within_it"
FRAME = "tests/detection/test_frame.py"
BY_HAND = f"{FRAME}::test_a_frame_is_the_one_worked_out_by_hand"
SIGNS = f"{FRAME}::test_every_frame_has_a_unit_normal_and_a_gap_that_changes_sign"
DETECTOR = "tests/detection/test_detector.py"
FOLLOWS = f"{DETECTOR}::test_a_detector_that_follows_a_path_finds_what_a_new_one_finds"
WITHIN_REACH = f"{DETECTOR}::test_impacts_within_the_reach_are_found"
AT_REST = f"{DETECTOR}::test_a_component_at_rest_is_found_once_something_reaches_it"
EXCLUDED = f"{DETECTOR}::test_excluded_pairs_are_excluded_everywhere"
COMPONENTS = "tests/detection/test_components.py"
FIND = "tests/detection/test_find.py"
ARMADILLO = f"{FIND}::test_armadillo_rollers_gives_exactly_the_published_pairs"
TREES = "tests/detection/test_trees.py"
SCENES = "tests/data/test_scenes.py::test_detection_finds_the_true_pairs_and_no_other"
SCENE = "tests/test_scene.py"
SIMULATOR = "tests/cuda/test_simulator.py"

DETECTION = [
    Fault(
        "degenerate-cubic-without-root",
        "izo_ref/detection/formulas/coplanar.py",
        "    low = t\n    _, rest = split(c, low)\n",
        "    if c[3] - 3.0 * c[2] + 3.0 * c[1] - c[0] == 0.0:\n        return 2.0\n"
        "    low = t\n    _, rest = split(c, low)\n",
        "A coplanarity cubic whose leading coefficient is zero counts as a cubic without a root.",
        (CASES,),
        ELSEWHERE,
    ),
    Fault(
        "linear-cubic-with-wrong-root",
        "izo_ref/detection/formulas/coplanar.py",
        "        return x0 + (x1 - x0) * (y0 / (y0 - y1))\n",
        "        return x0 + (x1 - x0) * (y0 / (y0 + y1))\n",
        "Where the cubic is nearly straight, its root is computed with a wrong sign.",
        (CASES, RANDOM),
        ELSEWHERE,
    ),
    Fault(
        "absolute-gap-tolerance",
        "izo_ref/detection/formulas/advance.py",
        "    gap_error = GAP_ERROR * max(m1, max(m2, m3))\n",
        "    gap_error = 1e-6\n",
        "Pairs that come closer than 1e-6 m meet, whatever their size is.",
        (CASES,),
        CPU_SIMULATOR,
    ),
    Fault(
        "coplanar-at-the-start-skipped",
        "izo_ref/detection/formulas/advance.py",
        "    cubic = bernstein_coefficients(a1, a2, a3, b1, b2, b3)\n",
        "    cubic = bernstein_coefficients(a1, a2, a3, b1, b2, b3)\n"
        "    if cubic[0] == 0.0:\n        return APART, 1.0, (0.0, 0.0, 0.0), 1\n",
        "Pairs that are coplanar at t = 0 are not examined.",
        (CASES,),
        CPU_SIMULATOR,
    ),
    Fault(
        "half-open-step",
        "izo_ref/detection/formulas/advance.py",
        "        until -= MIN_STEP\n",
        "        until -= MIN_STEP\n        if until > 1.0 - 1e-9:\n"
        "            return APART, 1.0, direction, step\n",
        "The step is [0, 1) instead of [0, 1], so pairs that meet at its end are dropped.",
        (CASES,),
    ),
    Fault(
        "no-gap-error",
        "izo_ref/detection/formulas/advance.py",
        "GAP_ERROR = 48.0 * 2.0**-53\n",
        "GAP_ERROR = 0.0\n",
        "The rounding of projections is not bounded.",
        (CONSTRUCTED, CASES, QUERIES),
    ),
    Fault(
        "no-coefficient-error",
        "izo_ref/detection/formulas/coplanar.py",
        "COEFFICIENT_ERROR = 192.0 * 2.0**-53\n",
        "COEFFICIENT_ERROR = 0.0\n",
        "The rounding of the cubic's coefficients is not bounded.",
        (CONSTRUCTED, QUERIES),
    ),
    Fault(
        "spent-depth-is-apart",
        "izo_ref/detection/formulas/advance.py",
        "    return UNDECIDED, t, direction, max_steps\n",
        "    return APART, 1.0, direction, max_steps\n",
        "A pair that is not decided within the largest number of steps counts as apart.",
        (ARMADILLO, CONSTRUCTED, QUERIES),
    ),
    Fault(
        "shallow-depth",
        "izo_ref/detection/formulas/advance.py",
        "MAX_STEPS = 400\n",
        "MAX_STEPS = 8\n",
        "After eight proofs a pair counts as an impact at the time that was reached.",
        (RANDOM, QUERIES),
    ),
    Fault(
        "parallel-edges-by-their-ends",
        "izo_ref/detection/formulas/closest.py",
        "    s = _clamp01((b * f - c * e) / (a * e - b * b))\n",
        "    if a * e - b * b <= 1e-12 * a * e:\n        return (1.0, 0.0, -1.0, 0.0)\n"
        "    s = _clamp01((b * f - c * e) / (a * e - b * b))\n",
        "The closest points of parallel edges are taken at their first ends.",
        (CASES, INTEGERS),
    ),
    Fault(
        "axis-test-with-wrong-end",
        "izo_ref/detection/formulas/advance.py",
        "        low_t1 = min(r2 - e2, r3 - e3) - max(e0, r1 + e1)\n",
        "        low_t1 = min(r2 - e2, r3 - e3) - min(e0, r1 + e1)\n",
        "The first test of two edges along an axis takes the wrong end at t = 1.",
        (CASES, INTEGERS),
    ),
    Fault(
        "diagonal-of-one-end",
        "izo_ref/detection/formulas/advance.py",
        "        b3[i] - b3[j],\n",
        "        a3[i] - a3[j],\n",
        "The test along a diagonal takes the position of the last node at the start.",
        (CASES, INTEGERS),
    ),
    Fault(
        "sign-of-the-cubic-at-its-ends",
        "izo_ref/detection/formulas/advance.py",
        "    low = min(min(cubic[0], cubic[1]), min(cubic[2], cubic[3]))\n",
        "    low = min(cubic[0], cubic[3])\n",
        "A cubic that is positive at both ends counts as positive in between.",
        (CASES, INTEGERS),
    ),
    Fault(
        "wrong-sign-of-normal",
        "izo_ref/detection/formulas/frame.py",
        "    if gap_t0 < 0.0:\n",
        "    if gap_t0 > 0.0:\n",
        "Normals point to the side on which the pair must not be.",
        (BY_HAND,),
        ELSEWHERE,
    ),
    Fault(
        "frame-at-the-end-of-the-step",
        "izo_ref/detection/formulas/frame.py",
        "    q1, q2, q3 = lerp3(a1, b1, toi), lerp3(a2, b2, toi), lerp3(a3, b3, toi)\n",
        "    q1, q2, q3 = lerp3(a1, b1, 1.0), lerp3(a2, b2, 1.0), lerp3(a3, b3, 1.0)\n",
        "Weights and normals are those at t = 1 instead of those at the time of impact.",
        (BY_HAND, SIGNS),
    ),
    Fault(
        "reach-of-one-side",
        "izo_ref/detection/formulas/advance.py",
        "        t12 = _gap_until(s1 - s2, r1 - r2 - size * (reach[1] + reach[2]), t, threshold)\n",
        "        t12 = _gap_until(s1 - s2, r1 - r2 - size * reach[2], t, threshold)\n",
        "A gap at the end is reduced by the reach of only one of its two nodes.",
        (REACH,),
    ),
    Fault(
        "reach-along-one-axis",
        "izo_ref/detection/formulas/advance.py",
        "    size = sum_abs3(n)\n",
        "    size = max_abs3(n)\n",
        "The reach of a node is taken along the largest axis only.",
        (REACH,),
    ),
    Fault(
        "reach-forgotten-by-the-cubic",
        "izo_ref/detection/formulas/advance.py",
        "    cubic_error += REACH_ERROR *",
        "    cubic_error += 0.0 *",
        "A pair that is never coplanar counts as apart, however far its nodes may still move.",
        (REACH,),
    ),
    Fault(
        "reach-not-in-the-boxes",
        "izo_ref/detection/detector.py",
        "            self._centres + reach,\n",
        "            self._centres,\n",
        "On one side, boxes hold where vertices are and not how far they may still move.",
        (WITHIN_REACH,),
    ),
    Fault(
        "reach-never-left",
        "izo_ref/detection/detector.py",
        "        left = _largest(positions_t1 - self._centres) > self._reach\n",
        "        left = _largest(positions_t1 - previous_t1) > self._reach\n",
        "A vertex that creeps away in small steps is never searched for again.",
        (WITHIN_REACH,),
    ),
    Fault(
        "near-pairs-kept-for-ever",
        "izo_ref/detection/near_pairs.py",
        "        self._near = np.concatenate((self._near[~old], pairs))\n",
        "        self._near = np.concatenate((self._near, pairs))\n",
        "The old near pairs of a vertex that moved on are kept beside its new ones.",
        (FOLLOWS,),
    ),
    Fault(
        "old-impacts-kept",
        "izo_ref/detection/near_pairs.py",
        "        still = ~moved[self.impacts.nodes].any(axis=1)\n",
        "        still = ~moved[self.impacts.nodes].all(axis=1)\n",
        "An impact is kept unchanged as long as one of its vertices did not move.",
        (FOLLOWS,),
    ),
    Fault(
        "part-at-rest-never-woken",
        "izo_ref/detection/detector.py",
        "        return bool((self._left_out & ~far).any())\n",
        "        return False\n",
        "A component at rest that was out of reach at first is left out for ever.",
        (AT_REST,),
    ),
    Fault(
        "parts-by-their-start",
        "izo_ref/detection/components.py",
        "        low, high = np.minimum(low_t0, low_t1), np.maximum(high_t0, high_t1)\n",
        "        low, high = low_t0, high_t0\n",
        "Whether a moving component reaches one at rest is decided by where it starts.",
        (COMPONENTS, FOLLOWS),
    ),
    Fault(
        "boxes-of-the-end-only",
        "izo_ref/detection/serial/tree.py",
        "            ((box[3] < blocks[block, 0, k]) & (box[9] < blocks[block, 6, k]))\n",
        "            (box[9] < blocks[block, 6, k])\n",
        "Boxes count as apart if they are apart along the first axis at the end of the path only.",
        (TREES,),
    ),
    Fault(
        "touching-boxes-apart",
        "izo_ref/detection/serial/tree.py",
        "(box[3] < blocks[block, 0, k])",
        "(box[3] <= blocks[block, 0, k])",
        "Boxes that only touch along the first axis do not meet.",
        (TREES,),
    ),
    Fault(
        "boxes-rounded-each-their-way",
        "izo_ref/detection/serial/boxes.py",
        "        boxes_out[i, axis + 6] = min(max(c, -LARGEST_F4), LARGEST_F4)\n",
        "        boxes_out[i, axis + 6] = 0.999999 * min(max(c, -LARGEST_F4), LARGEST_F4)\n",
        "Maxima are rounded down more than minima, so the order of coordinates is lost.",
        (TREES,),
        ELSEWHERE,
    ),
    Fault(
        "levels-share-what-is-left",
        "izo_ref/detection/serial/tree.py",
        "        shift = 8 * (level - 1)  # levels",
        "        shift = 0 * (level - 1)  # levels",
        "The blocks of a tree level that are still to be entered are forgotten below that level.",
        (TREES,),
    ),
    Fault(
        "sums-of-a-block-alone",
        "izo_ref/base/cuda/arrays.py",
        "starts_out[i + 1] += before[i // TILE]",
        "starts_out[i + 1] += 0 * before[i // TILE]",
        "On a GPU, each block of threads writes as if it were the first one.",
        (SIMULATOR,),
    ),
    Fault(
        "parents-of-what-moved-alone",
        "izo_ref/detection/cuda/tree.py",
        "parent_block(parent, first, end, True, tree.lanes, tree.blocks)",
        "parent_block(parent, first, end, False, tree.lanes, tree.blocks)",
        "On a GPU, elements at rest have no boxes above their own, so nothing meets them.",
        (SIMULATOR,),
    ),
    Fault(
        "equal-keys-change-places",
        "izo_ref/base/cuda/arrays.py",
        "if keys[middle] < key or (beside < run and keys[middle] == key):",
        "if keys[middle] < key or (beside > run and keys[middle] == key):",
        "On a GPU, a sort is not stable.",
        (SIMULATOR,),
    ),
    Fault(
        "excluded-pairs-kept-on-the-device",
        "izo_ref/detection/cuda/paths.py",
        "kept_out[i] = moves and not is_among(keys[i], excluded)",
        "kept_out[i] = moves",
        "A GPU finds the pairs that are to be left out.",
        (SIMULATOR,),
    ),
    Fault(
        "no-room-after-the-first-batch",
        "izo_ref/detection/gpu_detector.py",
        "batch = pairs[begin : begin + BATCH]",
        "batch = pairs[:BATCH]",
        "On a GPU, the first batch of pairs is examined again and again, and the others never.",
        (SIMULATOR,),
    ),
    Fault(
        "last-of-each-block-dropped",
        "izo_ref/detection/serial/boxes.py",
        "    for lane in range(min(WIDTH, end - first - WIDTH * parent)):\n",
        "    for lane in range(min(WIDTH - 1, end - first - WIDTH * parent)):\n",
        "Elements below the last lane of each full block of a tree are never candidates.",
        (TREES,),
        ELSEWHERE,
    ),
    Fault(
        "own-block-skipped",
        "izo_ref/detection/serial/tree.py",
        "            mask &= ALL_LANES << (above & 7)\n",
        "            mask &= ALL_LANES << ((above & 7) + 1)\n",
        "Edges that are neighbours in the tree are never compared with each other.",
        (TREES,),
    ),
    Fault(
        "moved-leaves-of-still-queries",
        "izo_ref/detection/serial/tree.py",
        "        if not (query_lanes >> lane) & 1:\n            mask &= leaf_lanes\n",
        "        if not (query_lanes >> lane) & 1:\n            continue\n",
        "A query that did not move is not made, even where a leaf moved.",
        (TREES,),
    ),
    Fault(
        "contacts-beyond-capacity-dropped",
        "izo_ref/detection/trees.py",
        "    if full.any():\n",
        "    if False:\n",
        "Contacts beyond the capacity of the output are dropped without a message.",
        (TREES,),
        GPU_SIMULATOR,
    ),
    Fault(
        "one-impact-a-vertex",
        "izo_ref/detection/near_pairs.py",
        "        keys, nodes = self._keys_and_nodes(pairs)\n        order = np.argsort(keys)\n",
        "        keys, nodes = self._keys_and_nodes(pairs)\n        order = np.argsort(keys)\n"
        "        order = order[np.unique(keys[order] >> 32, return_index=True)[1]]\n",
        "Only the first of the impacts of one vertex or edge is kept.",
        (SCENES, ARMADILLO),
        ELSEWHERE,
    ),
    Fault(
        "order-as-found",
        "izo_ref/detection/near_pairs.py",
        "        keys, nodes = self._keys_and_nodes(pairs)\n        order = np.argsort(keys)\n",
        "        keys, nodes = self._keys_and_nodes(pairs)\n        order = np.arange(len(keys))\n",
        "Impacts come in the order in which trees or threads found them.",
        (DETECTOR, FIND),
        ELSEWHERE,
    ),
    Fault(
        "pairs-with-a-node-at-rest-skipped",
        "izo_ref/detection/near_pairs.py",
        "            order = order[moving[nodes[order]].any(axis=1)]\n",
        "            order = order[moving[nodes[order]].all(axis=1)]\n",
        "Pairs with one node at rest are skipped, as if all their nodes were at rest.",
        (BY_HAND,),
    ),
    Fault(
        "excluded-pairs-not-excluded",
        "izo_ref/detection/near_pairs.py",
        "            order = order[np.array([key not in self._excluded for key in named], bool)]\n",
        "            order = order[np.array([key is not None for key in named], bool)]\n",
        "Pairs that intersect at the start are examined although they are to be left out.",
        (SCENE, EXCLUDED),
    ),
    Fault(
        "excluded-pairs-by-order-of-corners",
        "izo_ref/detection/pair_keys.py",
        "    nodes[~ee, 1:] = np.sort(nodes[~ee, 1:], axis=1)\n",
        "",
        "An excluded pair is recognised only if its corners come in the same order.",
        (EXCLUDED,),
    ),
    Fault(
        "coplanar-edge-and-face-apart",
        "izo_ref/detection/formulas/crossing.py",
        "    if side_p * side_q > 0:\n",
        "    if side_p * side_q >= 0:\n",
        "At the start, an edge with an end in the plane of a face counts as apart from that face.",
        (SCENE,),
    ),
]
