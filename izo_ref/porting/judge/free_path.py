"""Judge `free-path`: pinned vertices end where they must, and the path is certified free."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from izo_ref.porting.judge.geometry import dot, minus, vectors
from izo_ref.porting.judge.measure import number_at, ratio
from izo_ref.porting.judge.outcome import Difference, Question
from izo_ref.porting.reference.rounded import to_float32


def judge_free_path(question: Question) -> list[Difference]:
    """Check the end positions of a step that a port says is free; nothing else if it does not."""
    if "free" not in question.replies:
        return [question.needs("free")]
    if question.replies["free"][0] != 1:
        return []
    found = _too_large(question) or _pinned(question)
    found = found or _objective(question)
    return found or _certificate(question)


def to_dtype(number: float, dtype: str) -> float:
    """Return a float as the port's type holds it."""
    return number if dtype == "f8" else to_float32(number)


def _too_large(question: Question) -> list[Difference]:
    """Check that the port's type can hold each coordinate."""
    for i, got in enumerate(question.got):
        if not math.isfinite(to_dtype(got, question.dtype)):
            text = f"no number of type {question.dtype} is as large as {got!r}"
            return [question.difference(text, i, None, got)]
    return []


def _pinned(question: Question) -> list[Difference]:
    """Check that pinned vertices are at their proposed positions, bit for bit."""
    inputs: Any = question.case.inputs
    found = []
    for i, (got, proposed) in enumerate(zip(question.got, inputs["positions_t1"], strict=True)):
        want = to_dtype(proposed, question.dtype)
        if inputs["pinned"][i // 3] and to_dtype(got, question.dtype) != want:
            text = f"pinned vertex {i // 3} must end exactly at {want!r}, got {got!r}"
            found.append(question.difference(text, i, want, got))
    return found


def _objective(question: Question) -> list[Difference]:
    """Check that sum m |x - y|^2 / sum m over unpinned vertices is within its limits."""
    inputs: Any = question.case.inputs
    if "objective_at_most" not in question.expected:
        return []
    total = moved = Fraction(0)
    got, proposed = (
        vectors([to_dtype(number, question.dtype) for number in numbers])
        for numbers in (question.got, inputs["positions_t1"])
    )
    ends = zip(got, proposed, strict=True)
    for i, (x, y) in enumerate(ends):
        if not inputs["pinned"][i]:
            mass = Fraction(inputs["masses"][i])
            step = minus(x, y)
            total, moved = total + mass, moved + mass * dot(step, step)
    most = Fraction(number_at(question.expected["objective_at_most"], 0))
    least = Fraction(number_at(question.expected.get("objective_at_least", 0), 0))
    if total == 0 or least * total <= moved <= most * total:
        return []
    objective = ratio(moved, total)
    if moved < least * total:
        return [_outside(question, objective, least, "least", "nearer to the obstacle than d")]
    why = "farther from the proposed ones than they need be"
    return [_outside(question, objective, most, "most", why)]


def _outside(
    question: Question, objective: float, limit: Fraction, word: str, why: str
) -> Difference:
    """Return the difference of an objective that is not at least, or not at most, its limit."""
    text = f"the objective: expected at {word} {float(limit):.6g} m^2, got {objective:.6g} m^2; "
    difference = question.difference(
        f"{text}the positions are {why}", None, float(limit), objective
    )
    return difference._replace(quantity=f"the objective, at {word}")


def _certificate(question: Question) -> list[Difference]:
    """Certify the path."""
    import numpy as np

    from izo_ref.base.errors import IzoError
    from izo_ref.certificate.certify import certify_path
    from izo_ref.scene import Scene

    inputs: Any = question.case.inputs
    start, end = (
        np.array([to_dtype(x, question.dtype) for x in inputs[name]]).reshape(-1, 3)
        for name in ("positions_t0", "positions_t1")
    )
    ends = np.array([to_dtype(x, question.dtype) for x in question.got], float).reshape(-1, 3)
    pinned = np.array(inputs["pinned"], bool)
    ends[pinned] = end[pinned]
    faces = np.array(inputs["faces"], np.int32).reshape(-1, 3)
    try:
        scene = Scene(start, end, faces, pinned=pinned)
        certificate = certify_path(scene, ends)
    except IzoError as error:
        return [question.difference(f"the path cannot be certified: {error}")]
    if certificate.free:
        return []
    pairs, time = certificate.meeting, float(certificate.meeting_toi[0])
    kind = "edge-edge" if pairs.is_edge_edge[0] else "vertex-face"
    text = (
        f"the port says that the path is free, but {len(certificate.meeting_toi)} pairs meet on "
        f"it; the first is the {kind} pair {tuple(pairs.nodes[0].tolist())} at t = {time:.6g}"
    )
    return [question.difference(text)]
