"""Faults of the detection: boxes, candidates, proofs, frames of impacts."""

from validation.mutants.fault import CPU_SIMULATOR, ELSEWHERE, GPU_SIMULATOR, Fault

CASES = "tests/test_detect.py::test_degenerate_cases"
CONSTRUCTED = "tests/test_detect.py::test_no_exact_meeting_is_missed_and_no_time_comes_late"
INTEGERS = "tests/test_detect.py::test_against_exact_arithmetic_on_small_integers"
RANDOM = "tests/test_detect.py::test_against_exact_arithmetic_on_random_pairs"
FRAMES = "tests/test_detect.py::test_frames_of_impacts"
QUERIES = "tests/test_detect.py::test_no_query_is_missed_and_every_false_alarm_touches"
ARMADILLO = "tests/test_detect.py::test_armadillo_rollers_gives_exactly_the_published_pairs"
BROAD = "tests/test_broad.py"
CAUGHT = "tests/test_caught.py"

DETECTION = [
    Fault(
        "degenerate-cubic-without-root",
        "izo_ref/scalar/coplanar.py",
        "    low = t\n    _, rest = split(c, low)\n",
        "    if c[3] - 3.0 * c[2] + 3.0 * c[1] - c[0] == 0.0:\n        return 2.0\n"
        "    low = t\n    _, rest = split(c, low)\n",
        "a coplanarity cubic whose leading coefficient is zero counts as one without root",
        (CASES,),
        ELSEWHERE,
    ),
    Fault(
        "linear-cubic-with-wrong-root",
        "izo_ref/scalar/coplanar.py",
        "        return x0 + (x1 - x0) * (y0 / (y0 - y1))\n",
        "        return x0 + (x1 - x0) * (y0 / (y0 + y1))\n",
        "where the cubic is nearly straight its root is computed with a wrong sign",
        (CASES, RANDOM),
        ELSEWHERE,
    ),
    Fault(
        "absolute-gap-tolerance",
        "izo_ref/scalar/advance.py",
        "    gap_error = GAP_ERROR * max(m1, max(m2, m3))\n",
        "    gap_error = 1e-6\n",
        "pairs closer than 1e-6 m meet, whatever their size",
        (CASES,),
        CPU_SIMULATOR,
    ),
    Fault(
        "coplanar-at-the-start-skipped",
        "izo_ref/scalar/advance.py",
        "    cubic = bernstein_coefficients(a1, a2, a3, b1, b2, b3)\n",
        "    cubic = bernstein_coefficients(a1, a2, a3, b1, b2, b3)\n"
        "    if cubic[0] == 0.0:\n        return APART, 1.0, (0.0, 0.0, 0.0), 1\n",
        "pairs that are coplanar at t = 0 are not looked at",
        (CASES,),
        CPU_SIMULATOR,
    ),
    Fault(
        "half-open-step",
        "izo_ref/scalar/advance.py",
        "        until -= MIN_STEP\n",
        "        until -= MIN_STEP\n        if until > 1.0 - 1e-9:\n"
        "            return APART, 1.0, direction, step\n",
        "the step is [0, 1) instead of [0, 1]: what meets at its end is dropped",
        (CASES,),
    ),
    Fault(
        "no-gap-error",
        "izo_ref/scalar/advance.py",
        "GAP_ERROR = 48.0 * 2.0**-53\n",
        "GAP_ERROR = 0.0\n",
        "the rounding of projections is not bounded",
        (CONSTRUCTED, CASES, QUERIES),
    ),
    Fault(
        "no-coefficient-error",
        "izo_ref/scalar/coplanar.py",
        "COEFFICIENT_ERROR = 192.0 * 2.0**-53\n",
        "COEFFICIENT_ERROR = 0.0\n",
        "the rounding of the cubic's coefficients is not bounded",
        (CONSTRUCTED, QUERIES),
    ),
    Fault(
        "spent-depth-is-apart",
        "izo_ref/scalar/advance.py",
        "    return UNDECIDED, t, direction, MAX_STEPS\n",
        "    return APART, 1.0, direction, MAX_STEPS\n",
        "a pair that the largest number of steps does not settle counts as apart",
        (ARMADILLO, CONSTRUCTED, QUERIES),
    ),
    Fault(
        "shallow-depth",
        "izo_ref/scalar/advance.py",
        "MAX_STEPS = 400\n",
        "MAX_STEPS = 8\n",
        "eight proofs a pair, then it counts as an impact at the time reached",
        (RANDOM, QUERIES),
    ),
    Fault(
        "parallel-edges-by-their-ends",
        "izo_ref/scalar/closest.py",
        "    s = _clamp01((b * f - c * e) / (a * e - b * b))\n",
        "    if a * e - b * b <= 1e-12 * a * e:\n        return (1.0, 0.0, -1.0, 0.0)\n"
        "    s = _clamp01((b * f - c * e) / (a * e - b * b))\n",
        "the closest points of parallel edges are their first ends",
        (CASES, INTEGERS),
    ),
    Fault(
        "axis-test-with-wrong-end",
        "izo_ref/scalar/advance.py",
        "s3 - max(0.0, s1)), min(r2, r3) - max(0.0, r1))\n",
        "s3 - max(0.0, s1)), min(r2, r3) - min(0.0, r1))\n",
        "the first test of two edges along an axis takes the wrong end at t = 1",
        (CASES, INTEGERS),
    ),
    Fault(
        "diagonal-of-one-end",
        "izo_ref/scalar/advance.py",
        "        b3[i] - b3[j],\n",
        "        a3[i] - a3[j],\n",
        "the test along a diagonal takes the last node where it was at the start",
        (CASES, INTEGERS),
    ),
    Fault(
        "sign-of-the-cubic-at-its-ends",
        "izo_ref/scalar/advance.py",
        "    low = min(min(cubic[0], cubic[1]), min(cubic[2], cubic[3]))\n",
        "    low = min(cubic[0], cubic[3])\n",
        "a cubic that is positive at both ends counts as positive in between",
        (CASES, INTEGERS),
    ),
    Fault(
        "wrong-sign-of-normal",
        "izo_ref/scalar/frame.py",
        "    if gap_t0 < 0.0:\n",
        "    if gap_t0 > 0.0:\n",
        "normals point to the side on which the pair must not be",
        (FRAMES,),
        ELSEWHERE,
    ),
    Fault(
        "frame-at-the-end-of-the-step",
        "izo_ref/scalar/frame.py",
        "    q1, q2, q3 = lerp3(a1, b1, toi), lerp3(a2, b2, toi), lerp3(a3, b3, toi)\n",
        "    q1, q2, q3 = lerp3(a1, b1, 1.0), lerp3(a2, b2, 1.0), lerp3(a3, b3, 1.0)\n",
        "weights and normals are those at t = 1, not those at the time of impact",
        (FRAMES, "tests/test_detect.py::test_every_impact_has_a_sound_frame"),
    ),
    Fault(
        "boxes-in-single-precision",
        "izo_ref/cpu/tree.py",
        "            boxes_out[i, axis] = low\n            boxes_out[i, axis + 3] = high\n",
        "            boxes_out[i, axis] = np.float32(low)\n"
        "            boxes_out[i, axis + 3] = np.float32(high)\n",
        "boxes are rounded to single precision, not outward",
        (BROAD,),
        ELSEWHERE,
    ),
    Fault(
        "boxes-of-the-end-only",
        "izo_ref/cpu/tree.py",
        "                low = min(low, min(a, b))\n",
        "                low = min(low, b)\n",
        "boxes hold the lower corner of the end of the path only",
        (BROAD,),
    ),
    Fault(
        "touching-boxes-apart",
        "izo_ref/serial/tree.py",
        "        a[i, 0] <= b[j, 3]\n",
        "        a[i, 0] < b[j, 3]\n",
        "boxes that only touch along the first axis do not meet",
        (CAUGHT, BROAD),
    ),
    Fault(
        "last-of-each-leaf-dropped",
        "izo_ref/serial/tree.py",
        "            end = min(begin + GROUP, leaf_boxes.shape[0])\n",
        "            end = min(begin + GROUP - 1, leaf_boxes.shape[0])\n",
        "the last element of each full leaf of a tree is never a candidate",
        (BROAD,),
        ELSEWHERE,
    ),
    Fault(
        "contacts-beyond-capacity-dropped",
        "izo_ref/broad.py",
        "    if full.any():\n",
        "    if False:\n",
        "what was found beyond the room for it is dropped without a word",
        (BROAD,),
        GPU_SIMULATOR,
    ),
    Fault(
        "buffer-forgets-where-it-was",
        "izo_ref/serial/tree.py",
        "                return count, node\n",
        "                return count, 0\n",
        "when the buffer of candidates is full, the rest of the tree is skipped",
        (BROAD,),
    ),
    Fault(
        "one-impact-a-vertex",
        "izo_ref/detect.py",
        "        order = np.lexsort((elements[:, 1], elements[:, 0]))\n",
        "        order = np.lexsort((elements[:, 1], elements[:, 0]))\n"
        "        order = order[np.unique(elements[order, 0], return_index=True)[1]]\n",
        "of the impacts of one vertex or edge, all but the first are dropped",
        (ARMADILLO,),
        ELSEWHERE,
    ),
    Fault(
        "order-as-found",
        "izo_ref/detect.py",
        "        order = np.lexsort((elements[:, 1], elements[:, 0]))\n",
        "        order = np.arange(len(elements))\n",
        "impacts come in the order in which trees or threads found them",
        ("tests/test_detect.py",),
        ELSEWHERE,
    ),
    Fault(
        "pairs-with-a-node-at-rest-skipped",
        "izo_ref/detect.py",
        "            kept = (self.positions_t0[nodes] != positions_t1[nodes]).any(axis=(1, 2))\n",
        "            kept = (self.positions_t0[nodes] != positions_t1[nodes]).any(axis=2)"
        ".all(axis=1)\n",
        "pairs with a node at rest are skipped, as if all were",
        (FRAMES,),
    ),
    Fault(
        "excluded-pairs-not-excluded",
        "izo_ref/detect.py",
        "            kept &= np.array([key not in self._excluded for key in keys], bool)\n",
        "            kept &= np.array([key is not None for key in keys], bool)\n",
        "pairs that intersect at the start are looked at although they were left out",
        ("tests/test_scene.py", CAUGHT),
    ),
    Fault(
        "excluded-pairs-by-order-of-corners",
        "izo_ref/detect.py",
        "    nodes[~ee, 1:] = np.sort(nodes[~ee, 1:], axis=1)\n",
        "",
        "an excluded pair is known again only if its corners come in the same order",
        (CAUGHT,),
    ),
    Fault(
        "coplanar-edge-and-face-apart",
        "izo_ref/scalar/crossing.py",
        "    if side_p * side_q > 0:\n",
        "    if side_p * side_q >= 0:\n",
        "at the start, an edge with an end in the plane of a face counts as apart from it",
        ("tests/test_scene.py", CAUGHT),
    ),
]
