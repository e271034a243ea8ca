"""Steps of any size: the answer of the same step near 1, bit for bit, or an error that says why."""

import numpy as np
import pytest

import izo_ref
from izo_ref import errors
from tests.helpers import own_scenes, shapes, touching
from tests.helpers.sample import sample
from tests.helpers.seams import seams
from validation.scenes import stored

FLOAT_MAX = 1.79e308
NAMES = ("crumple", "sheets", "stack", "pinch-blocked", "moving-obstacle", "swapped")


def arrays(scene):
    """Return the arguments of a scene."""
    return [
        getattr(scene, name)
        for name in ("positions_t0", "positions_t1", "faces", "masses", "pinned")
    ]


def times(positions, exponent):
    """Return positions times a power of two."""
    with np.errstate(under="ignore"):
        return np.ldexp(positions, exponent)


def resolved(scene, length=0, mass=0, thickness=None):
    """Resolve a scene whose lengths and masses are multiplied by powers of two."""
    start, end, faces, masses, pinned = arrays(scene)
    scaled = izo_ref.Scene(
        times(start, length), times(end, length), faces, times(masses, mass), pinned
    )
    with np.errstate(under="ignore"):
        d = None if thickness is None else float(np.ldexp(thickness, length))
    return izo_ref.resolve(scaled, d)


def random_scene(rng):
    """Return a random step, light or deep."""
    if rng.random() < 0.5:
        return shapes.two_sheets(rng, n=5, gap=float(rng.uniform(0.01, 0.1)))
    return shapes.falling_sheet(2, float(rng.uniform(0.1, 3.0)), n=3)


def assert_same(result, other, length, mass=0):
    """Assert that one result is the other times powers of two."""
    assert result.status is other.status
    assert np.array_equal(result.positions, times(other.positions, length))
    assert np.array_equal(result.impacts.nodes, other.impacts.nodes)
    assert np.array_equal(result.impacts.normals, other.impacts.normals)
    with np.errstate(all="ignore"):
        assert result.objective == np.ldexp(other.objective, 2 * length)
        expected = np.ldexp(other.multipliers, length + mass)
        assert np.array_equal(result.multipliers, expected)
        assert result.thickness == np.ldexp(other.thickness, length)
    assert [r.gap for r in result.residuals] == [r.gap for r in other.residuals]
    assert result.certificate.candidates == other.certificate.candidates
    assert result.certificate.scene.positions_t0 is not other.certificate.scene.positions_t0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("length", sample([-985, -99, 101, 985], 2))
def test_own_scenes_of_any_size_have_the_same_bits(name, length):
    scene = own_scenes.scene(name)
    thickness = stored.thickness(name)
    assert_same(resolved(scene, length, thickness=thickness), own_scenes.result(name), length)


@pytest.mark.parametrize("seed", range(10))
def test_random_steps_of_any_size_have_the_same_bits(seed):
    rng = np.random.default_rng(seed)
    scene = random_scene(rng)
    thickness = None if rng.random() < 0.5 else float(10.0 ** rng.uniform(-5, -2))
    length, mass = int(rng.integers(-900, 901)), 2 * int(rng.integers(-500, 501))
    other = resolved(scene, thickness=thickness)
    assert len(other.impacts.toi)
    assert_same(resolved(scene, length, thickness=thickness), other, length)
    assert_same(resolved(scene, mass=mass, thickness=thickness), other, 0, mass)
    assert_same(resolved(scene, length, mass, thickness), other, length, mass)


@pytest.mark.parametrize("seed", range(3))
def test_masses_times_two_give_the_same_positions_up_to_rounding(seed):
    scene = shapes.two_sheets(np.random.default_rng(seed), n=5)
    other = resolved(scene)
    for mass in (1, -301, 901):
        result = resolved(scene, mass=mass)
        assert result.status is other.status
        assert np.allclose(result.positions, other.positions, rtol=0.0, atol=1e-13)


def one_impact(scale=1.0, masses=None, far=None):
    """Return a step in which a vertex falls through a face, perhaps with one more vertex."""
    start = scale * np.array([[0.2, 0.3, 0.1], [0, 0, 0], [1, 0, 0], [0, 1, 0]])
    end = start.copy()
    end[0, 2] = -end[0, 2]
    for way in () if far is None else [far]:
        start, end = np.vstack((start, way[0])), np.vstack((end, way[1]))
    return izo_ref.Scene(start, end, [[1, 2, 3]], masses)


def test_coordinates_of_1e150_have_the_bits_of_the_same_step_near_1():
    scene = one_impact(1e150)
    result = izo_ref.resolve(scene, 1e146)
    near = izo_ref.Scene(
        times(scene.positions_t0, -498), times(scene.positions_t1, -498), scene.faces
    )
    other = izo_ref.resolve(near, float(np.ldexp(1e146, -498)))
    assert result.status is izo_ref.Status.FREE
    assert np.array_equal(result.positions, times(other.positions, 498))
    after = scene.after(result, result.positions + 1e147)
    assert izo_ref.resolve(after, 1e146).status is izo_ref.Status.FREE


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_results_that_no_float_can_hold_are_infinite_or_zero(scale):
    records = []
    scene = one_impact(scale)
    result = izo_ref.resolve(scene, 1e-4 * scale, on_iteration=records.append)
    assert result.status is izo_ref.Status.FREE
    expected = 0.0 if scale < 1.0 else np.inf
    assert result.objective == expected
    assert izo_ref.resolve(scene).converged
    assert records == result.history
    assert records[-1].objective == expected


@pytest.mark.parametrize("light", [1e-29, 1e-200, 1e-310])
def test_light_vertices_end_where_the_closed_form_says_or_are_refused(light):
    masses = (light, 1.0, 1.0, 1.0)
    if light < 1e-30:
        with pytest.raises(errors.MassError, match=r"at least 7\.89e-31 .* 1 smaller .* vertex 0"):
            one_impact(masses=masses)
        return
    result = izo_ref.resolve(one_impact(masses=masses), 1e-4)
    assert result.status is izo_ref.Status.FREE
    assert len(result.impacts.toi) == 1
    assert np.allclose(result.positions[0], [0.2, 0.3, 1e-4], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("length", [-900, 0, 900])
@pytest.mark.parametrize(
    "far",
    [
        [[FLOAT_MAX] * 3],
        [[-FLOAT_MAX] * 3],
        [[FLOAT_MAX] * 3, [-FLOAT_MAX] * 3],
        [[0.0, -FLOAT_MAX, 0.2]],
        [[FLOAT_MAX] * 3] * 10,
    ],
    ids=["corner", "other-corner", "both", "one-axis", "ten"],
)
def test_unused_vertices_far_out_change_nothing(far, length, first):
    scene = own_scenes.scene("crumple")
    start, end, faces, masses, pinned = arrays(scene)
    n, far = len(start), np.array(far)
    moved = far * 0.5 if length == 0 else far

    def joined(own, more):
        return np.concatenate((more, own) if first else (own, more))

    given = izo_ref.Scene(
        joined(times(start, length), far),
        joined(times(end, length), moved),
        faces + (len(far) if first else 0),
        joined(masses, np.ones(len(far))),
        joined(pinned, np.zeros(len(far), bool)),
    )
    with np.errstate(under="ignore"):
        thickness = float(np.ldexp(stored.thickness("crumple"), length))
    result = izo_ref.resolve(given, thickness)
    own = result.positions[len(far) :] if first else result.positions[:n]
    left = result.positions[: len(far)] if first else result.positions[n:]
    assert np.array_equal(own, times(own_scenes.result("crumple").positions, length))
    assert np.array_equal(left, moved)
    assert result.certificate.candidates == own_scenes.result("crumple").certificate.candidates
    assert len(izo_ref.find_impacts(given).toi) == len(izo_ref.find_impacts(scene).toi)
    assert str(result.plan)


def test_a_vertex_that_comes_from_far_out_is_refused():
    corner = np.full(3, FLOAT_MAX)
    with pytest.raises(errors.SizeError, match=r"within 2\.54e\+30 m.* the first is vertex 4"):
        one_impact(far=(corner, -corner))
    assert izo_ref.resolve(one_impact(far=(corner, corner)), 1e-4).status is izo_ref.Status.FREE


def test_sizes_that_cannot_be_computed_are_refused_by_name():
    with pytest.raises(errors.SizeError, match=r"at most 1\.07e\+301 .* the first is vertex 2"):
        one_impact(1.1e301)
    with pytest.raises(errors.SizeError, match=r"at least 9\.33e-302 .* got one with 9e-302"):
        one_impact(9e-302)
    scene = one_impact(1e300)
    scene.positions_t0[3, 0] = scene.positions_t1[3, 0] = 1.23e-100
    with pytest.raises(errors.SizeError, match=r"1\.23e-100 at vertex 3; set them to 0"):
        izo_ref.resolve(scene, 1e296)
    for thickness in (1e-120, 1e61):
        with pytest.raises(errors.ThicknessError, match=r"from 9\.82e-91 to 3\.21e\+60 \[m\]"):
            izo_ref.resolve(one_impact(), thickness)


@pytest.mark.parametrize("seed", range(10))
def test_zones_of_any_size_have_the_same_bits(seed):
    rng = np.random.default_rng(seed)
    problem = shapes.random_problem(rng, int(rng.integers(1, 20)), mass_ratio=1e4)
    length, mass = int(rng.integers(-900, 901)), 2 * int(rng.integers(-450, 451))
    scaled = izo_ref.ZoneProblem(
        problem.nodes,
        problem.weights,
        problem.normals,
        times(problem.proposed, length),
        times(problem.masses, mass),
        float(np.ldexp(problem.thickness, length)),
    )
    solution, other = izo_ref.solve_zone(scaled), izo_ref.solve_zone(problem)
    assert np.array_equal(solution.positions, times(other.positions, length))
    with np.errstate(all="ignore"):
        assert np.array_equal(solution.multipliers, np.ldexp(other.multipliers, length + mass))
    if abs(length) + abs(mass) < 1000:  # so that the multipliers have all of their digits
        judged = izo_ref.residuals(scaled, solution.positions, solution.multipliers)
        assert judged == solution.residuals
        assert judged.violation_m == np.ldexp(other.residuals.violation_m, length)
        assert judged[1:] == other.residuals[1:]
        arguments = solution.positions, solution.multipliers, solution.displacements
        bound = izo_ref.distance_bound(scaled, *arguments)
        arguments = other.positions, other.multipliers, other.displacements
        expected = izo_ref.distance_bound(problem, *arguments)
        assert bound == pytest.approx(np.ldexp(expected, length + mass // 2), rel=0.1)


@pytest.mark.parametrize("length", [-900, -200, 300, 900])
def test_starts_that_touch_or_coincide_have_the_same_answer_at_any_size(rng, length):
    """Welded seams, and parts that touch or cross at the start."""
    welded = seams(np.random.default_rng(7))
    scenes = [(welded[name], {"weld": 0}) for name in ("soup", "one seam")]
    for seed in range(12):
        start, end, faces, pinned = touching.random_scene(np.random.default_rng(seed))
        mesh = {"positions_t0": start, "positions_t1": end, "faces": faces, "pinned": pinned}
        scenes.append((mesh, {"initial_intersections": "ratchet"}))
    for mesh, options in scenes:
        near = izo_ref.resolve(izo_ref.Scene(**mesh, **options), 1e-3)
        far = {name: np.ldexp(mesh[name], length) for name in ("positions_t0", "positions_t1")}
        scene = izo_ref.Scene(**{**mesh, **far}, **options)
        result = izo_ref.resolve(scene, float(np.ldexp(1e-3, length)))
        assert result.status is near.status
        np.testing.assert_array_equal(result.positions, np.ldexp(near.positions, length))
        np.testing.assert_array_equal(
            result.certificate.excluded_ends, near.certificate.excluded_ends
        )
