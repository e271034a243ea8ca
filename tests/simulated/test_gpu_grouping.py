"""Selection and zones on the GPU, compared with those on the CPU."""

import numpy as np
import pytest

from izo_ref.base.gpu_arrays import to_cpu, to_gpu
from izo_ref.base.records import Impacts
from izo_ref.zones import grouping as zones
from izo_ref.zones import selection
from izo_ref.zones.gpu_grouping import build_zones
from izo_ref.zones.gpu_selection import find_deep_impacts, select_impacts


class Scene:
    """The part of a scene that zones and the selection read."""

    def __init__(self, pinned, positions_t0=None):
        self.pinned, self.positions_t0 = pinned, positions_t0


def random_impacts(rng, n, n_vertices):
    """Draw impacts of random vertices, some of them at equal times."""
    nodes = np.array([rng.choice(n_vertices, 4, replace=False) for _ in range(n)])
    toi = rng.integers(0, 8, n) / 8.0
    kinds = rng.random(n) < 0.5
    return Impacts(
        nodes.reshape(-1, 4).astype(np.int32), kinds, toi, np.zeros((n, 4)), np.zeros((n, 3))
    )


def on_gpu(impacts):
    """Send impacts to the GPU."""
    return Impacts(*(to_gpu(column) for column in impacts))


@pytest.mark.parametrize("name", ["independent", "first-of-any", "all"])
@pytest.mark.parametrize(("n", "n_vertices"), [(0, 5), (1, 5), (30, 12), (60, 90)])
def test_the_same_impacts_are_selected(rng, name, n, n_vertices):
    impacts, pinned = random_impacts(rng, n, n_vertices), rng.random(n_vertices) < 0.2
    chosen = to_cpu(select_impacts(on_gpu(impacts), to_gpu(pinned), name))
    expected = np.flatnonzero(selection.select_impacts(impacts, pinned, name))
    assert np.array_equal(chosen, expected)


@pytest.mark.parametrize(("n", "n_vertices"), [(0, 5), (1, 5), (30, 12), (60, 90)])
def test_the_same_impacts_are_selected_in_deep_zones(rng, n, n_vertices):
    impacts, pinned = random_impacts(rng, n, n_vertices), rng.random(n_vertices) < 0.2
    inside = rng.dirichlet([1.0, 1.0, 1.0], n)
    edges = np.column_stack((inside[:, 0], 1.0 - inside[:, 0], -inside[:, 1], inside[:, 1] - 1.0))
    faces = np.column_stack((np.ones(n), -inside))
    impacts = impacts._replace(weights=np.where(impacts.is_edge_edge[:, None], edges, faces))
    impacts = impacts.take(~pinned[impacts.nodes].all(axis=1))
    components = zones.build_zones(Scene(pinned), impacts)
    some = np.zeros(len(impacts.toi), bool)
    for zone in range(0, len(components), 2):
        some[components.impacts_of(zone)] = True
    for deep in (some, np.ones(len(some), bool), np.zeros(len(some), bool)):
        own = to_gpu(pinned), "independent", to_gpu(deep)
        chosen = to_cpu(select_impacts(on_gpu(impacts), *own))
        expected = selection.select_impacts(impacts, pinned, "independent", deep)
        assert np.array_equal(chosen, np.flatnonzero(expected))


@pytest.mark.parametrize(("n", "n_vertices"), [(0, 5), (1, 5), (40, 12), (25, 90)])
def test_the_same_zones_are_deep(rng, n, n_vertices):
    impacts, pinned = random_impacts(rng, n, n_vertices), rng.random(n_vertices) < 0.2
    weights, start = rng.normal(size=(n, 4)), rng.normal(size=(n_vertices, 3))
    impacts = impacts._replace(
        weights=weights - weights.mean(axis=1)[:, None], normals=rng.normal(size=(n, 3))
    )
    known, answers = np.zeros(n_vertices, np.int32), set()
    on_device = to_gpu(known)
    for scale in (1.0, 1e3, -1e3):
        for fresh in (True, False):
            if fresh:
                known, on_device = np.zeros(n_vertices, np.int32), to_gpu(0 * known)
            end, before = scale * start, on_gpu(impacts)
            deep = selection.find_deep_impacts(Scene(pinned, start), impacts, end, known)
            state = to_gpu(start), to_gpu(end), to_gpu(pinned), on_device
            assert np.array_equal(to_cpu(find_deep_impacts(before, *state)), deep)
            assert np.array_equal(to_cpu(on_device), known)
            answers.update(deep.tolist())
    assert len(answers) == (0 if n == 0 else 2)


@pytest.mark.parametrize(("n", "n_vertices"), [(1, 5), (30, 12), (25, 90), (60, 200)])
def test_zones_are_those_of_the_cpu(rng, n, n_vertices):
    impacts, pinned = random_impacts(rng, n, n_vertices), rng.random(n_vertices) < 0.3
    impacts.nodes[0] = np.flatnonzero(~pinned)[:4]
    found = build_zones(on_gpu(impacts), to_gpu(pinned))
    expected = zones.build_zones(Scene(pinned), impacts)
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(to_cpu(own), other)


def test_a_chain_is_one_zone(rng):
    n = 40
    ends = rng.permutation(n + 1)
    nodes = np.column_stack((ends[:-1], ends[1:], np.full((n, 2), n + 1)))
    order = rng.permutation(n)
    pinned = np.arange(n + 2) == n + 1
    impacts = random_impacts(rng, n, n + 2)._replace(nodes=nodes[order].astype(np.int32))
    found = build_zones(on_gpu(impacts), to_gpu(pinned))
    assert to_cpu(found.impact_offsets).tolist() == [0, n]
    assert to_cpu(found.vertices).tolist() == list(range(n + 1))
