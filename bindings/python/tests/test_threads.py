"""Many calls, from many threads and from forked processes: no leak, no deadlock, one result."""

import multiprocessing
import os
import resource
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scenes import noise

import uvgraft

CALLS = 1000


def resident():
    """Bytes of this process in memory."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def transfer(graft, index):
    """Transfer a texture whose values depend on the index."""
    face = np.full((64, 64, 3), index % 251, np.uint8)
    base = np.zeros((256, 256, 3), np.uint8)
    return graft.apply(face, base)


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs /proc")
def test_a_thousand_calls_leak_nothing(pair):
    graft = uvgraft.Graft(pair, threads=2)
    for index in range(200):
        transfer(graft, index)
    before = resident()
    for index in range(CALLS):
        result = transfer(graft, index)
        assert result[128, 128, 0] == index % 251
    # One result is 196 kB, so a leak of one in ten would show.
    assert resident() - before < 0.1 * CALLS * result.nbytes


def test_failing_calls_leak_nothing(pair):
    graft = uvgraft.Graft(pair)
    face = noise(256, 256, 3)
    base = noise(128, 128, 3)
    out = np.empty((256, 256, 3), np.uint16)
    for _ in range(50):
        with pytest.raises(ValueError):
            graft.apply(face, base, out=out)
    before = resident()
    for _ in range(CALLS):
        with pytest.raises(ValueError):
            graft.apply(face, base, out=out)
    assert resident() - before < 0.1 * CALLS * face.nbytes


def test_four_threads_share_a_graft(pair):
    graft = uvgraft.Graft(pair, threads=2)
    with ThreadPoolExecutor(4) as pool:
        results = pool.map(lambda index: transfer(graft, index)[128, 128, 0], range(CALLS))
        assert list(results) == [index % 251 for index in range(CALLS)]


def test_threads_that_fit_do_not_wait_for_each_other(pair):
    # Each builds the same system on first use.
    graft = uvgraft.Graft(pair, filter="bilinear", size=64, threads=2)
    face = noise(64, 64, 3)
    with ThreadPoolExecutor(4) as pool:
        fits = list(pool.map(lambda _: graft.fit(face, "#000", steps=2).texture, range(8)))
    for fit in fits:
        np.testing.assert_array_equal(fit, fits[0])


def test_results_do_not_depend_on_threads(pair):
    face, base = noise(64, 64, 4), noise(300, 200, 3)
    wanted = uvgraft.Graft(pair, threads=1).apply(face, base)
    for threads in (2, 3, 0):
        np.testing.assert_array_equal(
            uvgraft.Graft(pair).apply(face, base, threads=threads), wanted
        )
    uvgraft.set_threads(1)
    try:
        assert uvgraft.get_threads() == 1
        np.testing.assert_array_equal(uvgraft.Graft(pair).apply(face, base), wanted)
    finally:
        uvgraft.set_threads(0)


def in_child(graft, index):
    """Work in another process."""
    return int(transfer(graft, index)[128, 128, 0])


@pytest.mark.parametrize("how", ["fork", "forkserver", "spawn"])
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_forked_workers(pair, how):
    graft = uvgraft.Graft(pair, threads=2)
    # The parent's threads exist when it forks.
    transfer(graft, 1)
    context = multiprocessing.get_context(how)
    with context.Pool(2) as pool:
        done = pool.starmap_async(in_child, [(graft, index) for index in range(20)])
        assert done.get(timeout=120) == list(range(20))
    assert transfer(graft, 7)[128, 128, 0] == 7


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_forking_while_other_threads_work(pair):
    graft = uvgraft.Graft(pair, threads=2)
    stop = threading.Event()

    def work():
        while not stop.is_set():
            transfer(graft, 3)

    workers = [threading.Thread(target=work) for _ in range(3)]
    for worker in workers:
        worker.start()
    try:
        for index in range(20):
            child = os.fork()
            if child == 0:
                os._exit(0 if transfer(graft, index)[128, 128, 0] == index else 1)
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    finally:
        stop.set()
        for worker in workers:
            worker.join()


def test_the_lock_is_released(pair):
    # A second thread counts while the first works.
    graft = uvgraft.Graft(pair, filter="lanczos3", threads=1)
    face, base = noise(512, 512, 3), noise(2048, 2048, 3)
    graft.apply(face, base)
    counted = 0
    done = threading.Event()

    def work():
        for _ in range(5):
            graft.apply(face, base)
        done.set()

    worker = threading.Thread(target=work)
    worker.start()
    while not done.wait(0.0005):
        counted += 1
    worker.join()
    assert counted > 5
