"""Blocks of work: all of the range, each part once, errors not lost."""

import threading

import numpy as np
import pytest

from renderers.threads import BLOCK, Threads


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("count", [0, 1, BLOCK, 5 * BLOCK + 7])
def test_slices_cover_the_range_once(threads, count):
    hits, pool = np.zeros(count, dtype=int), Threads(threads)

    def work(part):
        hits[part] += 1

    pool.over(count, work)
    pool.close()
    assert (hits == 1).all()


def test_two_threads_work_side_by_side():
    both, pool = threading.Barrier(2, timeout=10), Threads(2)
    pool.over(2 * BLOCK, lambda part: both.wait())  # breaks unless two blocks run at once
    pool.close()


def test_an_error_in_a_block_reaches_the_caller():
    def work(part):
        if part.start:
            raise ValueError("bad block")

    pool = Threads(2)
    with pytest.raises(ValueError, match="bad block"):
        pool.over(3 * BLOCK, work)
    pool.close()
