"""Block pivoting by a thread group: its answer is optimal, or it reports that it has none."""

from typing import NamedTuple

import numpy as np
import pytest

from izo_ref.base.arrays import Flags, Floats, Ints
from izo_ref.base.serial.thread_group import ALONE
from izo_ref.solvers.scaled_constraints import scale_constraints
from izo_ref.solvers.serial import group_pivot as pivoting
from izo_ref.solvers.serial.constraints import residuals
from izo_ref.solvers.serial.envelope import SIDE, dense_tiles
from izo_ref.solvers.serial.group_memory import memory_of, vector_size, work_of_group_pivot
from izo_ref.solvers.serial.group_pivot import group_pivot
from izo_ref.solvers.serial.group_zone import Zone, link_entries, product, pull
from izo_ref.solvers.serial.small_zone import Limits
from izo_ref.solvers.solve import solve_zone
from izo_ref.zones.problem import ZoneProblem
from izo_ref.zones.system import problem_system
from validation.scenes.piles import chain_zone, pinch_zone, stack_zone
from validation.scenes.zones import THICKNESS_M, random_zone

TOLERANCE = 1e-9
NEVER: Flags = np.zeros(1, bool)
LIMITS = Limits(TOLERANCE, TOLERANCE * THICKNESS_M, 1e4, NEVER)


class Pivoted(NamedTuple):
    """What a group returns for a zone, and the residuals of its answer."""

    solved: bool
    solves: int
    multipliers: Floats
    displacements: Floats  # (n_unpinned, 3)
    violation_m: float
    gap: float


def pivoted(
    zone: ZoneProblem,
    most_active: int = 10_000,
    near_size: int = 0,
    limits: Limits = LIMITS,
    last_solution: Floats | None = None,
) -> Pivoted:
    """Solve a zone by a group of one thread, whose factor has room for `most_active` dense rows."""
    system, _ = problem_system([zone])
    rows, n = scale_constraints(system), len(zone.nodes)
    last = int(system.vertex_offsets[1])
    own = rows.unknowns, rows.coefficients, system.normals, rows.rhs, rows.lengths
    n_numbers, n_indices = work_of_group_pivot(n, last, dense_tiles(min(n, most_active)))
    work: tuple[Floats, Floats, Ints] = (
        np.full(near_size, np.nan),
        np.full(n_numbers, np.nan),
        np.full(n_indices, -7, np.int32),
    )
    u = np.zeros(n) if last_solution is None else last_solution.copy()
    z, positions = np.full(3 * last, np.nan), system.proposed[:last]
    solved, solves = group_pivot(ALONE, 0, n, 0, last, *own, positions, limits, *work, u, z)
    violation_m, gap = residuals(0, *own, u, z)
    displacements = z.reshape(-1, 3) / np.sqrt(system.masses[:last])[:, None]
    return Pivoted(solved, solves, u, displacements, violation_m, gap)


def families(rng):
    """Yield zones with the structure of contacts, by a name."""
    for n in (1, 2, 33, 120):
        yield f"fresh {n}", random_zone(rng, n, fresh_only=True)
        yield f"chain {n}", chain_zone(rng, n)
    yield "pinch", pinch_zone(rng, 40)
    yield "stack", stack_zone(rng, 3, 5)
    yield "higher stack", stack_zone(rng, 5, 6)


def test_answers_keep_the_tolerances_and_are_those_of_the_processor(rng):
    for name, zone in families(rng):
        found, expected = pivoted(zone), solve_zone(zone)
        assert found.solved, name
        assert found.multipliers.min() >= 0.0, name
        assert found.violation_m <= LIMITS.violation, name
        assert found.gap <= TOLERANCE, name
        # Both have a gap of at most 1e-9, so each is within sqrt(2e-9) of the optimum, relative to
        # the distance of the optimum.
        free = np.isfinite(zone.masses)
        mass, other = zone.masses[free, None], expected.displacements[free]
        size = np.sqrt((mass * other**2).sum())
        apart = np.sqrt((mass * (found.displacements - other) ** 2).sum())
        assert apart <= 2.0 * np.sqrt(2.0 * TOLERANCE) * size, name


def test_each_zone_is_solved_or_reported_unsolved(rng):
    """The constraints are nearly parallel, duplicated and opposed, as no real ones are."""
    answers = [pivoted(random_zone(rng, 40, 1e12)) for _ in range(60)]
    for number, found in enumerate(answers):
        if found.solved:
            assert found.multipliers.min() >= 0.0, number
            assert found.violation_m <= LIMITS.violation, number
            assert found.gap <= TOLERANCE, number
    assert {found.solved for found in answers} == {True, False}, "both occur in such zones"


@pytest.mark.parametrize("near_size", [100, 2_000, 100_000])
def test_near_memory_changes_no_bit(rng, near_size):
    """The vectors and the factor are in far memory, or the vectors are near, or both are."""
    zone = stack_zone(rng, 4, 6)
    found, expected = pivoted(zone, near_size=near_size), pivoted(zone)
    assert found.solved
    assert np.array_equal(found.multipliers, expected.multipliers)
    assert np.array_equal(found.displacements, expected.displacements)


def test_a_zone_whose_factor_does_not_fit_is_left(rng):
    """The impacts of this zone share vertices with many others, so its factor is dense."""
    zone = random_zone(rng, 60, fresh_only=True)
    found = pivoted(zone)
    n_active = int(np.count_nonzero(found.multipliers))
    assert found.solved
    assert pivoted(zone, most_active=n_active).solved
    assert not pivoted(zone, most_active=n_active - SIDE).solved


def test_a_long_zone_needs_little_room(rng):
    """The factor of a chain is narrow, in whichever order its impacts are numbered."""
    zone = chain_zone(rng, 400)
    order = rng.permutation(len(zone.nodes))
    own = zone.nodes[order], zone.weights[order], zone.normals[order], zone.proposed, zone.masses
    for one in (zone, ZoneProblem(*own, zone.thickness)):
        assert np.count_nonzero(pivoted(one).multipliers) > 6 * SIDE
        assert pivoted(one, most_active=6 * SIDE).solved


def test_the_last_solution_saves_solves(rng):
    zone = stack_zone(rng, 6, 9)
    found = pivoted(zone)
    again = pivoted(zone, last_solution=found.multipliers)
    assert found.solved
    assert again.solved
    assert again.solves < found.solves
    assert again.gap <= TOLERANCE


def test_a_satisfied_zone_stays_where_it_is(rng):
    zone = chain_zone(rng, 5)
    own = zone.nodes, zone.weights, zone.normals, solve_zone(zone).positions, zone.masses
    found = pivoted(ZoneProblem(*own, 0.5 * zone.thickness))
    assert (found.solved, found.solves) == (True, 0)
    assert not found.multipliers.any()
    assert not found.displacements.any()


def test_an_infeasible_zone_is_reported_unsolved():
    """A vertex between two pinned faces that are nearer to each other than twice the thickness."""
    nodes = np.array([[3, 0, 1, 2], [3, 0, 1, 2]], np.int32)
    weights = np.tile([1.0, -1 / 3, -1 / 3, -1 / 3], (2, 1))
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    proposed = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1 / 3, 1 / 3, 0]])
    masses = np.array([np.inf, np.inf, np.inf, 1.0])
    assert not pivoted(ZoneProblem(nodes, weights, normals, proposed, masses, THICKNESS_M)).solved


def test_an_answer_that_is_too_far_off_counts_as_unsolved(rng):
    zone = random_zone(rng, 40, fresh_only=True)
    assert pivoted(zone).solved
    assert not pivoted(zone, limits=LIMITS._replace(farthest=1e-3)).solved


def test_gap_and_violation_are_judged_apart(rng):
    """The guess begins far off, so the loose limits end before the strict ones are reached."""
    strict, loose, n_between = 1e-12, 1e-2, 0
    for _ in range(5):
        zone = pinch_zone(rng, 40)
        own = {"last_solution": np.full(len(zone.nodes), 100.0)}
        limits = [
            LIMITS._replace(gap=gap, violation=violation * THICKNESS_M)
            for gap, violation in ((loose, loose), (strict, loose), (loose, strict))
        ]
        found, exact, feasible = (pivoted(zone, limits=one, **own) for one in limits)
        n_between += min(found.gap, found.violation_m / THICKNESS_M) > strict
        assert not exact.solved or exact.gap <= strict
        assert not feasible.solved or feasible.violation_m <= strict * THICKNESS_M
        assert found.solved
    assert n_between > 0


@pytest.mark.parametrize("scale", [0.0, 1.0])
def test_residuals_are_those_of_a_small_zone(rng, scale):
    """One thread adds the same terms in the same order."""
    for n in (1, 2, 40):
        system, _ = problem_system([random_zone(rng, n, fresh_only=True)])
        rows, last = scale_constraints(system), int(system.vertex_offsets[1])
        work = np.zeros(vector_size(n, last)), np.zeros(12 * n + 4 * last + 9, np.int32)
        memory = memory_of(n, last, *work)
        own = rows.unknowns, rows.coefficients, system.normals, rows.rhs
        lists = np.full(last, -7, np.int32), np.full(4 * n, -7, np.int32)
        zone = Zone(ALONE, 0, *own, *lists)
        link_entries(zone)
        memory.u[:] = scale * rng.random(n)
        pull(zone, memory.u, memory.z)
        memory.products[:] = [product(zone, j, memory.z) for j in range(n)]
        *found, norm = pivoting._residuals(zone, memory)
        expected = residuals(0, *own, np.ones(n), memory.u, memory.z)
        assert found == list(expected)
        # both sums of squares have `3 last` terms, which are not negative
        assert abs(norm - np.linalg.norm(memory.z)) <= (3 * last + 2) * 2.0**-52 * norm
