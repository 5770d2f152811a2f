"""Where on its floor a robot can be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.model import FloatArray, Surface
from scenes.occupancy import obstacles

RESOLUTION_M = 0.05
MOST_CELLS = 2000
"""Along a side; larger floors get larger cells."""

FLOOR_BAND_M = (-0.05, 0.05)


@dataclass(frozen=True, eq=False)
class Ground:
    """The free floor as a grid.

    Attributes
    ----------
    clearance : (rows, cols) float64
        From each cell's centre to the nearest obstacle or end of the floor, metres; up to a cell too little.
    origin : (2,) float64
        World position of the lower left corner of cell [0, 0], metres.
    resolution : float
        Cell edge, metres.
    """

    clearance: FloatArray
    origin: FloatArray
    resolution: float

    def at(self, points: FloatArray) -> FloatArray:
        """(n,) clearance at points (n, 2), 0 outside of the grid."""
        cell = np.floor((points - self.origin) / self.resolution).astype(int)
        shape = np.array(self.clearance.shape)[::-1]
        inside = np.asarray(((cell >= 0) & (cell < shape)).all(axis=1))
        cell = np.where(inside[:, None], cell, 0)
        return np.asarray(np.where(inside, self.clearance[cell[:, 1], cell[:, 0]], 0.0))

    def centres(self, cells: NDArray[np.int64]) -> FloatArray:
        """(n, 2) metres of cells given as (row, column)."""
        return np.asarray(self.origin + (cells[:, ::-1] + 0.5) * self.resolution)


def ground_of(surfaces: Sequence[Surface], floor: Sequence[str]) -> Ground:
    """Rasterise floor and obstacles and measure the distance between them."""
    from scipy.ndimage import distance_transform_edt

    floors = [s for s in surfaces if s.name in floor]
    bounds = bounds_of(floors)
    resolution = max(RESOLUTION_M, max(bounds[2] - bounds[0], bounds[3] - bounds[1]) / MOST_CELLS)
    covered, origin = obstacles(floors, bounds, resolution, FLOOR_BAND_M)
    blocked, _ = obstacles(surfaces, bounds, resolution)
    cells = np.asarray(distance_transform_edt(covered & ~blocked))  # to the nearest blocked cell's centre
    return Ground(np.maximum(cells - 1, 0.0) * resolution, origin, resolution)


def bounds_of(surfaces: Sequence[Surface]) -> tuple[float, float, float, float]:
    """Seen from above: x_min, y_min, x_max, y_max."""
    corners = np.concatenate([s.vertices[:, :2] for s in surfaces])
    (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)
