"""``seed``: the dissertation's filter on one picture, on one thread, against its plain NumPy form.

Ours: `vslam.filters.seed.Seed` with its defaults. Baseline: `bench.speed.numpy_seed`. Both filter the same
picture, of the corridor under sun, sky and six bulbs, and find the same mask.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from bench.speed import numpy_seed, relight_expose
from bench.speed.measure import copy_bandwidth
from bench.speed.model import Benchmark, Configuration, Sides
from vslam.filters import registry

CALLS, BASELINE_CALLS = 40, 4
"""A round's; one call is too short to time."""


def picture(configuration: Configuration) -> NDArray[np.uint8]:
    """One picture of the corridor, (H, W, 3) uint8."""
    return relight_expose.ours(configuration, 0).image


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Render the picture and compile the filter; OpenCV gets one thread, as in a run's processes."""
    import cv2

    image, light_filter = picture(configuration), registry.create("seed")
    threads, masked = cv2.getNumThreads(), light_filter(image).mask.mean()

    def ours() -> int:
        for _ in range(CALLS):
            light_filter(image)
        return CALLS

    def plain() -> int:
        for _ in range(BASELINE_CALLS):
            numpy_seed.seed(image)
        return BASELINE_CALLS

    def note(ms: float, _: float) -> str:
        moved = 2 * image.nbytes + 5 * image[..., 0].nbytes  # picture in, picture, mask and score out
        limit = 1e3 * moved / copy_bandwidth()
        return (
            f"{image.shape[1]} × {image.shape[0]}, {100 * masked:.0f} % masked; "
            f"{1e6 * ms / image[..., 0].size:.1f} ns a pixel, {ms / limit:.0f} × copying in and out"
        )

    cv2.setNumThreads(1)
    try:
        yield Sides(ours, plain, note)
    finally:
        cv2.setNumThreads(threads)


BENCHMARK = Benchmark(
    "seed",
    "the dissertation's filter at 320 × 240, against plain NumPy",
    "ms",
    False,
    "ours ≤ 0.4, ratio ≤ 0.04",
    prepare,
)
