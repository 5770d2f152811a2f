"""A map follows the track that a smoother moves."""

import numpy as np
import pytest

from vslam.errors import VslamError
from vslam.mapper import Mapper
from vslam.occupancy import OccupancyGrid
from vslam.scan import Scan

BOUNDS = (-1.0, -4.0, 9.0, 4.0)


def wall_ahead(distance: float) -> Scan:
    """A wall across the way, seen by a fan of beams."""
    bearings = np.radians(np.linspace(-30, 30, 61))
    return Scan(bearings, distance / np.cos(bearings), np.ones(61, bool))


def drive(poses: np.ndarray) -> Mapper:
    mapper = Mapper(BOUNDS, 0.1)
    for pose in poses:
        mapper.add(pose, wall_ahead(6.0 - pose[0]))
    return mapper


def test_moved_poses_give_the_map_of_a_drive_along_them():
    true = np.column_stack([np.linspace(0, 3, 8), np.zeros(8), np.zeros(8)])
    drifted = true + np.column_stack([np.zeros(8), np.linspace(0, 0.6, 8), np.linspace(0, 0.1, 8)])
    mapper = Mapper(BOUNDS, 0.1)
    for pose, at in zip(drifted, true, strict=True):
        mapper.add(pose, wall_ahead(6.0 - at[0]))
    assert not np.array_equal(mapper.grid.log_odds, drive(true).grid.log_odds)
    assert mapper.move(true)
    np.testing.assert_array_equal(mapper.grid.log_odds, drive(true).grid.log_odds)
    np.testing.assert_array_equal(mapper.poses, true)


def test_less_than_half_a_cell_is_not_worth_it():
    poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    mapper = drive(poses)
    before = mapper.grid
    assert not mapper.move(poses + np.array([0.01, 0.0, 0.001])) and mapper.grid is before
    assert mapper.move(poses + np.array([0.0, 0.0, 0.02]))  # the wall is 6 m away: 12 cm


def test_an_empty_map_has_nothing_to_move():
    assert not Mapper(BOUNDS, 0.1).move(np.zeros((0, 3)))


@pytest.mark.parametrize("poses", [np.zeros((1, 3)), np.full((2, 3), np.nan), np.zeros((2, 2))])
def test_there_is_one_finite_pose_for_each_scan(poses):
    mapper = drive(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    with pytest.raises(VslamError, match="for 2 scans"):
        mapper.move(poses)


def test_a_bad_pose_leaves_the_map_as_it_was():
    mapper = drive(np.zeros((1, 3)))
    before = mapper.grid.log_odds.copy()
    with pytest.raises(VslamError, match="not finite"):
        mapper.add(np.array([np.nan, 0, 0]), wall_ahead(2.0))
    np.testing.assert_array_equal(mapper.grid.log_odds, before)
    assert isinstance(mapper.grid, OccupancyGrid) and len(mapper.poses) == 1
