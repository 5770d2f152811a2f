"""An occupancy grid built from scans and poses (Thrun, Burgard & Fox 2005, ch. 9)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from vslam.errors import VslamError
from vslam.scan import Scan

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def _log_odds(probability: float) -> float:
    return float(np.log(probability / (1.0 - probability)))


# The inverse sensor model and the clamping of OctoMap (Hornung et al. 2013, sec. 5):
# p(occupied | hit) 0.7, p(occupied | passed) 0.4, clamped to 0.12 … 0.97.
HIT, PASS = _log_odds(0.7), _log_odds(0.4)
LOWEST, HIGHEST = _log_odds(0.12), _log_odds(0.97)


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """Log odds of being occupied, per cell; 0 = never seen.

    Attributes
    ----------
    origin : (2,) float64
        Lower left corner of cell [0, 0], metres.
    resolution : float
        Side of a cell, metres.
    log_odds : (rows, cols) float32
        Row = y, column = x; ``integrate`` updates it in place.
    """

    origin: FloatArray
    resolution: float
    log_odds: NDArray[np.float32]

    @staticmethod
    def empty(bounds: tuple[float, float, float, float], resolution: float) -> OccupancyGrid:
        """A grid that has seen nothing and covers the bounds.

        Parameters
        ----------
        bounds : (x_min, y_min, x_max, y_max), metres
        resolution : float, metres

        Raises
        ------
        VslamError
            When the bounds are empty or the resolution is not positive.
        """
        x0, y0, x1, y1 = bounds
        if not (x1 > x0 and y1 > y0 and resolution > 0.0):
            raise VslamError(f"occupancy grid: bounds {bounds} at {resolution} m hold no cell")
        # A hair of tolerance, so that 2.5 m at 0.1 m are 25 cells and not 26.
        rows, cols = (int(np.ceil(side / resolution - 1e-6)) for side in (y1 - y0, x1 - x0))
        return OccupancyGrid(
            np.array([x0, y0], dtype=np.float64), resolution, np.zeros((rows, cols), dtype=np.float32)
        )

    def integrate(self, pose: ArrayLike, scan: Scan) -> None:
        """Add one scan, in place: every cell that the fan touches is updated once.

        A cell that one beam ends in and another passes counts as hit: a wall seen at a grazing angle stays.

        Parameters
        ----------
        pose : (3,) array_like
            x, y (metres) and heading (rad) of the robot in the grid's frame.
        scan : Scan

        Raises
        ------
        VslamError
            When the pose is not finite.
        """
        x, y, heading = np.asarray(pose, dtype=np.float64)
        if not np.isfinite([x, y, heading]).all():
            raise VslamError(f"occupancy grid: pose {[x, y, heading]} is not finite")
        c, s = np.cos(heading), np.sin(heading)
        start = np.array(
            [x + c * scan.origin[0] - s * scan.origin[1], y + s * scan.origin[0] + c * scan.origin[1]]
        )
        _integrate(
            self.log_odds,
            (start - self.origin) / self.resolution,
            scan.bearings + heading,
            scan.ranges / self.resolution,
            scan.hit,
        )

    def cell(self, xy: ArrayLike) -> tuple[int, int]:
        """(row, column) of a point in metres; may lie outside the grid."""
        col, row = np.floor((np.asarray(xy, dtype=np.float64) - self.origin) / self.resolution).astype(int)
        return int(row), int(col)

    @property
    def occupied(self) -> BoolArray:
        """(rows, cols) bool: more likely occupied than free."""
        return self.log_odds > 0.0

    @property
    def free(self) -> BoolArray:
        """(rows, cols) bool: more likely free than occupied."""
        return self.log_odds < 0.0

    @property
    def unknown(self) -> BoolArray:
        """(rows, cols) bool: never seen, or seen with no verdict."""
        return self.log_odds == 0.0


@njit(cache=True)
def _integrate(log_odds, start, bearings, ranges, hit):  # type: ignore[no-untyped-def]
    """All lengths in cells. First the ends of the beams, then the cells that they pass."""
    rows, cols = log_odds.shape
    seen = np.zeros((rows, cols), dtype=np.bool_)
    for i in range(len(bearings)):
        if not hit[i]:
            continue
        col = int(np.floor(start[0] + ranges[i] * np.cos(bearings[i])))
        row = int(np.floor(start[1] + ranges[i] * np.sin(bearings[i])))
        if 0 <= row < rows and 0 <= col < cols and not seen[row, col]:
            seen[row, col] = True
            log_odds[row, col] = min(log_odds[row, col] + HIT, HIGHEST)
    for i in range(len(bearings)):
        if ranges[i] > 0.0:
            _pass_cells(log_odds, seen, start[0], start[1], bearings[i], ranges[i])


@njit(cache=True)
def _pass_cells(log_odds, seen, x, y, bearing, length):  # type: ignore[no-untyped-def]
    """Walk the cells of a beam (Amanatides & Woo 1987) up to its end and skip those that are seen."""
    rows, cols = log_odds.shape
    dx, dy = np.cos(bearing), np.sin(bearing)
    col, row = int(np.floor(x)), int(np.floor(y))
    step_col, step_row = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    per_col = 1.0 / abs(dx) if dx != 0.0 else np.inf
    per_row = 1.0 / abs(dy) if dy != 0.0 else np.inf
    next_col = ((col + 1 - x) if dx > 0 else (x - col)) * per_col if dx != 0.0 else np.inf
    next_row = ((row + 1 - y) if dy > 0 else (y - row)) * per_row if dy != 0.0 else np.inf
    travelled = 0.0
    while travelled <= length:
        if 0 <= row < rows and 0 <= col < cols and not seen[row, col]:
            seen[row, col] = True
            log_odds[row, col] = max(log_odds[row, col] + PASS, LOWEST)
        if next_col < next_row:
            travelled, next_col, col = next_col, next_col + per_col, col + step_col
        else:
            travelled, next_row, row = next_row, next_row + per_row, row + step_row
