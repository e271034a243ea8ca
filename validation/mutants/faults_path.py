"""Faults of the outer loop, the fail-safe, the certificate and exact arithmetic."""

from validation.mutants.fault import CPU_SIMULATOR, Fault

RESOLVE = "tests/loop/test_resolve.py"
CERTIFY = "tests/certificate/test_certify.py"
MEETING = "tests/certificate/test_meeting.py"
BY_HAND = "tests/base/test_exact_path.py::test_meeting_times_are_those_worked_out_by_hand"
ROOTS = "tests/base/test_exact_path.py::test_roots_are_isolated_and_signs_there_are_exact"
EXACT = "tests/base/test_exact_path.py"
SCALE_BACK = "tests/loop/test_scale_back.py"
NEXT_STEP = "tests/loop/test_next_step.py"
BUDGET = f"{SCALE_BACK}::test_a_spent_budget_ends_free_by_fallback"

SIZES = "tests/loop/test_sizes.py"

PATHS = [
    Fault(
        "sizes-by-unused-vertices",
        "izo_ref/base/sizes.py",
        "    size = max(largest(end[in_face]) for end in ends)\n",
        "    size = max(largest(end) for end in ends)\n",
        "Vertices in no face decide the size of a step.",
        (f"{SIZES}::test_unused_vertices_far_out_change_nothing",),
    ),
    Fault(
        "multipliers-without-masses",
        "izo_ref/loop/result_back.py",
        "times_power(result.multipliers, -units.length - units.mass)",
        "times_power(result.multipliers, -units.length)",
        "Multipliers are not multiplied back by the factor of masses.",
        (f"{SIZES}::test_random_steps_of_any_size_have_the_same_bits",),
    ),
    Fault(
        "odd-powers-of-masses",
        "izo_ref/base/units.py",
        "    return -(middle - middle % 2)\n",
        "    return -middle\n",
        "Masses are multiplied by odd powers of two, whose roots have other digits.",
        (f"{SIZES}::test_random_steps_of_any_size_have_the_same_bits",),
    ),
    Fault(
        "digits-of-small-coordinates-lost",
        "izo_ref/base/sizes.py",
        "    if length >= 0:\n        return\n",
        "    if length < 0:\n        return\n",
        "Coordinates that lose digits when they are multiplied are accepted.",
        (f"{SIZES}::test_sizes_that_cannot_be_computed_are_refused_by_name",),
    ),
    Fault(
        "free-proposal-moved",
        "izo_ref/loop/iterate.py",
        "        return certify_path(scene, end).free\n",
        "        return False\n",
        "A proposal that is free is moved where detection cannot prove it apart.",
        ("tests/loop/test_proposal.py",),
    ),
    Fault(
        "doubtful-proposal-taken",
        "izo_ref/loop/iterate.py",
        "        if meets.any() or _one_meets(sample, scene):\n",
        "        if meets.any():\n",
        "A proposal is certified in full wherever floats cannot tell whether some impacts meet.",
        ("tests/loop/test_proposal.py",),
    ),
    Fault(
        "pending-impacts-forgotten",
        "izo_ref/detection/known_impacts.py",
        "            self._keys, self.impacts = self._keys[still], self.impacts.take(still)\n",
        "            self._keys, self.impacts = self._keys[:0], no_impacts()\n",
        "Incremental detection forgets the impacts of vertices that did not move since.",
        (RESOLVE,),
    ),
    Fault(
        "moved-along-all-axes",
        "izo_ref/detection/serial/reach.py",
        "    return max(abs(a[i, 0] - b[i, 0]), abs(a[i, 1] - b[i, 1]), abs(a[i, 2] - b[i, 2]))\n",
        "    return min(abs(a[i, 0] - b[i, 0]), abs(a[i, 1] - b[i, 1]), abs(a[i, 2] - b[i, 2]))\n",
        "Incremental detection does not look again at vertices that moved along some axes only.",
        (
            "tests/loop/test_resolve.py::test_a_falling_vertex_ends_at_the_thickness_above_the_face",
            RESOLVE,
        ),
    ),
    Fault(
        "zones-with-new-impacts-not-solved-again",
        "izo_ref/loop/cpu_step.py",
        "        changed = np.maximum.reduceat(zones.impacts, zones.impact_offsets[:-1])"
        " >= first_new\n",
        "        changed = np.minimum.reduceat(zones.impacts, zones.impact_offsets[:-1])"
        " >= first_new\n",
        "Only zones that consist of new impacts are solved.",
        (RESOLVE,),
    ),
    Fault(
        "relinearisation-accepts-an-increase",
        "izo_ref/loop/resolve.py",
        "        if not loop.run(number, limit=best):\n",
        "        if not loop.run(number):\n",
        "A round of new normals is kept although it ends farther from the proposed positions.",
        (RESOLVE,),
    ),
    Fault(
        "relinearisation-has-no-budget",
        "izo_ref/loop/resolve.py",
        "        if _work(loop.history[n_main:]) > budget:\n",
        "        if _work(loop.history[n_main:]) < 0:\n",
        "Rounds of new normals may take any multiple of the time of the main loop.",
        ("tests/loop/test_resolve.py::test_a_round_begins_only_within_the_budget",),
    ),
    Fault(
        "scaled-back-called-optimal",
        "izo_ref/loop/verdict.py",
        "    valid = certificate.free and not scaled_back\n",
        "    valid = certificate.free\n",
        "A result that was scaled back may be called converged.",
        (BUDGET,),
    ),
    Fault(
        "status-without-certificate",
        "izo_ref/loop/verdict.py",
        "    if not certificate.free:\n",
        "    if not (certificate.free or not scaled_back):\n",
        "A path that is not free is not called blocked.",
        (RESOLVE,),
        CPU_SIMULATOR,
    ),
    Fault(
        "fallback-compounds-scales",
        "izo_ref/loop/scale_back.py",
        "        step.positions = np.where(kept[:, None], step.positions,"
        " start + scale[:, None] * full)\n",
        "        step.positions = np.where(\n            kept[:, None], step.positions,"
        " start + scale[:, None] * (step.positions - start)\n        )\n",
        "In each round, vertices that were scaled back are scaled again by their whole scale.",
        (SCALE_BACK,),
    ),
    Fault(
        "fallback-moves-what-was-not-scaled",
        "izo_ref/loop/scale_back.py",
        "np.where(kept[:, None], step.positions, start + scale[:, None] * full)\n",
        "start + scale[:, None] * full\n",
        "Scaling back moves pinned vertices by rounding.",
        (BUDGET, RESOLVE),
    ),
    Fault(
        "certified-by-what-moved",
        "izo_ref/certificate/certify.py",
        "    found = detector.find(positions)\n",
        "    found = detector.find(positions, (positions != scene.positions_t1).any(axis=1))\n",
        "The certificate examines only vertices that the solver moved.",
        (CERTIFY,),
    ),
    Fault(
        "open-pairs-called-apart",
        "izo_ref/certificate/certify.py",
        "        meets[i] = time is not None\n",
        "        meets[i] = False\n",
        "Pairs that floats cannot decide are called apart without exact arithmetic.",
        (CERTIFY, EXACT),
    ),
    Fault(
        "open-pairs-called-meeting",
        "izo_ref/certificate/certify.py",
        "        meets[i] = time is not None\n",
        "        meets[i] = True\n",
        "Pairs that floats cannot decide are said to meet without exact arithmetic.",
        (CERTIFY, EXACT),
    ),
    Fault(
        "no-bound-of-areas",
        "izo_ref/certificate/formulas/meeting.py",
        "    bound12 = COEFFICIENT_ERROR * (m1 * m2) + TINY\n"
        "    bound23 = COEFFICIENT_ERROR * (m2 * m3) + TINY\n"
        "    bound31 = COEFFICIENT_ERROR * (m3 * m1) + TINY\n",
        "    bound12 = bound23 = bound31 = 0.0\n",
        "A contact is called certain although its side may come from rounding.",
        (f"{MEETING}::test_pairs_that_barely_touch_or_miss_are_never_certain",),
    ),
    Fault(
        "edges-cross-by-one-side",
        "izo_ref/certificate/formulas/meeting.py",
        "        return side_b * side_s == -1\n",
        "        return side_b != 0\n",
        "Two edges are said to cross if the ends of one lie on both sides of the other.",
        (MEETING,),
    ),
    Fault(
        "root-at-one-lost",
        "izo_ref/base/algebraic.py",
        "    parts = [(0, 1, 1)]\n",
        "    parts = [(0, 2**60 - 1, 2**60)]\n",
        "Exact arithmetic looks for roots in [0, 1), so pairs that meet at the end are lost.",
        (BY_HAND,),
    ),
    Fault(
        "always-coplanar-is-apart",
        "izo_ref/base/exact_path.py",
        "        times = [AlgebraicTime([], 0, 0, 1)]\n"
        "        times += [time for p in deciding if p for time in roots_in_unit_interval(p)]\n",
        "        times = [] if deciding else []\n",
        "In exact arithmetic, pairs that are coplanar all the time never meet.",
        (BY_HAND,),
    ),
    Fault(
        "always-coplanar-without-differences",
        "izo_ref/base/exact_path.py",
        "for vector in (*turns, *nodes) for p in vector] + differences\n",
        "for vector in (*turns, *nodes) for p in vector] + differences[:0]\n",
        "For edges in one plane, the times at which ends of different edges are level are left "
        "out.",
        (BY_HAND, EXACT),
    ),
    Fault(
        "common-roots-not-recognised",
        "izo_ref/base/algebraic.py",
        "            if len(common) > 1:\n",
        "            if len(common) > 4:\n",
        "A sign that is zero at an algebraic time is searched for by halving the interval.",
        (ROOTS,),
        limit_s=60.0,
    ),
    Fault(
        "nearly-zero-is-zero",
        "izo_ref/base/algebraic.py",
        "            common = common_divisor(time.polynomial, poly)\n",
        "            return 0\n            common = common_divisor(time.polynomial, poly)\n",
        "A sign that is not certain on a narrow interval counts as zero.",
        (BY_HAND, EXACT),
    ),
    Fault(
        "meeting-time-rounded-up",
        "izo_ref/base/algebraic.py",
        "    number = Fraction(time.low, time.unit)\n",
        "    number = Fraction(time.high, time.unit)\n",
        "The time of a meeting may be given too late.",
        (BY_HAND, EXACT),
    ),
    Fault(
        "uncertified-end-is-a-start",
        "izo_ref/base/certified.py",
        "    if not certificate.free:\n",
        "    if not certificate.free and certificate.time_free == 0.0:\n",
        "The next step may start where a path ends that is free only at its beginning.",
        (NEXT_STEP,),
    ),
    Fault(
        "changed-end-is-a-start",
        "izo_ref/base/certified.py",
        "    if not np.array_equal(result.positions, certificate.positions):\n",
        "    if result.positions.shape != certificate.positions.shape:\n",
        "The next step starts where the last one ended, although the caller's end is another.",
        (NEXT_STEP,),
    ),
    Fault(
        "excluded-pairs-stay-excluded",
        "izo_ref/scene.py",
        "        if result.certificate.excluded is not None:\n",
        "        if False:\n",
        "Pairs that came apart stay excluded in the next step, and others are never excluded.",
        (NEXT_STEP,),
    ),
    Fault(
        "one-coordinate-is-a-place",
        "izo_ref/base/exact.py",
        "(a[:, 1] == b[:, 1]) & (a[:, 2] == b[:, 2])\n",
        "(a[:, 1] == b[:, 1])\n",
        "Vertices one above the other count as being at the same place.",
        ("tests/base/test_exact.py",),
    ),
    Fault(
        "touched-side-is-outside",
        "izo_ref/base/exact.py",
        "    meet[across] = (np.minimum.reduce(turns) >= 0) | (np.maximum.reduce(turns) <= 0)\n",
        "    meet[across] = (np.minimum.reduce(turns) > 0) | (np.maximum.reduce(turns) < 0)\n",
        "An edge that goes through a side of a face is said to miss the face.",
        ("tests/base/test_exact.py",),
    ),
    Fault(
        "edge-in-the-plane-is-across",
        "izo_ref/base/exact.py",
        "            meet[left] = (s012 * s031 >= 0) & (s023 * s123 <= 0)\n",
        "            meet[left] = s012 * s031 >= 0\n",
        "Edges in one plane are said to meet if one of them meets the line of the other.",
        ("tests/base/test_exact.py",),
    ),
    Fault(
        "collinear-edges-meet",
        "izo_ref/base/exact.py",
        "        meet &= (ends[0][0] <= ends[1][1]) & (ends[1][0] <= ends[0][1])\n",
        "        meet &= ends[0][0] <= ends[1][1]\n",
        "An edge on the line of another one, beyond its end, is said to meet it.",
        ("tests/base/test_exact.py",),
    ),
]
