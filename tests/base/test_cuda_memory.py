"""Memory of a GPU and launches by the driver, with a driver that works in the memory of the CPU."""

import ctypes
import gc
from types import SimpleNamespace

import numpy as np
import pytest
from numba.core import types

pytest.importorskip("numba_cuda", reason="numba-cuda is not installed: izo-ref[cuda]")

from izo_ref.base.cuda import launch, memory, program
from izo_ref.base.errors import DeviceMemoryError
from izo_ref.detection.serial.tree import Tree
from validation.stand_in import ILLEGAL_ADDRESS, Code, Driver


@pytest.fixture
def driver(monkeypatch):
    own = Driver()
    monkeypatch.setattr(memory, "driver", own)
    monkeypatch.setattr(launch, "driver", own)
    monkeypatch.setattr(program, "driver", own)
    monkeypatch.setattr(program.config, "ENABLE_CUDASIM", 0)
    monkeypatch.setattr(memory, "unused_blocks", [])
    context = SimpleNamespace(get_memory_info=lambda: (own.left, 1 << 20))
    monkeypatch.setattr(memory.cuda, "current_context", lambda: context)
    return own


def sent(values):
    """Return a copy of an array in the memory of the driver."""
    array = memory.empty(values.shape, values.dtype)
    array.copy_to_device(np.ascontiguousarray(values))
    return array


@pytest.mark.parametrize("dtype", ["f8", "f4", "i8", "i4", "i1", "b1"])
@pytest.mark.parametrize("shape", [(5,), (4, 3), (2, 3, 4), (0,), (0, 3), (3, 0)])
def test_arrays_come_back_as_they_were_sent(driver, rng, dtype, shape):
    values = rng.integers(0, 100, shape).astype(dtype)
    array = sent(values)
    back = array.copy_to_host()
    assert back.dtype == values.dtype
    assert np.array_equal(back, values)
    assert (array.shape, array.ndim, array.size) == (values.shape, values.ndim, values.size)
    assert not values.size or array.strides == values.strides


def test_rows_shapes_and_views_share_the_memory(driver, rng):
    values = rng.random((6, 2))
    array = sent(values)
    assert np.array_equal(array[1:4].copy_to_host(), values[1:4])
    assert np.array_equal(array[4:].copy_to_host(), values[4:])
    assert array[3:2].shape == (0, 2)
    assert np.array_equal(array.reshape(4, 3).copy_to_host(), values.reshape(4, 3))
    assert np.array_equal(array.reshape((12,)).copy_to_host(), values.reshape(12))
    assert np.array_equal(array.view(np.int64).copy_to_host(), values.view(np.int64))
    array[2:3].copy_to_device(array[5:])
    assert np.array_equal(array.copy_to_host()[2], values[5])
    with pytest.raises(ValueError, match="step of 2"):
        array[::2]


def test_an_array_is_cleared(driver, rng):
    array = sent(rng.random((4, 3)))
    array[1:3].clear()
    assert (array.copy_to_host() == 0.0).all(axis=1).tolist() == [False, True, True, False]
    memory.empty((0, 3), np.float64).clear()


def test_memory_lives_as_long_as_a_view_of_it(driver):
    array = memory.empty((100,), np.float64)
    address, rows = array.address, array[50:]
    del array
    gc.collect()
    other = memory.empty((100,), np.float64)
    assert {address, other.address} == set(driver.blocks)
    del rows
    gc.collect()
    assert address in driver.blocks, "nothing is given back at any moment"
    another = memory.empty((110,), np.float64)
    assert {other.address, another.address} == set(driver.blocks)


@pytest.mark.parametrize("n", [0, 1, 511, 512, 513, 1000])
def test_a_block_is_as_large_as_asked(driver, n):
    array = memory.empty((n,), np.int8)
    assert len(driver.blocks[array.address]) == max(n, 1), "the driver gives no empty blocks"


def test_unused_blocks_are_given_back_before_memory_runs_out(driver):
    arrays = [memory.empty((1 << 17,), np.int8) for _ in range(6)]
    del arrays
    gc.collect()
    assert driver.left < 1 << 19
    assert memory.empty((1 << 19,), np.int8).size == 1 << 19


def test_blocks_of_another_driver_are_not_given_back_to_this_one(driver, monkeypatch):
    array = memory.empty((3,), np.float64)
    monkeypatch.setattr(memory, "unused_blocks", [])
    del array
    gc.collect()
    memory.empty((3,), np.float64)
    assert len(driver.blocks) == 2


def test_missing_memory_is_reported_with_its_size(driver):
    with pytest.raises(DeviceMemoryError, match="24 MiB more are needed, 1 of 1 MiB are free"):
        memory.empty((1 << 20, 3), np.float64)


def test_other_errors_of_the_driver_are_passed_on(driver, monkeypatch):
    monkeypatch.setattr(driver, "cuMemAlloc", lambda n: (Code(ILLEGAL_ADDRESS), None))
    with pytest.raises(memory.CudaAPIError, match="OTHER"):
        memory.empty((3,), np.float64)


class Dispatcher:
    """A dispatcher of numba whose kernels are names of their types."""

    def __init__(self, cooperative=False):
        self.compiled, self.cooperative = {}, cooperative

    def compile(self, signature):
        """Return the kernel for some types, which numba compiles once."""
        if signature not in self.compiled:
            function = SimpleNamespace(handle=len(self.compiled) + 1)
            self.compiled[signature] = SimpleNamespace(
                bind=lambda: None,
                cooperative=self.cooperative,
                _codelibrary=SimpleNamespace(get_cufunc=lambda: function),
            )
        return self.compiled[signature]

    def prepare(self, n_blocks, size, shared_bytes, *arguments):
        """Return a launch of the kernel."""
        return launch.Launch(self, n_blocks, size, shared_bytes, arguments)

    def types(self):
        """Return the types of the first kernel."""
        return next(iter(self.compiled))


def read(places, c_types):
    """Read the arguments of a launch as the driver would."""
    addresses = ctypes.cast(places, ctypes.POINTER(ctypes.c_void_p))
    return [kind.from_address(addresses[i]).value for i, kind in enumerate(c_types)]


ARRAY = 5 * (ctypes.c_int64,)


def test_arguments_are_where_the_driver_looks_for_them(driver, rng):
    dispatcher = Dispatcher()
    values, flags = sent(rng.random((7, 3))), sent(np.ones(4, bool))
    own = np.int8(-5), values, True, 2.5, flags, 1 << 40, np.float32(0.25)
    run = dispatcher.prepare(3, 128, 64, *own)
    run()
    ((handle, sizes, places),) = driver.launches
    assert handle == 1
    assert sizes == (3, 1, 1, 128, 1, 1, 64, 0)
    c = ctypes
    c_types = c.c_int8, *ARRAY, *4 * (c.c_int64,), c.c_bool, c.c_double, *ARRAY
    c_types += *2 * (c.c_int64,), c.c_int64, c.c_float
    assert read(places, c_types) == [
        -5,
        *(0, 0, 21, 8, values.address, 7, 3, 24, 8),
        True,
        2.5,
        *(0, 0, 4, 1, flags.address, 4, 1),
        1 << 40,
        0.25,
    ]
    expected = "int8", "array(float64, 2d, C)", "bool", "float64", "array(bool, 1d, C)"
    assert tuple(map(str, dispatcher.types())) == (*expected, "int64", "float32")


def test_records_are_handed_over_field_by_field(driver, rng):
    dispatcher = Dispatcher()
    tree = Tree(
        *(sent(np.zeros(s, t)) for s, t in (((3,), "i4"), ((3, 2), "i4"), ((1, 2), "f4"))),
        *(sent(np.zeros(s, t)) for s, t in (((1, 2), "f4"), ((2,), "i8"))),
    )
    run = dispatcher.prepare(1, 32, 0, tree, 5)
    run()
    addresses = ctypes.cast(driver.launches[0][2], ctypes.POINTER(ctypes.c_void_p))
    starts = np.cumsum([0, *(5 + 2 * column.ndim for column in tree)])
    found = [ctypes.c_int64.from_address(addresses[int(k) + 4]).value for k in starts[:-1]]
    assert found == [column.address for column in tree]
    assert ctypes.c_int64.from_address(addresses[int(starts[-1])]).value == 5
    record = dispatcher.types()[0]
    assert isinstance(record, types.NamedTuple)
    assert record.instance_class is Tree


def test_a_kernel_is_compiled_once_for_each_combination_of_types(driver):
    dispatcher = Dispatcher()
    numbers, rows = sent(np.zeros(3)), sent(np.zeros((3, 1)))
    for arguments in ((numbers, 1), (numbers, 2), (rows, 1), (numbers, 1.0), (rows, 7)):
        dispatcher.prepare(1, 1, 0, *arguments)()
    assert len(dispatcher.compiled) == 3
    assert [handle for handle, *_ in driver.launches] == [1, 1, 2, 3, 2]


def test_strided_arrays_of_others_are_told_apart(driver):
    dispatcher = Dispatcher()
    own = sent(np.zeros((4, 3)))
    strided = memory.DeviceArray(own.address, (4, 2), own.dtype, own, (24, 8))
    dispatcher.prepare(1, 1, 0, strided)
    assert str(dispatcher.types()[0]) == "array(float64, 2d, A)"
    assert strided.__cuda_array_interface__["strides"] == (24, 8)


def test_kernels_that_wait_for_all_blocks_are_launched_together(driver):
    Dispatcher(cooperative=True).prepare(2, 32, 0)()
    assert driver.launches[0][0] == ("cooperative", 1)


def test_much_shared_memory_is_asked_for_once(driver):
    dispatcher = Dispatcher()
    for n_bytes in (0, 48 << 10, 60 << 10, 50 << 10, 90 << 10):
        dispatcher.prepare(1, 32, n_bytes)
    assert driver.asked == [60 << 10, 90 << 10]


def test_prepared_launches_keep_their_arguments(driver, rng):
    own = Dispatcher()
    first, second = (own.prepare(2, 32, 0, sent(rng.random(3)), k) for k in (1, 2))
    own.prepare(1, 32, 0, sent(rng.random(4)), 3)()
    gc.collect()
    first(), second(), first()
    c_types = *ARRAY, *2 * (ctypes.c_int64,), ctypes.c_int64
    found = [read(places, c_types) for *_, places in driver.launches[1:]]
    assert [numbers[-1] for numbers in found] == [1, 2, 1]
    assert found[0] == found[2]
    assert all(numbers[4] in driver.blocks for numbers in found), "the arrays are alive"
    assert [sizes for _, sizes, _ in driver.launches[1:]] == 3 * [(2, 1, 1, 32, 1, 1, 0, 0)]


@pytest.mark.parametrize("can_record", [True, False])
def test_a_program_runs_its_launches_in_their_order(driver, can_record):
    driver.can_record = can_record
    kernel = Dispatcher()
    own = program.Program([kernel.prepare(k, 32, 0, 1.0) for k in (3, 1, 2)])
    assert driver.launches == [], "recording runs nothing"
    own.run()
    own.run()
    assert [sizes[0] for _, sizes, _ in driver.launches] == [3, 1, 2, 3, 1, 2]
    assert len(driver.started) == (2 if can_record else 0)
    del own
    gc.collect()
    assert driver.graphs == {}
