"""Why no input can show a fault that survived `python -m validation mutants --random`.

A reason holds for one change of one line, and a test checks that the line is still there.
"""

from validation.mutants.survivor import (
    ANY_DIRECTION,
    EXACT_DECIDES,
    SMALLER_MARGIN,
    TINY_ROOM,
    Survivor,
)

SURVIVORS: list[Survivor] = [
    Survivor(
        "izo_ref/zones/scaled_zone.py",
        "ScaledZone.moved",
        "return slack, self.slack_error + 24 * U * (self.size @ np.abs(step)) + U * np.abs(slack)",
        "return slack, self.slack_error + 24 * U * (self.size @ np.abs(step)) + (U / 64) * "
        "np.abs(slack)",
        "The rest covers this rounding too: `slack_error` has 2 u of the slack before the move "
        "where 1 u is needed, and 24 u of the moved terms where 20 u are needed.",
    ),
    Survivor(
        "izo_ref/zones/distance.py",
        "_bound_on_active",
        "smallest = values[0] - (24 + 8 * count) * count * U",
        "smallest = values[0] - ((8 * count)) * count * U",
        "The worst case of the entries, 24 u each, is far from what rounding does: in 20,800 "
        "random matrices with dependent rows, the smallest computed eigenvalue is at most 1.1 "
        "count^2 u.",
    ),
    Survivor(
        "izo_ref/zones/scaled_zone.py",
        "ScaledZone.__init__",
        "largest[empty] = 1.0",
        "largest[empty] = (0.5 * 1.0)",
        "Entries of empty rows are zero whatever they are divided by, and the length of these "
        "rows is set to 1 below.",
    ),
    Survivor(
        "izo_ref/zones/distance.py",
        "_bound_on_active",
        "return _rounded_up(norm(across) + 2.0 * beyond + along)",
        "return _rounded_up(norm(across) + beyond + along)",
        "What is left to move lies in the span of the active rows, where the fitted multipliers "
        "follow it. The second share is for multipliers that are clamped by rounding at the same "
        "time.",
    ),
    Survivor(
        "izo_ref/detection/formulas/margin.py",
        "MARGIN_SHARE",
        "MARGIN_SHARE = 0.5 - 2.0**-12",
        "MARGIN_SHARE = (0.5 - 2.0**-12) / 2",
        SMALLER_MARGIN,
    ),
    Survivor(
        "izo_ref/detection/serial/mesh.py",
        "sort_rows",
        "for value in range(n_values):",
        "for value in range(n_values - 1):",
        "The last place is where a value that does not exist would begin; no row reads it.",
    ),
    Survivor(
        "izo_ref/detection/formulas/advance.py",
        "_first_contact",
        "if until_m > until:",
        "if until_m >= until:",
        ANY_DIRECTION,
    ),
    Survivor(
        "izo_ref/detection/formulas/crossing.py",
        "_closest_vector",
        "for side in range(3):",
        "for side in range(1, 3):",
        EXACT_DECIDES,
    ),
    Survivor(
        "izo_ref/certificate/formulas/meeting.py",
        "_meets_between",
        "if not ((volume0 > bound and volume1 < -bound) or (volume0 < -bound and volume1 > "
        "bound)):",
        "if not ((volume0 > bound and volume1 <= -bound) or (volume0 < -bound and volume1 > "
        "bound)):",
        "A bound is larger than any error, so a volume that equals it has a certain sign too.",
    ),
    Survivor(
        "izo_ref/base/sizes.py",
        "_require_size",
        "if size > high:",
        "if size >= high:",
        "At the border itself no coordinate is larger, so the list of vertices is empty and no "
        "error is raised.",
    ),
    Survivor(
        "izo_ref/detection/formulas/advance.py",
        "advance",
        "cubic_error = COEFFICIENT_ERROR * (m1 * m2 * m3) + TINY",
        "cubic_error = COEFFICIENT_ERROR * (m1 * m2 * m3) + (TINY / 64)",
        TINY_ROOM,
    ),
    Survivor(
        "izo_ref/certificate/formulas/meeting.py",
        "_meets_between",
        "bound23 = COEFFICIENT_ERROR * (m2 * m3) + TINY",
        "bound23 = COEFFICIENT_ERROR * (m2 * m3) + (TINY / 64)",
        TINY_ROOM,
    ),
    Survivor(
        "izo_ref/detection/formulas/margin.py",
        "cubic_margin",
        "slack = low - COEFFICIENT_ERROR * (m1 * m2 * m3) - TINY",
        "slack = low - COEFFICIENT_ERROR * (m1 * m2 * m3) - (TINY / 2)",
        TINY_ROOM,
    ),
    Survivor(
        "izo_ref/zones/serial/deep_selection.py",
        "relative_depth",
        "for k in range(4):",
        "for k in range(1, 4):",
        "Positions are relative to those of node 0, which adds zero itself.",
    ),
    Survivor(
        "izo_ref/detection/formulas/touching.py",
        "_scaled",
        "unit = power_of_two_for(max(m1, max(m2, m3)))",
        "unit = power_of_two_for(max(m1, min(m2, m3)))",
        "Multiplying by a power of two is exact, and any that is near the size of the pair "
        "serves: coordinates of a scene are within 2^200 of each other, so that products stay "
        "far from overflow.",
    ),
    Survivor(
        "izo_ref/base/exact_closest.py",
        "_candidates",
        "if normal != NOWHERE and min(sides) >= 0:",
        "if normal != NOWHERE and min(sides) > 0:",
        "A point that lies over a side has the same closest point as a point of that side, which "
        "is a candidate too.",
    ),
    Survivor(
        "izo_ref/detection/weld.py",
        "ROUNDING",
        "ROUNDING = 1.0 + 2.0**-49",
        "ROUNDING = 1.0 + (2.0**-49) / 2",
        "Of the two ways, a difference and two roots lose at most 5 u, and a root of a sum of "
        "squares 3 u: together these are the 8 u that are left.",
    ),
    Survivor(
        "izo_ref/detection/formulas/touching.py",
        "volume_sign_after_start",
        "slope = (det3(b1, a2, a3) + det3(a1, b2, a3) + det3(a1, a2, b3)) / 3.0",
        "slope = (det3(b1, a2, a3) + det3(a1, b2, a3) + det3(a1, a2, b3)) / (0.5 * 3.0)",
        "Only the sign counts, and the rounding of twice the slope, 140 u, is still below the "
        "bound of 192 u.",
    ),
    Survivor(
        "izo_ref/base/exact.py",
        "_edge_face_meet",
        "(True, (0, 1, 3, 4)),",
        "(True, (0, 1, 3, (4 // 2))),",
        "An edge in the plane that meets the side b c meets another side as well, or has an end "
        "in the face.",
    ),
    Survivor(
        "izo_ref/base/exact_path.py",
        "_relative_nodes",
        "first, *others = zip(points[: len(start)], points[len(start) :], strict=True)",
        "first, *others = zip(points[: len(start)], points[len(end) :], strict=True)",
        "There are as many ends as starts.",
    ),
    Survivor(
        "izo_ref/certificate/formulas/meeting.py",
        "certainly_meets",
        "size = max(max_abs3(a1), max(max_abs3(a2), max_abs3(a3)))",
        "size = min(max_abs3(a1), max(max_abs3(a2), max_abs3(a3)))",
        "Multiplying by a power of two is exact, and any that is near the size of the pair "
        "serves: coordinates of a scene are within 2^200 of each other, so that products stay "
        "far from overflow.",
    ),
    Survivor(
        "izo_ref/detection/formulas/advance.py",
        "_is_inside",
        "return second and min(weights[0], weights[1]) > INSIDE",
        "return second and min(weights[0], weights[1]) >= INSIDE",
        "INSIDE is a choice: a weight that equals it to the bit may count as inside or not.",
    ),
    Survivor(
        "izo_ref/zones/scaled_zone.py",
        "_slack",
        "error += 10 * U * terms + (1.0 + 1e-9) * sums * first + 2 * U * np.abs(total)",
        "error += 10 * U * terms + (1.0 + 1e-9 / 64) * sums * first + 2 * U * np.abs(total)",
        "The factor covers the rounding of one product and a sum of three terms, which is 4e-16.",
    ),
    Survivor(
        "izo_ref/detection/formulas/closest.py",
        "vertex_face_weights",
        "if va > 0.0 and vb > 0.0 and vc > 0.0 and total > 0.0:",
        "if va > 0.0 and vb > 0.0 and vc >= 0.0 and total > 0.0:",
        "With vc = 0 the closest point is on the edge q1 q2, and both ways give this point.",
    ),
    Survivor(
        "izo_ref/solvers/serial/small_zone.py",
        "solve_small_zone",
        "holds = violation <= limits.violation and gap <= limits.gap",
        "holds = violation <= limits.violation and gap < limits.gap",
        "A gap that equals the tolerance to the bit may count as reached or not.",
    ),
    Survivor(
        "izo_ref/solvers/sparse.py",
        "_divide",
        "thread = int(np.argmin(loads))",
        "thread = int(np.argmax(loads))",
        "Any thread may take any subtree; with all on one thread the answer has the same bits, "
        "later.",
    ),
    Survivor(
        "izo_ref/solvers/serial/minimum_degree.py",
        "_unite",
        "for q in range(graph.begin[i], graph.begin[i] + graph.length[i]):",
        "for q in range(graph.begin[i], graph.begin[i] - graph.length[i]):",
        "Vertices with the same neighbours are then eliminated one by one, which gives an order "
        "of minimum degree too, later.",
    ),
    Survivor(
        "izo_ref/solvers/serial/active_set.py",
        "_most_violated",
        "if violation[j] > ROUNDING * constraint_size(j, first, nodes, coefficients, rhs, z):",
        "if violation[j] >= ROUNDING * constraint_size(j, first, nodes, coefficients, rhs, z):",
        "A violation that equals its rounding to the bit may count as one or not.",
    ),
    Survivor(
        "izo_ref/solvers/interior_point.py",
        "INSIDE",
        "INSIDE = 0.5",
        "INSIDE = 0.5 / 64",
        "INSIDE chooses where the interior point starts; from any positive one it ends at the "
        "same optimum, in other numbers of steps.",
    ),
    Survivor(
        "izo_ref/zones/serial/deep_selection.py",
        "relative_depth",
        "arm = positions[nodes[j, k], axis] - positions[nodes[j, 0], axis]",
        "arm = positions[nodes[j, k], axis] - positions_t0[nodes[j, 0], axis]",
        "The weights sum to zero, so any common origin gives the same gap, up to rounding.",
    ),
    Survivor(
        "izo_ref/solvers/serial/elimination.py",
        "postorder",
        "if parent[i] >= 0:",
        "if parent[i] > 0:",
        "A parent comes behind its children, so it is never number 0.",
    ),
    Survivor(
        "izo_ref/solvers/sparse.py",
        "_largest_stack",
        "np.add.at(taken, above[above >= 0], rest_sizes[above >= 0])",
        "np.add.at(taken, above[above >= 0], rest_sizes[above > 0])",
        "A front comes behind those below it, so none is above at number 0.",
    ),
    Survivor(
        "izo_ref/solvers/solve.py",
        "SERIAL_WORK",
        "SERIAL_WORK = 20_000",
        "SERIAL_WORK = (20_000 // 2)",
        "SERIAL_WORK chooses between one thread and several, which give the same bits.",
    ),
    Survivor(
        "izo_ref/solvers/serial/lagrangian.py",
        "evaluate",
        "for i in range(group.rank(), zone.x.size, group.size()):",
        "for i in range(group.rank(), zone.x.size - 1, group.size()):",
        "The last three unknowns stand for all pinned vertices, and stay zero.",
    ),
    Survivor(
        "izo_ref/solvers/pivoting.py",
        "polish",
        "for _ in range(POLISHES):",
        "for _ in range(1, POLISHES):",
        "An answer that needs the last factorisation stays as it came in, within its tolerance.",
    ),
]


def reason_of(key: tuple[str, str, str, str]) -> str:
    """Return why no input can show a fault; an empty text if no reason is known.

    Args:
        key: Its file, its function, and the lines before and after.
    """
    return {tuple(one[:4]): one.reason for one in SURVIVORS}.get(key, "")
