"""Flags of frames, selection, zones and the zone problem: S3 to S6."""

from izo_ref.porting.dictionary.record import ELSEWHERE, GPU_SIMULATOR, TYPICAL, Flag

FRAMES = (
    Flag(
        "normal-sign",
        ("S3",),
        "The normal points to the side on which the pair must not be. It has to make the gap at "
        "the start of the step positive, N . sum_k a_k x_k(0) > 0; the winding of the face does "
        "not decide, and neither do the positions at the time of impact, where the gap is zero.",
        "The solver pulls the surfaces through each other and holds them there.",
        ELSEWHERE,
    ),
    Flag(
        "frame-time",
        ("S3",),
        "Weights and normal are taken at the start, or at the proposed end, and not at the time "
        "of impact.",
        "Where elements turn during the step, the constraint is for another point and another "
        "direction. The loop takes many more iterations, or ends with the pair on the wrong side.",
        TYPICAL,
    ),
    Flag(
        "weights-order",
        ("S3",),
        "The four weights do not belong to the nodes in the agreed order and with the agreed "
        "signs: the vertex, then the corners of the face; or the ends of the first edge, then "
        "those of the second. The first side is positive, the second negative, the sum is zero.",
        "The correction goes to the wrong corner. In symmetric test scenes this is hardly visible.",
        TYPICAL,
    ),
    Flag(
        "clamped-points",
        ("S3",),
        "Where the closest point is on a border or at an end, the port extrapolates the weights, "
        "or clamps each coordinate by itself and leaves the others as they are. Or it takes areas "
        "of triangles with the vertex as though the sides touched already. A time of impact may "
        "be early, so the sides need not touch, and the pair may still be beside the face.",
        "Weights belong to points that are not the closest ones, or have the wrong sign: the "
        "correction moves the wrong vertices, and pulls some of them to the other side.",
        TYPICAL,
    ),
)
ZONES = (
    Flag(
        "zone-transitive",
        ("S5",),
        "Zones are merged in one pass. If A meets B and B meets C, then A and C belong to one zone "
        "although they share nothing; the merge has to be repeated until nothing changes, or to "
        "use union-find.",
        "Two zones write to the same vertex. The result depends on which is solved last, and one "
        "of the two constraints is violated.",
        f"XRTailor: the merge of its zones is not transitive. {GPU_SIMULATOR}",
    ),
    Flag(
        "zone-pinned",
        ("S5", "S4"),
        "Impacts that share only a pinned vertex are put into one zone, or wait for each other in "
        "the selection. A pinned vertex is no unknown, so it connects nothing. The mask of pinned "
        "vertices is often read with the wrong numbering.",
        "A body that touches a garment in a thousand places turns them all into one large zone, "
        "which is slow; with a wrong numbering, cloth is treated as obstacle, and goes through.",
        f"XRTailor confuses indices of cloth and of obstacles. {GPU_SIMULATOR}",
    ),
    Flag(
        "zone-capacity",
        ("S5",),
        "There is room for a fixed number of zones, or of impacts in a zone. The others are "
        "dropped.",
        "The scene is resolved in some places and intersects in others, without a message.",
        f"XRTailor has a limit of 100 zones. {GPU_SIMULATOR}",
    ),
    Flag(
        "selection-order",
        ("S4",),
        "Impacts are taken in the order in which they were found, and not in the order of their "
        "times; or an impact blocks others although it was itself not taken.",
        "Late impacts, which earlier ones would have prevented, enter the zones. The result is "
        "farther from the proposed positions, and changes with the numbering of the mesh.",
        ELSEWHERE,
    ),
    Flag(
        "selection-ties",
        ("S4",),
        "Impacts at equal times are ordered by an unstable sort, or by the order in which threads "
        "finish. Equal times keep the order in which the impacts were given.",
        "Two runs of the same step end differently, so nothing can be compared or debugged.",
        TYPICAL,
    ),
    Flag(
        "selection-deep",
        ("S4",),
        "The rule for deep zones is not the stated one: the main vertices are those of the largest "
        "weight on each side, an impact waits if it comes later than 1.5 times the first time of "
        "one of its main vertices, and vertex-face impacts go before edge-edge impacts.",
        "A sheet that moves by many edge lengths is torn into long triangles, which meet thousands "
        "of others.",
        TYPICAL,
    ),
)
PROBLEM = (
    Flag(
        "node-order",
        ("S6", "S7", "S11"),
        "The weights of an impact are combined with positions in another order than that of its "
        "nodes, often after the nodes were sorted, deduplicated or renumbered inside the zone.",
        "Constraint values look plausible and are wrong; the gradient pushes the wrong vertices.",
        TYPICAL,
    ),
    Flag(
        "mass-weighting",
        ("S6", "S7", "S10", "S11", "S12"),
        "Masses are left out, inverted, taken as their square roots, or the objective is divided "
        "by the number of vertices and not by the sum of masses.",
        "Light and heavy vertices share a correction in the wrong ratio: a light ribbon pushes a "
        "heavy coat away. With equal masses, nothing is visible.",
        TYPICAL,
    ),
    Flag(
        "pinned-masses",
        ("S6", "S7", "S11", "S12", "S13"),
        "The mass of a pinned vertex is used: it enters the sum of masses, or it is checked and "
        "refused although it may be zero, infinite or NaN. A pinned vertex has no mass in the "
        "problem and does not move.",
        "The objective is wrong by a factor that depends on the obstacle, obstacles move, or a "
        "sound scene is refused.",
        TYPICAL,
    ),
    Flag(
        "constraint-sign",
        ("S6", "S7", "S9", "S11"),
        "The sign of the constraint or of its gradient is wrong: c_j = d - N . sum_k a_k x_k is "
        "positive where it is violated, and its gradient is -a_k N.",
        "The solver drives surfaces into each other. With both signs wrong, the values look right "
        "and only the gradient fails.",
        TYPICAL,
    ),
    Flag(
        "lost-sum",
        ("S6", "S7"),
        "A vertex that is in several impacts gets the contribution of only one of them: parallel "
        "threads write in place of adding atomically, or the sum is stored and not accumulated.",
        "In corners and folds, where many impacts meet, the solver hardly moves or never ends. "
        "Single contacts work, so small tests pass.",
        ELSEWHERE,
    ),
)
