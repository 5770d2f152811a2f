"""Plans on occupancy grids: inflation, unknown cells, failures."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from vslam.errors import VslamError
from vslam.occupancy import OccupancyGrid
from vslam.planner import Plan, PlanFailure, Planner, inflate, plan


def known_grid(blocked: np.ndarray, resolution: float = 0.1) -> OccupancyGrid:
    return OccupancyGrid(np.array([-1.0, 2.0]), resolution, np.where(blocked, 2.0, -2.0).astype(np.float32))


def room(side: int = 40) -> np.ndarray:
    blocked = np.zeros((side, side), bool)
    blocked[[0, -1]] = blocked[:, [0, -1]] = True
    return blocked


def test_inflation_is_the_distance_between_centres():
    blocked = np.random.default_rng(5).random((25, 31)) < 0.02
    cells = np.argwhere(np.ones_like(blocked))
    nearest = cdist(cells, np.argwhere(blocked)).min(axis=1).reshape(blocked.shape) * 0.1
    np.testing.assert_array_equal(inflate(blocked, 0.33, 0.1), nearest <= 0.33)
    np.testing.assert_array_equal(inflate(blocked, 0.0, 0.1), blocked)
    assert not inflate(np.zeros((4, 4), bool), 1.0, 0.1).any()


def test_straight_plan_in_a_free_room():
    result = plan(known_grid(room()), [0.0, 4.0], [2.0, 4.0], 0.2)
    assert isinstance(result, Plan)
    assert 2.0 <= result.cost_m <= 2.1  # the ends lie on cell borders, the way between on centres
    np.testing.assert_allclose(result.path[[0, -1]], [[0.0, 4.0], [2.0, 4.0]])


def test_plan_keeps_the_robots_radius():
    blocked = room()
    blocked[20, :30] = True
    result = plan(known_grid(blocked), [0.0, 3.0], [0.0, 5.0], 0.3)
    assert isinstance(result, Plan)
    obstacles = np.argwhere(blocked)[:, ::-1] * 0.1 + 0.05 + [-1.0, 2.0]
    assert cdist(result.path, obstacles).min() > 0.3
    assert result.cost_m > 4.0


def test_gap_narrower_than_the_robot_is_closed():
    blocked = room()
    blocked[20] = True
    blocked[20, 18:22] = False
    ends = [0.0, 3.0], [0.0, 5.0]
    assert isinstance(plan(known_grid(blocked), *ends, 0.1), Plan)
    assert plan(known_grid(blocked), *ends, 0.3) == PlanFailure("goal cannot be reached")


def test_unknown_cells_block_only_on_request():
    grid = known_grid(room())
    grid.log_odds[20, :] = 0.0
    ends = [0.0, 3.0], [0.0, 5.0]
    assert plan(grid, *ends, 0.2) == PlanFailure("goal cannot be reached")
    assert isinstance(plan(grid, *ends, 0.2, unknown_is_blocked=False), Plan)
    grid.log_odds[20, 15] = -2.0
    assert isinstance(plan(grid, *ends, 0.2), Plan), "unknown cells are not inflated"


def test_failures_are_named():
    grid = known_grid(room())
    assert "start" in plan(grid, [-0.95, 3.0], [1.0, 3.0], 0.2).reason
    assert "outside" in plan(grid, [0.0, 3.0], [50.0, 3.0], 0.2).reason
    assert "finite" in plan(grid, [0.0, np.nan], [1.0, 3.0], 0.2).reason
    with pytest.raises(VslamError, match="radius"):
        plan(grid, [0.0, 3.0], [1.0, 3.0], -0.2)


def test_start_is_goal():
    result = plan(known_grid(room()), [0.5, 3.0], [0.5, 3.0], 0.2)
    assert isinstance(result, Plan) and result.cost_m == 0.0
    np.testing.assert_allclose(result.path, [[0.5, 3.0], [0.5, 3.0]])


def test_a_prepared_planner_gives_the_same_plans():
    grid = known_grid(room())
    prepared = Planner.of_grid(grid, 0.3)
    certain = Planner.of_blocked(room(), grid.origin, grid.resolution, 0.3)
    rng = np.random.default_rng(2)
    for _ in range(20):
        start, goal = rng.uniform([-0.5, 2.5], [2.5, 5.5], (2, 2))
        single = plan(grid, start, goal, 0.3)
        np.testing.assert_array_equal(prepared.plan(start, goal).path, single.path)
        np.testing.assert_array_equal(certain.plan(start, goal).path, single.path)
