"""Plain floors with lobes of light, discs and patches of sun: the dichromatic model (eq. 3-1) alone.

They teach what the rooms do not show apart from each other: that a lobe is light wherever it lies, and that a
disc or a sharp patch of sun is not.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.rng import generator
from tools.guarded.pictures import Pictures
from vslam.filters.stages.srgb import encode

ROWS, COLUMNS = 120, 160


def floors(split: str, count: int, seed: int) -> Pictures:
    """``count`` floors of half the usual size, one in three without any lobe."""
    rng = generator(seed, "guarded floors", split)
    shots = [_floor(rng, lobes=0 if k % 3 == 0 else int(rng.integers(1, 5))) for k in range(count)]
    return Pictures(*(np.stack(kind) for kind in zip(*shots, strict=True)))


def _floor(rng: np.random.Generator, lobes: int) -> tuple[NDArray, ...]:
    """Image, full, diffuse, disc."""
    rows, columns = np.mgrid[:ROWS, :COLUMNS].astype(np.float32)
    grey = rng.uniform(0.03, 0.5) * np.ones(3)
    paint = grey if rng.random() < 0.4 else grey * rng.uniform(0.3, 1.3, 3)
    slope = (
        1 + rng.uniform(-0.5, 0.5) * (rows / ROWS - 0.5) + rng.uniform(-0.5, 0.5) * (columns / COLUMNS - 0.5)
    )
    diffuse = slope[..., None] * paint
    for _ in range(int(rng.integers(0, 3))):  # sun through a window
        corners = rng.uniform((0, 0), (COLUMNS, ROWS)) + rng.uniform(-40, 40, (4, 2))
        patch = cv2.fillConvexPoly(
            np.zeros((ROWS, COLUMNS), np.uint8), cv2.convexHull(corners.astype(np.int32)), 1
        )
        diffuse = diffuse * (1 + rng.uniform(0.5, 4) * patch[..., None])
    disc = np.zeros((ROWS, COLUMNS), dtype=np.bool_)
    for _ in range(int(rng.integers(0, 5))):
        inside = _bump(rng, rows, columns, rng.uniform(4, 25)) < 1
        diffuse = np.where(inside[..., None], rng.choice([0.8, 0.03]) * slope[..., None], diffuse)
        disc |= inside
    light = np.zeros((ROWS, COLUMNS))
    for _ in range(lobes):
        distance = _bump(rng, rows, columns, rng.uniform(2, 15))
        lobe = np.exp(-distance / 2) if rng.random() < 0.5 else 1 / (1 + distance) ** 2  # Gauss; GGX's tails
        light += rng.uniform(0.1, 1.5) * lobe
    if light.max() < 0.05 and lobes:
        light *= 0.05 / light.max()
    full = diffuse + light[..., None]
    noise = rng.normal(0, 1, full.shape) * (rng.uniform(0.001, 0.006) + rng.uniform(0, 0.02) * np.sqrt(full))
    return (*(encode(np.clip(x, 0, 1).astype(np.float32)) for x in (full + noise, full, diffuse)), disc)


def _bump(rng: np.random.Generator, rows: NDArray, columns: NDArray, size: float) -> NDArray:
    """Squared distance from a random place, in sizes, seen on a floor: up to three times as wide as high."""
    flat = rng.uniform(1, 3)
    row, column = rng.uniform(0, ROWS), rng.uniform(0, COLUMNS)
    return (((rows - row) * flat) ** 2 + (columns - column) ** 2) / size**2
