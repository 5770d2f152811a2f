"""A* against SciPy's Dijkstra on the same graph, and against the published Moving-AI optima."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from vslam.astar import GridPath, NoPath, shortest_path
from vslam.errors import VslamError

ARENA = Path(os.environ.get("BENCH_DATA", "")) / "movingai" / "arena.map"


def grid_graph(blocked: np.ndarray) -> coo_array:
    """The 8-connected graph without corner cutting, built by shifting the grid."""
    free = ~blocked
    padded = np.pad(free, 1)
    rows, cols = blocked.shape
    index = np.arange(blocked.size).reshape(blocked.shape)
    sources, targets, weights = [], [], []
    for dr, dc in [(0, 1), (1, 0), (1, 1), (1, -1)]:
        there = padded[1 + dr : 1 + dr + rows, 1 + dc : 1 + dc + cols]
        side_a = padded[1 + dr : 1 + dr + rows, 1 : 1 + cols]
        side_b = padded[1 : 1 + rows, 1 + dc : 1 + dc + cols]
        step = free & there & side_a & side_b
        r, c = np.nonzero(step)
        sources.append(index[r, c])
        targets.append(index[r + dr, c + dc])
        weights.append(np.full(len(r), np.hypot(dr, dc)))
    triplet = (np.concatenate(weights), (np.concatenate(sources), np.concatenate(targets)))
    return coo_array(triplet, shape=(blocked.size, blocked.size))


def assert_drivable(path: GridPath, blocked: np.ndarray, resolution: float) -> None:
    cells = path.cells
    assert not blocked[cells[:, 0], cells[:, 1]].any()
    steps = np.diff(cells, axis=0)
    assert (np.abs(steps).max(axis=1) == 1).all() if len(steps) else True
    assert not blocked[cells[1:, 0], cells[:-1, 1]].any()
    assert not blocked[cells[:-1, 0], cells[1:, 1]].any()
    assert path.cost_m == pytest.approx(np.linalg.norm(steps, axis=1).sum() * resolution, abs=1e-9)


def test_costs_equal_dijkstra_on_random_grids():
    rng = np.random.default_rng(7)
    found = 0
    for _ in range(200):
        rows, cols = rng.integers(3, 40, 2)
        blocked = rng.random((rows, cols)) < rng.uniform(0.0, 0.5)
        free = np.argwhere(~blocked)
        if len(free) == 0:
            continue
        start, goal = (tuple(int(x) for x in free[k]) for k in rng.integers(len(free), size=2))
        resolution = rng.uniform(0.05, 2.0)
        expected = dijkstra(grid_graph(blocked), directed=False, indices=start[0] * cols + start[1])
        result = shortest_path(blocked, start, goal, resolution)
        best = expected[goal[0] * cols + goal[1]] * resolution
        if np.isinf(best):
            assert result == NoPath("goal cannot be reached")
        else:
            assert isinstance(result, GridPath)
            assert result.cost_m == pytest.approx(best, abs=1e-6)
            assert tuple(result.cells[0]) == start and tuple(result.cells[-1]) == goal
            assert_drivable(result, blocked, resolution)
            found += 1
    assert found > 100


@pytest.mark.skipif(not ARENA.is_file(), reason="needs $BENCH_DATA/movingai/arena.map")
def test_published_optima_of_arena():
    lines = ARENA.read_text().splitlines()[4:]
    blocked = np.array([[c not in ".G" for c in line] for line in lines])
    scenarios = [line.split("\t") for line in ARENA.with_suffix(".map.scen").read_text().splitlines()[1:]]
    assert len(scenarios) == 160
    for *_, sx, sy, gx, gy, optimum in scenarios:
        result = shortest_path(blocked, (int(sy), int(sx)), (int(gy), int(gx)), 1.0)
        assert isinstance(result, GridPath)
        # The files round to six significant digits.
        assert result.cost_m == pytest.approx(float(optimum), abs=1e-4)


def test_start_is_goal():
    result = shortest_path(np.zeros((3, 3), bool), (1, 2), (1, 2), 0.1)
    assert isinstance(result, GridPath)
    assert result.cost_m == 0.0 and result.cells.tolist() == [[1, 2]]


def test_no_diagonal_between_two_corners():
    blocked = np.array([[False, True], [True, False]])
    assert shortest_path(blocked, (0, 0), (1, 1), 1.0) == NoPath("goal cannot be reached")
    blocked[0, 1] = False
    result = shortest_path(blocked, (0, 0), (1, 1), 1.0)
    assert isinstance(result, GridPath) and result.cost_m == 2.0


@pytest.mark.parametrize(
    ("start", "goal", "reason"),
    [
        ((0, 0), (2, 2), "start (0, 0) is blocked"),
        ((2, 2), (0, 0), "goal (0, 0) is blocked"),
        ((-1, 0), (2, 2), "start (-1, 0) lies outside the grid"),
        ((2, 2), (0, 3), "goal (0, 3) lies outside the grid"),
    ],
)
def test_impossible_ends_are_named(start, goal, reason):
    blocked = np.zeros((3, 3), bool)
    blocked[0, 0] = True
    assert shortest_path(blocked, start, goal, 1.0) == NoPath(reason)


def test_input_stays_and_bad_grids_raise():
    blocked = np.random.default_rng(0).random((20, 20)) < 0.2
    blocked[0, 0] = blocked[19, 19] = False
    before = blocked.copy()
    shortest_path(blocked, (0, 0), (19, 19), 1.0)
    np.testing.assert_array_equal(blocked, before)
    with pytest.raises(VslamError, match="2-d grid"):
        shortest_path(np.zeros(5, bool), (0, 0), (0, 1), 1.0)
    with pytest.raises(VslamError, match="resolution"):
        shortest_path(blocked, (0, 0), (0, 1), 0.0)


@pytest.mark.parametrize("spacing", [2, 3, 5])
def test_many_equal_paths(spacing):
    """Regular posts: to most cells lead several shortest ways that differ in the order of their steps."""
    blocked = np.zeros((40, 47), bool)
    blocked[spacing - 1 :: spacing, spacing - 1 :: spacing] = True
    blocked[20, 5:40] = True
    distances = dijkstra(grid_graph(blocked), directed=False, indices=0).reshape(blocked.shape)
    for goal in np.argwhere(~blocked)[::23].tolist():
        result = shortest_path(blocked, (0, 0), tuple(goal), 1.0)
        assert isinstance(result, GridPath)
        assert result.cost_m == pytest.approx(distances[tuple(goal)], abs=1e-9)
        assert_drivable(result, blocked, 1.0)
