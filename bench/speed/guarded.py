"""``guarded``: one picture through our light filter, on one thread.

Baseline: `yang2010`, of the field's separations the most used, on the same pictures: the corridor under a
sweep of lights.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.speed import relight_expose
from bench.speed.model import Benchmark, Configuration, Sides
from vslam.filters import create
from vslam.filters.apply import apply
from vslam.filters.base import LightFilter

PICTURES = 8


def pictures(configuration: Configuration) -> list[NDArray[np.uint8]]:
    """(H, W, 3) uint8, evenly spread over the sweep."""
    count = min(PICTURES, configuration.illuminations)
    at = np.linspace(0, configuration.illuminations - 1, count).astype(int)
    return [relight_expose.ours(configuration, k).image for k in at.tolist()]


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Take the pictures, build both filters."""
    seen, threads = pictures(configuration), cv2.getNumThreads()
    guarded, yang = create("guarded"), create("yang2010")

    def side(light_filter: LightFilter) -> int:
        for picture in seen:
            apply(light_filter, picture)
        return len(seen)

    def note(_: float, __: float) -> str:
        return f"one thread, {configuration.width} × {configuration.height}, {len(seen)} pictures"

    cv2.setNumThreads(1)
    try:
        yield Sides(lambda: side(guarded), lambda: side(yang), note)
    finally:
        cv2.setNumThreads(threads)


BENCHMARK = Benchmark(
    "guarded",
    "one picture through `guarded`, against yang2010",
    "ms",
    False,
    "ours ≤ 5 at 320 × 240",
    prepare,
)
