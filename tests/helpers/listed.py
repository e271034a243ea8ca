"""A step whose zones are in lists, as on a GPU, with arrays of the CPU."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.options import Options
from izo_ref.base.records import Impacts
from izo_ref.base.serial.thread_group import ALONE, ThreadGroup
from izo_ref.loop.cpu_step import CpuStep
from izo_ref.loop.serial.update import update
from izo_ref.solvers.interior_point import FARTHEST
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.envelope import dense_tiles
from izo_ref.solvers.serial.group_memory import work_of_group_pivot
from izo_ref.solvers.serial.listed_zones import (
    most_vertices,
    solve_by_all,
    solve_by_group,
    solve_in_slot,
)
from izo_ref.solvers.serial.small_zone import CLOSED_FORM, Limits, work_of_small_zone
from izo_ref.solvers.serial.zone_buffers import ZoneAnswers, ZoneRows
from izo_ref.solvers.serial.zone_rows import write_rows
from izo_ref.zones.grouping import Zones, build_zones
from izo_ref.zones.serial import listed_zones as listed
from izo_ref.zones.serial.group_records import StepArrays
from izo_ref.zones.serial.listed_zones import ListedZones

SPARE = 3  # unused rows behind all arrays
MOST_SMALL, MOST_MIDDLE, MOST_LARGE = 8, 60, 80  # impacts


class ListedStep(NamedTuple):
    """All arrays of a step."""

    scene: Any
    impacts: Impacts
    on_cpu: Zones
    zones: ListedZones
    arrays: StepArrays
    rows: ZoneRows
    answers: ZoneAnswers
    places: Any  # (n_vertices,) i4
    sizes: Any  # (N_SIZES,) i8
    counts: Any  # (N_COUNTS,) i8
    values: Any  # (N_COUNTS,) f8, the same memory
    left: Any  # (n_zones,) i8

    @property
    def state(self):
        """What an update writes."""
        return self.arrays.positions, self.arrays.multipliers, self.arrays.active


def listed_step(problems, room=None) -> ListedStep:
    """Return the step of some zone problems, nothing solved, in arrays with spare room.

    Args:
        problems: Zone problems of the same thickness; infinite masses are pinned vertices.
        room: Zones, impacts and vertices that the solutions have room for; enough if None.
    """
    starts = np.cumsum([0, *(len(p.masses) for p in problems)])
    masses = np.concatenate([p.masses for p in problems])
    pinned = np.isinf(masses)
    scene = SimpleNamespace(
        positions_t1=np.concatenate([p.proposed for p in problems]),
        masses=np.where(pinned, 1.0, masses),
        pinned=pinned,
    )
    nodes = np.concatenate([p.nodes + s for p, s in zip(problems, starts[:-1], strict=True)])
    n = len(nodes)
    of_impacts = (np.concatenate([getattr(p, name) for p in problems]) for name in OF_IMPACTS)
    impacts = Impacts(nodes.astype(np.int32), np.zeros(n, bool), np.zeros(n), *of_impacts)
    zones = build_zones(scene, impacts)
    sizes = np.diff(zones.impact_offsets)
    numbers = np.arange(len(zones))
    lists = [
        numbers[sizes <= MOST_SMALL],
        numbers[(sizes > MOST_SMALL) & (sizes <= MOST_MIDDLE)],
        numbers[sizes > MOST_MIDDLE],
    ]
    counts = np.zeros(listed.N_COUNTS, np.int64)
    counts[listed.OF_STEP], counts[listed.NEEDED], counts[listed.ZONES] = n, n, len(zones)
    counts[listed.IMPACTS], counts[listed.VERTICES] = len(zones.impacts), len(zones.vertices)
    counts[[listed.SMALL, listed.MIDDLE, listed.LARGE]] = [len(own) for own in lists]
    inverse = np.where(pinned, 0.0, 1.0 / np.sqrt(scene.masses))
    arrays = StepArrays(
        *map(_with_room, impacts),
        multipliers=np.zeros(n + SPARE),
        active=np.zeros(n + SPARE, bool),
        start=scene.positions_t1,
        proposed=scene.positions_t1,
        positions=scene.positions_t1.copy(),
        pinned=pinned,
        stuck=np.zeros(len(masses), bool),
        known_depths=np.zeros(len(masses), np.int32),
        masses=np.where(pinned, 0.0, masses),
        inverse_sqrt_masses=inverse,
        thickness=problems[0].thickness,
    )
    of_zones = zones.impacts, zones.impact_offsets, zones.vertices, zones.vertex_offsets
    own_counts = np.full(at.N_COUNTS, -7)
    return ListedStep(
        scene,
        impacts,
        zones,
        ListedZones(*(_with_room(own) for own in (*of_zones, *lists)), counts),
        arrays,
        *buffers(*(room or (len(zones), len(zones.impacts), len(zones.vertices)))),
        np.full(len(masses), -7, np.int32),
        np.full(at.N_SIZES, -7),
        own_counts,
        own_counts.view(np.float64),
        np.full(len(zones) + SPARE, -7),
    )


OF_IMPACTS = "weights", "normals"


def _with_room(values):
    """Return an array with more rows, whose numbers are no indices of anything."""
    rows = np.full((SPARE, *values.shape[1:]), 10**9 if values.dtype.kind == "i" else np.nan)
    return np.concatenate((values, rows.astype(values.dtype)))


def buffers(n_zones, m, n) -> tuple[ZoneRows, ZoneAnswers]:
    """Return room for constraints and solutions, with numbers that nothing should read."""
    flags, numbers = np.ones(m, bool), (np.full(s, np.nan) for s in ((m, 4), (m, 3), m, m, m))
    coefficients, normals, rhs, lengths, multipliers = numbers
    return (
        ZoneRows(
            np.full((m, 4), 10**9, np.int32),
            coefficients,
            normals,
            rhs,
            lengths,
            flags,
            np.full((n, 3), np.nan),
        ),
        ZoneAnswers(
            multipliers,
            np.full(3 * n, np.nan),
            np.ones(n_zones, bool),
            np.full(n_zones, -7, np.int32),
        ),
    )


def limits_of(step, options) -> Limits:
    """Return what counts as solved."""
    violation_m = options.violation_tolerance * step.arrays.thickness
    return Limits(options.gap_tolerance, violation_m, FARTHEST, np.zeros(1, bool))


def write(step, group: ThreadGroup = ALONE):
    """Write the constraints."""
    write_rows(
        group,
        step.zones,
        step.arrays,
        step.rows,
        step.answers,
        step.places,
        step.sizes,
        step.counts,
    )


def solve_small(step, slot=0, n_slots=1, options=None, most=MOST_SMALL, work=None):
    """Solve the small zones of a slot, whose work space fits zones of `most` impacts."""
    n_numbers, n_indices = work_of_small_zone(most, most_vertices(most))
    numbers, indices = work or (np.full(n_numbers, np.nan), np.full(n_indices, -7, np.int32))
    solve_in_slot(
        slot,
        n_slots,
        step.zones.small,
        step.zones.impact_offsets,
        step.zones.vertex_offsets,
        step.sizes,
        step.rows,
        limits_of(step, options or Options()),
        CLOSED_FORM,
        numbers,
        indices,
        step.answers,
    )


def solve_middle(step, group: ThreadGroup = ALONE, options=None, most=MOST_MIDDLE, work=None):
    """Solve the middle zones; the work space fits zones of `most` impacts."""
    numbers, indices = work or work_of_group(most)
    solve_by_group(
        group,
        step.zones.middle,
        step.zones.impact_offsets,
        step.zones.vertex_offsets,
        step.sizes,
        step.rows,
        limits_of(step, options or Options()),
        np.empty(0),
        numbers,
        indices,
        step.answers,
    )


def solve_large(step, group: ThreadGroup = ALONE, options=None, most=MOST_LARGE, work=None):
    """Solve the large zones; the work space fits zones of `most` impacts."""
    numbers, indices = work or work_of_group(most)
    solve_by_all(
        group,
        step.zones.large,
        step.zones.middle,
        step.zones.impact_offsets,
        step.zones.vertex_offsets,
        step.sizes,
        step.rows,
        limits_of(step, options or Options()),
        numbers,
        indices,
        step.answers,
    )


def work_of_group(most=MOST_MIDDLE):
    """Return the work space of a group for zones of `most` impacts."""
    n_numbers, n_indices = work_of_group_pivot(most, most_vertices(most), dense_tiles(most))
    return np.full(n_numbers, np.nan), np.full(n_indices, -7, np.int32)


def take_answers(step, group: ThreadGroup = ALONE):
    """Update the step."""
    update(
        group,
        step.zones,
        step.rows.lengths,
        step.answers,
        step.sizes,
        step.arrays,
        step.left,
        step.counts,
        step.values,
    )


def run(step):
    """Run all parts on one thread, and return the zones that are left, ascending."""
    write(step)
    solve_small(step)
    solve_middle(step)
    solve_large(step)
    take_answers(step)
    return np.sort(step.left[: step.counts[at.LEFT]])


def step_of_cpu(step) -> Any:
    """Return the step of the CPU with the same zones solved."""
    same = CpuStep(step.scene, step.arrays.thickness, Options(), None)
    same.begin(step.impacts, np.zeros(len(step.impacts.toi)))
    same.solve(0)
    return same


def leave_larger_zones(monkeypatch, pivoting):
    """Give the launches for middle and large zones no room for any zone.

    Args:
        monkeypatch: The fixture.
        pivoting: The module `izo_ref/solvers/gpu_pivoting.py`.
    """
    monkeypatch.setattr(pivoting, "work_of_group_pivot", work_without_room)


def work_without_room(n, n_vertices, n_tiles):
    """Return the work space of a group that has no room for any zone."""
    return 1, 1
