"""Routes on a map that is only half known: with a wide berth where there is room, close by where not."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vslam.line_of_sight import line_of_sight
from vslam.occupancy import OccupancyGrid
from vslam.planner import Plan, PlanFailure, Planner

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class RouteSettings:
    """How near to obstacles routes may lead.

    Attributes
    ----------
    robot_radius_m : float
    margin_m : float
        At the least, besides the radius; a cell of the map is a natural choice.
    berth_m : float
        As far from obstacles as this besides the radius, where that leads there at all.
    reach_m : float
        Where start or goal is too near to an obstacle, the nearest place within so many metres that is not.
    """

    robot_radius_m: float = 0.25
    margin_m: float = 0.1
    berth_m: float = 0.3
    reach_m: float = 0.6


class Routes:
    """Plans on one state of a map.

    Parameters
    ----------
    unknown_is_free : bool
        The free-space assumption: what nobody saw may be driven through, until it is seen to be blocked.
    """

    def __init__(
        self, grid: OccupancyGrid, unknown_is_free: bool, settings: RouteSettings | None = None
    ) -> None:
        self._own = own = settings or RouteSettings()
        self.near = Planner.of_grid(grid, own.robot_radius_m + own.margin_m, not unknown_is_free)
        self.far = Planner.of_grid(grid, own.robot_radius_m + own.berth_m, not unknown_is_free)

    def route(self, start: FloatArray, goal: FloatArray) -> Plan | PlanFailure:
        """The way from one place to another, metres, or why there is none."""
        failure = PlanFailure("goal is blocked")
        for planner in (self.far, self.near):
            ends = [self._free_near(planner, place) for place in (start, goal)]
            if ends[0] is None or ends[1] is None:
                failure = PlanFailure(f"{'start' if ends[0] is None else 'goal'} is blocked")
                continue
            found = planner.plan(ends[0], ends[1], any_angle=True)
            if isinstance(found, PlanFailure):
                failure = found
                continue
            if not (np.array_equal(ends[1], goal) or self.in_sight(ends[1], goal)):
                failure = PlanFailure("goal is blocked")
                continue
            path = np.vstack([start, found.path, goal])
            return Plan(path, float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()))
        return failure

    def blocks(self, path: FloatArray) -> bool:
        """Whether a path leads through what is now blocked; a start too near to something is let go."""
        legs = list(pairwise(path))
        if legs and self._blocked_at(self.near, path[0]):
            legs = legs[1:]
        return not all(self.in_sight(a, b) for a, b in legs)

    def in_sight(self, a: FloatArray, b: FloatArray) -> bool:
        """Whether the straight way between two places is free."""
        cells = (np.stack([a, b]) - self.near.origin) / self.near.resolution
        return bool(line_of_sight(self.near.blocked, *cells[0], *cells[1]))

    def _blocked_at(self, planner: Planner, place: FloatArray) -> bool:
        col, row = np.floor((place - planner.origin) / planner.resolution).astype(int)
        rows, cols = planner.blocked.shape
        return not (0 <= row < rows and 0 <= col < cols) or bool(planner.blocked[row, col])

    def _free_near(self, planner: Planner, place: FloatArray) -> FloatArray | None:
        """The place itself, or the nearest free cell's centre within reach."""
        if not self._blocked_at(planner, place):
            return place
        reach = int(np.ceil(self._own.reach_m / planner.resolution))
        col, row = np.floor((place - planner.origin) / planner.resolution).astype(int)
        low = np.maximum([row - reach, col - reach], 0)
        part = planner.blocked[low[0] : max(row + reach + 1, 0), low[1] : max(col + reach + 1, 0)]
        cells = np.argwhere(~part) + low
        centres = planner.origin + (cells[:, ::-1] + 0.5) * planner.resolution
        distances = np.linalg.norm(centres - place, axis=1)
        if not len(cells) or distances.min() > self._own.reach_m:
            return None
        nearest: FloatArray = centres[int(np.argmin(distances))]
        return nearest
