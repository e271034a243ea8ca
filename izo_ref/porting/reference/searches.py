"""The line searches of stage S10, step by step as the loop of izo_ref takes them.

Stage S8 accepts any step with the strong Wolfe conditions. The iterations that follow depend on the
step, so S10 says which one: that of Newton's method on the slope of L along the line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from izo_ref.porting.reference.line_search import Found, Line, at, backtrack, exact
from izo_ref.porting.reference.rounded import CONTEXT, ZERO, Rounded, total
from izo_ref.porting.reference.tracked import Tracked

MOST_TRIED = 200


def search(
    line: Line, inputs: Mapping[str, Any], active: Sequence[bool], last: Rounded, alone: bool
) -> Found:
    """Search a step along a line; step 0 if there is none.

    Args:
        line: The line x + step p.
        inputs: The parameters, by the names of `stages.py`.
        active: Which constraints are active at x.
        last: The last step.
        alone: Whether there are no pairs yet: then lbfgs begins at the minimum of the model.
    """
    if inputs["search"] == "exact":
        return _exact(line)
    first = Rounded.of(1.0)
    if inputs["begin"] == "last":
        first = last * inputs["grow"]
    elif inputs["begin"] == "model" or (inputs["direction_name"] == "lbfgs" and alone):
        squares = total(q * q for q, counts in zip(line.along, active, strict=True) if counts)
        first = -line.slope / (line.curvature + line.mu * squares)
    smallest = inputs["smallest_step"]
    if inputs["search"] == "backtracking":
        return backtrack(line, first, inputs["armijo"], inputs["shrink"], smallest)
    return wolfe(line, first, inputs["armijo"], inputs["wolfe"], smallest)


def _exact(line: Line) -> Found:
    """Return the minimum of L along the line, as Newton's last step on the slope finds it.

    The search of izo_ref ends where the slope has fallen to 2 eps of that at x.
    """
    near = Rounded(exact(line).step.value)
    point = at(line, near)
    _note_pieces(line, near)
    step = near - point.rise / point.second
    missing = CONTEXT.divide(2 * abs(line.slope.value), point.second.value)
    step = step.more(missing) if isinstance(step, Tracked) else step
    return Found(step, at(line, step).change, [step])


def wolfe(line: Line, first: Rounded, armijo: float, wanted: float, smallest: float) -> Found:
    """Return a step with the strong Wolfe conditions.

    Newton's method on the slope proposes steps, with the second derivative of the piece that the
    step is in. A step that leaves the bracket is replaced by its middle, or by twice its lower end
    while it has no upper end.

    Args:
        line: The line.
        first: The step to try first.
        armijo: c_1.
        wanted: c_2.
        smallest: The search fails when it reaches a smaller step.
    """
    limit, step, tried = wanted * abs(line.slope), first, []
    low, high = Rounded(ZERO), None
    for _ in range(MOST_TRIED):
        tried.append(step)
        point = at(line, step)
        too_far = point.rise > limit or not point.change < armijo * step * line.slope
        if not too_far and point.rise >= -limit:
            return Found(step, point.change, tried)
        low, high = (low, step) if too_far else (step, high)
        _note_pieces(line, step)
        step = step - point.rise / point.second
        if not step > low or (high is not None and not step < high):
            step = 2.0 * low if high is None else 0.5 * (low + high)
        if step < smallest:
            break
    return Found(Rounded(ZERO), Rounded(ZERO), tried)


def _note_pieces(line: Line, step: Rounded) -> None:
    """Note how close a step is to the ends of its quadratic piece."""
    for t, q in zip(line.pushed, line.along, strict=True):
        _ = t > step * q
