"""The true world of a drive: how the robot really moves, what it runs into, what it has left to see."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.kinds.drive import ClosedLoopStudy
from bench.rng import generator
from bench.sequences.rendered import increment_sigma
from scenes.occupancy import TrueOccupancy
from vslam.follower import Command
from vslam.frame import Odometry
from vslam.motion import move
from vslam.occupancy import OccupancyGrid
from vslam.planner import inflate

FloatArray = NDArray[np.float64]


class TrueWorld:
    """Where the robot truly is.

    It moves as commanded plus noise; the odometry reports what was commanded, as wheels do that slip (eq.
    3-8: R_t = f(R, u, n)). The noise of a picture's interval is one draw, in proportion to what is driven in
    it, so that it is the study's for an increment from picture to picture, whatever the rate of commands.

    Attributes
    ----------
    pose : (3,) float64
        True pose.
    driven_m : float
        True length of the way so far.
    collided : bool
        Whether the robot's disc has touched what is truly blocked. It stays where that happened.
    """

    def __init__(
        self, study: ClosedLoopStudy, occupancy: TrueOccupancy, start: FloatArray, stream: int
    ) -> None:
        self._study, self._occupancy, self._stream = study, occupancy, stream
        self._blocked = inflate(occupancy.blocked, study.navigation.robot_radius_m, occupancy.resolution)
        self.pose: FloatArray = np.array(start, dtype=np.float64)
        self.driven_m, self.collided = 0.0, self._touches(start)
        self._interval, self._slip = 0, self._drawn(0)
        self._counted, self._length, self._turn = np.zeros(3), 0.0, 0.0

    def apply(self, command: Command, seconds: float) -> FloatArray:
        """Drive a command for a while; gives the odometry's increment, (3,) as in `vslam.motion.move`."""
        counted = arc(command, seconds)
        sigma = increment_sigma(
            self._study.odometry, abs(command.speed_mps) * seconds, abs(command.turn_radps) * seconds
        )
        before = self.pose
        after = move(before, counted + sigma * self._slip)
        self._counted = move(self._counted, counted)
        self._length += abs(command.speed_mps) * seconds
        self._turn += abs(command.turn_radps) * seconds
        self.collided = any(self._touches(before + share * (after - before)) for share in (0.5, 1.0))
        self.driven_m += float(np.hypot(*(after - before)[:2]))
        self.pose = after
        return counted

    def odometry(self) -> Odometry:
        """The increment since the last picture, with the covariance that it tells itself; starts anew."""
        sigma = increment_sigma(self._study.odometry, self._length, self._turn)
        increment = Odometry(self._counted, np.diag(sigma**2))
        self._interval += 1
        self._slip = self._drawn(self._interval)
        self._counted, self._length, self._turn = np.zeros(3), 0.0, 0.0
        return increment

    def explored(self, grid: OccupancyGrid) -> float:
        """Share of the truly free cells that can be reached, held for free by a map of the same extent."""
        free = ~self._occupancy.blocked
        rows, cols = free.shape
        held = grid.free[:rows, :cols]
        return float((held & free[: held.shape[0], : held.shape[1]]).sum() / max(free.sum(), 1))

    def _drawn(self, interval: int) -> FloatArray:
        return generator(self._study.seed, "motion", self._stream, interval).standard_normal(3)

    def _touches(self, pose: FloatArray) -> bool:
        place = self._occupancy
        col, row = np.floor((pose[:2] - place.origin) / place.resolution).astype(int)
        rows, cols = self._blocked.shape
        return not (0 <= row < rows and 0 <= col < cols) or bool(self._blocked[row, col])


def arc(command: Command, seconds: float) -> FloatArray:
    """(3,) float64: the increment of a constant command, an arc of a circle."""
    turn, length = command.turn_radps * seconds, command.speed_mps * seconds
    if abs(turn) < 1e-9:
        return np.array([length, 0.0, turn])
    radius = length / turn
    return np.array([radius * np.sin(turn), radius * (1.0 - np.cos(turn)), turn])
