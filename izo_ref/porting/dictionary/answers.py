"""Flags of the optimum of a zone, of the outer loop and of bad input: S11 to S13."""

from izo_ref.porting.dictionary.record import CPU_SIMULATOR, TYPICAL, Flag

OPTIMUM = (
    Flag(
        "rows-redundant",
        ("S11",),
        "The solver needs linearly independent constraints. Real zones have redundant ones: two "
        "edges that meet a third one at their common vertex give the same row twice. The matrix "
        "A M^-1 A^T is then singular, and the multipliers are not unique, though the positions "
        "are.",
        "The factorisation breaks down, or the active set changes for ever.",
        "A plain primal-dual active-set method, which is fast on random zones, cycles without end "
        "on the large zones of armadillo-rollers.",
    ),
    Flag(
        "rows-opposed",
        ("S11",),
        "Two constraints push in nearly opposite directions, from both sides of a thin layer. The "
        "port takes a nearly singular system as singular, or a problem that is only just feasible "
        "as infeasible.",
        "Pinched cloth, the hardest thing in a garment, is given up or explodes.",
        TYPICAL,
    ),
    Flag(
        "mass-ratio",
        ("S11",),
        "Masses range over many decades, and the unknowns are not scaled by their roots. "
        "Tolerances then mean nothing for the light vertices.",
        "The solver says 'converged', and positions are off by half of the correction.",
        "SciPy's SLSQP, called in metres and kilograms with masses from 1e-3 to 1e3, reports "
        "success with positions that are 39 to 50 % off (docs/method section 5).",
    ),
    Flag(
        "cap-100",
        ("S11", "S12"),
        "A fixed number of iterations, often 100, ends the work, and what is reached then is taken "
        "as the answer.",
        "Large zones and deep contacts, which need more, are returned unsolved and unmarked.",
        "ARCSim 0.2.1, XRTailor and I-Cloth stop after 100 iterations (docs/method section 4). "
        "I-Cloth reports 1002 unresolved impacts after 200 iterations in one of its own scenes.",
    ),
    Flag(
        "early-stop",
        ("S11",),
        "The solver ends when constraints hold, or when a step is small, and does not check that "
        "the answer is optimal. A feasible point can be far from the closest one, and steps are "
        "small also where progress is slow.",
        "Cloth is pushed farther than needed, which shows as jitter and as gaps between layers.",
        TYPICAL,
    ),
    Flag(
        "infeasible",
        ("S11", "S12"),
        "No positions satisfy all constraints, for example between two pinned parts, and the port "
        "returns positions as if they did, or never ends.",
        "The simulation continues with an intersection that it does not know of; the next step "
        "starts with it.",
        TYPICAL,
    ),
)
LOOP = (
    Flag(
        "tunnel-swap",
        ("S12",),
        "Only the end positions are tested for intersections, not the path. Two surfaces that "
        "change places are free at both ends.",
        "Fast or thin cloth goes through other cloth in one step, and nothing reports it.",
        "Every test of intersections at rest has this gap; data/scenes/swapped.npz shows it.",
    ),
    Flag(
        "pinned-motion",
        ("S12",),
        "Pinned vertices that move, as those of an animated body do, are treated as if they were "
        "at rest, are moved by the solver, or end a rounding away from their prescribed positions.",
        "Bodies cut through cloth that they should push, or animated parts drift.",
        "ARCSim frees its obstacles in a second round, with mass 1e3, so they may leave their "
        "prescribed positions (docs/method section 4).",
    ),
    Flag(
        "unhonest-status",
        ("S12",),
        "The port reports a free path although it is not free: the loop ended by its cap, a zone "
        "was not solved, or only the vertices that the solver moved were checked again.",
        "Nobody repairs what is reported as good. The fault appears many steps later, as cloth "
        "that is knotted with itself.",
        "ARCSim 0.3.x reports success with 101 real contacts left; ARCSim, I-Cloth and XRTailor "
        f"say in a printed line alone that collisions are left. {CPU_SIMULATOR}",
    ),
    Flag(
        "fail-safe",
        ("S12",),
        "There is no last resort: if a zone cannot be solved, its intersecting positions are kept. "
        "The start is free, so moving less along the same path always ends free, except where "
        "pinned vertices meet each other.",
        "One impossible place spoils the whole step.",
        "ARCSim has no fail-safe. El Topo has a chain of them and halves the time step.",
    ),
)
DOOR = (
    Flag(
        "bad-shape",
        ("S13",),
        "Arrays of the wrong length are accepted: coordinates that are not a multiple of three, "
        "one position less at the end than at the start, too few masses.",
        "The program reads beyond its arrays. On a GPU this shows as noise far away from the "
        "cause, or not at all.",
        TYPICAL,
    ),
    Flag(
        "bad-number",
        ("S13",),
        "NaN or an infinite coordinate is accepted. Every comparison with NaN is false, so "
        "'a <= b' and 'not a > b' are not the same test.",
        "A pair with a NaN counts as apart, and the path as free.",
        TYPICAL,
    ),
    Flag(
        "bad-index",
        ("S13",),
        "A face that names a vertex which does not exist, or a negative one, is accepted; or the "
        "port does not say which face it is.",
        "Memory is read out of bounds; or a file whose faces are counted from 1 is taken as "
        "it is, and everything is shifted by one.",
        TYPICAL,
    ),
    Flag(
        "bad-mass",
        ("S13",),
        "A mass that is zero, negative, infinite or NaN is accepted for a vertex that is not "
        "pinned. To fix a vertex, pin it.",
        "A division by zero makes all positions of a zone NaN, or a negative mass turns the "
        "minimum into a maximum.",
        TYPICAL,
    ),
    Flag(
        "bad-thickness",
        ("S13",),
        "A thickness that is zero, negative, infinite or NaN is accepted.",
        "With zero or less, surfaces may end on or in each other, and the next step starts in "
        "contact.",
        TYPICAL,
    ),
    Flag(
        "bad-start",
        ("S13",),
        "The start of the step is not checked for intersections. Every guarantee of the method "
        "rests on a free start.",
        "The method then holds the surfaces on the wrong side with great care.",
        "ARCSim does not check the start. Users ask for a repair of such starts in "
        "ppf-contact-solver issues 64, 93 and 110.",
    ),
    Flag(
        "over-strict",
        ("S13",),
        "The port refuses what is fine: unused vertices, several components, faces without area, "
        "pinned vertices with any mass, a mesh without motion, a step in which nothing meets.",
        "Users have to clean scenes that need no cleaning, or switch the checks off.",
        TYPICAL,
    ),
)
