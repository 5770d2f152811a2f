"""Phase 5 in closed loop: keep a way on the robot's own map, follow it, plan anew where the map says so."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from vslam.follower import STOP, Command, FollowerSettings, PathFollower
from vslam.missions import Finished, Mission
from vslam.occupancy import OccupancyGrid
from vslam.planner import PlanFailure
from vslam.routes import RouteSettings

FloatArray = NDArray[np.float64]


class State(StrEnum):
    """How the mission stands."""

    under_way = "under way"
    done = "done"
    stuck = "stuck"


@dataclass(frozen=True)
class NavigatorSettings:
    """When the robot plans.

    Attributes
    ----------
    off_path_m : float
        Farther from its path than this it plans anew.
    refresh_looks : int
        After so many pictures it looks for a shorter way, as the map has grown.
    gain_m : float
        A shorter way has to save so many metres to be taken.
    """

    routes: RouteSettings = field(default_factory=RouteSettings)
    follower: FollowerSettings = field(default_factory=FollowerSettings)
    off_path_m: float = 0.5
    refresh_looks: int = 5
    gain_m: float = 0.5


class Navigator:
    """Drives one mission.

    Where there is no way the robot turns once around to see more; with still no way after that it is stuck.

    Attributes
    ----------
    state : State
    replans : int
        How often a way had to be given up: it was blocked, or the robot was not on it any more.
    """

    def __init__(self, mission: Mission, settings: NavigatorSettings | None = None) -> None:
        self.mission, self.settings = mission, settings or NavigatorSettings()
        self.state, self.replans = State.under_way, 0
        self._follower: PathFollower | None = None
        self._looks = 0
        self._to_turn, self._heading = (
            0.0,
            0.0,
        )  # rad left of a turn on the spot, and the heading last counted
        self._sweeping, self._searched = (
            False,
            False,
        )  # it looks around as the mission wants, for want of a way

    @property
    def path(self) -> FloatArray:
        """(n, 2) float64: the way ahead, empty while there is none."""
        return self._follower.remaining if self._follower else np.zeros((0, 2))

    def look(self, pose: FloatArray, grid: OccupancyGrid) -> None:
        """Check the way against the map as it is now, once for each picture."""
        if self.state is not State.under_way:
            return
        self._looks += 1
        if self._follower is None:
            if not (self._sweeping and self._to_turn > 0.0):
                self._plan(pose, grid)
        elif not self.mission.still_wanted(grid):
            self._plan(pose, grid)
        elif self._lost_its_way(pose, grid):
            self.replans += 1
            self._plan(pose, grid)
        elif self.mission.refreshes and self._looks % self.settings.refresh_looks == 0:
            self._refresh(pose, grid)

    def command(self, pose: FloatArray) -> Command:
        """What to do now."""
        if self.state is not State.under_way:
            return STOP
        if self._follower is None:
            return self._turn_around(pose)
        if self._follower.arrived(pose):
            self._follower = None
            if self.mission.arrived():
                self._turn_once(pose, sweeping=True)
            return STOP
        return self._follower.command(pose)

    def _lost_its_way(self, pose: FloatArray, grid: OccupancyGrid) -> bool:
        follower = self._follower
        assert follower is not None
        if follower.off_path_m(pose) > self.settings.off_path_m:
            return True
        routes = self.mission.routes(grid, self.settings.routes)
        return routes.blocks(follower.remaining)

    def _plan(self, pose: FloatArray, grid: OccupancyGrid) -> None:
        found = self.mission.next_way(grid, pose[:2], self.settings.routes)
        if isinstance(found, Finished):
            self._follower, self.state = None, State.done
        elif isinstance(found, PlanFailure):
            self._follower = None
            if not self._searched:
                self._searched = True
                self._turn_once(pose, sweeping=False)
            elif self._to_turn <= 0.0:
                self.state = State.stuck
        else:
            self._follower = PathFollower(found.path, self.settings.follower)
            self._to_turn, self._searched = 0.0, False

    def _refresh(self, pose: FloatArray, grid: OccupancyGrid) -> None:
        assert self._follower is not None
        found = self.mission.next_way(grid, pose[:2], self.settings.routes)
        shorter = self._follower.remaining_m - self.settings.gain_m
        if not isinstance(found, Finished | PlanFailure) and found.cost_m < shorter:
            self._follower = PathFollower(found.path, self.settings.follower)

    def _turn_once(self, pose: FloatArray, sweeping: bool) -> None:
        self._to_turn, self._heading, self._sweeping = 2 * np.pi, float(pose[2]), sweeping

    def _turn_around(self, pose: FloatArray) -> Command:
        if self._to_turn <= 0.0:
            return STOP
        self._to_turn -= abs(float(pose[2]) - self._heading)  # headings count turns and are not wrapped
        self._heading = float(pose[2])
        return Command(0.0, self.settings.follower.turn_radps)
