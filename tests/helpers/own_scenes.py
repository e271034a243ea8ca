"""The scenes of `data/scenes`; each is read and resolved once for all tests of a run."""

from functools import cache
from typing import Any

import numpy as np

import izo_ref
from validation.scenes import stored

STEPS = stored.names("step")
FREE_STEPS = stored.names("step", "FREE")


@cache
def scene(name) -> izo_ref.Scene:
    """Return a scene of the kind `step`; tests must not change it."""
    return stored.load_step(name)


@cache
def result(name) -> izo_ref.Result:
    """Resolve a step with its recorded thickness."""
    return izo_ref.resolve(scene(name), stored.thickness(name))


@cache
def sequence_results(name) -> list[tuple[izo_ref.Scene, izo_ref.Result]]:
    """Resolve a sequence frame by frame; each step starts where the previous one ended."""
    arrays = stored.load(name)
    start, steps = arrays["positions"][0], []
    for end in arrays["positions"][1:]:
        step = izo_ref.Scene(start, end, arrays["faces"], arrays["masses"], arrays["pinned"])
        steps.append((step, izo_ref.resolve(step, stored.thickness(name))))
        start = steps[-1][1].positions
    return steps


def results(name) -> list[tuple[izo_ref.Scene, izo_ref.Result]]:
    """Return the resolved steps of a scene of either kind."""
    return [(scene(name), result(name))] if name in STEPS else sequence_results(name)


@cache
def zone_of_all_impacts(name) -> izo_ref.ZoneProblem:
    """Return the zone with the most impacts among all impacts of the proposed path."""
    step = scene(name)
    impacts = izo_ref.find_impacts(step)
    zones = izo_ref.build_zones(step, impacts)
    largest = int(np.argmax(np.diff(zones.impact_offsets)))
    return izo_ref.zone_problem(step, impacts, zones, largest, stored.thickness(name))


def pair_key(nodes, is_edge_edge):
    """Return a key that does not depend on the order of corners, ends or the two edges."""
    nodes = [int(node) for node in nodes]
    if is_edge_edge:
        return tuple(sorted((tuple(sorted(nodes[:2])), tuple(sorted(nodes[2:])))))
    return nodes[0], tuple(sorted(nodes[1:]))


def excluded_keys(excluded):
    """Return the keys of excluded pairs, or of None."""
    if excluded is None:
        return set()
    return {pair_key(*pair) for pair in zip(excluded.nodes, excluded.is_edge_edge, strict=True)}


def pair_times(nodes, is_edge_edge, times) -> dict[Any, float]:
    """Return {key of the pair: time}, and check that no pair comes twice."""
    rows = zip(nodes, np.broadcast_to(is_edge_edge, len(nodes)), times, strict=True)
    pairs = {pair_key(row, kind): float(time) for row, kind, time in rows}
    assert len(pairs) == len(nodes)
    return pairs
