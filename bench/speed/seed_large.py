"""``seed_large``: `bench.speed.seed` with a picture of 1280 × 720, where memory decides."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from bench.speed import seed
from bench.speed.model import Benchmark, Configuration, Sides


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Do the same with four times the width and three times the height."""
    large = replace(configuration, width=4 * configuration.width, height=3 * configuration.height)
    with seed.prepare(large) as sides:
        yield sides


BENCHMARK = Benchmark(
    "seed_large",
    "the dissertation's filter at 1280 × 720, against plain NumPy",
    "ms",
    False,
    "ours ≤ 4, ratio ≤ 0.04",
    prepare,
)
