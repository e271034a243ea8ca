"""Faults of starts that touch or cross, of what is left out, and of what is said about it."""

from validation.mutants.fault import Fault

SIDES = "tests/detection/test_sides.py"
EXACT = "tests/base/test_exact_path.py"
TOUCHING = "tests/loop/test_touching.py"
EXCLUDED = "tests/loop/test_excluded.py"

STARTS = [
    Fault(
        "told-side-not-turned",
        "izo_ref/detection/sides.py",
        "                told -= unit_vector(normal)\n",
        "                told += unit_vector(normal)\n",
        "A pair that touches may be pushed to the wrong side.",
        (SIDES,),
    ),
    Fault(
        "side-by-one-star",
        "izo_ref/detection/sides.py",
        "            if min(signs, default=0) >= 0 >= max(others, default=0):\n",
        "            if min(signs, default=0) >= 0:\n",
        "The faces around the second side do not matter for the side that the mesh tells.",
        (SIDES,),
    ),
    Fault(
        "nothing-in-one-plane-is-told",
        "izo_ref/detection/sides.py",
        "            normals = [cross(plane, v) for v in (edges or corners)]\n",
        "            normals = []\n",
        "Parts that touch in one plane, side by side, are left out.",
        (SIDES,),
    ),
    Fault(
        "touching-counts-as-crossing",
        "izo_ref/detection/touching.py",
        "    through = (touching < 0).all(axis=1) | crossing[touching].any(axis=1)\n",
        "    through = np.ones(len(touching), bool)\n",
        "Wherever an edge touches a face, their five pairs are left out.",
        (SIDES,),
    ),
    Fault(
        "edges-go-through-after-the-start",
        "izo_ref/detection/touching_path.py",
        "        toi[own.pair[self._crosses[own.contact]]] = 0.0\n",
        "",
        "A vertex that touches a face may leave it on the wrong side.",
        (SIDES, TOUCHING),
    ),
    Fault(
        "sides-stay-in-touch",
        "izo_ref/base/exact_path.py",
        "        if _coplanar_meet(is_edge_edge, nodes, turns, _before(times)):\n",
        "        if False:\n",
        "A pair that stays in touch counts as apart until something changes.",
        (EXACT,),
    ),
    Fault(
        "apart-by-three-coefficients-of-four",
        "izo_ref/detection/formulas/touching.py",
        "    return min(c1, min(c2, c3)) > error or max(c1, max(c2, c3)) < -error\n",
        "    return min(c1, c2) > error or max(c1, c2) < -error\n",
        "A pair that lifts off and comes back counts as apart.",
        (EXCLUDED,),
    ),
    Fault(
        "left-out-but-called-free",
        "izo_ref/loop/verdict.py",
        "    elif certificate.excluded is not None:\n",
        "    elif certificate.excluded is not None and not converged:\n",
        "A step of which pairs were left out is called FREE.",
        (EXCLUDED,),
    ),
    Fault(
        "prescribed-pairs-are-not-named",
        "izo_ref/certificate/certify.py",
        "        excluded = _joined(excluded, meeting.take(prescribed))\n",
        "",
        "Pairs that meet between pinned points are left out, and nobody learns of it.",
        (EXCLUDED,),
    ),
    Fault(
        "crossing-at-the-end-is-apart",
        "izo_ref/detection/intersections.py",
        "    states |= dict.fromkeys(pair_keys(fives), PairState.CROSSING)\n",
        "",
        "Excluded pairs that cross at the end count as apart there.",
        (EXCLUDED,),
    ),
    Fault(
        "ratchet-lets-in",
        "izo_ref/scene.py",
        "            kept |= [key in keys for key in pair_keys(found)]\n",
        "            kept[:] = True\n",
        "With `ratchet`, pairs that were apart may be left out later.",
        (EXCLUDED,),
    ),
    Fault(
        "meeting-pairs-in-any-order",
        "izo_ref/certificate/certify.py",
        '    in_time = met[np.argsort(toi[met], kind="stable")]\n',
        "    in_time = met\n",
        "The list of a certificate does not begin with the pair that ends the free path.",
        (EXCLUDED, "tests/certificate/test_certify.py"),
    ),
    Fault(
        "blocked-zone-blocks-all",
        "izo_ref/loop/resolve.py",
        "        step.positions = np.where(blocked[:, None], step.longest[0], step.positions)\n",
        "        step.positions = step.longest[0]\n",
        "If one zone is blocked, no other one is resolved.",
        (EXCLUDED,),
    ),
    Fault(
        "doubts-are-impacts",
        "izo_ref/detection/doubts.py",
        "            meets[i] = False\n",
        "            pass\n",
        "A pair that starts nearer than rounding can tell is an impact, whatever it does.",
        ("tests/loop/test_proposal.py",),
    ),
    Fault(
        "doubtful-normals",
        "izo_ref/detection/doubts.py",
        "            toi[i], directions[i] = time, normal\n",
        "            toi[i] = time\n",
        "The normal of a pair that starts nearer than rounding can tell is noise.",
        ("tests/loop/test_proposal.py",),
    ),
    Fault(
        "satisfied-impacts-enter-again",
        "izo_ref/zones/serial/selection.py",
        "    return gap < thickness * (1.0 - SHORTFALL)\n",
        "    return True\n",
        "Impacts that are satisfied keep others out of the zones, until no iteration is left.",
        (EXCLUDED,),
    ),
]
