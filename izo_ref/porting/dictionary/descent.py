"""Flags of the augmented Lagrangian, its line searches and its iterations: S7 to S10."""

from izo_ref.porting.dictionary.record import ELSEWHERE, TYPICAL, Flag

LAGRANGIAN = (
    Flag(
        "kink",
        ("S7", "S9", "S10"),
        "The maximum in max(c_j + l_j / mu, 0) is taken of the wrong thing: of c_j alone, or "
        "separately in value and gradient, so that the two do not belong together where the term "
        "is just zero.",
        "Line searches fail near the solution, because the slope does not fit the values; "
        "constraints flicker between active and inactive.",
        TYPICAL,
    ),
    Flag(
        "penalty-scaling",
        ("S7", "S9", "S10"),
        "The penalty mu belongs to another scaling of the objective: the sum of m |x - y|^2, its "
        "half, or its mean differ by factors, and so does mu. Common forms are mu in place of "
        "mu / 2, and l_j * mu in place of l_j / mu.",
        "The method converges slowly or not at all, in some scenes only; a value of mu that was "
        "tuned for one program is useless in another.",
        "The page names no scaling for its mu, which has no meaning without one "
        "(docs/method section 3).",
    ),
    Flag(
        "multipliers-not-clamped",
        ("S7", "S9"),
        "Multipliers become negative, because the update l_j + mu c_j is not clamped at zero.",
        "Constraints that are satisfied pull: surfaces stick to each other and are dragged along.",
        "Page eq. 9 reads like this if its slack is left out (docs/method section 3). " + ELSEWHERE,
    ),
)
SEARCHES = (
    Flag(
        "armijo",
        ("S8", "S10"),
        "The condition of sufficient decrease is wrong: the slope is left out, c_1 is that of "
        "another system, the comparison has the wrong sign, or a step that increases the function "
        "is accepted.",
        "Steps are too long and the iteration oscillates, or too short and it stops early.",
        "The page says 1e-4 where its program uses 0.5 (docs/method section 3). " + ELSEWHERE,
    ),
    Flag(
        "wolfe-gradient",
        ("S8",),
        "The curvature condition takes the gradient at another point than x + s p, or compares "
        "without absolute values.",
        "The search accepts points that are not stationary along the line, and conjugate gradients "
        "or L-BFGS lose their direction of descent.",
        "Page eqs. 17 and 20 take the gradient at a mean value (docs/method section 3). "
        + ELSEWHERE,
    ),
    Flag(
        "exact-search",
        ("S8",),
        "The exact search takes the minimiser of the first piece of the function. Along a line, "
        "the function is piecewise quadratic: every constraint that becomes active or inactive "
        "starts a new piece.",
        "The step is far too long or too short whenever the set of active constraints changes, "
        "which is in nearly every step.",
        TYPICAL,
    ),
    Flag(
        "no-step",
        ("S8",),
        "The search finds no acceptable step and returns the last one that it tried, or goes on "
        "for ever. It has to return 0 if the step falls below the smallest one or if the direction "
        "does not descend.",
        "The function rises, or the program hangs on a zone that is already solved.",
        TYPICAL,
    ),
    Flag(
        "change-by-difference",
        ("S8",),
        "The change of the function is the difference of two values. Near the solution the values "
        "agree in almost all digits, so the difference is noise. Sum the small terms of the change "
        "itself.",
        "The search stops with 8 digits where 15 can be had, and in float32 with 3.",
        TYPICAL,
    ),
)
ITERATIONS = (
    Flag(
        "multiplier-order",
        ("S10",),
        "Multipliers are updated at the wrong place: before the move, from constraints of the old "
        "positions, before the acceleration, or after every step where the preset does so after an "
        "inner solve.",
        "The iteration converges more slowly than the published one, or oscillates, and no single "
        "formula is wrong.",
        TYPICAL,
    ),
    Flag(
        "preset-scaling",
        ("S10",),
        "The variables of a preset are mixed up. ARCSim and XRTailor multiply the objective by the "
        "mean inverse mass, I-Cloth divides it by the sum of masses, and izo_ref scales positions "
        "by the roots of the masses.",
        "With equal masses everything agrees; with unequal ones mu is wrong by the ratio of the "
        "two means.",
        TYPICAL,
    ),
    Flag(
        "chebyshev-omega",
        ("S10",),
        "The sequence of omega is wrong: rho is not squared, the delay is off by one, omega is not "
        "reset, or the acceleration combines the wrong two iterates.",
        "The iteration diverges slowly after the delay, or gains nothing from the acceleration.",
        TYPICAL,
    ),
    Flag(
        "cg-beta",
        ("S10",),
        "Conjugate gradients use another beta, do not clamp it at zero, or take the change of the "
        "gradient across an update of the multipliers. After the update, the old gradient has to "
        "be computed again.",
        "Directions lose descent after a few steps, and the method falls back to plain gradients.",
        TYPICAL,
    ),
    Flag(
        "lbfgs-order",
        ("S10",),
        "The two loops of L-BFGS run over the stored pairs in the wrong order: from the newest to "
        "the oldest in the first loop, and back in the second. Pairs without positive curvature "
        "must not be stored.",
        "With one stored pair all is right; with more, the method is slower than the gradient.",
        TYPICAL,
    ),
    Flag(
        "newton-active-set",
        ("S10",),
        "The Hessian of Newton's method includes constraints that are not active, or leaves out "
        "those that are active because of their multiplier alone, c_j + l_j / mu > 0 with c_j < 0.",
        "Steps are too small, since inactive constraints hold the vertices; or the method jumps "
        "between two sets for ever.",
        TYPICAL,
    ),
    Flag(
        "inner-solve",
        ("S10",),
        "The inner solve ends by another rule: the number of steps, the length of the step, the "
        "relative change of L or the norm of the gradient, and the multipliers are updated at its "
        "end alone. What an inner solve remembers must not survive into the next one.",
        "The same formulas give another sequence of iterates, so a comparison with the published "
        "system fails after the first inner solve.",
        TYPICAL,
    ),
)
