"""The virtual scan of analytic rooms."""

import numpy as np
import pytest

from vslam.camera import Calibration, mounted
from vslam.errors import VslamError
from vslam.scan import ScanSettings, scan


def room_depth(c: Calibration, wall_x: float, wall_bottom: float = 0.0, wall_top: float = 3.0) -> np.ndarray:
    """z of an endless floor and a wall at x = wall_x between two heights; 0 where a ray meets neither."""
    rays = c.rays() @ c.T_robot_camera[:3, :3].T
    start = c.T_robot_camera[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        to_floor = np.where(rays[..., 2] < 0, -start[2] / rays[..., 2], np.inf)
        to_wall = np.where(rays[..., 0] > 0, (wall_x - start[0]) / rays[..., 0], np.inf)
        height = start[2] + to_wall * rays[..., 2]
    to_wall[(height < wall_bottom) | (height > wall_top)] = np.inf
    distance = np.minimum(to_floor, to_wall)
    z = distance * c.rays()[..., 2]
    return np.where(np.isfinite(z) & (z > 0), z, 0.0).astype(np.float32)


@pytest.mark.parametrize("model", ["fisheye", "pinhole"])
def test_wall_ahead_is_found_at_its_distance(model):
    c = mounted(model, fov_deg=150.0 if model == "fisheye" else 90.0, forward_m=0.1)
    s = scan(room_depth(c, wall_x=3.0), c)
    assert len(s.bearings) == 151
    np.testing.assert_allclose(np.degrees(s.bearings[[0, 75, 150]]), [-75, 0, 75], atol=1e-9)
    np.testing.assert_allclose(s.origin, [0.1, 0.0])
    middle = np.abs(s.bearings) < np.radians(30)
    assert s.hit[middle].all()
    # A pixel counts for the bearing half a degree around it.
    np.testing.assert_allclose(s.ranges[middle], 2.9 / np.cos(s.bearings[middle]), rtol=0.01)


def test_depth_noise_does_not_pull_the_wall_nearer():
    c = mounted()
    depth = room_depth(c, wall_x=4.0)
    noisy = depth + np.random.default_rng(0).normal(0.0, 0.0014, depth.shape) * depth**2
    s = scan(noisy.astype(np.float32), c)
    middle = np.abs(s.bearings) < np.radians(30)
    error = s.ranges[middle] - 4.0 / np.cos(s.bearings[middle])
    assert abs(error.mean()) < 0.01 and np.abs(error).max() < 0.05


def test_open_floor_is_free_to_the_sensor_range():
    c = mounted()
    s = scan(room_depth(c, wall_x=1e6), c, ScanSettings(max_range_m=5.0))
    assert not s.hit.any()
    np.testing.assert_allclose(s.ranges[np.abs(s.bearings) < np.radians(60)], 5.0)


def test_wall_beyond_range_is_no_hit():
    c = mounted()
    s = scan(room_depth(c, wall_x=6.0), c, ScanSettings(max_range_m=4.0))
    assert not s.hit[np.abs(s.bearings) < np.radians(40)].any()


@pytest.mark.parametrize(
    ("bottom", "top", "blocks"), [(0.0, 0.09, False), (1.05, 3.0, False), (0.3, 0.6, True)]
)
def test_only_heights_of_the_robot_block(bottom, top, blocks):
    c = mounted()
    s = scan(room_depth(c, 2.0, bottom, top), c)
    assert s.hit[75] == blocks
    if not blocks and bottom > 1.0:
        assert s.ranges[75] > 2.0


def test_no_reading_says_nothing():
    c = mounted()
    for nothing in (0.0, np.nan, np.inf):
        s = scan(np.full((240, 320), nothing, np.float32), c)
        assert not s.hit.any() and (s.ranges == 0).all()


def test_input_unchanged_and_wrong_size_refused():
    c = mounted()
    depth = room_depth(c, 3.0)
    before = depth.copy()
    scan(depth, c)
    np.testing.assert_array_equal(depth, before)
    with pytest.raises(VslamError, match="depth is"):
        scan(depth[:100], c)
