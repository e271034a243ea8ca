"""Flags of the candidate pairs and of the time of impact: S1 and S2."""

from izo_ref.porting.dictionary.record import CCD_BENCHMARK, CPU_SIMULATOR, ELSEWHERE, TYPICAL, Flag

DETECTION = (
    Flag(
        "missed-pairs",
        ("S1",),
        "The broad phase leaves out a pair that meets on the path. Usual causes are boxes of the "
        "end position alone, boxes whose maxima are rounded down, a tree whose last element of a "
        "block is never visited, and a query that skips its own part of the tree.",
        "A pair that is never listed is never resolved: the surfaces go through each other, and "
        "every later stage still reports success.",
        ELSEWHERE,
    ),
    Flag(
        "touching-boxes",
        ("S1",),
        "Boxes that share only a plane, an edge or a corner count as apart, because they are "
        "compared with <= in place of <. A flat box, with no extent along an axis, is lost in the "
        "same way.",
        "Elements that lie along a coordinate axis, as they do in made-up scenes and on floors, "
        "meet without being noticed.",
        TYPICAL,
    ),
    Flag(
        "still-nodes",
        ("S1", "S2", "S12"),
        "A pair is skipped because one of its nodes or one of its elements does not move. Only a "
        "pair of which all four nodes rest can be skipped; an element at rest must still be found "
        "by a moving one.",
        "Cloth falls through a floor that rests, or through the part of a garment that is at rest.",
        TYPICAL,
    ),
    Flag(
        "shared-vertices",
        ("S1",),
        "The port lists pairs whose two elements have a vertex in common, or it leaves out more "
        "than these: a vertex and every face near it, or all edges of neighbouring faces.",
        "A listed pair with a common vertex touches at all times, so the loop never ends. If too "
        "many pairs are left out, a fold that closes onto its own neighbours goes through itself.",
        TYPICAL,
    ),
    Flag(
        "linear-cubic",
        ("S2",),
        "The solver of the coplanarity cubic divides by the leading coefficient. Where this is "
        "zero or tiny, the polynomial is quadratic or linear, and the port finds no root, or a "
        "wrong one. Elements that move without turning, which is very common, have such a cubic.",
        "Pairs that meet in the plainest way, at constant speed along the normal, are missed or "
        "get a wrong time.",
        f"{ELSEWHERE} {CCD_BENCHMARK}",
    ),
    Flag(
        "coplanar-motion",
        ("S2", "S3"),
        "The four nodes stay in one plane during the whole step, so that the coplanarity cubic is "
        "zero everywhere and has no isolated root. The port takes this as 'never meets', although "
        "the elements may meet within the plane. Or it asks whether the gap along the normal is "
        "exactly zero, and rounding gives 1e-16.",
        "Sheets that slide in one plane, and edges on a common floor, go through each other; or "
        "the normal is divided by zero and becomes NaN.",
        CCD_BENCHMARK,
    ),
    Flag(
        "absolute-tolerance",
        ("S2", "S3", "S7", "S8", "S9", "S11"),
        "A tolerance is a fixed number, such as 1e-6, whatever the size of the scene is. It has "
        "to be relative to the sizes in the case.",
        "The port works in metres and fails in millimetres or for a scene that is 100 times "
        "larger: it claims success with intersections left, or reports pairs that are far apart "
        "for their size.",
        "ARCSim 0.2.1: with absolute tolerances of 1e-6 it claims success, and intersects, if the "
        f"scene is scaled by 100. {CPU_SIMULATOR}",
    ),
    Flag(
        "step-cap",
        ("S2",),
        "A proof, an advancement or a subdivision ends after a fixed small number of steps, and "
        "what is not decided then counts as contact, or as apart.",
        "Counted as apart, surfaces go through each other where they turn past each other closely. "
        "Counted as contact, the step is held back for pairs that never meet.",
        TYPICAL,
    ),
    Flag(
        "late-time",
        ("S2",),
        "The time of impact is later than the true first contact. A time may be a little early; "
        "it must not be late by more than rounding.",
        "At the reported time the elements are already through each other. The normal then points "
        "to the wrong side, and the solver holds the pair there.",
        "Scalable-CCD: under overflow, its queue on a GPU reports late times in 265 of 394 steps "
        "of armadillo-rollers, as the authors of zulianp/sccd found.",
    ),
    Flag(
        "ends-of-step",
        ("S2",),
        "The interval of time is open where it has to be closed: contacts at exactly t = 0 or at "
        "exactly t = 1 are dropped, or roots just outside of [0, 1] are taken.",
        "A contact at t = 1 is missed now, and the next step starts with a mesh that touches "
        "itself, which many programs cannot repair.",
        TYPICAL,
    ),
    Flag(
        "beside-the-face",
        ("S2",),
        "The port tests only whether the four nodes become coplanar, or tests the inside with a "
        "tolerance that is too wide or too narrow. The vertex has to be within the face, and both "
        "contact parameters of two edges have to be within [0, 1]. Corners and borders belong to "
        "the elements.",
        "Vertices that pass beside a face stop in mid-air; or, if the test is too narrow, a "
        "vertex slips through the seam between two faces, since neither of them claims it.",
        TYPICAL,
    ),
    Flag(
        "many-roots",
        ("S2",),
        "The cubic has up to three roots in [0, 1]. The port examines only the first one, although "
        "the vertex is beside the face then, or returns one that is not the first contact.",
        "A vertex that first crosses the plane outside of the face, and later the face itself, "
        "goes through it.",
        TYPICAL,
    ),
    Flag(
        "starts-in-contact",
        ("S2", "S12"),
        "Pairs whose nodes are coplanar at t = 0 are skipped, so that no contact is reported at "
        "the start, and none later in the step either.",
        "The contacts that matter most, those of surfaces that already rest on each other, are "
        "never resolved.",
        "ARCSim 0.3.x skips pairs that are coplanar at the start, and then reports success with "
        f"101 real contacts left. {CPU_SIMULATOR}",
    ),
    Flag(
        "stays-coplanar",
        ("S2",),
        "Two or more coefficients of the cubic are zero because the pair is coplanar at the start "
        "and keeps that for a while, or because it touches the plane with a double root. The port "
        "compares signs at both ends and sees no change.",
        "A vertex that touches a face and lifts off again, or that slides along it and goes "
        "through at the end, is missed.",
        CCD_BENCHMARK,
    ),
    Flag(
        "float32-coordinates",
        ("S2", "S3", "S6", "S7", "S8", "S9"),
        "Coordinates far from the origin are multiplied or interpolated before they are "
        "subtracted, or inputs are stored in float32 although the case needs float64. Subtract "
        "first: differences of nearby positions are exact, products of large coordinates are not.",
        "A scene that works at the origin jitters, misses contacts or gets wrong normals at 1 km "
        "from it.",
        "GPU programs such as I-Cloth compute in float32. Float32 detection that never misses is "
        "what users ask for in Scalable-CCD issue 8.",
    ),
    Flag(
        "parallel-edges",
        ("S2", "S3"),
        "The closest points of two edges are found from a 2 x 2 system whose determinant is zero "
        "for parallel edges. The port divides by it, or takes the first ends of both edges.",
        "Parallel edges are frequent in regular meshes. Their weights become NaN, or belong to "
        "points that are far from each other, and the correction moves the wrong vertices.",
        TYPICAL,
    ),
    Flag(
        "degenerate-elements",
        ("S2", "S3", "S13"),
        "A face of area zero, or an edge of length zero, has no normal and no unique closest "
        "points, and the port divides by zero. In input, a face without area is no error; a face "
        "that names a vertex twice is one, and has to be refused.",
        "One bad triangle of a remeshed or exported garment turns all positions into NaN.",
        TYPICAL,
    ),
    Flag(
        "queue-overflow",
        ("S1", "S12"),
        "Pairs, contacts or stack entries are stored in a place of fixed size, and those beyond it "
        "are dropped without a message, or written over others.",
        "Everything works until a scene is crowded. Then contacts vanish, and the status is still "
        "good.",
        "XRTailor: a stack of 1024 entries is not checked. Scalable-CCD: its queue on a GPU "
        "reports late times when it overflows. Newton: issues 3702 and 3795 are about full "
        "buffers of contacts. Found in a GPU simulator (validation/mutants).",
    ),
)
