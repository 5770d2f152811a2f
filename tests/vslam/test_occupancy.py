"""The occupancy grid by hand and on a simulated room."""

import numpy as np
import pytest

from vslam.errors import VslamError
from vslam.occupancy import HIGHEST, HIT, LOWEST, PASS, OccupancyGrid
from vslam.scan import Scan


def one_beam(bearing: float, length: float, hit: bool) -> Scan:
    return Scan(np.array([bearing]), np.array([length]), np.array([hit]))


def slow_cells(start, bearing, length, shape, resolution):
    """Cells under a beam by dense sampling."""
    t = np.arange(0.0, length, 1e-4)
    col = np.floor((start[0] + t * np.cos(bearing)) / resolution).astype(int)
    row = np.floor((start[1] + t * np.sin(bearing)) / resolution).astype(int)
    inside = (row >= 0) & (row < shape[0]) & (col >= 0) & (col < shape[1])
    return set(zip(row[inside].tolist(), col[inside].tolist(), strict=True))


def test_one_beam_by_hand():
    grid = OccupancyGrid.empty((0, 0, 1.0, 0.3), 0.1)
    assert grid.log_odds.shape == (3, 10)
    grid.integrate([0.05, 0.15, 0.0], one_beam(0.0, 0.5, True))
    expected = np.zeros((3, 10))
    expected[1, :5], expected[1, 5] = PASS, HIT
    np.testing.assert_allclose(grid.log_odds, expected, rtol=1e-6)
    assert grid.occupied.sum() == 1 and grid.free.sum() == 5 and grid.unknown.sum() == 24


def test_free_beam_marks_its_last_cell_free():
    grid = OccupancyGrid.empty((0, 0, 1.0, 0.3), 0.1)
    grid.integrate([0.05, 0.15, 0.0], one_beam(0.0, 0.5, False))
    assert grid.free[1, :6].all() and grid.free.sum() == 6 and not grid.occupied.any()


def test_beams_cover_the_cells_that_dense_sampling_finds():
    rng = np.random.default_rng(3)
    for _ in range(200):
        grid = OccupancyGrid.empty((0, 0, 4.0, 3.0), 0.1)
        start, bearing, length = (
            rng.uniform([-0.5, -0.5], [4.5, 3.5]),
            rng.uniform(-4, 4),
            rng.uniform(0.1, 5),
        )
        grid.integrate([*start, 0.3], one_beam(bearing - 0.3, length, False))
        found = set(map(tuple, np.argwhere(grid.free).tolist()))
        sampled = slow_cells(start, bearing, length, grid.log_odds.shape, 0.1)
        assert sampled <= found
        assert len(found - sampled) <= 2  # a corner clipped by less than the sampling step


def test_log_odds_are_clamped():
    grid = OccupancyGrid.empty((0, 0, 1, 1), 0.1)
    for _ in range(50):
        grid.integrate([0.05, 0.55, 0.0], one_beam(0.0, 0.5, True))
    assert grid.log_odds.max() == pytest.approx(HIGHEST) and grid.log_odds.min() == pytest.approx(LOWEST)


def test_a_hit_outweighs_passing_beams_of_the_same_scan():
    grid = OccupancyGrid.empty((0, 0, 1, 1), 0.1)
    bearings = np.radians([-1.0, 0.0, 1.0])
    grid.integrate(
        [0.05, 0.55, 0.0], Scan(bearings, np.array([0.9, 0.5, 0.9]), np.array([False, True, False]))
    )
    assert grid.log_odds[5, 5] == pytest.approx(HIT)


def test_scan_origin_and_pose_are_applied():
    grid = OccupancyGrid.empty((-2, -2, 2, 2), 0.1)
    scan = Scan(np.array([0.0]), np.array([1.0]), np.array([True]), origin=np.array([0.5, 0.0]))
    grid.integrate([0.05, 0.05, np.pi / 2], scan)
    assert grid.occupied[grid.cell([0.05, 1.55])] and grid.free[grid.cell([0.05, 0.6])]
    assert grid.unknown[grid.cell([0.05, 0.05])]


def test_a_square_room_is_mapped():
    grid = OccupancyGrid.empty((0, 0, 6, 6), 0.1)
    bearings = np.radians(np.arange(-75, 76.0))
    for heading in np.linspace(0, 2 * np.pi, 24, endpoint=False):
        angle = bearings + heading
        c, s = np.cos(angle), np.sin(angle)
        to_wall = 2.45 / np.maximum(np.abs(c), np.abs(s))
        grid.integrate([3.0, 3.0, heading], Scan(bearings, to_wall, np.ones(151, bool)))
    inside = np.zeros((60, 60), bool)
    inside[6:54, 6:54] = True
    assert grid.free[inside].all()
    wall = np.zeros((60, 60), bool)
    wall[5:55, 5:55] = True
    wall &= ~inside
    assert grid.occupied[wall].mean() > 0.97
    assert not grid.occupied[~wall].any()


def test_bad_grids_and_poses_are_refused():
    with pytest.raises(VslamError, match="hold no cell"):
        OccupancyGrid.empty((0, 0, 0, 1), 0.1)
    with pytest.raises(VslamError, match="not finite"):
        OccupancyGrid.empty((0, 0, 1, 1), 0.1).integrate([0, np.nan, 0], one_beam(0.0, 1.0, True))
