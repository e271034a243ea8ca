"""Selection and grouping by a thread group on the CPU, random impacts, and what a step does."""

from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.compile import compiled
from izo_ref.base.options import Options
from izo_ref.base.records import Impacts
from izo_ref.base.serial.thread_group import alone
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.zones import group_buffers as buffers
from izo_ref.zones.serial import group_counts as at
from izo_ref.zones.serial.group_records import SELECTIONS as RULES
from izo_ref.zones.serial.group_records import StepArrays, ZoneImpacts, ZoneRule
from izo_ref.zones.serial.group_select import group_select
from izo_ref.zones.serial.group_zones import group_zones

THICKNESS_M = 0.01
P_STUCK = 0.004  # share of vertices of zones that no positions satisfy
RULE = ZoneRule(every_zone=False, small=1, middle=4)
UNWRITTEN = 1  # integers that nobody wrote; a vertex and an impact that most cases have


class Scene(NamedTuple):
    """The part of a scene that selection and zones read."""

    positions_t0: Any
    positions_t1: Any
    pinned: Any


class Case(NamedTuple):
    """Impacts found on a path, and the state of the vertices."""

    scene: Scene
    found: Any  # Impacts
    stuck: Any
    known_depths: Any


def unwritten(shape, dtype):
    """Return an array of numbers that no result may depend on."""
    return np.full(shape, np.nan if dtype is np.float64 else UNWRITTEN, dtype)


def random_case(rng, n, n_vertices, p_pinned=0.2, n_times=8, edges=1.0):
    """Draw impacts of random vertices, many of them at equal times.

    Args:
        rng: The generator.
        n: Impacts to draw, from which those that have no unpinned vertex of a weight are left out.
        n_vertices: Vertices.
        p_pinned: Share of pinned vertices.
        n_times: Different times of impact.
        edges: How far vertices move, in edges.
    """
    nodes = np.array([rng.choice(n_vertices, 4, replace=False) for _ in range(n)], np.int32)
    kinds, inside = rng.random(n) < 0.5, rng.dirichlet([1.0, 1.0, 1.0], n)
    inside[::2] = rng.multinomial(4, [1 / 3, 1 / 3, 1 / 3], n)[::2] / 4.0
    faces = np.column_stack((np.ones(n), -inside))
    pairs = np.column_stack((inside[:, 0], 1.0 - inside[:, 0], -inside[:, 1], inside[:, 1] - 1.0))
    normals = rng.normal(size=(n, 3))
    found = Impacts(
        nodes.reshape(-1, 4),
        kinds,
        rng.integers(1, n_times + 1, n) / n_times,
        np.where(kinds[:, None], pairs, faces),
        normals / np.linalg.norm(normals, axis=1)[:, None],
    )
    pinned = rng.random(n_vertices) < p_pinned
    has_weight = (np.abs(found.weights) * ~pinned[found.nodes]).any(axis=1)
    start = rng.normal(size=(n_vertices, 3))
    scene = Scene(start, start + edges * rng.normal(size=(n_vertices, 3)), pinned)
    stuck = rng.random(n_vertices) < P_STUCK
    return Case(scene, found.take(has_weight), stuck, np.zeros(n_vertices, np.int32))


class RecordedStep(CpuStep):
    """A step of the CPU that keeps the zones which it is to solve, and solves nothing."""

    to_solve = None

    def __init__(self, case, impacts, **options):
        """Take the state of a case, and the impacts that are in zones already."""
        super().__init__(case.scene, THICKNESS_M, Options(**options), None)  # pyright: ignore
        self.begin(impacts, np.zeros(len(impacts.toi)))
        self.found = case.found
        self.stuck, self.known_depths = case.stuck.copy(), case.known_depths.copy()

    def _solve_zones(self, zones):
        self.to_solve = zones


def step_arrays(impacts: ZoneImpacts, case: Case) -> StepArrays:
    """Return the arrays of a step whose masses nothing reads."""
    (start, end, pinned), masses = case.scene, np.empty(0)
    own = start, end, end, pinned, case.stuck, case.known_depths, masses, masses
    return StepArrays(*impacts, *own, THICKNESS_M)


@compiled
def select_alone(arguments):
    """Select with one thread."""
    group_select(alone(), *arguments)


@compiled
def group_alone(arguments):
    """Group with one thread."""
    group_zones(alone(), *arguments)


class Selection:
    """A selection by a thread group, with all its arrays.

    Args:
        case: The impacts found.
        impacts: The impacts that are in zones already.
        rule: One of RULES.
        room: Most impacts in zones.
        room_found: Most impacts found; as many as there are if None.
    """

    def __init__(self, case, impacts, rule, room, room_found=None):
        """Make the arrays."""
        n_vertices, n = len(case.scene.pinned), len(case.found.toi)
        found = buffers.zone_impacts(n if room_found is None else room_found, unwritten)
        found = Impacts._make(found[:5])
        fits = min(n, len(found.toi))
        for column, values in zip(found, case.found, strict=True):
            column[:fits] = values[:fits]
        self.n_found, self.counts = np.array([n]), np.full(at.N_COUNTS, -1)
        self.impacts = buffers.zone_impacts(room, unwritten)
        for column, values in zip(self.impacts, impacts, strict=False):
            column[: len(values)] = values
        self.counts[at.IMPACTS] = len(impacts.toi)
        self.known_depths = case.known_depths.copy()
        step = step_arrays(self.impacts, case._replace(known_depths=self.known_depths))
        self.vertices = buffers.vertex_labels(len(found.toi), n_vertices, unwritten, np.zeros)
        self.arguments = (
            found,
            self.n_found,
            RULES.index(rule),
            step,
            self.vertices,
            buffers.selection_work(found, n_vertices, unwritten),
            self.counts,
        )

    def has_entered(self, expected):
        """Return whether the impacts in zones are these, and the new ones have no multiplier."""
        n = self.counts[at.IMPACTS]
        own = zip(self.impacts[:5], expected, strict=True)
        new = slice(self.counts[at.FIRST_NEW], n)
        return (
            all(np.array_equal(column[:n], values) for column, values in own)
            and not self.impacts.multipliers[new].any()
            and not self.impacts.active[new].any()
        )


class Grouping:
    """A grouping by a thread group, with all its arrays.

    Args:
        nodes: (n, 4) i4.
        pinned: (n_vertices,) b1.
        stuck: (n_vertices,) b1.
        first_new: The first new impact.
        rule: Which zones are solved.
        room: Most impacts; as many as there are if None.
    """

    def __init__(self, nodes, pinned, stuck, first_new=0, rule=RULE, room=None):
        """Make the arrays."""
        n, n_vertices = len(nodes), len(pinned)
        room = n if room is None else room
        self.stuck, self.counts = stuck.copy(), np.full(at.N_COUNTS, -1)
        self.counts[at.FIRST_NEW], self.counts[at.IMPACTS] = first_new, n
        impacts, positions = buffers.zone_impacts(room, unwritten), np.empty((n_vertices, 3))
        impacts.nodes[:n] = nodes
        scene, known_depths = Scene(positions, positions, pinned), np.zeros(n_vertices, np.int32)
        step = step_arrays(impacts, Case(scene, None, self.stuck, known_depths))
        self.lists = buffers.listed_zones(room, n_vertices, self.counts, unwritten)
        self.vertices = buffers.vertex_labels(room, n_vertices, unwritten, np.zeros)
        self.arguments = (
            step,
            rule,
            self.lists,
            self.vertices,
            buffers.group_work(room, n_vertices, unwritten),
        )

    def zones(self):
        """Return the columns of `Zones`."""
        n, m = self.counts[at.ZONE_IMPACTS], self.counts[at.ZONE_VERTICES]
        ends = self.counts[at.ZONES] + 1
        sizes = n, ends, m, ends
        return [column[:k] for column, k in zip(self.lists[:4], sizes, strict=True)]

    def to_solve(self):
        """Return the small, the middle and the large zones to solve."""
        sizes = self.counts[at.OF_SIZE : at.OF_SIZE + 3]
        assert sizes.sum() == self.counts[at.TO_SOLVE]
        return [row[:n] for row, n in zip(self.lists[4:7], sizes, strict=True)]
