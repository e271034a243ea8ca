"""Judge `partition`: the same groups, whatever their numbers."""

from __future__ import annotations

from izo_ref.porting.judge.outcome import Difference, Question


def judge_partition(question: Question) -> list[Difference]:
    """Compare groups: equal numbers stand for the same group, and -1 for no group at all."""
    found = []
    first_with: dict[int, int] = {}  # the first element with each expected number
    first_got: dict[int, int] = {}
    for i, (value, got) in enumerate(zip(question.expected["values"], question.got, strict=True)):
        wanted = ""
        if (value == -1) != (got == -1):
            wanted = "no group, which is -1" if value == -1 else "a group, so not -1"
        elif value != -1:
            mate, got_mate = first_with.setdefault(value, i), first_got.setdefault(got, i)
            if mate != got_mate:
                with_mate = f"the group of element {mate}"
                wanted = with_mate if mate != i else f"another group than element {got_mate}"
        if wanted:
            text = f"element {i} belongs to {wanted}; the reply has the number {got}"
            found.append(question.difference(text, i, wanted, got))
    return found
