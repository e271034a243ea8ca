"""Threads share the items of a loop."""

import multiprocessing
import threading
import time

import numba
import numpy as np
import pytest

from izo_ref.base.threads import share

TWO = pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="needs two threads")


@pytest.fixture
def on_threads():
    """Set the number of threads in a test."""
    before = numba.get_num_threads()
    yield numba.set_num_threads
    numba.set_num_threads(before)


def count(begin, end, times):
    """Count each item, and wait so long that another thread can take a part."""
    time.sleep(1e-3)
    times[begin:end] += 1


@TWO
@pytest.mark.parametrize("items", [range(0), range(1), range(5, 7), range(3, 1000)])
@pytest.mark.parametrize("threads", [1, 2])
def test_each_item_comes_once(items, threads, on_threads):
    on_threads(threads)
    times = np.zeros(1001, int)
    share(count, items, (times,))
    assert times[items.start : items.stop].all()
    assert times.sum() == len(items)


@TWO
def test_as_many_threads_take_part_as_numba_is_set_to(on_threads):
    for n in (1, 2):
        on_threads(n)
        seen = set()
        meeting = threading.Barrier(n)  # each thread waits for the others

        def note(begin, end, seen=seen, meeting=meeting):
            if threading.get_ident() not in seen:
                meeting.wait(10)
                seen.add(threading.get_ident())

        share(note, range(100), ())
        assert len(seen) == n
        assert threading.get_ident() in seen


@TWO
def test_one_item_runs_on_the_calling_thread(on_threads):
    on_threads(2)
    seen = []
    share(lambda begin, end: seen.append(threading.get_ident()), range(1), ())
    assert seen == [threading.get_ident()]


@TWO
def test_nobody_waits_for_a_thread_that_comes_late(on_threads):
    on_threads(2)
    both, free = threading.Barrier(3), threading.Event()

    def occupy(begin, end):
        both.wait(10)
        free.wait(10)

    other = threading.Thread(target=share, args=(occupy, range(2), ()))
    other.start()
    both.wait(10)  # the helper is in a part of the other thread's launch, and stays there
    times = np.zeros(100, int)
    share(count, range(100), (times,))
    assert (times == 1).all()
    free.set()
    other.join(10)
    assert not other.is_alive()


@TWO
def test_an_error_of_any_thread_is_raised_at_the_end(on_threads):
    on_threads(2)
    done = []

    def fail(begin, end):
        time.sleep(1e-3)
        done.append(end - begin)
        if begin == 0:
            raise ValueError("item 0")

    with pytest.raises(ValueError, match="item 0"):
        share(fail, range(100), ())
    assert sum(done) == 100


@TWO
def test_several_threads_launch_at_the_same_time():
    times = np.zeros((8, 100), int)
    launches = [
        threading.Thread(target=share, args=(count, range(100), (times[k],))) for k in range(8)
    ]
    for launch in launches:
        launch.start()
    for launch in launches:
        launch.join(10)
    assert (times == 1).all()


def share_in_a_child(answers):
    times = np.zeros(100, int)
    share(count, range(100), (times,))
    answers.put(bool((times == 1).all()))


@TWO
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")  # forking with threads is the point
@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="needs fork")
def test_a_forked_process_starts_helpers_of_its_own(on_threads):
    on_threads(2)
    share(count, range(100), (np.zeros(100, int),))
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    child = context.Process(target=share_in_a_child, args=(answers,))
    child.start()
    assert answers.get(timeout=20)
    child.join(20)
