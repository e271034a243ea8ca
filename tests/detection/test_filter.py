"""The float32 filter never settles a pair that meets, and settles most of the others."""

import numpy as np
import pytest
from numba import float32, njit, types

import izo_ref
from izo_ref.detection.formulas import filter as filter_module
from izo_ref.detection.formulas.filter import (
    CUBIC_ERROR_N,
    CUBIC_ERROR_Q,
    GAP_ERROR,
    INPUT_SHARE,
    LARGEST,
    U,
    differences,
    is_never_coplanar,
    is_surely_apart,
    lowest_gap,
)
from tests.helpers import rounding
from tests.helpers.filtered import (
    boxes_of,
    each_in_its_frame,
    settled_pairs,
)
from tests.helpers.queries import SOURCES, constructed_meetings, queries_of
from tests.helpers.rounding import Bounded, pure
from tests.helpers.steps import load_step
from validation.oracles import path
from validation.scenes import stored
from validation.study.gpu_filter import candidates

VF, EE = False, True
FAR = (1e6, -3e6, 2e6)  # [m]
ONE_FRAME = np.zeros(3), 1.0


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
@pytest.mark.parametrize("together", [True, False])
def test_no_exact_meeting_is_settled(rng, is_edge_edge, together):
    """Flat, grazing and degenerate pairs, of sizes from 2^-11 to 2^22, in one frame and in many."""
    for _ in range(25 if together else 6):
        start, end, _ = constructed_meetings(rng, 4000 if together else 300, is_edge_edge)
        settle = settled_pairs if together else each_in_its_frame
        assert not settle(is_edge_edge, start, end).any()


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
def test_no_exact_meeting_in_a_corner_of_a_large_mesh_is_settled(rng, is_edge_edge):
    """The rounding of the positions is then up to a thousandth of the size of a pair."""
    for extent in (2.0**4, 2.0**8, 2.0**12, 2.0**14):
        for _ in range(6):
            start, end, _ = constructed_meetings(rng, 2000, is_edge_edge)
            size = np.abs((start, end)).max()
            frame = np.array((-0.7, 0.6, -0.9)) * size * extent, 1.0 / (size * extent)
            assert not settled_pairs(is_edge_edge, start, end, frame).any()


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
def test_no_exact_meeting_far_from_the_origin_is_settled(rng, is_edge_edge):
    """The shift by a float on the grid of the pairs is exact, so they still meet."""
    met = 0
    for _ in range(25):
        start, end, _ = constructed_meetings(rng, 2000, is_edge_edge)
        far = start + FAR, end + FAR
        same = ((far[0] - FAR == start) & (far[1] - FAR == end)).all(axis=(1, 2))
        met += same.sum()
        assert not settled_pairs(is_edge_edge, far[0][same], far[1][same]).any()
    assert met > 20_000


def rounded_apart(rng, n, is_edge_edge, size):
    """Draw pairs that go through each other, but whose float32 positions are apart.

    The float32 grid of numbers between 1/2 and 1 has a width of 2^-24. Both sides are in planes
    across a diagonal of space, and the rounded planes are two widths apart along this diagonal.
    Each node is nearly half a width from its rounded position, along all three axes and away from
    its own side. So at the end, the exact planes have passed each other by nearly one width.

    Args:
        rng: draws everything.
        n: number of pairs.
        is_edge_edge: kind of all pairs.
        size: extent of a pair in widths.

    Returns:
        start and end, (n, 4, 3).
    """
    width = 2.0**-24
    signs = rng.choice([-1.0, 1.0], (n, 1, 3))
    flat = rng.integers(-size, size + 1, (n, 4, 2))
    if is_edge_edge:
        flat[:, 1], flat[:, 3] = -flat[:, 0], -flat[:, 2]  # both edges go through the centre
    else:
        flat[:, 0] = np.round(flat[:, 1:].mean(axis=1))
    grid = np.concatenate((flat, -flat.sum(axis=2, keepdims=True)), axis=2) * signs
    side = np.where(np.arange(4) < (2 if is_edge_edge else 1), 1.0, -1.0)[:, None]
    grid += np.where(side > 0.0, signs * (1.0, 1.0, 0.0), 0.0)
    end = 0.5 + 2.0**-8 + width * (grid - side * signs * 0.5 * (1.0 - 2.0**-11))
    return end + np.where(side > 0.0, signs * 2.0**-10, 0.0), end


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
@pytest.mark.parametrize("size", [8, 64, 1024])
def test_no_pair_that_rounding_takes_apart_is_settled(rng, is_edge_edge, size):
    """With 60 % of the bound, the direction of the diagonal would settle every one of them."""
    start, end = rounded_apart(rng, 300, is_edge_edge, size)
    meets = np.array(
        [path.meets(is_edge_edge, a, b) for a, b in zip(start, end, strict=True)], bool
    )
    start, end = start[meets], end[meets]
    assert len(start) > 150
    assert not settled_pairs(is_edge_edge, start, end, ONE_FRAME).any()
    boxes = boxes_of(start.reshape(-1, 3), end.reshape(-1, 3), ONE_FRAME)
    careless = 0
    for rows in boxes.reshape(-1, 4, 9):
        p, q = (tuple(map(tuple, rows[:, part])) for part in (slice(0, 3), slice(3, 6)))
        a, b = differences(is_edge_edge, p), differences(is_edge_edge, q)
        sizes = np.float32(2.0 * np.abs((a, b)).max() + np.abs((p, q)).max())
        gap, _ = lowest_gap(tuple(np.sign(np.subtract(p[0], q[0]))), a, b)
        assert gap <= 3.0 * GAP_ERROR * sizes
        careless += gap > 0.6 * 3.0 * GAP_ERROR * sizes
    assert careless == len(start)


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
@pytest.mark.parametrize("scale", [1.0, 2.0**-18, 2.0**15])
def test_pairs_are_settled_only_if_they_are_apart_in_exact_arithmetic(rng, is_edge_edge, scale):
    """Pairs of a few widths of the float32 grid, whose rounding decides everything."""
    n_apart = n_met = 0
    for spread in (1.0, 1e-3, 1e-6, 3e-7):
        centre = scale * rng.uniform(0.3, 1.0, (150, 1, 3))
        shape = spread * scale * rng.normal(size=(2, 150, 4, 3))
        start, end = centre + shape[0], centre + shape[0] + shape[1]
        settled = settled_pairs(is_edge_edge, start, end, ONE_FRAME)
        for a, b, sure in zip(start, end, settled, strict=True):
            meets = path.meets(is_edge_edge, a, b)
            assert not (sure and meets)
            n_met += meets
        n_apart += settled.sum()
    assert n_apart > 100
    assert n_met > 20


@pytest.mark.parametrize("source", SOURCES)
def test_no_query_that_meets_is_settled(rng, source):
    queries = queries_of(source, rng)
    settled, apart = 0, 0
    for kind in (VF, EE):
        own = queries.vertices[queries.is_edge_edge == kind]
        truth = np.asarray(queries.truth)[queries.is_edge_edge == kind]
        start, end = own[:, :4], own[:, 4:]
        for found in (
            settled_pairs(kind, start, end),
            each_in_its_frame(kind, start, end),
        ):
            assert not (found & truth).any()
            settled += found.sum()
        apart += 2 * (~truth).sum()
    print(f"\n{settled} of {apart} pairs that stay apart are settled")
    assert settled > 0


STEPS = [
    *stored.names("step"),
    *(
        pytest.param(name, marks=pytest.mark.data)
        for name in ("sheets-10k", "stack-6k", "crumple-10k", "cloth-ball-clean", "pinch-free-20k")
    ),
]


@pytest.mark.parametrize("name", STEPS)
def test_no_contact_of_a_step_is_settled(name):
    """So the contacts with and without the filter are the same: `advance` decides all others."""
    scene = load_step(name, initial_intersections="ratchet")
    ends = [scene.positions_t1, 0.5 * (scene.positions_t0 + scene.positions_t1)]
    apart = settled_all = 0
    for end in ends:
        for kind, settled, contact in candidates(scene, end):
            assert not (settled & contact).any(), kind
            apart += (~contact).sum()
            settled_all += settled.sum()
    print(f"\n{settled_all} of {apart} pairs that stay apart are settled")
    assert settled_all >= 0.85 * apart


@pytest.mark.parametrize("is_edge_edge", [VF, EE])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 3e38, 2.0**21, -(2.0**21)])
def test_a_pair_with_a_number_that_is_too_large_is_left_open(is_edge_edge, bad):
    apart = np.array([(0, 0, 1), (0, 0, 0), (1, 0, 0), (0, 1, 0)], np.float32)
    if is_edge_edge:
        apart[1] = (1, 1, 1)
    for first in (True, False):
        for node in range(4):
            for axis in range(3):
                p, q = apart.copy(), apart.copy()
                assert sure(is_edge_edge, p, q)
                (p if first else q)[node, axis] = bad
                assert not sure(is_edge_edge, p, q)
    assert LARGEST == 2.0**20


def sure(is_edge_edge, p, q):
    """Call `is_surely_apart` for two arrays of nodes."""
    return is_surely_apart(is_edge_edge, tuple(map(tuple, p)), tuple(map(tuple, q)))


@pytest.mark.parametrize("scale", [2.0**-100, 2.0**-60, 2.0**-30, 1.0, 2.0**17])
def test_products_that_underflow_settle_nothing_that_meets(rng, scale):
    settled = 0
    for is_edge_edge in (VF, EE):
        start, end, _ = constructed_meetings(rng, 2000, is_edge_edge)
        frame = np.zeros(3), scale / np.abs(start).max()
        assert not settled_pairs(is_edge_edge, start, end, frame).any()
        settled += settled_pairs(is_edge_edge, start, start + (3.0, 0.0, 0.0), frame).sum()
    assert (settled > 0) == (scale > 2.0**-60)


def test_the_bound_of_a_gap_covers_positions_differences_and_the_dot_product(monkeypatch):
    monkeypatch.setattr(rounding, "U", U)
    for reach in (1.0, 1e3, 1e9):  # largest position over the size of a difference
        for n in ((1.0, 0.0, 0.0), (0.25, 0.25, 0.5), (0.3, 0.3, 0.4), (0.0, 0.7, 0.3)):
            direction = tuple(Bounded(abs(x), 0.0, [], x) for x in n)
            error = U + 2.0 * U * reach * (1.0 + 2.0**-28)
            a, b = ((tuple(Bounded(1.0, error, []) for _ in range(3)),) * 4 for _ in range(2))
            gap, _ = pure(lowest_gap)(direction, a, b)
            bound = float(GAP_ERROR) * (2.0 + reach) * sum(n)
            assert 0.7 * bound < gap.error <= bound * (1.0 - 8.0 * U)


def test_the_bound_of_the_cubic_covers_positions_and_determinants(monkeypatch):
    """Also where a rounded position is off by more than the size of the pair."""
    monkeypatch.setattr(rounding, "U", U)
    for reach in (1.0, 1e3, 2.0**23, 2.0**25, 1e9):
        error = U + 2.0 * U * reach * (1.0 + 2.0**-28)
        nodes = [tuple(Bounded(1.0 + error, error, []) for _ in range(3)) for _ in range(6)]
        cubic = pure(filter_module.coefficient_sums)(*nodes)
        m = 1.0 + float(INPUT_SHARE) * reach
        outer = float(CUBIC_ERROR_N) * m**3 + float(CUBIC_ERROR_Q) * reach * 3.0 * m**2
        for c, bound in zip(cubic, (outer, 3.0 * outer, 3.0 * outer, outer), strict=True):
            # `Bounded` leaves out products of two errors; the proof has them in N_k
            assert c.error <= bound * (1.0 - 8.0 * U)
            assert c.error > 0.7 * bound or reach > 1e3


@pytest.mark.parametrize("call", [is_surely_apart, is_never_coplanar])
def test_nothing_is_computed_in_float64(call):
    four = types.UniTuple(types.UniTuple(float32, 3), 4)
    signature = (types.boolean, four, four) if call is is_surely_apart else (four, four, float32)
    called = njit(signature, error_model="numpy", no_cpython_wrapper=True)(call.py_func)
    assert "float" in called.inspect_llvm(called.signatures[0])
    assert "double" not in called.inspect_llvm(called.signatures[0])


def test_the_filter_settles_nearly_all_pairs_of_a_free_path():
    """After a step is resolved, all candidates are apart, and most of them are close."""
    scene = load_step("sheets")
    end = np.ascontiguousarray(izo_ref.resolve(scene, 1e-3).positions)
    apart = total = 0
    for _, settled, contact in candidates(scene, end):
        apart, total = apart + settled.sum(), total + (~contact).sum()
    print(f"\n{apart} of {total}")
    assert apart >= 0.97 * total
