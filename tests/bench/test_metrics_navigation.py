"""The navigation metric on small maps whose answer is known."""

from itertools import pairwise

import numpy as np
import pytest

from bench.errors import BenchError
from bench.metrics.navigation import collides, evaluate, prepare, sample_pairs
from vslam.occupancy import OccupancyGrid
from vslam.planner import Planner

ORIGIN = np.array([-2.0, 1.0])


def rooms() -> np.ndarray:
    """8 m × 5 m, a wall across with one door of 1.5 m."""
    blocked = np.zeros((50, 80), bool)
    blocked[[0, -1]] = blocked[:, [0, -1]] = True
    blocked[:, 40] = True
    blocked[15:30, 40] = False
    return blocked


def as_estimate(blocked: np.ndarray, shift=(0.0, 0.0)) -> OccupancyGrid:
    return OccupancyGrid(ORIGIN + shift, 0.1, np.where(blocked, 2.0, -2.0).astype(np.float32))


def task(seed: int = 1):
    return prepare(rooms(), ORIGIN, 0.1, 0.3, np.random.default_rng(seed), min_distance_m=2.0)


def test_the_true_map_scores_one():
    scores = evaluate(as_estimate(rooms()), task())
    assert (scores.success, scores.planned) == (1.0, 1.0)
    assert scores.cost_ratio == pytest.approx(1.0, abs=1e-12)


def test_a_map_shifted_by_less_than_the_margin_still_holds():
    scores = evaluate(as_estimate(rooms(), (0.05, -0.05)), task())
    assert scores.success == 1.0
    assert scores.cost_ratio == pytest.approx(1.0, abs=0.03)


def test_a_map_shifted_by_a_metre_runs_into_the_wall():
    scores = evaluate(as_estimate(rooms(), (0.0, 1.0)), task())
    assert scores.success < 0.7


def test_a_missing_wall_is_collided_with():
    blind = rooms()
    blind[:, 40] = False
    blind[[0, -1], 40] = True
    t = task()
    scores = evaluate(as_estimate(blind), t)
    crosses = (t.pairs[:, 0, 0] < 2.05) != (t.pairs[:, 1, 0] < 2.05)
    assert crosses.any() and scores.planned == 1.0
    assert scores.success < 1.0


def test_a_closed_door_leaves_only_pairs_of_one_room():
    shut = rooms()
    shut[:, 40] = True
    t = task()
    crosses = (t.pairs[:, 0, 0] < 2.05) != (t.pairs[:, 1, 0] < 2.05)
    scores = evaluate(as_estimate(shut), t)
    assert scores.success == scores.planned == pytest.approx(1.0 - crosses.mean())


def test_an_obstacle_that_is_not_there_costs_a_detour():
    phantom = rooms()
    phantom[16:29, 20] = True
    scores = evaluate(as_estimate(phantom), task())
    assert scores.cost_ratio > 1.0 and scores.success > 0.7


def test_an_empty_map_has_no_plan():
    scores = evaluate(OccupancyGrid.empty((-2, 1, 6, 6), 0.1), task())
    assert scores.success == 0.0 and scores.planned == 0.0 and np.isnan(scores.cost_ratio)


def test_optima_are_those_of_a_planner_on_the_true_map():
    t = task()
    planner = Planner.of_blocked(rooms(), ORIGIN, 0.1, t.planner_radius_m)
    assert t.planner_radius_m == pytest.approx(0.4)
    expected = [planner.plan(*pair).cost_m for pair in t.pairs]
    np.testing.assert_array_equal(t.optimum_m, expected)
    straight = np.linalg.norm(t.pairs[:, 0] - t.pairs[:, 1], axis=1)
    assert (t.optimum_m >= straight - 1e-9).all() and (straight >= 2.0).all()


def test_same_generator_same_pairs():
    np.testing.assert_array_equal(task(5).pairs, task(5).pairs)
    assert (task(5).pairs != task(6).pairs).any()


def test_pairs_lie_in_free_cells():
    free = np.zeros((30, 40), bool)
    free[3:9, 5:35] = True
    pairs = sample_pairs(free, ORIGIN, 0.1, np.random.default_rng(0), 50, 1.0)
    col, row = np.floor((pairs.reshape(-1, 2) - ORIGIN) / 0.1).astype(int).T
    assert free[row, col].all()


def test_maps_without_room_are_refused():
    with pytest.raises(BenchError, match="no free cell"):
        prepare(np.ones((20, 20), bool), ORIGIN, 0.1, 0.3, np.random.default_rng(0))
    with pytest.raises(BenchError, match="apart"):
        prepare(rooms(), ORIGIN, 0.1, 0.3, np.random.default_rng(0), min_distance_m=50.0)
    with pytest.raises(BenchError, match="2-d bool"):
        prepare(np.zeros((20, 20)), ORIGIN, 0.1, 0.3, np.random.default_rng(0))


def test_collision_between_the_vertices():
    blocked = np.zeros((10, 10), bool)
    blocked[5, 5] = True
    assert collides(np.array([[0.5, 5.5], [9.5, 5.5]]), blocked, [0, 0], 1.0)
    assert not collides(np.array([[0.5, 4.5], [9.5, 4.5]]), blocked, [0, 0], 1.0)
    assert collides(np.array([[4.5, 5.05], [5.1, 4.9], [6.0, 5.3]]), blocked, [0, 0], 1.0)
    assert collides(np.array([[8.0, 8.0], [8.0, 11.0]]), blocked, [0, 0], 1.0), "outside the map"


def test_collision_against_dense_sampling():
    rng = np.random.default_rng(4)
    blocked = rng.random((20, 30)) < 0.05
    outcomes = []
    for _ in range(300):
        path = rng.uniform([0.1, 0.1], [2.9, 1.9], (3, 2))
        t = np.linspace(0, 1, 20001)[:, None]
        dense = np.vstack([a + t * (b - a) for a, b in pairwise(path)])
        col, row = np.floor(dense / 0.1).astype(int).T
        hits = blocked[row, col].sum()
        if 0 < hits < 5:
            continue  # grazes a corner by less than the sampling resolves
        outcomes.append((collides(path, blocked, [0, 0], 0.1), bool(hits)))
    got, expected = np.array(outcomes).T
    np.testing.assert_array_equal(got, expected)
    assert 0.2 < expected.mean() < 0.95
