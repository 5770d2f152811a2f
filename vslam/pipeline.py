"""The five phases of visual SLAM under light noise, one frame after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vslam.camera import Calibration
from vslam.filters.apply import FilterFailureError, apply
from vslam.filters.base import LightFilter
from vslam.frame import Frame, Observations
from vslam.motion import move
from vslam.occupancy import OccupancyGrid
from vslam.planner import Plan, PlanFailure, plan
from vslam.scan import scan
from vslam.slam import Slam

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What the robot knows at the end of a drive.

    Attributes
    ----------
    poses : (n, 3) float64
        Estimated x, y (metres) and heading (rad) at each frame, in the grid's frame.
    grid : OccupancyGrid
        The map built on the way.
    plan : Plan or PlanFailure
        The way from where it stands to the goal.
    """

    poses: FloatArray
    grid: OccupancyGrid
    plan: Plan | PlanFailure


def run(
    frames: Iterable[Frame],
    light_filter: LightFilter,
    detect: Callable[[NDArray[np.uint8]], Observations],
    slam: Slam,
    calibration: Calibration,
    grid: OccupancyGrid,
    goal_xy: ArrayLike,
    start_pose: ArrayLike = (0.0, 0.0, 0.0),
    robot_radius_m: float = 0.25,
) -> Outcome:
    """Drive through the frames, map on the way, and plan to a goal.

    Parameters
    ----------
    frames : iterable of Frame
        Phase 1, image acquisition, happens where they come from.
    light_filter, detect, slam
        The variants under test.
    grid : OccupancyGrid
        Filled in place; an empty one for an unknown place.
    goal_xy : (2,) array_like
        In the grid's frame, metres.
    start_pose : (3,) array_like
        Where the first frame stands in the grid's frame; SLAM itself starts at its own origin.

    Notes
    -----
    A frame that the filter fails on gives no observations; the robot drives on by its odometry.
    """
    poses = []
    for frame in frames:
        observations = _see(frame, light_filter, detect)  # phases 2 to 4: light filter, landmark extraction,
        slam.step(frame.odometry, observations)  # association and EKF-SLAM,
        poses.append(move(np.asarray(start_pose, dtype=np.float64), slam.backend.pose))
        grid.integrate(poses[-1], scan(frame.depth, calibration))  # and mapping
    way = plan(grid, poses[-1][:2], goal_xy, robot_radius_m)  # phase 5: navigation
    return Outcome(np.array(poses), grid, way)


def _see(
    frame: Frame, light_filter: LightFilter, detect: Callable[[NDArray[np.uint8]], Observations]
) -> Observations:
    try:
        return detect(apply(light_filter, frame.image).image)
    except FilterFailureError:
        return Observations.none()
