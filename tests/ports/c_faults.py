"""Deliberate faults of the port in C, each a small change of one line or two.

They are mistakes that ports make. The vectors have to catch each of them at its stage, and `izo
conform` has to explain it among the likely mistakes.
"""

from __future__ import annotations

from typing import NamedTuple


class Fault(NamedTuple):
    """A change of the source that makes a stage wrong.

    Attributes:
        name: What is wrong.
        file: The file to change.
        old: Text that occurs once in the file.
        new: What to write in its place.
        stage: The first stage that has to fail.
        flag: The name of the mistake in the dictionary of flags.
        dtype: Type of floats of the build.
    """

    name: str
    file: str
    old: str
    new: str
    stage: str
    flag: str
    dtype: str = "f8"


FAULTS = (
    Fault(
        "the motion within one plane is missed",
        "pair.c",
        "        add_edge_times(pair, vertex_edge[pair->is_edge_edge][i], &all);",
        "        (void)add_edge_times;",
        "S2",
        "coplanar-motion",
    ),
    Fault(
        "times are late by an absolute tolerance",
        "roots.c",
        "if (!(low < middle && middle < high)) return low;",
        "if (high - low < (real)1e-3) return high;",
        "S2",
        "late-time",
        "f4",
    ),
    Fault(
        "a cubic whose leading coefficient is zero has no root",
        "roots.c",
        "    cuts[n_cuts++] = 0;\n    if (degree > 1) {",
        "    const real *b = coefficients;\n"
        "    if (degree == 3 && b[3] - 3 * b[2] + 3 * b[1] - b[0] == 0) return 0;\n"
        "    cuts[n_cuts++] = 0;\n    if (degree > 1) {",
        "S2",
        "linear-cubic",
    ),
    Fault(
        "the cubic is taken for a straight line",
        "pair.c",
        "    add_roots(cubic, 3, error, all);",
        "    const real straight[2] = {cubic[0], cubic[3]};\n"
        "    add_roots(straight, 1, error, all);",
        "S2",
        "many-roots",
    ),
    Fault(
        "only the first root of the cubic is looked at",
        "pair.c",
        "    add_roots(cubic, 3, error, all);",
        "    int before = all->count;\n"
        "    add_roots(cubic, 3, error, all);\n"
        "    if (all->count > before + 1) all->count = before + 1;",
        "S2",
        "many-roots",
    ),
    Fault(
        "pairs meet at an absolute distance",
        "pair.c",
        "distance <= 4 * EPSILON * size + root.doubt * speed;",
        "distance <= (real)1e-12;",
        "S2",
        "absolute-tolerance",
    ),
    Fault(
        "the normal always follows the order of the corners",
        "pair.c",
        "return along > 0 ? normal : scale(-1, normal);",
        "return normal;",
        "S3",
        "normal-sign",
    ),
    Fault(
        "the weights of the second edge are exchanged",
        "pair.c",
        "const real edges[4] = {1 - first, first, second - 1, -second};",
        "const real edges[4] = {1 - first, first, -second, second - 1};",
        "S3",
        "weights-order",
    ),
    Fault(
        "the normal is that of the start of the step",
        "pair.c",
        "vec normal = separating_normal(&pair, &nodes, contact.weights);",
        "struct nodes start = nodes_at(&pair, 0);\n"
        "    vec normal = separating_normal(&pair, &start, contact.weights);",
        "S3",
        "frame-time",
    ),
    Fault(
        "zones are merged in one pass",
        "zones.c",
        "zones[j] = root(parent, nodes[4 * j + k]);",
        "zones[j] = parent[nodes[4 * j + k]];",
        "S5",
        "zone-transitive",
    ),
    Fault(
        "pinned vertices join zones",
        "zones.c",
        "        if (pinned[node]) continue;\n",
        "",
        "S5",
        "zone-pinned",
    ),
    Fault(
        "the objective has no masses",
        "zone.c",
        "sum += (double)zone->masses[i] * dot(move, move);",
        "sum += (double)dot(move, move);",
        "S6",
        "mass-weighting",
    ),
    Fault(
        "pinned vertices have their masses",
        "zone.c",
        "        if (pinned[i]) masses[i] = 0;\n",
        "",
        "S6",
        "pinned-masses",
    ),
    Fault(
        "coordinates are not taken relative to a node in float32",
        "zone.c",
        "vec origin = vec_at(positions, (size_t)nodes[0]), between_points = {0, 0, 0};",
        "vec origin = {0, 0, 0}, between_points = {0, 0, 0};",
        "S6",
        "float32-coordinates",
        "f4",
    ),
    Fault(
        "impacts that are not active pull",
        "zone.c",
        "forces[j] = larger(multipliers[j] + penalty * constraints[j], 0);",
        "forces[j] = multipliers[j] + penalty * constraints[j];",
        "S7",
        "multipliers-not-clamped",
    ),
    Fault(
        "a vertex in several impacts keeps the last one only",
        "zone.c",
        "gradient_out[3 * vertex + axis] -= factor * zone->normals[3 * j + axis];",
        "{\n"
        "                size_t c = 3 * vertex + axis;\n"
        "                real own = positions[c] - zone->proposed[c];\n"
        "                gradient_out[c] = weight_in_objective(zone, vertex) * own -\n"
        "                                  factor * zone->normals[3 * j + axis];\n"
        "            }",
        "S7",
        "lost-sum",
    ),
    Fault(
        "Wolfe's condition takes the slope half-way",
        "search.c",
        "if (enough && fabs(here.slope) <= flat)",
        "if (enough && fabs(at_step(line, 0.5 * step).slope) <= flat)",
        "S8",
        "wolfe-gradient",
    ),
    Fault(
        "the exact search knows the first piece only",
        "search.c",
        "        if (kink > 0 && isfinite(kink)) kinks[n_kinks++] = kink;",
        "        (void)kink;",
        "S8",
        "exact-search",
    ),
    Fault(
        "the change of L is a difference of two values",
        "search.c",
        'write_real("change", (real)step.change);',
        'write_real("change", (real)((0.01 + step.change) - 0.01));',
        "S8",
        "change-by-difference",
    ),
    Fault(
        "multipliers are not clamped",
        "zone.c",
        "        multipliers[j] = larger(multipliers[j] + penalty * constraints[j], 0);",
        "        multipliers[j] = multipliers[j] + penalty * constraints[j];",
        "S9",
        "multipliers-not-clamped",
    ),
    Fault(
        "omega of Chebyshev's acceleration has rho in place of its square",
        "directions.c",
        "double square = descent->rho * descent->rho;",
        "double square = descent->rho;",
        "S10",
        "chebyshev-omega",
    ),
    Fault(
        "beta of the conjugate gradients is that of Dai and Yuan alone",
        "directions.c",
        "fmin(g_q, g_g) / p_q",
        "g_g / p_q",
        "S10",
        "cg-beta",
    ),
    Fault(
        "inner solves end after the largest number of steps only",
        "steps.c",
        "return measures->error <= delta * delta * descent->penalty * measures->shift_sq;",
        "return delta < 0;",
        "S10",
        "inner-solve",
    ),
    Fault(
        "multipliers change before the move",
        "steps.c",
        "        if (moved) {\n            moved = take_step(",
        "        if (settings->every_step && !has_memory) update(descent);\n"
        "        if (moved) {\n            moved = take_step(",
        "S10",
        "multiplier-order",
    ),
    Fault(
        "the objective of a preset has half its weight",
        "steps.c",
        "scaling == TOTAL_MASS ? 2 / zone->total_mass",
        "scaling == TOTAL_MASS ? 1 / zone->total_mass",
        "S10",
        "preset-scaling",
    ),
    Fault(
        "the active set stops early",
        "optimum.c",
        "if (worst == problem->m) return true;",
        "if (worst == problem->m || steps == 8) return true;",
        "S11",
        "early-stop",
    ),
    Fault(
        "a zone without an answer counts as solved",
        "optimum.c",
        "!satisfy(problem, set, worst, z)) return false;",
        "!satisfy(problem, set, worst, z)) return true;",
        "S11",
        "infeasible",
    ),
    Fault(
        "multipliers are those of the scaled constraints",
        "optimum.c",
        "(real)(fmax(0, set.multipliers[k]) / problem.scales[set.members[k]]);",
        "(real)fmax(0, set.multipliers[k]);",
        "S11",
        "mass-weighting",
    ),
    Fault(
        "a constraint that depends on the active ones makes a zone infeasible",
        "optimum.c",
        "if (isinf(step)) return false;",
        "if (is_dependent) return false;",
        "S11",
        "rows-redundant",
    ),
)
