"""How a step becomes smaller and simpler."""

import json
from collections.abc import Iterator

import numpy as np

from izo_ref.base.arrays import AnyArray, Indices
from izo_ref.base.errors import IzoError
from izo_ref.detection.components import MeshComponents
from validation.shrink import numbers
from validation.shrink.search import Search
from validation.stability_steps.case import Case

SIMPLE_THICKNESS = (None, 1.0, 1e-3)


def shrink_step(search: Search[Case]) -> None:
    """Make the best step of a search smaller until nothing more can be left out.

    Raises:
        OutOfTimeError: The time is used up; the best step so far is in the search.
    """
    while True:
        before = key(search.best)
        _fewer_steps(search)
        _fewer_elements(search)
        _simpler_settings(search)
        _less_motion(search)
        _simpler_numbers(search)
        search.say(describe(search.best))
        if key(search.best) == before:
            return


def key(case: Case) -> bytes:
    """Return bytes that are equal for equal cases."""
    arrays = (case.positions_t0, *case.ends, case.faces, case.masses, case.pinned)
    settings = json.dumps([case.modes, case.settings, case.thickness], sort_keys=True)
    return b"|".join([settings.encode(), *(_bytes(array) for array in arrays)])


def _bytes(array: AnyArray | None) -> bytes:
    if array is None:
        return b"-"
    return repr(np.shape(array)).encode() + np.ascontiguousarray(array).tobytes()


def door(case: Case) -> str:
    """Return how the start of a case comes through the door: accepted, or the class of the error.

    A step that becomes smaller has to stay valid, or has to be refused in the same way.
    """
    try:
        case.scene()
    except IzoError as error:
        return type(error).__name__
    return ""


def describe(case: Case) -> str:
    """Return the size of a case in a line."""
    n, moving = len(case.positions_t0), np.zeros(len(case.positions_t0), bool)
    for end in case.ends:
        moving |= (end != case.positions_t0).any(axis=1)
    pinned = 0 if case.pinned is None else int(np.sum(case.pinned))
    digits = numbers.length(np.array([case.positions_t0, *case.ends]))
    masses = "equal masses" if case.masses is None else f"{len(np.unique(case.masses))} masses"
    settings = [f"{name}={value!r}" for name, value in (case.modes | case.settings).items()]
    return (
        f"{len(case.faces)} faces, {n} vertices ({int(moving.sum())} move, {pinned} pinned), "
        f"{masses}, {len(case.ends)} steps, {digits} characters of coordinates, "
        f"{', '.join(settings) or 'default options'}"
    )


def _fewer_steps(search: Search[Case]) -> None:
    """Leave out steps of a sequence, the last ones first."""
    for k in range(len(search.best.ends) - 1, 0, -1):
        ends = search.best.ends
        if not search.take(search.best.change(ends=ends[:k])):
            search.take(search.best.change(ends=ends[: k - 1] + ends[k:]))


def _fewer_elements(search: Search[Case]) -> None:
    """Leave out components, then faces, then vertices in no face."""
    case = search.best
    component = MeshComponents(len(case.positions_t0), np.asarray(case.faces)).component
    of_faces = component[case.faces[:, 0]] if len(case.faces) else np.empty(0, int)
    alone = _alone(case)

    def keep_components(origin: Case, kept: list[int]) -> Case | None:
        faces = np.flatnonzero(np.isin(of_faces, kept))
        return with_elements(origin, faces, alone)

    if len(np.unique(of_faces)) > 2:
        search.keep_few(np.unique(of_faces).tolist(), keep_components)
    search.keep_few(range(len(search.best.faces)), _keep_faces)
    search.keep_few(range(len(search.best.faces)), _keep_faces_and_vertices)
    m = len(search.best.faces)  # then faces and vertices in no face together
    search.keep_few([*range(m), *(m + int(v) for v in _alone(search.best))], _keep_elements)


def _keep_faces(origin: Case, kept: list[int]) -> Case | None:
    return with_elements(origin, np.array(kept, int), _alone(origin))


def _keep_faces_and_vertices(origin: Case, kept: list[int]) -> Case:
    """Keep faces, and the vertices of the others as vertices in no face."""
    return origin.change(faces=np.asarray(origin.faces)[kept].reshape(-1, 3))


def _keep_elements(origin: Case, kept: list[int]) -> Case | None:
    """Keep faces, and vertices in no face, which are numbered behind the faces."""
    items, m = np.array(kept, int), len(origin.faces)
    return with_elements(origin, items[items < m], items[items >= m] - m)


def with_elements(case: Case, faces: Indices, alone: Indices) -> Case | None:
    """Return a case with some faces, their vertices, and some vertices in no face.

    Args:
        case: The case.
        faces: Indices of the faces.
        alone: Vertices that may be in no face.

    Returns:
        The case; None if nothing is left.
    """
    own = np.asarray(case.faces)[faces].reshape(-1, 3)
    kept = np.union1d(own.ravel(), alone).astype(int)
    if len(kept) == 0:
        return None
    place = np.zeros(len(case.positions_t0), np.int32)
    place[kept] = np.arange(len(kept))
    return case.take_vertices(kept).change(faces=place[own])


def _alone(case: Case) -> Indices:
    return np.setdiff1d(np.arange(len(case.positions_t0)), np.asarray(case.faces))


def _simpler_settings(search: Search[Case]) -> None:
    """Set options, modes, masses and pinned vertices to their defaults, where that may be."""
    case = search.best
    if not search.take(case.change(modes={}, settings={}, masses=None, pinned=None)):
        for name in [*case.settings]:
            rest = {k: v for k, v in search.best.settings.items() if k != name}
            search.take(search.best.change(settings=rest))
        for name in [*case.modes]:
            rest = {k: v for k, v in search.best.modes.items() if k != name}
            search.take(search.best.change(modes=rest))
        search.take(search.best.change(masses=None))
        search.take(search.best.change(pinned=None))
    if search.best.pinned is not None:
        pinned = np.flatnonzero(search.best.pinned).tolist()
        search.keep_few(pinned, _keep_pinned)
    for thickness in SIMPLE_THICKNESS:
        if thickness == search.best.thickness:
            break
        if search.take(search.best.change(thickness=thickness)):
            break
    if search.best.thickness is not None:
        _simpler_array(search, "thickness")
    if search.best.masses is not None:
        _simpler_array(search, "masses")


def _keep_pinned(origin: Case, kept: list[int]) -> Case:
    pinned = np.zeros(len(origin.positions_t0), bool)
    pinned[kept] = True
    return origin.change(pinned=pinned)


def _less_motion(search: Search[Case]) -> None:
    """Let as few vertices move as the failure needs."""
    for k in range(len(search.best.ends)):
        case = search.best
        moving = np.flatnonzero((case.ends[k] != case.positions_t0).any(axis=1)).tolist()

        def keep(origin: Case, kept: list[int], k: int = k) -> Case:
            end = origin.positions_t0.copy()
            end[kept] = origin.ends[k][kept]
            return origin.change(ends=(*origin.ends[:k], end, *origin.ends[k + 1 :]))

        search.keep_few(moving, keep)


def _simpler_numbers(search: Search[Case]) -> None:
    """Move to the origin, bring the size near 1, round all coordinates, then each of them."""
    search.take_first(_moved(search.best))
    search.take_first(_scaled(search.best))
    numbers.together(search, _coordinates, _with_coordinates)
    _simpler_motion(search)
    numbers.one_by_one(search, _coordinates, _with_coordinates)


def _coordinates(case: Case) -> AnyArray:
    return np.array([case.positions_t0, *case.ends])


def _with_coordinates(case: Case, coordinates: AnyArray) -> Case:
    return case.change(positions_t0=coordinates[0], ends=tuple(coordinates[1:]))


def _moved(case: Case) -> Iterator[Case]:
    """Yield the case with another place at the origin."""
    everything = _coordinates(case)
    if not np.isfinite(everything).all() or everything.size == 0:
        return
    for place in (everything[0].min(axis=0), everything[0, 0], everything[0].mean(axis=0)):
        made = everything - place
        if numbers.length(made) < numbers.length(everything):
            yield _with_coordinates(case, made)
    far = np.round(everything[0, 0])
    if np.abs(far).max() > 1e3:
        yield _with_coordinates(case, everything - far)


def _scaled(case: Case) -> Iterator[Case]:
    """Yield the case at a size near 1, which a power of two brings about."""
    everything = _coordinates(case)
    size = float(np.abs(everything).max(initial=0.0))
    exponent = int(np.frexp(size)[1]) if np.isfinite(size) else 0
    if abs(exponent) > 4:
        thickness = case.thickness and float(np.ldexp(case.thickness, -exponent))
        yield _with_coordinates(case, np.ldexp(everything, -exponent)).change(thickness=thickness)


def _simpler_motion(search: Search[Case]) -> None:
    """Give all coordinates of a vertex at rest one simple value, at all times together."""

    def values(case: Case) -> AnyArray:
        return case.positions_t0

    def change(case: Case, start: AnyArray) -> Case:
        moved = start - case.positions_t0
        return case.change(positions_t0=start, ends=tuple(end + moved for end in case.ends))

    numbers.one_by_one(search, values, change)


def _simpler_array(search: Search[Case], name: str) -> None:
    def values(case: Case) -> AnyArray:
        return np.atleast_1d(np.asarray(getattr(case, name), float))

    def change(case: Case, array: AnyArray) -> Case | None:
        if name == "thickness":
            return case.change(thickness=float(array[0]))
        return case.change(masses=array)

    if name == "masses":
        search.take_first([change(search.best, np.ones_like(values(search.best)))])  # type: ignore[list-item]
    numbers.together(search, values, change)
    numbers.one_by_one(search, values, change)
