"""Judge a refusal at the door: it is right only if the input is not allowed (docs/limits.md)."""

import math

import numpy as np

from izo_ref.base.errors import (
    DegenerateFaceError,
    InitialIntersectionError,
    IzoError,
    MassError,
    NonFiniteError,
    SizeError,
    ThicknessError,
    UncertifiedStartError,
    WeldError,
)
from izo_ref.base.sizes import LARGEST_LENGTH, THICKEST, THINNEST
from izo_ref.base.units import LENGTHS, RATIO
from validation.oracles import path
from validation.stability_steps.case import Case
from validation.stability_steps.exact import all_meetings


def judge_refusal(case: Case, step: int, error: IzoError) -> list[str]:
    """Return a line if the input of a step is allowed although it was refused.

    Args:
        case: The case.
        step: Number of its step, from 0.
        error: How it was refused.
    """
    right = False
    if isinstance(error, InitialIntersectionError):
        right = _start_meets(case, error, step)
    elif isinstance(error, SizeError):
        right = _size_is_out_of_range(case)
    elif isinstance(error, ThicknessError):
        # the edges of a later step may have no length, and then there is no default
        has_no_default = case.thickness is None and "the default is" in str(error)
        right = has_no_default or _thickness_is_out_of_range(case)
    elif isinstance(error, MassError):
        masses = case.masses
        used = np.ones(len(case.positions_t0), bool) if case.pinned is None else ~case.pinned
        right = masses is not None and not masses[used].max() <= masses[used].min() * 2.0**RATIO
    elif isinstance(error, WeldError):
        right = bool(case.modes.get("weld")) or (step > 0 and _copies_part(case, step))
    elif isinstance(error, DegenerateFaceError):  # no face is drawn so; welding joins its corners
        right = case.modes.get("weld") is not None
    elif isinstance(error, NonFiniteError):
        right = not all(np.isfinite(p).all() for p in (case.positions_t0, *case.ends))
    elif isinstance(error, UncertifiedStartError):
        right = False  # `after` is called with free results only
    return [] if right else [f"refused: {type(error).__name__}: {str(error)[:200]}"]


def _copies_part(case: Case, step: int) -> bool:
    """Return whether vertices that are welded without tolerance have different ends in a step."""
    if case.modes.get("weld") is None:
        return False
    first = np.hstack((case.positions_t0, case.ends[0])) + 0.0  # so that -0 and 0 are equal bits
    _, group = np.unique(first, axis=0, return_inverse=True)
    both = np.column_stack((group.ravel(), case.ends[step] + 0.0))
    return len(np.unique(both, axis=0)) > len(np.unique(group))


def _start_meets(case: Case, error: InitialIntersectionError, step: int) -> bool:
    """Return whether the start touches or crosses, by the second oracle and by the named pairs.

    At rest, an edge that goes through the inside of a face touches none of its sides: then no pair
    meets, and the named pairs are those of the edge and the face.
    """
    if step > 0 or case.modes.get("initial_intersections", "raise") != "raise":
        return step > 0 and case.modes.get("initial_intersections") == "raise"
    start = case.positions_t0
    if all_meetings(start, start, case.faces, None):
        return True
    return any(_goes_through(case, nodes.tolist()) for nodes in error.pairs.nodes)


def _goes_through(case: Case, nodes: list[int]) -> bool:
    """Return whether an edge of some nodes and a face of the mesh cross at rest, exactly."""
    start = case.positions_t0
    for a in nodes:
        for b in nodes:
            for face in case.faces:
                if a < b and a not in face and b not in face:
                    five = start[[a, b, *face]]
                    if path.goes_through_after_start(five, five):
                        return True
    return False


def _size(case: Case) -> float:
    corners = np.unique(case.faces)
    parts = [case.positions_t0, *case.ends]
    return max((float(np.abs(p[corners]).max(initial=0.0)) for p in parts), default=0.0)


def _size_is_out_of_range(case: Case) -> bool:
    """Return whether docs/limits.md refuses the coordinates."""
    size = _size(case)
    if not 2.0**-LARGEST_LENGTH <= size <= 2.0**LARGEST_LENGTH:
        return True
    everything = np.concatenate([case.positions_t0, *case.ends])
    small = np.abs(everything[everything != 0.0])
    if size > 2.0**LENGTHS and small.min(initial=np.inf) < size * 2.0 ** -(1022 + LENGTHS):
        return True
    alone = ~np.isin(np.arange(len(case.positions_t0)), case.faces)
    far = max(float(np.abs(p[alone]).max(initial=0.0)) for p in (case.positions_t0, *case.ends))
    return far > size * 2.0**100 / 2.0


def _thickness_is_out_of_range(case: Case) -> bool:
    """Return whether docs/limits.md refuses the thickness, or there is no default thickness."""
    thickness = case.thickness
    if thickness is None:
        a, b = case.faces, np.roll(case.faces, 1, axis=1)
        with np.errstate(under="ignore"):
            lengths = np.linalg.norm(case.positions_t0[a] - case.positions_t0[b], axis=2)
        # half of the edges have no length that floats can hold, up to a face that is there twice
        return bool((lengths == 0.0).mean() >= 0.3)
    size = _size(case)
    exponent = math.frexp(size)[1] if size > 0.0 else 0
    low, high = (math.ldexp(1.0, exponent + k) for k in (THINNEST, THICKEST))
    return not low <= thickness <= high or thickness < 2.0**-1022
