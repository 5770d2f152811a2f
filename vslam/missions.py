"""Where a robot wants to go: through a list of places, or to whatever it has not seen yet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import distance_transform_edt

from vslam.frontier import frontiers
from vslam.occupancy import OccupancyGrid
from vslam.planner import Plan, PlanFailure
from vslam.routes import Routes, RouteSettings

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Finished:
    """There is nothing left to do."""


class Mission(Protocol):
    """What the navigator asks for its next way."""

    refreshes: bool
    """Whether a shorter way to the same place is worth looking for as the map grows."""

    @property
    def places_left(self) -> int:
        """How many places it has still to go to; 0 where it has none in mind."""

    def next_way(
        self, grid: OccupancyGrid, position: FloatArray, settings: RouteSettings
    ) -> Plan | PlanFailure | Finished:
        """The way to where it wants to go now."""

    def still_wanted(self, grid: OccupancyGrid) -> bool:
        """Whether what it drives to is still worth it."""

    def routes(self, grid: OccupancyGrid, settings: RouteSettings) -> Routes:
        """The map as this mission may use it."""

    def arrived(self) -> bool:
        """Note that the way is driven to its end; whether the robot should look around there."""


class GoTo:
    """Through places, one after the other; unknown space is taken for free until it is seen."""

    refreshes = True

    def __init__(self, places: ArrayLike) -> None:
        self._places = [
            np.array(p, dtype=np.float64) for p in np.asarray(places, dtype=np.float64).reshape(-1, 2)
        ]

    @property
    def places_left(self) -> int:
        """See `Mission`."""
        return len(self._places)

    def next_way(
        self, grid: OccupancyGrid, position: FloatArray, settings: RouteSettings
    ) -> Plan | PlanFailure | Finished:
        """See `Mission`."""
        if not self._places:
            return Finished()
        return self.routes(grid, settings).route(position, self._places[0])

    def still_wanted(self, grid: OccupancyGrid) -> bool:
        """See `Mission`."""
        return True

    def routes(self, grid: OccupancyGrid, settings: RouteSettings) -> Routes:
        """See `Mission`."""
        return Routes(grid, unknown_is_free=True, settings=settings)

    def arrived(self) -> bool:
        """See `Mission`."""
        self._places.pop(0)
        return False


class Explore:
    """To the nearest frontier, through known free space, until none can be reached (Yamauchi 1997).

    A frontier that is still there after a look around from it is given up.
    """

    refreshes = False  # its target changes as soon as there is nothing more to see there

    def __init__(self) -> None:
        self._target: FloatArray | None = None
        self._given_up: list[FloatArray] = []

    @property
    def places_left(self) -> int:
        """See `Mission`."""
        return 0

    def next_way(
        self, grid: OccupancyGrid, position: FloatArray, settings: RouteSettings
    ) -> Plan | PlanFailure | Finished:
        """See `Mission`."""
        routes = self.routes(grid, settings)
        smallest = max(1, round(2 * settings.robot_radius_m / grid.resolution))
        clear = (
            distance_transform_edt(~grid.occupied) if grid.occupied.any() else np.ones(grid.log_odds.shape)
        )
        best: Plan | None = None
        for group in frontiers(grid.free, grid.unknown, smallest):
            row, col = group[int(np.argmax(clear[group[:, 0], group[:, 1]]))]
            place = grid.origin + (np.array([col, row]) + 0.5) * grid.resolution
            if any(np.linalg.norm(place - old) < settings.reach_m for old in self._given_up):
                continue
            if best is not None and np.linalg.norm(place - position) >= best.cost_m:
                continue
            found = routes.route(position, place)
            if isinstance(found, Plan) and (best is None or found.cost_m < best.cost_m):
                best, self._target = found, place
        return Finished() if best is None else best

    def still_wanted(self, grid: OccupancyGrid) -> bool:
        """Whether anything within two cells of the target is still unknown."""
        if self._target is None:
            return False
        row, col = grid.cell(self._target)
        around = grid.unknown[max(row - 2, 0) : row + 3, max(col - 2, 0) : col + 3]
        return bool(around.any())

    def routes(self, grid: OccupancyGrid, settings: RouteSettings) -> Routes:
        """See `Mission`."""
        return Routes(grid, unknown_is_free=False, settings=settings)

    def arrived(self) -> bool:
        """See `Mission`."""
        if self._target is not None:
            self._given_up.append(self._target)
        return True
