"""Wrong frames: plausible ports of stage S3, each of which fails three cases of its flag."""

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.judge.outcome import PASSED
from izo_ref.porting.judge.verdict import judge
from tests.helpers.frames import (
    NUMBERS,
    coordinates,
    edges,
    face,
    fractions,
    frame,
    nearest,
    no_side,
    of_fractions,
)

CASES = load_cases(stages=["S3"])


def failing(dtype, parts, chosen=CASES):
    """Return the ids of the cases at which a port with these parts is wrong."""
    found = []
    for case in chosen:
        if dtype in case.dtypes:
            reply = {"status": "ok", "output": frame(case.inputs, dtype, parts)}
            if judge(case, reply, dtype).result != PASSED:
                found.append(case.id)
    return found


def interpolates_first(start, end, time):
    at = (1 - time) * start + time * end
    return at - at[0]


def adds_the_way(start, end, time):
    at = start + time * (end - start)
    return at - at[0]


def extrapolates(x):
    with np.errstate(all="ignore"):
        return np.array([1, *-coordinates(x)], x.dtype)


def clamps_each_coordinate(x):
    with np.errstate(all="ignore"):
        inner = np.clip(coordinates(x), 0, 1)
        return np.array([1, *(-inner / inner.sum())], x.dtype)


def takes_the_corner_behind_two_sides(x):
    with np.errstate(all="ignore"):
        inner = coordinates(x)
    if (inner < 0).sum() == 2:
        weights = np.zeros(4, x.dtype)
        weights[[0, 1 + inner.argmax()]] = 1, -1
        return weights
    return face(x)


def takes_areas_with_the_vertex(x):
    """Return shares of areas that are right only if the vertex is in the plane."""
    sizes = [np.linalg.norm(np.cross(x[i], x[j])) for i, j in ((2, 3), (3, 1), (1, 2))]
    with np.errstate(all="ignore"):
        return np.array([1, *(-np.array(sizes) / sum(sizes))], x.dtype)


def extends_both_edges(x):
    return of_fractions(x, *fractions(x))


def clamps_each_fraction(x):
    return of_fractions(x, *np.clip(fractions(x), 0, 1))


def clamps_the_second_fraction_last(x):
    """Find the second point from the first one, and leave the first one as it is then."""
    s = np.clip(fractions(x)[0], 0, 1)
    return of_fractions(x, s, nearest(x[0] + s * (x[1] - x[0]), x[2], x[3]))


def takes_small_edges_for_parallel(x):
    n = np.cross(x[1] - x[0], x[3] - x[2])
    return edges(x) if n @ n > 1e-14 else of_fractions(x, 0, nearest(x[0], x[2], x[3]))


def fixed_gap(gap, size, length, sides, eps):
    return gap != gap or abs(gap) <= 1e-3


def fixed_area(gap, size, length, sides, eps):
    return not length > 1e-8 or no_side(gap, size, length, sides, eps)


def exact(gap, size, length, sides, eps):
    return not length > 64 * eps * sides or gap == 0


def fixed_tiny_gap(gap, size, length, sides, eps):
    return not length > 64 * eps * sides or abs(gap) <= 1e-14


# A port with each mistake: its flag and the parts that are wrong.
WRONG = [
    ("float32-coordinates", {"nodes_at": interpolates_first}),
    ("float32-coordinates", {"nodes_at": adds_the_way}),
    ("clamped-points", {"face": extrapolates}),
    ("clamped-points", {"face": clamps_each_coordinate}),
    ("clamped-points", {"face": takes_the_corner_behind_two_sides}),
    ("clamped-points", {"face": takes_areas_with_the_vertex}),
    ("clamped-points", {"edges": extends_both_edges}),
    ("clamped-points", {"edges": clamps_each_fraction}),
    ("clamped-points", {"edges": clamps_the_second_fraction_last}),
    ("absolute-tolerance", {"no_side": fixed_gap}),
    ("absolute-tolerance", {"no_side": fixed_area}),
    ("coplanar-motion", {"no_side": exact}),
]


@pytest.mark.parametrize("dtype", NUMBERS)
def test_a_wrong_part_fails_three_cases_of_its_flag(dtype):
    few = {}
    for flag, parts in WRONG:
        failed = failing(dtype, parts, [case for case in CASES if flag in case.flags])
        if len(failed) < 3:
            few[flag, *(part.__name__ for part in parts.values())] = failed
    assert not few


def test_a_fixed_tolerance_below_the_rounding_of_a_large_pair_fails():
    assert "S3-size-11" in failing("f8", {"no_side": fixed_tiny_gap})


def test_an_edge_that_is_small_and_not_parallel_is_not_taken_for_parallel():
    sizes = [case for case in CASES if case.id.startswith("S3-size")]
    assert len(failing("f4", {"edges": takes_small_edges_for_parallel}, sizes)) >= 3


@pytest.mark.parametrize("dtype", NUMBERS)
@pytest.mark.parametrize("tolerance", [4, 64, 1e3, 1e5])
def test_a_tolerance_of_the_gap_relative_to_the_size_may_be_small_or_large(dtype, tolerance):
    def parts(gap, size, length, sides, eps):
        return not length > 64 * eps * sides or abs(gap) <= tolerance * eps * size

    assert not failing(dtype, {"no_side": parts})
