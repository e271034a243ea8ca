"""The stages of the method as a porter meets them: what goes in, what comes out, where to read.

This table is the contract between the vectors, the judge, the traces and the guide. Arrays are
flat lists in the files, row by row; the shapes are stated here.
"""

from __future__ import annotations

from typing import NamedTuple

FLOAT, INTEGER, FLAG, TEXT = "f", "i", "b", "s"


class Field(NamedTuple):
    """One array, number or word that goes into a stage or comes out of it.

    Attributes:
        name: Name in the files, in replies and in traces.
        kind: FLOAT, INTEGER, FLAG (0 or 1) or TEXT.
        shape: Letters for counts that a case decides, and numbers; () for a single value. The
            letter n counts vertices, m impacts (or faces, where there are no impacts).
        unit: Unit; empty if there is none.
        what: What it is, one phrase.
        optional: Whether it may be missing.
    """

    name: str
    kind: str
    shape: tuple[str | int, ...]
    unit: str
    what: str
    optional: bool = False


class Stage(NamedTuple):
    """One stage of the method.

    Attributes:
        name: `S1` to `S13`.
        title: A few words.
        formula: The formula or rule in ASCII, for the guide and for `izo vectors show`.
        source: `path:function` of our own implementation, relative to the repository.
        method: Page and section of the documentation of the method.
        inputs: What goes in.
        outputs: What comes out.
    """

    name: str
    title: str
    formula: str
    source: str
    method: str
    inputs: tuple[Field, ...]
    outputs: tuple[Field, ...]


_PATH = (
    Field("positions_t0", FLOAT, ("n", 3), "m", "start of the step, free of intersections"),
    Field("positions_t1", FLOAT, ("n", 3), "m", "proposed end of the step"),
    Field("faces", INTEGER, ("m", 3), "", "vertices of each face, counted from 0"),
)
_PAIR = (
    Field("is_edge_edge", FLAG, (), "", "0: a vertex and a face; 1: two edges"),
    Field("start", FLOAT, (4, 3), "m", "the four nodes at t = 0"),
    Field("end", FLOAT, (4, 3), "m", "the four nodes at t = 1"),
)
_GROUPS = (
    Field("nodes", INTEGER, ("m", 4), "", "vertices of each impact"),
    Field("pinned", FLAG, ("n",), "", "1 for vertices that follow their path exactly"),
)
_ZONE = (
    Field("nodes", INTEGER, ("m", 4), "", "vertices of each impact"),
    Field("weights", FLOAT, ("m", 4), "", "a: signed weights of the closest points"),
    Field("normals", FLOAT, ("m", 3), "", "N: unit normals"),
    Field("proposed", FLOAT, ("n", 3), "m", "y: proposed positions"),
    Field("masses", FLOAT, ("n",), "kg", "m; that of a pinned vertex is not used"),
    Field("pinned", FLAG, ("n",), "", "1 for vertices that stay at y"),
    Field("thickness", FLOAT, (), "m", "d"),
)
_AT = Field("positions", FLOAT, ("n", 3), "m", "x: the point at which to evaluate")
_MULTIPLIERS = Field("multipliers", FLOAT, ("m",), "", "l >= 0, one for each impact")
_PENALTY = Field("penalty", FLOAT, (), "", "mu > 0")
_SEARCH = (
    Field("search", TEXT, (), "", "backtracking, exact or wolfe"),
    Field("first", FLOAT, (), "", "the step to try first"),
    Field("armijo", FLOAT, (), "", "c_1 of eq. armijo"),
    Field("wolfe", FLOAT, (), "", "c_2 of eq. wolfe"),
    Field("shrink", FLOAT, (), "", "backtracking multiplies a step that is too long by this"),
    Field("smallest_step", FLOAT, (), "", "a search that reaches a smaller step has failed"),
)
_ITERATION = (
    Field("direction_name", TEXT, (), "", "gradient, jacobi, chebyshev, cg, lbfgs or newton"),
    Field("pairs", INTEGER, (), "", "how many of the last pairs s, q lbfgs uses"),
    Field("scaling", TEXT, (), "", "total-mass, mean-inverse-mass or scaled: the variables"),
    Field("every_step", FLAG, (), "", "1: multipliers change after each step; 0: inner solves"),
    Field("preconditioned", FLAG, (), "", "1: the gradient is divided by the diagonal of H"),
    Field("penalty", FLOAT, (), "", "mu, fixed"),
    Field("begin", TEXT, (), "", "where a search begins: last, unit or model"),
    Field("first_step", FLOAT, (), "", "the step before the first one, for begin = last"),
    Field("grow", FLOAT, (), "", "begin = last multiplies the last step by this"),
    Field("search", TEXT, (), "", "backtracking, exact or wolfe"),
    Field("armijo", FLOAT, (), "", "c_1"),
    Field("wolfe", FLOAT, (), "", "c_2"),
    Field("shrink", FLOAT, (), "", "factor of backtracking"),
    Field("smallest_step", FLOAT, (), "", "a search that reaches a smaller step has failed"),
    Field("faithful", FLAG, (), "", "1: the stops of a preset; 0: those of izo_ref"),
    Field("inner_steps", INTEGER, (), "", "largest number of steps of an inner solve"),
    Field(
        "inner_accuracy",
        FLOAT,
        (),
        "",
        "delta: an inner solve of izo_ref ends at sum (dL/dx)^2 / w <= delta^2 mu sum shift^2, "
        "shift = min(-c, l / mu)",
    ),
    Field("eps_x", FLOAT, (), "", "an inner solve of a preset stops at this length of a step"),
    Field("eps_f", FLOAT, (), "", "or at this relative change of L"),
    Field("eps_g", FLOAT, (), "", "or at this norm of the gradient"),
    Field("delay", INTEGER, (), "", "K of Chebyshev's acceleration"),
    Field("rho", FLOAT, (), "", "rho of Chebyshev's acceleration"),
    Field("linear_tolerance", FLOAT, (), "", "relative residual of Newton's linear systems"),
    Field("steps", INTEGER, (), "", "how many steps to take"),
)

STAGES = (
    Stage(
        "S1",
        "candidate pairs",
        "list every vertex-face and edge-edge pair, without a common vertex, that meets on the "
        "path x(t) = (1 - t) x0 + t x1, 0 <= t <= 1; more pairs may be listed",
        "izo_ref/detection/trees.py:Elements",
        "6-outer-loop",
        _PATH,
        (
            Field("vertex_face", INTEGER, ("k", 4), "", "the vertex, then the corners of the face"),
            Field("edge_edge", INTEGER, ("l", 4), "", "the ends of one edge, then of the other"),
        ),
    ),
    Stage(
        "S2",
        "time of impact",
        "the first t in [0, 1] at which the vertex touches the face, or the edges touch",
        "izo_ref/detection/formulas/advance.py:advance",
        "6-outer-loop",
        _PAIR,
        (
            Field("meets", FLAG, (), "", "whether the pair meets at any time in [0, 1]"),
            Field("toi", FLOAT, (), "", "the first such time; left out if the pair is apart", True),
        ),
    ),
    Stage(
        "S3",
        "normal and weights",
        "closest points at t = toi; a = (1, -a1, -a2, -a3) or (1 - b, b, c - 1, -c); N = unit "
        "normal of the face or of both edges, with N . sum_k a_k x_k(0) > 0",
        "izo_ref/detection/formulas/frame.py:impact_frame",
        "1-problem",
        (
            *_PAIR,
            Field(
                "toi",
                FLOAT,
                (),
                "",
                "the time at which to take them; it may be early, and is above 0: a pair that "
                "touches at t = 0 has no side",
            ),
        ),
        (
            Field("weights", FLOAT, (4,), "", "positive on the first side; their sum is 0"),
            Field(
                "normal",
                FLOAT,
                (3,),
                "",
                "unit vector; the gap is positive at t = 0, and where the normal is not unique, "
                "at least 1/64 of the length of sum_k a_k x_k(0)",
            ),
        ),
    ),
    Stage(
        "S4",
        "selection",
        "in the order of times (equal times: in the order given): independent takes an impact if "
        "none of its unpinned vertices is in one taken before; first-of-any takes it if it is the "
        "first for one of its unpinned vertices; all takes all",
        "izo_ref/zones/selection.py:select_impacts",
        "6-outer-loop",
        (
            Field("toi", FLOAT, ("m",), "", "times of impact"),
            *_GROUPS,
            Field("selection", TEXT, (), "", "independent, first-of-any, all or deep"),
            Field("weights", FLOAT, ("m", 4), "", "for deep alone", True),
            Field("edge_edge_impacts", FLAG, ("m",), "", "for deep alone: 1 for two edges", True),
        ),
        (Field("selected", FLAG, ("m",), "", "1 for the impacts that enter the zones"),),
    ),
    Stage(
        "S5",
        "zones",
        "two impacts are in one zone if they share an unpinned vertex, or if a chain of impacts "
        "that do so connects them",
        "izo_ref/zones/grouping.py:build_zones",
        "2-zones",
        _GROUPS,
        (
            Field(
                "zone_of_impact", INTEGER, ("m",), "", "any numbers; -1 if all vertices are pinned"
            ),
        ),
    ),
    Stage(
        "S6",
        "objective, gradient and constraints",
        "g = sum m |x - y|^2 / sum m; dg/dx_i = 2 m_i (x_i - y_i) / sum m; "
        "c_j = d - N_j . sum_k a_jk x_jk; sums over unpinned vertices",
        "izo_ref/zones/problem.py:ZoneProblem",
        "1-problem",
        (*_ZONE, _AT),
        (
            Field("objective", FLOAT, (), "m^2", "g"),
            Field("gradient", FLOAT, ("n", 3), "m", "of g; 0 at pinned vertices"),
            Field("constraints", FLOAT, ("m",), "m", "c; positive is a violation"),
        ),
    ),
    Stage(
        "S7",
        "augmented Lagrangian",
        "L = g + mu/2 sum max(c_j + l_j / mu, 0)^2 - sum l_j^2 / (2 mu); "
        "dL/dx_i = 2 m_i (x_i - y_i) / sum m - sum_j a_ji N_j max(l_j + mu c_j, 0)",
        "izo_ref/solvers/serial/lagrangian.py:evaluate",
        "3-augmented-lagrangian",
        (*_ZONE, _AT, _MULTIPLIERS, _PENALTY),
        (
            Field("value", FLOAT, (), "m^2", "L"),
            Field("gradient", FLOAT, ("n", 3), "m", "of L; 0 at pinned vertices"),
        ),
    ),
    Stage(
        "S8",
        "line search",
        "phi(s) = L(x + s p); backtracking: the first of first, shrink first, ... with "
        "phi(s) < phi(0) + armijo s phi'(0); exact: phi'(s) = 0; wolfe: also "
        "|phi'(s)| <= wolfe |phi'(0)|",
        "izo_ref/solvers/serial/line_search.py:search_line",
        "4-directions",
        (
            *_ZONE,
            _AT,
            _MULTIPLIERS,
            _PENALTY,
            Field("direction", FLOAT, ("n", 3), "m", "p; 0 at pinned vertices"),
            *_SEARCH,
        ),
        (
            Field("step", FLOAT, (), "", "the accepted step; 0 if no step was accepted"),
            Field("change", FLOAT, (), "m^2", "phi(step) - phi(0)"),
            Field("tried", FLOAT, ("k",), "", "all steps tried, of backtracking", True),
        ),
    ),
    Stage(
        "S9",
        "multiplier update",
        "l_j <- max(l_j + mu c_j, 0)",
        "izo_ref/solvers/serial/lagrangian.py:update_multipliers",
        "3-augmented-lagrangian",
        (_MULTIPLIERS, Field("constraints", FLOAT, ("m",), "m", "c"), _PENALTY),
        (Field("multipliers", FLOAT, ("m",), "", "the new multipliers"),),
    ),
    Stage(
        "S10",
        "first iterations",
        "from x = y and l = 0, repeat: direction p; step s by a search; x <- x + s p; chebyshev: "
        "x <- omega (x - x_before) + x_before; after each step or each inner solve: "
        "l_j <- max(l_j + mu c_j, 0)",
        "izo_ref/solvers/serial/descent.py:minimise",
        "4-directions",
        (*_ZONE, *_ITERATION),
        (
            Field("objectives", FLOAT, ("k",), "kg m^2", "1/2 sum m |x - y|^2 after each step"),
            Field("violations", FLOAT, ("k",), "m", "largest max(c, 0) after each step"),
            Field("positions", FLOAT, ("n", 3), "m", "x after the last step"),
            Field("step_sizes", FLOAT, ("k",), "", "the step of each line search", True),
        ),
    ),
    Stage(
        "S11",
        "optimum of a zone",
        "minimise 1/2 sum m |x - y|^2 subject to c_j(x) <= 0; x is unique; "
        "M (x - y) = A^T l, l >= 0, l . c = 0",
        "izo_ref/solvers/solve.py:solve_zone",
        "5-scaling",
        _ZONE,
        (
            Field("feasible", FLAG, (), "", "0 if no positions satisfy the constraints"),
            Field("positions", FLOAT, ("n", 3), "m", "x", True),
            Field("multipliers", FLOAT, ("m",), "kg", "l, for 1/2 sum m |x - y|^2", True),
        ),
    ),
    Stage(
        "S12",
        "outer loop",
        "detect, select, group, solve, until the path from positions_t0 to x is free",
        "izo_ref/loop/resolve.py:resolve",
        "6-outer-loop",
        (
            *_PATH,
            Field("masses", FLOAT, ("n",), "kg", "m; that of a pinned vertex is not used"),
            Field("pinned", FLAG, ("n",), "", "1 for vertices that follow their path exactly"),
            Field("thickness", FLOAT, (), "m", "d"),
        ),
        (
            Field("free", FLAG, (), "", "1 if the port says that its path is free"),
            Field("positions", FLOAT, ("n", 3), "m", "end positions; those of pinned vertices too"),
        ),
    ),
    Stage(
        "S13",
        "bad input",
        "refuse what cannot be resolved, and accept everything else",
        "izo_ref/scene.py:Scene",
        "7-statuses",
        (
            *_PATH,
            Field("masses", FLOAT, ("k",), "kg", "m"),
            Field("pinned", FLAG, ("l",), "", "1 for vertices that follow their path exactly"),
            Field("thickness", FLOAT, (), "m", "d"),
        ),
        (Field("offender", INTEGER, (), "", "index of the first wrong vertex or face", True),),
    ),
)
STAGE = {stage.name: stage for stage in STAGES}
