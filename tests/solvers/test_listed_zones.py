"""Zones that are solved from lists, on one thread, compared with the step of the CPU."""

import numpy as np
import pytest

from izo_ref.base.options import Options
from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.serial import listed_zones
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.envelope import dense_tiles
from izo_ref.solvers.serial.group_memory import work_of_group_pivot
from izo_ref.solvers.serial.group_pivot import NO_ROOM
from izo_ref.solvers.serial.small_zone import work_of_small_zone
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.serial import listed_zones as listed
from tests.helpers.listed import (
    MOST_MIDDLE,
    MOST_SMALL,
    listed_step,
    run,
    solve_large,
    solve_middle,
    solve_small,
    step_of_cpu,
    take_answers,
    write,
)
from validation.scenes.zones import THICKNESS_M, random_zone

SIZES = (1, 1, 2, 3, 5, 8, 8, 9, 20, 33, 60, 61, 70)  # impacts of zones: of all three lists


def some_zones(rng, sizes=SIZES, pinned=0.0):
    """Return zones, some of whose vertices are pinned."""
    zones = [random_zone(rng, n, fresh_only=True) for n in sizes]
    for zone in zones:
        zone.masses[rng.random(len(zone.masses)) < pinned] = np.inf
    return zones


def hopeless_zone(rng, number=0):
    """Return a zone of three impacts, in one of which only a vertex of weight 0 could move.

    Args:
        rng: The generator.
        number: The number of this impact.
    """
    zone = random_zone(rng, 1, fresh_only=True)
    masses = np.array([1.0, np.inf, np.inf, np.inf, *zone.masses])
    nodes = np.vstack(([0, 1, 2, 3], [0, 4, 5, 6], zone.nodes + 4))
    weights = np.vstack(([0.0, 1.0, -1.0, 0.0], zone.weights, zone.weights))
    normals = np.vstack(([0.0, 0.0, 1.0], zone.normals, zone.normals))
    proposed = np.vstack((np.zeros((4, 3)), zone.proposed))
    order = np.insert([1, 2], number, 0)
    rows = nodes.astype(np.int32)[order], weights[order], normals[order], proposed, masses
    return ZoneProblem(*rows, zone.thickness)


def all_active_zone(rng, n):
    """Return a zone of n violated impacts, which share one vertex."""
    nodes = 1 + np.arange(3 * n).reshape(n, 3)
    nodes = np.column_stack((np.zeros(n), nodes)).astype(np.int32)
    proposed, masses = np.zeros((3 * n + 1, 3)), np.ones(3 * n + 1)
    weights, normals = np.tile([1.0, -0.3, -0.3, -0.4], (n, 1)), rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return ZoneProblem(nodes, weights, normals, proposed, masses, THICKNESS_M)


@pytest.mark.parametrize("pinned", [0.0, 0.3])
def test_small_zones_end_with_the_bits_of_the_cpu(rng, pinned):
    step = listed_step(some_zones(rng, pinned=pinned))
    left, expected = run(step), step_of_cpu(step)
    small = step.zones.small[: step.zones.counts[listed.SMALL]]
    assert len(small) >= 7
    solved = np.setdiff1d(small, left)
    assert len(solved) >= 7 * (pinned == 0.0)
    for zone in solved:
        own = step.on_cpu.vertices_of(zone)
        assert np.array_equal(step.arrays.positions[own], expected.positions[own])
        own = step.on_cpu.impacts_of(zone)
        assert np.array_equal(step.arrays.multipliers[own], expected.multipliers[own])
        assert np.array_equal(step.arrays.active[own], expected.active[own])


@pytest.mark.parametrize("pinned", [0.0, 0.3])
@pytest.mark.parametrize(("size", "least"), [("middle", 4), ("large", 2)])
def test_larger_zones_end_near_the_cpu(rng, size, least, pinned):
    step = listed_step(some_zones(rng, pinned=pinned))
    left, expected = run(step), step_of_cpu(step)
    own = getattr(step.zones, size)[: step.zones.counts[getattr(listed, size.upper())]]
    solved = np.setdiff1d(own, left)
    assert len(solved) >= least * (pinned == 0.0)
    for zone in solved:
        own = step.on_cpu.vertices_of(zone)
        # Both have a gap of at most 1e-9, so each is within sqrt(2e-9) of the optimum, relative to
        # the distance of the optimum.
        mass = step.arrays.masses[own, None]
        ends = step.arrays.positions[own], expected.positions[own]
        offsets = [end - step.arrays.proposed[own] for end in ends]
        size = np.sqrt((mass * offsets[1] ** 2).sum())
        apart = np.sqrt((mass * (offsets[0] - offsets[1]) ** 2).sum())
        assert apart <= 2.0 * np.sqrt(2e-9) * size
        own = step.on_cpu.impacts_of(zone)
        assert np.array_equal(step.arrays.active[own], step.arrays.multipliers[own] > 0.0)


def test_what_is_left_is_not_touched(rng):
    """These are zones that no positions satisfy, and those without a list."""
    step = listed_step([*some_zones(rng, pinned=0.3), hopeless_zone(rng)])
    step.arrays.positions[:] += 1.0
    step.arrays.multipliers[:], step.arrays.active[:] = 3.0, True
    before = step.arrays.positions.copy()
    unlisted = step.zones.small[0]
    step.zones.small[0] = step.zones.small[1]
    step.zones.small[1] = step.zones.small[step.zones.counts[listed.SMALL] - 1]
    step.zones.counts[listed.SMALL] -= 1
    left, expected = run(step), step_of_cpu(step)
    is_stuck = [expected.stuck[step.on_cpu.vertices_of(z)].any() for z in range(len(step.on_cpu))]
    stuck = np.setdiff1d(np.flatnonzero(is_stuck), [unlisted])
    assert len(stuck) > 0
    assert np.isin(stuck, left).all()
    assert unlisted not in left
    for zone in (*left, unlisted):
        own = step.on_cpu.vertices_of(zone)
        assert np.array_equal(step.arrays.positions[own], before[own])
        own = step.on_cpu.impacts_of(zone)
        assert (step.arrays.multipliers[own] == 3.0).all()
        assert step.arrays.active[own].all()
    n_listed = sum(step.zones.counts[k] for k in (listed.SMALL, listed.MIDDLE, listed.LARGE))
    assert step.counts[at.SOLVED] == n_listed - len(left)


@pytest.mark.parametrize("number", [0, 1, 2])
@pytest.mark.parametrize("size", ["SMALL", "MIDDLE", "LARGE"])
def test_a_hopeless_impact_leaves_its_zone(rng, size, number):
    step = listed_step([hopeless_zone(rng, number), *some_zones(rng, (1, 2))])
    n, zones = len(step.on_cpu), step.zones
    assert step_of_cpu(step).stuck.any()
    lists = {"SMALL": zones.small, "MIDDLE": zones.middle, "LARGE": zones.large}
    lists[size][:n] = np.arange(n)
    zones.counts[[listed.SMALL, listed.MIDDLE, listed.LARGE]] = 0
    zones.counts[getattr(listed, size)] = n
    assert run(step).tolist() == [0]
    assert step.counts[at.SOLVED] == n - 1


def test_constraints_begin_at_the_last_solution(rng):
    """It is scaled as the constraints are; impacts that are not active in it begin at 0."""
    step = listed_step(some_zones(rng))
    assert len(run(step)) == 0
    expected = step.answers.multipliers.copy()
    assert np.count_nonzero(expected) > 20
    step.arrays.multipliers[step.on_cpu.impacts[::3]] = 3.0
    step.arrays.active[step.on_cpu.impacts[::3]] = False
    expected[::3] = 0.0
    write(step)
    # a division by the length and a product with it are rounded
    np.testing.assert_allclose(step.answers.multipliers, expected, rtol=2.0**-52, atol=0.0)


def test_each_part_begins_its_counts_anew(rng):
    step = listed_step(some_zones(rng))
    first = run(step)
    counts, positions = step.counts.copy(), step.arrays.positions.copy()
    step.arrays.active[:] = False  # larger zones begin at the last solution
    assert np.array_equal(run(step), first)
    assert np.array_equal(step.counts, counts)
    assert np.array_equal(step.arrays.positions, positions)
    assert counts[at.ZONES_NEEDED] == len(step.on_cpu)
    assert counts[at.IMPACTS_NEEDED] == len(step.on_cpu.impacts)
    assert counts[at.VERTICES_NEEDED] == len(step.on_cpu.vertices)


@pytest.mark.parametrize("full", ["zones", "impacts", "vertices"])
def test_buffers_that_are_too_small_are_counted_and_not_written(rng, full):
    zones = some_zones(rng, (1, 2, 9, 61))
    enough = listed_step(zones)
    needed = enough.zones.counts[[listed.ZONES, listed.IMPACTS, listed.VERTICES]]
    k = ("zones", "impacts", "vertices").index(full)
    step = listed_step(zones, tuple(n - (i == k) for i, n in enumerate(needed)))
    check_nothing_is_done(step)


@pytest.mark.parametrize(
    "count", ["NEEDED", "ZONES", "SMALL", "MIDDLE", "LARGE", "IMPACTS", "VERTICES"]
)
def test_lists_that_are_not_complete_are_not_used(rng, count):
    step = listed_step(some_zones(rng, (1, 2, 9, 61)))
    k = getattr(listed, count)
    step.zones.counts[k] += 3  # all arrays have room for three more rows
    room = listed.all_fit(step.zones, len(step.arrays.nodes))
    assert room
    step.zones.counts[k] += 1
    check_nothing_is_done(step)


def check_nothing_is_done(step):
    """Run all parts, and check that they only count what is needed."""
    before = [array.copy() for array in (*step.state, *step.rows, *step.answers, step.places)]
    assert len(run(step)) == 0
    after = (*step.state, *step.rows, *step.answers, step.places)
    for own, other in zip(before, after, strict=True):
        assert np.array_equal(own, other, equal_nan=own.dtype.kind == "f")
    assert not step.sizes[: at.TICKET].any()
    assert step.counts[at.SOLVED] == step.counts[at.ACTIVE] == 0
    needed = step.zones.counts[[listed.ZONES, listed.IMPACTS, listed.VERTICES]]
    own = step.counts[[at.ZONES_NEEDED, at.IMPACTS_NEEDED, at.VERTICES_NEEDED]]
    assert np.array_equal(own, needed)


def test_zones_without_work_space_are_left(rng):
    step = listed_step(some_zones(rng, (1, 2, 7, 9, 33, 61)))
    write(step)
    solve_small(step, most=MOST_SMALL - 4)
    solve_middle(step, most=MOST_MIDDLE // 3)
    solve_large(step, most=MOST_MIDDLE // 3)
    take_answers(step)
    sizes = np.diff(step.on_cpu.impact_offsets)
    left = step.left[: step.counts[at.LEFT]]
    assert 0 < len(left) < len(sizes)
    assert sizes[left].tolist() == [7, 33, 61]
    solved = np.setdiff1d(np.arange(len(sizes)), left)
    assert sizes[solved].min() == 1


def test_all_threads_solve_the_middle_zones_that_had_no_room(rng):
    zones = some_zones(rng, (9, 33, 60))
    expected, step = listed_step(zones), listed_step(zones)
    run(expected)
    write(step)
    solve_middle(step, most=MOST_MIDDLE // 3)
    sizes = np.diff(step.on_cpu.impact_offsets)
    assert (step.answers.steps[: len(sizes)] == NO_ROOM).tolist() == (sizes > 9).tolist()
    solve_large(step)
    take_answers(step)
    assert step.counts[at.LEFT] == 0
    assert np.array_equal(step.arrays.positions, expected.arrays.positions)


@pytest.mark.parametrize("missing", [(0, 0), (1, 0), (0, 1)])
@pytest.mark.parametrize(
    ("n", "solve", "work_of"),
    [
        (7, solve_small, work_of_small_zone),
        (
            20,
            solve_middle,
            lambda n, n_vertices: work_of_group_pivot(n, n_vertices, dense_tiles(n)),
        ),
        (61, solve_large, lambda n, n_vertices: work_of_group_pivot(n, n_vertices, dense_tiles(n))),
    ],
)
def test_no_number_of_the_work_space_can_be_missing(rng, n, solve, work_of, missing):
    step = listed_step([all_active_zone(rng, n)])
    sizes = work_of(n, len(step.on_cpu.vertices))
    numbers, indices = (size - short for size, short in zip(sizes, missing, strict=True))
    write(step)
    solve(step, work=(np.full(numbers, np.nan), np.full(indices, -7, np.int32)))
    take_answers(step)
    assert step.counts[at.SOLVED] == (missing == (0, 0))
    assert step.counts[at.LEFT] == (missing != (0, 0))


def test_slots_solve_each_zone_once(rng):
    zones = some_zones(rng, (1, 2, 3, 4, 5, 6, 7))
    steps = [listed_step(zones) for _ in range(2)]
    for step, n_slots in zip(steps, (1, 3), strict=True):
        write(step)
        for slot in range(n_slots):
            solve_small(step, slot, n_slots)
        take_answers(step)
    assert steps[0].counts[at.SOLVED] == len(steps[0].on_cpu)
    assert np.array_equal(steps[0].arrays.positions, steps[1].arrays.positions)


def test_blocks_take_each_zone_once_and_big_ones_first():
    sizes = np.array([300, 20, 257, 256, 400, 9])
    n, taken = len(sizes), []
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    work = np.zeros(at.N_SIZES, np.int64)
    work[at.MIDDLE] = n
    while not taken or taken[-1] >= 0:
        taken.append(listed_zones._next_zone(ALONE, np.arange(n), offsets, work))
    assert taken == [0, 2, 4, 1, 3, 5, -1]
    assert listed_zones._next_zone(ALONE, np.arange(n), offsets, work) == -1


def test_limits_are_those_of_the_options(rng):
    """No answer of a middle zone has a gap of 0."""
    step = listed_step(some_zones(rng, (20, 33)))
    write(step)
    solve_middle(step, options=Options(gap_tolerance=0.0, violation_tolerance=0.0))
    take_answers(step)
    strict = step.counts[at.LEFT]
    run(step)
    assert step.counts[at.LEFT] == 0
    assert strict > 0
