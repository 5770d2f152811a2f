"""How long a light filter takes for a picture, by default of the size that the suite works at."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import LightFilter

WIDTH, HEIGHT = 320, 240
BUDGET_S, MOST = 0.2, 15


def milliseconds(light_filter: LightFilter, width: int = WIDTH, height: int = HEIGHT) -> float:
    """The median time of a filter on `sample`, through `vslam.filters.apply.apply`.

    Raises
    ------
    VslamError
        When it fails on the picture.
    """
    from vslam.filters.apply import apply

    picture = sample(width, height)
    apply(light_filter, picture)  # what is made once is made here
    taken: list[float] = []
    while len(taken) < MOST and (not taken or sum(taken) < BUDGET_S):
        start = time.perf_counter()
        apply(light_filter, picture)
        taken.append(time.perf_counter() - start)
    return 1e3 * float(np.median(taken))


def sample(width: int = WIDTH, height: int = HEIGHT) -> NDArray[np.uint8]:
    """A picture for timing, (H, W, 3) uint8: coloured tiles with noise under three round highlights."""
    rng = np.random.default_rng(0)
    tiles = rng.uniform(20, 150, (8, 10, 3))
    rows, columns = np.arange(height) * 8 // height, np.arange(width) * 10 // width
    picture = tiles[rows[:, None], columns] + rng.normal(0, 2, (height, width, 3))
    y, x = np.mgrid[:height, :width] / height
    for cx, cy in ((0.3, 0.3), (0.9, 0.6), (0.5, 0.85)):
        picture += 250 * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * 0.06**2))[..., None]
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)
