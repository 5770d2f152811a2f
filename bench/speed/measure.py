"""Timing: ours, baseline, ours, baseline … so that whatever else the machine does meets both."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from bench.speed.model import Benchmark, Configuration, Result, summarise


def measure(benchmark: Benchmark, configuration: Configuration) -> Result:
    """Run a benchmark: one round to warm up, then the alternating rounds."""
    with benchmark.prepare(configuration) as sides:
        sides.ours()
        sides.baseline()
        rounds = np.array(
            [
                [_timed(side, benchmark.rate) for side in (sides.ours, sides.baseline)]
                for _ in range(min(configuration.rounds, benchmark.rounds or configuration.rounds))
            ]
        )
        ours, baseline = np.median(rounds, axis=0)
        return summarise(benchmark, rounds[:, 0], rounds[:, 1], sides.note(float(ours), float(baseline)))


def _timed(side: Callable[[], int], rate: bool) -> float:
    """Units per second, or milliseconds per unit."""
    start = time.perf_counter()
    units = side()
    seconds = time.perf_counter() - start
    return units / seconds if rate else 1e3 * seconds / units


def copy_bandwidth(size: int = 32_000_000, repeats: int = 5) -> float:
    """Bytes per second that one core reads and writes when it copies far more than its caches hold."""
    source, target = np.ones(size, dtype=np.float32), np.empty(size, dtype=np.float32)
    np.copyto(target, source)
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        np.copyto(target, source)
        best = min(best, time.perf_counter() - start)
    return 2 * source.nbytes / best
