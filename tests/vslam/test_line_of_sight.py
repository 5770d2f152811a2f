"""Straight ways over a grid against clipping to each cell; tight paths against their grid paths."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vslam.line_of_sight import line_of_sight, pulled_tight
from vslam.planner import Plan, Planner


def clipped(blocked: np.ndarray, start: np.ndarray, end: np.ndarray) -> bool:
    """The same by cutting the segment to each blocked square (Liang & Barsky 1984)."""
    for row, col in np.argwhere(blocked):
        low, high = 0.0, 1.0
        for p, d, edge in zip(start, end - start, (col, row), strict=True):
            if d == 0.0:
                high = high if edge <= p < edge + 1 else -1.0
                continue
            near, far = sorted(((edge - p) / d, (edge + 1 - p) / d))
            low, high = max(low, near), min(high, far)
        if high - low > 1e-12:
            return False
    return True


@given(st.integers(0, 10_000))
@settings(max_examples=150, deadline=None)
def test_sight_is_what_clipping_finds(seed):
    rng = np.random.default_rng(seed)
    blocked = rng.random((12, 17)) < 0.15
    start, end = rng.random((2, 2)) * [17, 12]
    assert line_of_sight(blocked, *start, *end) == clipped(blocked, start, end)
    assert line_of_sight(blocked, *end, *start) == clipped(blocked, start, end)


@pytest.mark.parametrize("corner", [(0, 1), (1, 0)])
def test_a_segment_through_a_corner_needs_all_four_cells(corner):
    blocked = np.zeros((2, 2), bool)
    assert line_of_sight(blocked, 0.5, 0.5, 1.5, 1.5) and line_of_sight(blocked, 0.5, 1.5, 1.5, 0.5)
    blocked[corner] = True
    assert not line_of_sight(blocked, 0.5, 0.5, 1.5, 1.5)


def test_nothing_is_seen_outside_the_grid():
    blocked = np.zeros((3, 3), bool)
    assert not line_of_sight(blocked, 1.5, 1.5, 3.5, 1.5) and not line_of_sight(blocked, -0.1, 1.0, 1.0, 1.0)


def test_in_the_open_a_tight_path_is_one_segment():
    blocked = np.zeros((20, 20), bool)
    planner = Planner(blocked, np.zeros(2), 0.1)
    plan = planner.plan([0.25, 0.25], [1.75, 0.95], any_angle=True)
    assert isinstance(plan, Plan) and len(plan.path) == 2
    assert plan.cost_m == pytest.approx(np.hypot(1.5, 0.7))


@given(st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_a_tight_path_is_free_and_no_longer(seed):
    rng = np.random.default_rng(seed)
    blocked = rng.random((40, 40)) < 0.2
    blocked[0, 0] = blocked[-1, -1] = False
    planner = Planner(blocked, np.array([-2.0, 1.0]), 0.25)
    ends = [-1.9, 1.1], [7.9, 10.9]
    grid, tight = planner.plan(*ends), planner.plan(*ends, any_angle=True)
    assert isinstance(grid, Plan) == isinstance(tight, Plan)
    if isinstance(grid, Plan) and isinstance(tight, Plan):
        assert np.linalg.norm(np.subtract(*ends)) - 1e-9 <= tight.cost_m <= grid.cost_m + 1e-9
        cells = (tight.path - planner.origin) / planner.resolution
        assert all(clipped(blocked, a, b) for a, b in pairwise(cells))
        np.testing.assert_array_equal(tight.path[[0, -1]], ends)


def test_pulling_keeps_a_path_of_one_or_two_points():
    blocked = np.zeros((4, 4), bool)
    for path in (np.array([[1.5, 1.5]]), np.array([[1.5, 1.5], [2.5, 1.5]])):
        np.testing.assert_array_equal(pulled_tight(blocked, path), path)
