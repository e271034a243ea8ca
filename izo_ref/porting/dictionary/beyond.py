"""Flags of mistakes that no single case can show: they have no stage, and no vectors.

A vector asks for one stage anew, on small input. What follows shows in the next step, on large
zones, with several threads, or only in a program that has the part at all.
"""

from izo_ref.porting.dictionary.record import ELSEWHERE, TYPICAL, Flag

BEYOND = (
    Flag(
        "incremental-detection",
        (),
        "A later detection looks only at what moved, and forgets something: moves are compared one "
        "by one and not added up, impacts of vertices that rest are dropped, or a part at rest is "
        "never looked at again.",
        "Contacts are missed in the second iteration or later, in scenes where parts come to rest. "
        "Compare each detection with a complete one on the same positions.",
        TYPICAL,
    ),
    Flag(
        "thread-race",
        (),
        "Threads write to the same place, read what another one has not written yet, or share out "
        "the work so that an item is done twice or never.",
        "Results differ from run to run, or are wrong for one number of threads only. Run the same "
        "step with one thread and with many, and compare all bits.",
        ELSEWHERE,
    ),
    Flag(
        "gpu-only",
        (),
        "The code of the GPU does something else than that of the CPU beside it: it sums a part of "
        "the threads, examines the first batch of pairs alone, or sorts without keeping the order "
        "of equal keys.",
        "Small tests pass, since they fit into one block of threads. Run the vectors on the GPU "
        "too, and compare traces of a large step with those of the CPU.",
        TYPICAL,
    ),
    Flag(
        "linear-algebra",
        (),
        "A factorisation or an elimination order is wrong in a part that small systems do not "
        "reach: the last rows of a tile, the children of a front, a row that is left out.",
        "Zones of a few impacts are solved, large ones are not. Residuals show it, if they are "
        "computed from the problem and not from the factors.",
        TYPICAL,
    ),
    Flag(
        "renumbering",
        (),
        "The program renumbers vertices, corners or sides for its own use, and brings something "
        "back in the wrong order: positions by the inverse of the numbering, or corners without "
        "their weights.",
        "Everything is right in tests whose numbering happens to be kept. Renumber the vertices of "
        "a mesh at random; apart from rounding, the answer must be the same.",
        TYPICAL,
    ),
    Flag(
        "relinearize",
        (),
        "The rounds that take normals again at the answer keep a worse answer, take no time limit, "
        "or leave out the impacts that are exactly at the thickness.",
        "The result is farther from the proposed positions than without these rounds, or the step "
        "takes many times longer.",
        TYPICAL,
    ),
    Flag(
        "certificate",
        (),
        "The judge is wrong, and not the method: residuals cancel each other, a proof leaves out "
        "rounding, or pairs that floats cannot decide count as apart.",
        "Wrong answers are called right. Give the judge answers that are wrong on purpose, and see "
        "whether it says so.",
        TYPICAL,
    ),
    Flag(
        "touching-start",
        (),
        "Pairs that touch at the start, where a program accepts that, are pushed to the wrong "
        "side, or may leave on either side although the mesh tells which one is right.",
        "A ball that rests on a table ends below it.",
        TYPICAL,
    ),
    Flag(
        "excluded-pairs",
        (),
        "Pairs that are left out on purpose, because they cross at the start or are prescribed, "
        "are examined all the same, stay left out for ever, or are not named in the result.",
        "Either the step cannot be resolved, or a result is called free that is not.",
        TYPICAL,
    ),
    Flag(
        "weld",
        (),
        "Vertices that are one vertex, as along a seam, are welded wrongly: by their start alone, "
        "with the mass of one of them, or with copies that do not follow.",
        "Seams open, or their copies touch the faces beside them and stop everything.",
        TYPICAL,
    ),
    Flag(
        "sizes",
        (),
        "Coordinates are scaled before the computation, by a size that unused vertices decide or "
        "by a factor that costs digits, or a result is not scaled back.",
        "The answer depends on the unit of length or of mass.",
        TYPICAL,
    ),
)
