"""What each judge needs to know: the members beside `judge` of an expected output.

`schema.json` and the checks of new vectors are made from this table; `judge/` has the judges.
"""

from __future__ import annotations

from typing import NamedTuple

NUMBER, NUMBERS, SCALE, COUNT = "float", "floats", "float or floats", "count"
INTEGERS, WORDS, PAIR_KIND = "integers", "integers or texts", "kind of pairs"
PAIR_KINDS = ("vertex-face", "edge-edge")


class Judge(NamedTuple):
    """One way to judge an output.

    Attributes:
        what: When a reply passes.
        parameters: Kind of each member of the expected output beside `judge`.
        kinds: Kinds of the outputs that it can judge (`stages.py`).
        optional: Kinds of members that may be missing.
        outputs: `stage.output` of the outputs that it is for; empty if it is for all.
    """

    what: str
    parameters: dict[str, str]
    kinds: str
    optional: dict[str, str] = {}  # noqa: RUF012 - nothing changes it
    outputs: tuple[str, ...] = ()

    def judges(self, stage: str, output: str, kind: str) -> bool:
        """Return whether it can judge an output of a stage.

        Args:
            stage: Name of the stage.
            output: Name of the output.
            kind: Kind of the output (`stages.py`).
        """
        return kind in self.kinds and (not self.outputs or f"{stage}.{output}" in self.outputs)


TOLERANCE = {"scale": SCALE, "multiple": COUNT}
# In place of `multiple`, where one type of floats needs another one.
OF_ONE_TYPE = {"multiple_f8": COUNT, "multiple_f4": COUNT}
JUDGES = {
    "values": Judge(
        "|got - value| <= multiple * eps * scale for each element; a single scale is for all",
        {"values": NUMBERS, **TOLERANCE},
        "f",
        OF_ONE_TYPE,
    ),
    "equal": Judge("the same integers or texts", {"values": WORDS}, "ibs"),
    "superset": Judge(
        "every pair is listed, with its corners or edges in any order; more pairs may be listed",
        {"kind": PAIR_KIND, "pairs": INTEGERS},
        "i",
        {},
        ("S1.vertex_face", "S1.edge_edge"),
    ),
    "time": Judge(
        "time * (1 - early) - tol <= got <= time + tol, tol = multiple * eps * scale",
        {"time": NUMBER, **TOLERANCE, "early": NUMBER},
        "f",
        OF_ONE_TYPE,
    ),
    "partition": Judge(
        "the same partition, whatever the numbers are; -1 stays -1", {"values": INTEGERS}, "i"
    ),
    "range": Judge(
        "low - tol <= got <= high + tol, tol = multiple * eps * scale",
        {"low": SCALE, "high": SCALE, **TOLERANCE},
        "f",
        OF_ONE_TYPE,
    ),
    "side": Judge(
        "unit length within tol, and the gap at t = 0 by the weights of the reply is at least "
        "least_gap - tol, tol = multiple * eps * scale",
        {**TOLERANCE, "least_gap": NUMBER},
        "f",
        OF_ONE_TYPE,
        ("S3.normal",),
    ),
    "weights": Judge(
        "signs and sum are right, and the two points have the least distance within "
        "tol = multiple * eps * scale",
        {"distance": NUMBER, **TOLERANCE},
        "f",
        OF_ONE_TYPE,
        ("S3.weights",),
    ),
    "kkt": Judge(
        "by the positions x of the reply: |x - y - M^-1 A^T l| <= multiple * eps * scale for each "
        "coordinate, and |min(l_j K_jj, -c_j)| <= multiple * eps * gap_scale for each impact",
        TOLERANCE,
        "f",
        {**OF_ONE_TYPE, "gap_scale": NUMBERS},
        ("S11.multipliers",),
    ),
    "free-path": Judge(
        "if the reply says that the path is free, pinned vertices are where they were proposed, "
        "the path is certified free, and objective_at_least <= sum m |x - y|^2 / sum m <= "
        "objective_at_most, where these are stated",
        {},
        "f",
        {"objective_at_most": NUMBER, "objective_at_least": NUMBER},
        ("S12.positions",),
    ),
}
STATUS = "status"  # the pseudo output that says whether a port answers
STATUSES = ("ok", "refused")
