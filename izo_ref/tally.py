"""What a detection looked at, and what it found."""

from typing import NamedTuple


class Detected(NamedTuple):
    """Counts of a detection."""

    found: int  # impacts of the path, but those between pinned points
    blocked: int  # and of those
    moved: int  # vertices that moved since the last detection
    candidates: int  # pairs looked at


class Tally:
    """Counts of one detection.

    Attributes:
        moved: vertices that ended elsewhere than in the detection before.
        pairs: candidate pairs, by kind.
        steps: proofs these took together, and the most for one pair.
    """

    def __init__(self, moved=0):
        self.moved = moved
        self.pairs = {"vertex_face": 0, "edge_edge": 0}
        self.steps = 0
        self.most_steps = 0

    def add(self, kind, pairs, steps, most_steps):
        self.pairs[kind] += int(pairs)
        self.steps += int(steps)
        self.most_steps = max(self.most_steps, int(most_steps))
