"""A map that follows its track: its scans are kept, and integrated anew where a smoother moves them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.geometry import wrap_angle
from vslam.occupancy import OccupancyGrid
from vslam.scan import Scan

FloatArray = NDArray[np.float64]


class Mapper:
    """An occupancy grid with the scans and poses that it was made from.

    Parameters
    ----------
    bounds : (x_min, y_min, x_max, y_max), metres
    resolution : float, metres

    Attributes
    ----------
    grid : OccupancyGrid
        The map so far.
    """

    def __init__(self, bounds: tuple[float, float, float, float], resolution: float) -> None:
        self._bounds = bounds
        self.grid = OccupancyGrid.empty(bounds, resolution)
        self._poses: list[FloatArray] = []
        self._scans: list[Scan] = []

    @property
    def poses(self) -> FloatArray:
        """(n, 3) float64: where the map's scans were taken, as far as it knows."""
        return np.array(self._poses).reshape(-1, 3)

    def add(self, pose: FloatArray, scan: Scan) -> None:
        """Integrate one more scan.

        Raises
        ------
        VslamError
            When the pose is not finite; the map stays as it was.
        """
        self.grid.integrate(pose, scan)
        self._poses.append(np.array(pose, dtype=np.float64))
        self._scans.append(scan)

    def move(self, poses: FloatArray) -> bool:
        """Put the track where a smoother has it; the map is made anew if any scan's end moves by half a cell.

        Clamped log odds cannot be taken back one by one, so all scans are integrated again.

        Parameters
        ----------
        poses : (n, 3) float64
            One for each scan added.

        Returns
        -------
        bool: whether the map was made anew.

        Raises
        ------
        VslamError
            When there is not one finite pose for each scan.
        """
        moved = np.asarray(poses, dtype=np.float64)
        if moved.shape != (len(self._poses), 3) or not np.isfinite(moved).all():
            raise VslamError(
                f"mapper: {moved.shape} poses for {len(self._poses)} scans; give a finite one for each"
            )
        if not len(moved) or self._farthest_shift(moved) < self.grid.resolution / 2:
            return False
        grid = OccupancyGrid.empty(self._bounds, self.grid.resolution)
        for pose, scan in zip(moved, self._scans, strict=True):
            grid.integrate(pose, scan)
        self.grid, self._poses = grid, list(moved)
        return True

    def _farthest_shift(self, moved: FloatArray) -> float:
        """Bound on how far a beam's end moves, metres: the shift, and the turn over the beam's length."""
        shift = np.linalg.norm(moved[:, :2] - self.poses[:, :2], axis=1)
        turn = np.abs(wrap_angle(moved[:, 2] - self.poses[:, 2]))
        reach = np.array([s.ranges.max(initial=0.0) + np.linalg.norm(s.origin) for s in self._scans])
        return float((shift + turn * reach).max())
