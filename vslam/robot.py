"""The five phases in closed loop: what a robot's computer runs, from its sensors to its drive."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vslam.camera import Calibration
from vslam.filters.apply import apply
from vslam.filters.base import LightFilter
from vslam.follower import Command
from vslam.frame import Frame, Observations
from vslam.motion import move
from vslam.navigator import Navigator
from vslam.occupancy import OccupancyGrid
from vslam.scan import scan
from vslam.slam import Slam

FloatArray = NDArray[np.float64]


class Robot:
    """Sees, maps, plans and gives commands; the SLAM pose is all it knows of where it is.

    Parameters
    ----------
    light_filter, detect, slam
        The variants under test.
    grid : OccupancyGrid
        Filled in place; an empty one for an unknown place.
    navigator : Navigator
    start_pose : (3,) array_like
        Where it believes to start in the grid's frame; SLAM itself starts at its own origin.

    Attributes
    ----------
    observations : Observations
        What the last picture showed.
    """

    def __init__(
        self,
        light_filter: LightFilter,
        detect: Callable[[NDArray[np.uint8]], Observations],
        slam: Slam,
        calibration: Calibration,
        grid: OccupancyGrid,
        navigator: Navigator,
        start_pose: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self._filter, self._detect, self._calibration = light_filter, detect, calibration
        self.slam, self.grid, self.navigator = slam, grid, navigator
        self._start = np.asarray(start_pose, dtype=np.float64)
        self._since = np.zeros(3)
        self.observations = Observations.none()

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: where it believes to be, in the grid's frame: SLAM's pose and the odometry since."""
        return move(move(self._start, self.slam.backend.pose), self._since)

    def see(self, frame: Frame) -> None:
        """Take a picture in, with the odometry since the one before.

        Raises
        ------
        VslamError
            As `Slam.step`; also when the filter fails.
        """
        filtered = apply(self._filter, frame.image)  # phases 2 and 3: pre-processing and light filter
        self.observations = self._detect(filtered.image)  # phase 4: landmark extraction,
        self.slam.step(frame.odometry, self.observations)  # association and SLAM,
        self._since = np.zeros(3)
        self.grid.integrate(self.pose, scan(frame.depth, self._calibration))  # and mapping
        self.navigator.look(self.pose, self.grid)  # phase 5: navigation

    def feel(self, delta: FloatArray) -> None:
        """Count an increment of the odometry between two pictures, (3,) as in `vslam.motion.move`."""
        self._since = move(self._since, delta)

    def command(self) -> Command:
        """What the drive shall do now."""
        return self.navigator.command(self.pose)
