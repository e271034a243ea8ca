"""Threads that detect together never read or write what another one writes before they wait."""

import numpy as np
import pytest

from izo_ref.base.serial.thread_group import ALONE
from izo_ref.detection.serial import found_counts as places
from tests.helpers.group_detection import GroupDetection
from tests.helpers.logged import Log, logged
from tests.helpers.shapes import two_sheets

PARTS = "fit", "list_pairs", "list_open_pairs", "list_contacts", "list_impacts"


def scene_of(rng, n):
    """Return two sheets that meet, with some vertices pinned and some at rest."""
    scene = two_sheets(rng, n)
    scene.pinned[:] = rng.random(len(scene.masses)) < 0.7
    still = rng.random(len(scene.masses)) < 0.3
    scene.positions_t1[still] = scene.positions_t0[still]
    return scene


def logs_of(scene, n_threads, parts=PARTS):
    """Run parts of a detection, each by threads of a log of its own; return it and the logs."""
    current = []

    class Current:
        """Hands the accesses to the log of the part that runs."""

        def add(self, *access):
            current[-1].add(*access)

    own = GroupDetection(scene, view=lambda array: logged(array, Current()))
    logs = {}
    for part in parts:
        log = logs[part] = Log(n_threads)
        current.append(log)
        log.run(lambda part=part, log=log: getattr(own, part)(log.group()))
    current.append(Log(1))
    return own, logs


@pytest.mark.parametrize("n_threads", [2, 3, 7])
def test_threads_detect_without_conflicts(rng, n_threads):
    scene = scene_of(rng, 3)
    expected = GroupDetection(scene)
    for part in PARTS:
        getattr(expected, part)(ALONE)
    own, logs = logs_of(scene, n_threads)
    for part, log in logs.items():
        assert log.conflicts() == (0, []), part
    assert np.array_equal(own.counts, expected.counts)
    for column, other in zip(own.found, expected.found, strict=True):
        assert np.array_equal(column, other)
    assert own.counts[places.FOUND] > 8, "the sort merges runs"
    n_pairs, found = own.counts[places.PAIRS], (own.pairs.tolist(), expected.pairs.tolist())
    mine, others = (sorted(pairs[:n_pairs]) for pairs in found)
    assert mine == others


@pytest.mark.parametrize("n_threads", [2, 3, 7])
def test_threads_check_edges_and_faces_at_rest_without_conflicts_or_waits(rng, n_threads):
    scene = scene_of(rng, 3)
    scene.positions_t0[:] = scene.positions_t1  # where the sheets went through each other
    parts = "fit_at_rest", "list_edge_faces", "count_crossings"
    expected = GroupDetection(scene)
    for part in parts:
        getattr(expected, part)(ALONE)
    own, logs = logs_of(scene, n_threads, parts)
    for part, log in logs.items():
        assert log.conflicts() == (0, []), part
    assert not any(logs[part].sites for part in parts[1:])
    assert np.array_equal(own.counts, expected.counts)
    assert own.counts[places.PAIRS] > own.counts[places.OPEN] > 0


def test_no_wait_can_be_left_out(rng):
    _, logs = logs_of(scene_of(rng, 6), 3, ["fit"])
    sites = set(logs["fit"].sites.values()) - {None}
    assert len(sites) == 1
    assert logs["fit"].conflicts(*sites)[0] > 0
    _, logs = logs_of(scene_of(rng, 3), 3)
    sites = set(logs["list_impacts"].sites.values()) - {None}
    assert len(sites) == 2, "those of the sort"
    assert [site for site in sorted(sites) if logs["list_impacts"].conflicts(site)[0] == 0] == []


def test_launches_whose_blocks_may_run_one_after_the_other_do_not_wait(rng):
    _, logs = logs_of(scene_of(rng, 3), 3)
    assert not any(logs[part].sites for part in PARTS[1:4])
