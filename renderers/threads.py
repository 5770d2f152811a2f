"""Work on blocks of pixels, spread over the threads that a renderer may use.

Kernels that let go of Python's lock (``nogil``) run side by side. A block's result depends on nothing but its
own pixels, so it is the same, bit by bit, for any number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

BLOCK = 4096
"""Pixels at a time: what a step leaves for the next one stays in a core's cache."""


class Threads:
    """A number of threads, 0 for all cores; one means the caller's own."""

    def __init__(self, count: int = 1) -> None:
        count = count or len(os.sched_getaffinity(0))
        self._pool = ThreadPoolExecutor(count) if count > 1 else None

    def over(self, count: int, work: Callable[[slice], None]) -> None:
        """Call ``work`` with slices that together cover 0…count, in any order, and wait for all of them."""
        parts = [slice(start, min(start + BLOCK, count)) for start in range(0, count, BLOCK)]
        if self._pool is None or len(parts) < 2:
            for part in parts:
                work(part)
        else:
            for _ in self._pool.map(work, parts):
                pass

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()


ALONE = Threads(1)
