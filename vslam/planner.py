"""Plans for a round robot: the grid inflated by its radius, then A*, then the path pulled tight if wanted."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from vslam.astar import NoPath, shortest_path
from vslam.errors import VslamError
from vslam.line_of_sight import pulled_tight
from vslam.occupancy import OccupancyGrid

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Plan:
    """A path to drive.

    Attributes
    ----------
    path : (n, 2) float64
        From the start over cell centres to the goal, metres.
    cost_m : float
        Length of the path, metres.
    """

    path: FloatArray
    cost_m: float


@dataclass(frozen=True)
class PlanFailure:
    """Why there is no plan, in a few words."""

    reason: str


@dataclass(frozen=True, eq=False)
class Planner:
    """A grid made ready for plans, so that many plans inflate it once.

    Attributes
    ----------
    blocked : (rows, cols) bool
        Cells the robot's centre may not enter.
    origin : (2,) float64
        Lower left corner of cell [0, 0], metres.
    resolution : float
        Side of a cell, metres.
    """

    blocked: BoolArray
    origin: FloatArray
    resolution: float

    @staticmethod
    def of_grid(grid: OccupancyGrid, robot_radius_m: float, unknown_is_blocked: bool = True) -> Planner:
        """Inflate the occupied cells; unknown cells may be entered or not, but are never inflated.

        (The rule of ROS's costmap_2d: a cell nobody saw inside a free corridor must not close it.)
        """
        blocked = inflate(grid.occupied, robot_radius_m, grid.resolution)
        return Planner(
            blocked | grid.unknown if unknown_is_blocked else blocked, grid.origin, grid.resolution
        )

    @staticmethod
    def of_blocked(
        blocked: BoolArray, origin: ArrayLike, resolution: float, robot_radius_m: float
    ) -> Planner:
        """The same for a map that is known for certain."""
        inflated = inflate(blocked, robot_radius_m, resolution)
        return Planner(inflated, np.asarray(origin, dtype=np.float64), resolution)

    def plan(self, start_xy: ArrayLike, goal_xy: ArrayLike, any_angle: bool = False) -> Plan | PlanFailure:
        """The shortest path between two points in metres, or the reason why there is none.

        ``any_angle`` pulls the path over neighbouring cells tight: shorter, with few corners, through free
        cells alone; it need not be the shortest of all such paths.
        """
        start, goal = (np.asarray(p, dtype=np.float64).reshape(2) for p in (start_xy, goal_xy))
        if not np.isfinite([start, goal]).all():
            return PlanFailure("start or goal is not finite")
        cells = [np.floor((p - self.origin) / self.resolution).astype(int)[::-1] for p in (start, goal)]
        found = shortest_path(self.blocked, tuple(cells[0]), tuple(cells[1]), self.resolution)
        if isinstance(found, NoPath):
            return PlanFailure(found.reason)
        centres = self.origin + (found.cells[:, ::-1] + 0.5) * self.resolution
        # The ends leave their cells straight for the next centre: two neighbouring cells (or the four around
        # a diagonal step, all free) are convex, so that stays in free cells.
        path = np.vstack([start, centres[1:-1], goal])
        if any_angle:
            cells_xy = (path - self.origin) / self.resolution
            path = self.origin + pulled_tight(self.blocked, cells_xy) * self.resolution
        return Plan(path, float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()))


def plan(
    grid: OccupancyGrid,
    start_xy: ArrayLike,
    goal_xy: ArrayLike,
    robot_radius_m: float,
    unknown_is_blocked: bool = True,
    any_angle: bool = False,
) -> Plan | PlanFailure:
    """One plan on a grid; for many, keep a `Planner`.

    Parameters
    ----------
    grid : OccupancyGrid
    start_xy, goal_xy : (2,) array_like
        Metres, in the grid's frame.
    robot_radius_m : float
    unknown_is_blocked : bool
        Whether cells that nobody saw are out of bounds.
    any_angle : bool
        Whether the path is pulled tight.

    Returns
    -------
    Plan or PlanFailure
    """
    return Planner.of_grid(grid, robot_radius_m, unknown_is_blocked).plan(start_xy, goal_xy, any_angle)


def inflate(blocked: BoolArray, radius_m: float, resolution: float) -> BoolArray:
    """Cells whose centre is no farther than a radius from the centre of a blocked one.

    Parameters
    ----------
    blocked : (rows, cols) bool
    radius_m : float
        Not negative, metres.
    resolution : float
        Side of a cell, metres.

    Raises
    ------
    VslamError
        When the radius is negative.
    """
    if not radius_m >= 0.0:
        raise VslamError(f"planner: robot radius must not be negative, got {radius_m}")
    if not blocked.any():
        return np.zeros(blocked.shape, dtype=np.bool_)
    cells = cv2.distanceTransform((~blocked).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # Squared distances are whole numbers. 1e-9: one equal to the radius counts as blocked whatever the
    # rounding.
    squared = np.rint(np.square(cells, dtype=np.float64))
    inflated: BoolArray = np.sqrt(squared) * resolution <= radius_m + 1e-9
    return inflated
