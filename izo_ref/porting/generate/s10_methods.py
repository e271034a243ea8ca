"""Cases of stage S10: the directions, with each line search and both updates of multipliers."""

from __future__ import annotations

from izo_ref.porting.generate.expected import CaseList
from izo_ref.porting.generate.iterations import add, method, plain_zone, zone

ORDER = "multiplier-order"
SCALING = "preset-scaling"
OMEGA = "chebyshev-omega"
BETA = "cg-beta"
PAIRS = "lbfgs-order"
ROWS = "newton-active-set"
INNER = "inner-solve"
PENALTY = "penalty-scaling"
MASS = "mass-weighting"
ARMIJO = "armijo"
KINK = "kink"

MASSES = (1.0, 3.0, 0.5, 2.0)  # [kg]
THREE = zone(0, 3, 7, masses=MASSES, apart=(1,))
FOUR = zone(0, 4, 8, masses=MASSES, apart=(2,), pinned=(1,))
OTHER_FOUR = zone(2, 4, 8, masses=MASSES, apart=(2,), pinned=(1,))


def add_methods(found: CaseList) -> None:
    """Append the cases of all directions."""
    _add_gradient(found)
    _add_jacobi(found)
    _add_chebyshev(found)
    _add_cg(found)
    _add_lbfgs(found)
    _add_newton(found)
    _add_inexact_newton(found)


def _add_gradient(found: CaseList) -> None:
    """Append cases of the direction `gradient`."""
    word = "gradient"
    what = "One impact in scaled variables; the penalty is 4, and each step is the whole model's."
    heavy = plain_zone(masses=(8.0, 1.0, 1.0, 2.0))
    flags = f"{PENALTY} {MASS} {ORDER}"
    add(found, word, flags, "easy", what, 5, heavy, method("gradient", penalty=4.0))
    what = "The exact step leaves one of two constraints behind: it becomes inactive on the way."
    unequal = plain_zone(2)
    unequal["proposed"][5] = -(2.0**-7)
    parameters = method("gradient", penalty=8.0, search="exact")
    add(found, word, f"{KINK} {PENALTY}", "easy", what, 4, unequal, parameters)
    what = "Wolfe's search has to look beyond the first quadratic piece."
    parameters = method("gradient", penalty=8.0, search="wolfe")
    add(found, word, f"{KINK} {PENALTY}", "medium", what, 8, THREE, parameters)
    what = "The exact search crosses kinks; inner solves end when L is near its minimum."
    parameters = method("gradient", penalty=8.0, search="exact", every_step=0)
    add(found, word, f"{INNER} {KINK}", "medium", what, 8, FOUR, parameters)
    what = "A search begins at twice the last step, and asks for half of the decrease of the slope."
    parameters = method("gradient", penalty=8.0, begin="last", first_step=0.5, armijo=0.5)
    flags = f"{ARMIJO} {KINK} {ORDER}"
    add(found, word, flags, "hard", what, 10, THREE, parameters)
    what = "An impact has left contact and keeps its multiplier: the shift counts l / mu there."
    parameters = method("gradient", search="exact", every_step=0)
    add(found, word, INNER, "hard", what, 8, zone(5, 5, 9, masses=MASSES), parameters)


def _add_jacobi(found: CaseList) -> None:
    """Append cases of the direction `jacobi`."""
    word = "jacobi"
    what = "Two vertices above one face; the diagonal has the squares of the entries of rows."
    light = plain_zone(2, masses=(2.0, 1.0, 1.0, 4.0))
    add(found, word, f"{PENALTY} {MASS}", "easy", what, 4, light, method("jacobi", penalty=4.0))
    what = "One impact is inactive and has no share in the diagonal; the search is exact."
    parameters = method("jacobi", penalty=8.0, search="exact")
    add(found, word, f"{ROWS} {KINK}", "medium", what, 8, THREE, parameters)
    what = "Inner solves of different lengths, with Wolfe's search and a changing active set."
    parameters = method("jacobi", penalty=8.0, search="wolfe", every_step=0)
    flags = f"{INNER} {ROWS} {KINK}"
    add(found, word, flags, "hard", what, 8, FOUR, parameters)


def _add_chebyshev(found: CaseList) -> None:
    """Append cases of the direction `chebyshev`."""
    word, fixed = "chebyshev", {"begin": "last", "first_step": 0.25, "grow": 1.0}
    what = "The first accelerated step: omega is 2 / (2 - rho^2)."
    parameters = method("chebyshev", **fixed)
    add(found, word, f"{OMEGA} {ORDER}", "easy", what, 2, plain_zone(), parameters)
    what = "Three plain steps, then omega from both formulas, then a restart at step 4."
    parameters = method("chebyshev", delay=3, **fixed)
    add(found, word, f"{OMEGA} {ROWS}", "medium", what, 8, THREE, parameters)
    what = "Searches begin at the model's minimum, and accelerated steps overshoot."
    add(found, word, f"{OMEGA} {KINK}", "medium", what, 6, FOUR, method("chebyshev"))
    what = "Inner solves and uphill steps both restart the acceleration; the multipliers wait."
    parameters = method("chebyshev", delay=1, rho=0.5, every_step=0, **fixed)
    add(found, word, f"{OMEGA} {INNER}", "hard", what, 8, OTHER_FOUR, parameters)
    what = "L rises along the last step, but not with its momentum, or the other way round."
    parameters = method("chebyshev", **fixed)
    add(found, word, f"{OMEGA} {ORDER}", "hard", what, 8, zone(16, 3, 7, masses=MASSES), parameters)


def _add_cg(found: CaseList) -> None:
    """Append cases of the direction `cg`."""
    word = "cg"
    what = "Multipliers change after each step; q is taken before they do."
    parameters = method("cg", penalty=8.0)
    heavy = plain_zone(2, masses=(1.0, 4.0, 1.0, 2.0, 8.0))
    add(found, word, f"{BETA} {ORDER}", "easy", what, 4, heavy, parameters)
    what = "The active set changes, and beta is clamped or bounded in some steps."
    add(found, word, f"{BETA} {KINK}", "medium", what, 6, THREE, parameters)
    what = "Inner solves with an exact search: each one begins anew with the gradient."
    tight = method("cg", penalty=32.0, search="exact", every_step=0, inner_accuracy=0.0625)
    add(found, word, f"{BETA} {INNER} {PENALTY}", "medium", what, 6, THREE, tight)
    what = "One long inner solve over a changing active set."
    add(found, word, f"{BETA} {KINK}", "hard", what, 8, OTHER_FOUR, tight)


def _add_lbfgs(found: CaseList) -> None:
    """Append cases of the direction `lbfgs`."""
    word = "lbfgs"
    what = "Two pairs at the third step; the first search begins at the model's minimum."
    heavy = plain_zone(2, masses=(1.0, 4.0, 1.0, 2.0, 8.0))
    flags = f"{PAIRS} {ORDER}"
    add(found, word, flags, "easy", what, 3, heavy, method("lbfgs", penalty=10.0))
    what = "Pairs whose active sets differ, so their order matters."
    flags = f"{PAIRS} {ORDER} {KINK}"
    add(found, word, flags, "medium", what, 6, FOUR, method("lbfgs", penalty=10.0))
    what = "The pairs outlive the inner solve in which they were made."
    tight = method("lbfgs", penalty=32.0, search="wolfe", every_step=0, inner_accuracy=0.0625)
    add(found, word, f"{PAIRS} {INNER}", "medium", what, 7, THREE, tight)
    what = "Twelve steps: from the tenth on, the oldest pairs are forgotten."
    exact = {"search": "exact", "every_step": 0, "inner_accuracy": 0.015625}
    parameters = method("lbfgs", penalty=100.0, **exact)
    add(found, word, f"{PAIRS} {PENALTY}", "hard", what, 11, OTHER_FOUR, parameters)


def _add_newton(found: CaseList) -> None:
    """Append cases of the direction `newton`."""
    word = "newton"
    what = "One impact: two conjugate-gradient products solve the linear system."
    heavy = plain_zone(masses=(2.0, 1.0, 1.0, 4.0))
    add(found, word, f"{PENALTY} {ORDER}", "easy", what, 3, heavy, method("newton", penalty=10.0))
    what = "The second vertex is above the face: its constraint has no share in H."
    apart = plain_zone(2, masses=(2.0, 1.0, 1.0, 4.0, 1.0))
    apart["proposed"][5] = 0.0625
    flags = f"{ROWS} {MASS}"
    add(found, word, flags, "easy", what, 3, apart, method("newton", penalty=10.0))
    what = "The active set changes, and a whole step is too long."
    parameters = method("newton", penalty=10.0)
    add(found, word, f"{ROWS} {ARMIJO} {KINK}", "medium", what, 4, OTHER_FOUR, parameters)
    what = "Inner solves with a penalty of 1000 and an exact search; the active set changes."
    parameters = method("newton", penalty=1e3, search="exact", every_step=0)
    add(found, word, f"{ROWS} {INNER} {PENALTY}", "hard", what, 4, FOUR, parameters)


def _add_inexact_newton(found: CaseList) -> None:
    """Append cases in which Newton's linear systems are solved roughly."""
    what = "Linear systems are solved to a quarter only, so p is not Newton's exact step."
    rough = method("newton", penalty=100.0, linear_tolerance=0.25)
    add(found, "newton", f"{ROWS} {ARMIJO}", "hard", what, 5, FOUR, rough)
    what = "The same with inner solves and Wolfe's search."
    rough = method("newton", linear_tolerance=0.25, penalty=10.0, search="wolfe", every_step=0)
    add(found, "newton", f"{ROWS} {INNER}", "hard", what, 6, FOUR, rough)
    what = "In metres, w differs between vertices: it is the preconditioner, and 1 / w the norm."
    rough = method("newton", linear_tolerance=0.25, penalty=10.0, scaling="total-mass")
    other = zone(4, 4, 8, masses=MASSES, apart=(2,), pinned=(1,))
    add(found, "newton", f"{ROWS} {ORDER}", "hard", what, 4, other, rough)
