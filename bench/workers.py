"""Work spread over local processes, in order, with the same results for any number of them."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, Protocol, TypeVar

from bench.errors import BenchError

T = TypeVar("T")
R = TypeVar("R")

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Workers(Protocol):
    """Applies a function to items; results come in the items' order."""

    def map(self, function: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        """Apply ``function``, a picklable module-level function, to each item."""


class _InProcess:
    def map(self, function: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        return map(function, items)


class _Pool:
    def __init__(self, executor: ProcessPoolExecutor) -> None:
        self._executor = executor

    def map(self, function: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        try:
            yield from self._executor.map(function, items)
        except BrokenProcessPool:
            raise BenchError(
                "a worker process was killed, most likely for lack of memory; run again with --workers 1"
            ) from None


@contextmanager
def workers(count: int) -> Iterator[Workers]:
    """Open ``count`` processes with one thread each; one means this process.

    Processes are spawned, not forked: Embree and OSMesa keep threads that do not survive a fork.
    """
    if count <= 1:
        yield _InProcess()
        return
    with _one_thread_each():
        executor = ProcessPoolExecutor(
            count, mp_context=multiprocessing.get_context("spawn"), initializer=_start_worker
        )
        try:
            yield _Pool(executor)
        finally:
            executor.shutdown(cancel_futures=True)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """What the processes inherit; restored afterwards."""
    before: dict[str, Any] = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value


def _start_worker() -> None:
    import cv2

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is interrupted, and ends the pool

    cv2.setNumThreads(1)
