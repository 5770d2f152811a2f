"""Routes and missions on maps drawn by hand: blocked ways, places in walls, nothing free, nothing left."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from vslam.missions import Explore, GoTo
from vslam.navigator import Navigator, State
from vslam.occupancy import OccupancyGrid
from vslam.planner import Plan, PlanFailure
from vslam.routes import Routes, RouteSettings


def grid(rows: int = 40, cols: int = 60, known: float = -1.0) -> OccupancyGrid:
    """4 m × 6 m of one verdict at 0.1 m."""
    return OccupancyGrid(np.zeros(2), 0.1, np.full((rows, cols), known, dtype=np.float32))


def spin(navigator: Navigator, place: OccupancyGrid, pose: np.ndarray, seconds: float = 10.0) -> np.ndarray:
    """Obey its turns on the spot, looking four times a command."""
    for k in range(round(seconds / 0.1)):
        if k % 4 == 0:
            navigator.look(pose, place)
        pose = pose + np.array([0.0, 0.0, 0.1 * navigator.command(pose).turn_radps])
    return pose


def test_routes_keep_the_berth_where_there_is_room_and_go_close_where_not() -> None:
    place = grid()
    place.log_odds[:, 30] = 1.0
    place.log_odds[10:19, 30] = -1.0  # a door of 0.9 m: too narrow for a berth of 0.55 m, not of 0.35
    routes = Routes(place, unknown_is_free=True)
    found = routes.route(np.array([1.0, 2.0]), np.array([5.0, 2.0]))
    assert isinstance(found, Plan)
    place.log_odds[10:12, 30] = 1.0
    place.log_odds[16:19, 30] = 1.0  # 0.4 m: too narrow for the robot
    shut = Routes(place, unknown_is_free=True)
    assert shut.blocks(found.path) and not routes.blocks(found.path)
    assert shut.route(np.array([1.0, 2.0]), np.array([5.0, 2.0])) == PlanFailure("goal cannot be reached")


def test_with_room_the_way_round_an_edge_keeps_the_whole_berth() -> None:
    place = grid()
    place.log_odds[:20, 30] = 1.0
    found = Routes(place, unknown_is_free=True).route(np.array([1.0, 1.0]), np.array([5.0, 1.0]))
    assert isinstance(found, Plan)
    dense = np.concatenate([np.linspace(a, b, 50) for a, b in pairwise(found.path)])
    edge = np.array([3.05, 1.95])
    assert np.linalg.norm(dense - edge, axis=1).min() > RouteSettings().robot_radius_m + 0.2


def test_unknown_space_is_a_matter_of_the_mission() -> None:
    place = grid()
    place.log_odds[:, 25:35] = 0.0
    ends = np.array([1.0, 2.0]), np.array([5.0, 2.0])
    assert isinstance(Routes(place, unknown_is_free=True).route(*ends), Plan)
    assert isinstance(Routes(place, unknown_is_free=False).route(*ends), PlanFailure)


def test_a_goal_in_an_obstacle_ends_stuck_after_one_look_around() -> None:
    place = grid()
    place.log_odds[10:30, 40:60] = 1.0
    navigator = Navigator(GoTo([[5.0, 2.0]]))
    pose = spin(navigator, place, np.array([1.0, 2.0, 0.0]), seconds=3.0)
    assert navigator.state is State.under_way and pose[2] > 2.0
    pose = spin(navigator, place, pose, seconds=7.0)
    assert navigator.state is State.stuck
    assert 2 * np.pi <= pose[2] < 2 * np.pi + 0.5


def test_a_start_in_a_wall_ends_stuck() -> None:
    navigator = Navigator(GoTo([[5.0, 2.0]]))
    spin(navigator, grid(known=1.0), np.array([1.0, 2.0, 0.0]))
    assert navigator.state is State.stuck


def test_a_start_beside_a_wall_gets_away_from_it() -> None:
    place = grid()
    place.log_odds[:12] = 1.0
    found = Routes(place, unknown_is_free=True).route(np.array([1.0, 1.3]), np.array([5.0, 2.0]))
    assert isinstance(found, Plan)


def test_exploring_a_map_without_free_space_or_without_frontiers_is_done_at_once() -> None:
    for known in (0.0, 1.0, -1.0):
        navigator = Navigator(Explore())
        navigator.look(np.array([1.0, 2.0, 0.0]), grid(known=known))
        assert navigator.state is State.done


def test_exploring_drives_to_the_nearest_frontier_and_gives_it_up_if_looking_does_not_help() -> None:
    place = grid()
    place.log_odds[:, :4] = 0.0
    place.log_odds[:, 56:] = 0.0
    navigator = Navigator(Explore())
    pose = np.array([2.0, 2.0, 0.0])
    navigator.look(pose, place)
    assert abs(navigator.path[-1][0] - 0.45) < 0.06  # 1.6 m to the left, 3.5 m to the right
    pose = np.array([*navigator.path[-1], np.pi])
    navigator.command(pose)
    pose = spin(navigator, place, pose, seconds=8.0)
    assert pose[2] > np.pi + 2 * np.pi - 0.2
    assert abs(navigator.path[-1][0] - 5.55) < 0.06


def test_a_way_that_is_seen_to_be_blocked_is_planned_anew() -> None:
    place = grid()
    navigator, pose = Navigator(GoTo([[5.0, 2.0]])), np.array([1.0, 2.0, 0.0])
    navigator.look(pose, place)
    assert len(navigator.path) == 2 and navigator.replans == 0
    place.log_odds[15:25, 30] = 1.0
    navigator.look(pose, place)
    assert navigator.replans == 1
    assert np.abs(navigator.path[:, 1] - 2.0).max() > 0.6
