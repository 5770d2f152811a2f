"""How long a light filter takes for a picture of the size that the suite works at."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 320, 240
BUDGET_S, MOST = 0.2, 15


def milliseconds(name: str) -> float:
    """The median time of the filter ``name`` with its defaults, through `vslam.filters.apply.apply`.

    Raises
    ------
    VslamError
        When it cannot be built without parameters, or fails on the picture.
    """
    from vslam.filters import registry
    from vslam.filters.apply import apply

    light_filter, picture = registry.create(name), sample()
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
