"""One zone, solved by every exact method and by gradient descent."""

import numpy as np
import pytest

import izo_ref
from izo_ref.base import errors
from tests.helpers.own_scenes import zone_of_all_impacts
from tests.helpers.shapes import ONE_IMPACT, one_impact_problem, opposed_problem, random_problem
from tests.helpers.steps import load_zone
from tests.naive.qp import dense_rows, solve_qp
from validation.scenes import stored

EXACT_METHODS = ["auto", "active-set", "interior-point"]
APART = [[0, 0, 0.75], [0, 0, 0], [1, 0, 0], [0, 1, 0.0]]


def weighted_distance(zone, a, b):
    """Return the distance of two sets of positions, weighted by mass."""
    return np.sqrt(np.sum(zone.masses[:, None] * (a - b) ** 2))


@pytest.mark.parametrize("method", [*EXACT_METHODS, "gradient"])
def test_one_impact_has_a_closed_form(method):
    one = one_impact_problem()
    k = float(np.sum(one.weights[0] ** 2 / one.masses))
    solution = izo_ref.solve_zone(one, method=method)
    assert solution.multipliers == pytest.approx([1.5 / k], rel=1e-9)
    expected = one.proposed[:, 2] + 1.5 / k * one.weights[0] / one.masses
    np.testing.assert_allclose(solution.positions[:, 2], expected, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(solution.positions[:, :2], one.proposed[:, :2])
    assert solution.residuals.solved(1e-9, 1e-9)


def test_one_impact_takes_the_closed_form():
    assert izo_ref.solve_zone(one_impact_problem()).method == "closed-form"


@pytest.mark.parametrize("method", [*EXACT_METHODS, "gradient"])
def test_a_satisfied_constraint_moves_nothing(method):
    solution = izo_ref.solve_zone(one_impact_problem(proposed=APART), method=method)
    np.testing.assert_array_equal(solution.positions, APART)
    assert solution.multipliers.tolist() == [0.0]


@pytest.mark.parametrize("method", EXACT_METHODS)
@pytest.mark.parametrize("mass_ratio", [1.0, 1e3, 1e6])
def test_solutions_are_the_best_over_all_active_sets(rng, method, mass_ratio):
    compared = 0
    for n in (2, 3, 4, 6, 8):
        for _ in range(4):
            zone = random_problem(rng, n, mass_ratio)
            rows = dense_rows(zone.nodes, zone.weights, zone.normals, len(zone.proposed))
            b = np.full(n, zone.thickness)
            expected = solve_qp(rows, b, zone.masses, zone.proposed)
            found = izo_ref.solve_zone(zone, method=method)
            if expected is None:
                continue
            compared += 1
            scale = weighted_distance(zone, expected, zone.proposed)
            # The oracle solves in unscaled units, so it is the one that loses digits.
            error = weighted_distance(zone, found.positions, expected)
            assert error <= 1e-6 * scale + 1e-15
            assert found.residuals.solved(1e-9, 1e-9)
    assert compared > 10


@pytest.mark.parametrize("method", EXACT_METHODS)
@pytest.mark.parametrize("n", [1, 4, 16, 64, 256])
@pytest.mark.parametrize("mass_ratio", [1.0, 1e6, 1e12])
def test_random_zones_are_solved_to_tolerance(rng, method, n, mass_ratio):
    zone = random_problem(rng, n, mass_ratio)
    solution = izo_ref.solve_zone(zone, method=method)
    assert solution.feasible
    assert solution.residuals.gap <= 1e-9
    assert solution.residuals.violation <= 1e-9
    assert solution.residuals.dual_violation == 0.0


@pytest.mark.parametrize("method", EXACT_METHODS)
def test_redundant_constraints_do_not_change_the_solution(rng, method):
    """40 constraints are duplicates of the first 12."""
    for _ in range(5):
        zone = random_problem(rng, 12)
        repeated = np.concatenate((np.arange(12), rng.integers(0, 12, 40)))
        more = izo_ref.ZoneProblem(
            zone.nodes[repeated],
            zone.weights[repeated],
            zone.normals[repeated],
            zone.proposed,
            zone.masses,
            zone.thickness,
        )
        once = izo_ref.solve_zone(zone, method=method)
        found = izo_ref.solve_zone(more, method=method)
        assert found.residuals.solved(1e-9, 1e-9)
        scale = weighted_distance(zone, once.positions, zone.proposed)
        assert weighted_distance(zone, once.positions, found.positions) <= 1e-5 * scale


@pytest.mark.parametrize("method", EXACT_METHODS)
def test_an_infeasible_zone_is_reported_infeasible(method):
    assert not izo_ref.solve_zone(opposed_problem(0.1), method=method).feasible


@pytest.mark.parametrize("method", [*EXACT_METHODS, "gradient"])
def test_a_constraint_without_unknowns_only_decides_feasibility(method):
    """All its vertices are pinned, so it is satisfied or not whatever the solution is."""
    pinned = one_impact_problem(
        nodes=[[0, 1, 2, 3], [4, 1, 2, 3]],
        weights=ONE_IMPACT["weights"] * 2,
        normals=ONE_IMPACT["normals"] * 2,
        proposed=[*ONE_IMPACT["proposed"], [0, 0, 2.0]],
        masses=[np.inf] * 4 + [1.0],
    )
    assert not izo_ref.solve_zone(pinned, method=method).feasible
    fine = one_impact_problem(
        nodes=[[0, 1, 2, 3], [4, 1, 2, 3]],
        weights=ONE_IMPACT["weights"] * 2,
        normals=ONE_IMPACT["normals"] * 2,
        proposed=[[0, 0, 3.0], *ONE_IMPACT["proposed"][1:], [0, 0, -2.0]],
        masses=[np.inf] * 4 + [1.0],
    )
    solution = izo_ref.solve_zone(fine, method=method)
    assert solution.feasible
    np.testing.assert_allclose(solution.positions[4], [0, 0, 0.5], rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(solution.positions[:4], fine.proposed[:4])


@pytest.mark.parametrize("method", [*EXACT_METHODS, "gradient"])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scaled_units_give_the_scaled_solution(rng, method, scale):
    zone = random_problem(rng, 16)
    scaled = izo_ref.ZoneProblem(
        zone.nodes,
        zone.weights,
        zone.normals,
        scale * zone.proposed,
        1e9 * zone.masses,
        scale * zone.thickness,
    )
    a = izo_ref.solve_zone(zone, method=method)
    b = izo_ref.solve_zone(scaled, method=method)
    np.testing.assert_allclose(b.positions / scale, a.positions, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("method", [*EXACT_METHODS, "gradient"])
def test_a_zone_without_pinned_vertices_keeps_its_momentum(rng, method):
    for n in (1, 8, 100):
        zone = random_problem(rng, n)
        solution = izo_ref.solve_zone(zone, method=method)
        forces = zone.masses[:, None] * (solution.positions - zone.proposed)
        # The rounding is that of positions of about 0.05 m, not of the displacements.
        assert np.abs(forces.sum(axis=0)).max() <= 1e-15 * len(zone.masses)


def test_gradient_descent_converges_to_the_exact_optimum(rng):
    for n in (2, 16, 64):
        zone = random_problem(rng, n)
        exact = izo_ref.solve_zone(zone)
        found = izo_ref.solve_zone(zone, method="gradient")
        scale = weighted_distance(zone, exact.positions, zone.proposed)
        assert weighted_distance(zone, exact.positions, found.positions) <= 1e-5 * scale
        assert found.residuals.gap <= 1e-9


@pytest.mark.parametrize("method", ["auto", "interior-point"])
@pytest.mark.parametrize("angle", [1e-5, 4e-7])
def test_a_narrow_wedge_is_reported_infeasible(method, angle):
    """Two nearly opposed constraints meet two hundred metres away, or five kilometres."""
    zone = izo_ref.ZoneProblem(
        [[0, 1, 2, 3], [0, 1, 2, 3]],
        [[1.0, -0.3, -0.3, -0.4]] * 2,
        [[0, 0, 1.0], [np.sin(angle), 0, -np.cos(angle)]],
        np.zeros((4, 3)),
        [1.0, np.inf, np.inf, np.inf],
        1e-3,
    )
    assert not izo_ref.solve_zone(zone, method=method).feasible


def test_gradient_descent_continues_after_a_step_to_the_minimum(rng):
    for _ in range(20):
        corners = rng.dirichlet([1.0, 1.0, 1.0])
        zone = one_impact_problem(weights=[[1.0, *-corners]], masses=[1.0] * 4)
        found = izo_ref.solve_zone(zone, method="gradient")
        assert found.residuals.solved(1e-9, 1e-9)


@pytest.mark.parametrize("method", [*EXACT_METHODS, "gradient"])
def test_a_zone_without_impacts_moves_nothing(method):
    zone = one_impact_problem(
        nodes=np.empty((0, 4), int), weights=np.empty((0, 4)), normals=np.empty((0, 3))
    )
    solution = izo_ref.solve_zone(zone, method=method)
    np.testing.assert_array_equal(solution.positions, zone.proposed)
    assert solution.residuals.solved(1e-9, 1e-9)


def test_bad_options_are_refused():
    with pytest.raises(errors.OptionError, match="newtonish"):
        izo_ref.solve_zone(one_impact_problem(), method="newtonish")
    with pytest.raises(errors.OptionError, match="line_search"):
        izo_ref.solve_zone(one_impact_problem(), line_search="guess")
    with pytest.raises(errors.OptionError, match="xrtailor"):
        izo_ref.solve_zone(one_impact_problem(), method="interior-point", preset="xrtailor")


@pytest.mark.parametrize(
    "name", [name for name, facts in stored.index().items() if "zone_of_all_impacts" in facts]
)
def test_a_zone_of_all_impacts_has_the_recorded_optimum(name):
    """Many constraints are redundant; the recorded optimum is that of two other solvers."""
    facts, zone = stored.index()[name]["zone_of_all_impacts"], zone_of_all_impacts(name)
    assert len(zone.nodes) == facts["impacts"]
    solution = izo_ref.solve_zone(zone)
    assert solution.residuals.solved(1e-9, 1e-9)
    mass = np.where(np.isfinite(zone.masses), zone.masses, 0.0)
    value = np.sum(mass[:, None] * solution.displacements**2)
    assert value == pytest.approx(facts["sum_m_dx2_kg_m2"], rel=2e-8)


@pytest.mark.data
@pytest.mark.parametrize("name", ["first", "last"])
def test_large_recorded_zones_have_the_recorded_optimum(name):
    """23,958 and 43,036 impacts; another solver gave the recorded optimum of sum m |dx|^2."""
    zone = load_zone(f"zone-armadillo-{name}")
    solution = izo_ref.solve_zone(zone)
    assert solution.residuals.solved(1e-9, 1e-9)
    value = np.sum(zone.masses[:, None] * (solution.positions - zone.proposed) ** 2)
    recorded = {"first": 1.8456319770, "last": 2.3204703848}[name]
    assert value == pytest.approx(recorded, rel=1e-9)
