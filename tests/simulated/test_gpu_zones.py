"""The launches that solve the zones of a step and update it, compared with one thread."""

import numpy as np
import pytest

from izo_ref.base.cuda import memory
from izo_ref.base.cuda.compile import Kernel
from izo_ref.base.cuda.launch import type_of
from izo_ref.base.cuda.program import Program
from izo_ref.base.gpu_arrays import empty, full, to_cpu, to_gpu
from izo_ref.base.options import Options
from izo_ref.loop.gpu_zones import launch_to_measure, launches_of_zones, zones_left
from izo_ref.solvers import gpu_pivoting as pivoting
from izo_ref.solvers import gpu_solve as solve
from izo_ref.solvers.serial import group_guess
from izo_ref.solvers.serial import zone_buffers as at
from izo_ref.solvers.serial.envelope import dense_tiles
from izo_ref.zones.gpu_grouping import launch_of_grouping
from izo_ref.zones.group_buffers import listed_zones
from izo_ref.zones.serial import group_counts
from izo_ref.zones.serial import listed_zones as listed
from izo_ref.zones.serial.group_records import StepArrays, ZoneRule
from tests.helpers import listed as helper
from tests.helpers.listed import leave_larger_zones, listed_step, run
from validation import ptx
from validation.scenes.zones import random_zone

SIZES = (1, 9, 2, 3, 61, 1, 10)  # impacts of zones: of all three lists
ENOUGH = (20, 200, 800)
GUESS_STEPS = 2  # so that the test ends soon
pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")


@pytest.fixture(autouse=True)
def _same_limits(monkeypatch):
    monkeypatch.setattr(group_guess, "GUESS_STEPS", GUESS_STEPS)
    monkeypatch.setattr(solve, "SMALL", helper.MOST_SMALL)
    monkeypatch.setattr(pivoting, "LARGEST", helper.MOST_MIDDLE)
    monkeypatch.setattr(pivoting, "TILES_OF_BLOCK", dense_tiles(helper.MOST_MIDDLE))
    monkeypatch.setattr(pivoting, "THREADS", 2)


def a_step():
    """Return a step of a few zones, one with a pinned vertex, and none of them solved."""
    rng = np.random.default_rng(5)
    zones = [random_zone(rng, n, fresh_only=True) for n in SIZES]
    zones[2].masses[0] = np.inf
    return listed_step(zones)


class OnGpu:
    """A step on the GPU, and what solves its zones."""

    def __init__(self, step, room, options=None):
        self.zones, thickness = to_gpu(step.zones), step.arrays.thickness
        self.step = StepArrays(*map(to_gpu, step.arrays[:-1]), thickness)
        self.counts, self.left = full(16, -7, np.int64), empty(room[0], np.int64)
        n = len(step.scene.masses)
        self.solver = solve.ZoneSolver(n, thickness, options or Options(), room)

    def launches(self):
        """Return the launches."""
        return launches_of_zones(self.solver, self.zones, self.step, self.left, self.counts)

    def to_measure(self):
        """Return the launch that measures the step again."""
        return launch_to_measure(self.solver, self.step, self.counts)

    def state(self):
        """Return what an update writes, on the CPU."""
        return [to_cpu(a) for a in (self.step.positions, self.step.multipliers, self.step.active)]


def check_same(own, step):
    """Check that a step on the GPU is that of the CPU, bit by bit."""
    counts = to_cpu(own.counts)
    others = [k for k in range(at.N_COUNTS) if k != at.SQUARES]
    assert np.array_equal(counts[others], step.counts[others])
    squares = counts.view(np.float64)[at.SQUARES]
    np.testing.assert_allclose(squares, step.values[at.SQUARES], rtol=1e-13)
    for found, expected in zip(own.state(), step.state, strict=True):
        assert np.array_equal(found, expected)
    n = step.counts[at.LEFT]
    assert np.array_equal(np.sort(to_cpu(own.left)[:n]), np.sort(step.left[:n]))
    for found, expected in zip(
        zones_left(own.zones, own.left, counts),
        step.on_cpu.part(np.sort(step.left[:n])),
        strict=True,
    ):
        assert np.array_equal(found, expected)


@pytest.mark.parametrize("fits", [True, False])
def test_five_launches_solve_the_zones_and_update_the_step(monkeypatch, fits):
    """Zones for which there is no room are left."""
    step = a_step()
    if not fits:
        leave_larger_zones(monkeypatch, pivoting)
        monkeypatch.setattr(helper, "solve_middle", lambda step: None)
        monkeypatch.setattr(helper, "solve_large", lambda step: None)
    own = OnGpu(step, ENOUGH)
    assert len(run(step)) == (0 if fits else 3)
    assert step.counts[at.SOLVED] == (7 if fits else 4)
    launches = own.launches()
    assert len(launches) == 5
    program = Program(launches)
    for _ in range(2):  # the tickets and the counts begin anew
        program.run()
        check_same(own, step)
        own.step.active.clear()  # larger zones begin at the last solution


def test_a_program_makes_no_arrays_and_reads_nothing(monkeypatch):
    own = OnGpu(a_step(), ENOUGH)
    program = Program(own.launches())

    def refuse(*arguments):
        raise AssertionError(arguments)

    monkeypatch.setattr(memory, "Block", refuse)
    monkeypatch.setattr(memory.DeviceArray, "copy_to_host", refuse)
    monkeypatch.setattr(memory.DeviceArray, "copy_to_device", refuse)
    program.run()


def test_the_arguments_have_the_types_of_the_contracts(monkeypatch):
    own, launched = OnGpu(a_step(), ENOUGH), {}

    def noted(kernel, n_blocks, size, *arguments, shared_bytes=0):
        launched[kernel] = arguments

    monkeypatch.setattr(Kernel, "prepare", noted)
    own.launches()
    own.to_measure()
    assert len(launched) == 6
    for kernel, arguments in launched.items():
        (expected,) = ptx.signatures(kernel).values()
        for argument, kind in zip(arguments, expected, strict=True):
            # no record has equal fields of another name here, so their types say what is compared
            assert str(type_of(argument)) == str(kind), kernel.function.__name__


@pytest.mark.parametrize("full_up", [0, 1, 2])
def test_nothing_is_solved_if_something_does_not_fit(full_up):
    step = a_step()
    counts = step.zones.counts
    needed = counts[[listed.ZONES, listed.IMPACTS, listed.VERTICES]]
    room = [int(n) for n in needed]
    own = OnGpu(step, tuple(room))
    room[full_up] -= 1
    too_little = OnGpu(step, tuple(room))
    for one in (own, too_little):
        Program(one.launches()).run()
    found = to_cpu(too_little.counts)
    assert found[at.SOLVED] == found[at.LEFT] == 0
    assert np.array_equal(to_cpu(too_little.step.positions), step.arrays.proposed)
    run(step)
    check_same(own, step)


def test_a_step_is_measured_again():
    step = a_step()
    own = OnGpu(step, ENOUGH)
    Program(own.launches()).run()
    before = to_cpu(own.counts)
    own.step.positions.copy_to_device(own.step.proposed)
    active = np.zeros_like(step.arrays.active)
    active[step.on_cpu.impacts[:3]] = True
    own.step.active.copy_to_device(active)
    own.to_measure()()
    found = to_cpu(own.counts)
    assert found.view(np.float64)[at.SQUARES] == 0.0
    assert found[at.ACTIVE] == 3
    others = [at.SOLVED, at.LEFT, at.ZONES_NEEDED]
    assert np.array_equal(found[others], before[others])


@pytest.mark.parametrize(
    "chosen", [{"method": "newton"}, {"preset": "icloth"}, {"method": "interior-point"}]
)
def test_other_methods_leave_all_zones(chosen):
    step = a_step()
    own = OnGpu(step, ENOUGH, Options(**chosen))
    launches = own.launches()
    assert len(launches) == 2
    Program(launches).run()
    counts = to_cpu(own.counts)
    assert counts[at.SOLVED] == 0
    for found, expected in zip(zones_left(own.zones, own.left, counts), step.on_cpu, strict=True):
        assert np.array_equal(found, expected)


def test_grouping_and_solving_are_one_program_without_host_reads():
    step = a_step()
    own = OnGpu(step, ENOUGH)
    counts = np.zeros(group_counts.N_COUNTS, np.int64)
    n = len(step.impacts.toi)
    counts[[group_counts.IMPACTS, group_counts.NEEDED_IMPACTS]] = n
    on_gpu = to_gpu(counts)
    rule = ZoneRule(True, own.solver.most_small, own.solver.most_middle)
    own.zones = listed_zones(len(own.step.toi), len(own.step.pinned), on_gpu, empty)
    program = Program([launch_of_grouping(own.step, rule, own.zones), *own.launches()])
    assert len(program.launches) == 6
    program.run()
    run(step)
    check_same(own, step)
