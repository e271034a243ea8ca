"""An iteration asks no more of a GPU than the limits say, and with the types that are compiled."""

from importlib.util import find_spec

import numpy as np
import pytest

if find_spec("numba_cuda") is None:
    pytest.skip("needs numba-cuda: izo-ref[cuda]", allow_module_level=True)

from izo_ref.base.cuda import memory
from izo_ref.base.cuda.compile import cuda_kernel
from izo_ref.base.cuda.program import Program
from validation.rows import read
from validation.stand_in import Checked, Driver, Replay, driving
from validation.study import gpu_launches
from validation.study.cuda import run_part
from validation.study.gpu_counts import Counter, Counts, counting, typical
from validation.study.gpu_launches import differences, recorded, replayed
from validation.study.gpu_limits import ARGUMENT_BYTES, LIMITS, exceeded

TRIANGLES = 200


@pytest.fixture(scope="module")
def simulated():
    """Return what a step counts and reads in the simulator."""
    return recorded(TRIANGLES)


def test_no_iteration_exceeds_a_limit(simulated):
    assert len(simulated.counts) > 4, "the making of the step, and several iterations"
    assert exceeded(typical(simulated.counts)) == []
    assert max(part.most_numbers for part in simulated.counts) * 8 <= ARGUMENT_BYTES


def test_the_host_code_of_a_gpu_asks_for_what_the_simulator_asks_for(simulated):
    found = replayed(TRIANGLES, simulated.reads)
    assert differences(simulated.counts, found.counts) == []
    assert found.host_ms[:2] == [None, None]
    assert min(found.host_ms[2:]) > 0.0
    assert len(found.host_ms) == len(found.counts)


def test_counts_of_each_iteration_become_rows(tmp_path, monkeypatch, simulated):
    monkeypatch.setattr(gpu_launches, "COUNTED", (TRIANGLES,))
    monkeypatch.setattr(gpu_launches, "recorded", lambda n: simulated)
    for _ in range(2):  # what is there is not counted again
        assert run_part("launches", tmp_path, lambda _: None) is None
    rows = read(tmp_path, "counts")
    assert [row["iteration"] for row in rows] == list(range(len(simulated.counts)))
    assert gpu_launches.counted_typical(tmp_path)._replace(allocations=0) == typical(
        simulated.counts
    )._replace(allocations=0)


def test_counts_that_differ_are_named(simulated):
    first = simulated.counts[0]
    other = [first._replace(reads=first.reads + 1), *simulated.counts[1:]]
    (said,) = differences(simulated.counts, other)
    assert said == f"iteration 0: reads: expected {first.reads} as in the simulator, got 1"


def test_reads_that_differ_from_those_of_the_simulator_are_noticed(simulated):
    with pytest.raises(ValueError, match="expected 0 bytes as before"):
        replayed(TRIANGLES, [b"", *simulated.reads[1:]])


@pytest.mark.parametrize("name", LIMITS)
def test_more_than_a_limit_is_named(name):
    most = LIMITS[name].most
    own = "nodes" if name == "kernels" else name
    assert exceeded(Counts(**{own: most})) == []
    (said,) = [line for line in exceeded(Counts(**{own: most + 1})) if line.startswith(name)]
    assert f"{most + 1} an iteration" in said


def scale(
    # In:
    factor: float,  # f8
    # Out:
    values_out,  # (n,) f8
):
    """Stand for a kernel."""


@pytest.fixture
def driver():
    """Put a driver in the place of one of a GPU, and a kernel with its launcher."""
    own = Driver()
    with driving(own):
        yield own


@pytest.fixture
def kernel(driver):
    """Return a kernel that nothing compiles."""
    own = cuda_kernel(scale)
    own._dispatcher = Checked("scale", own)
    return own


@pytest.mark.parametrize("can_record", [True, False])
def test_everything_is_counted(driver, kernel, can_record):
    driver.can_record = can_record
    counter = Counter(keeps_reads=True)
    with counting(counter):
        values = memory.empty((5,), np.float64)
        values.copy_to_device(np.arange(5.0))
        kernel[5](2.0, values)
        kernel[0](2.0, values)
        program = Program([kernel.prepare(1, 32, 3.0, values), kernel.prepare(1, 32, 4.0, values)])
        program.run()
        program.run()
        other = memory.empty((5,), np.float64)
        other.copy_to_device(values)
        read = other.copy_to_host()
    others = {"numbers": 8, "most_numbers": 8, "arrays": 2, "allocations": 2, "prepared": 2}
    others |= {"reads": 1, "read_bytes": 40, "sends": 1, "sent_bytes": 40}
    others |= {"copies": 1, "copied_bytes": 40, "recorded": 1}
    if can_record:
        ran = {"launches": 1, "programs": 2, "nodes": 4}
    else:
        ran = {"launches": 5, "numbers": 40}
    assert counter.counts == Counts(**(others | ran))
    assert counter.counts.kernels == 5
    assert counter.read == [read.tobytes()]
    before = counter.counts
    kernel[5](2.0, values)
    assert counter.counts == before, "outside the block nothing is counted"


def test_types_that_are_not_compiled_are_refused(driver, kernel):
    values = memory.empty((5,), np.float32)
    with pytest.raises(TypeError, match="scale: expected types"):
        kernel[5](2.0, values)


def test_a_driver_that_replays_has_nothing_to_read_at_the_end():
    with driving(Replay([])):
        values = memory.empty((5,), np.float64)
        with pytest.raises(ValueError, match="expected 0 bytes as before, got 40"):
            values.copy_to_host()
