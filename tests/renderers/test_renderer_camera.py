"""Cameras against OpenCV, and against themselves there and back."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderers.camera import Fisheye, Mount, Pinhole, T_world_robot, pixel_grid
from renderers.errors import RendererError

CAMERAS = [Pinhole(320, 240, 90.0), Pinhole(33, 20, 45.0), Fisheye(320, 240, 150.0), Fisheye(64, 48, 200.0)]
AHEAD = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.2, 10))


def matrix(camera):
    f = camera.focal
    return np.array([[f, 0, (camera.width - 1) / 2], [0, f, (camera.height - 1) / 2], [0, 0, 1]])


@given(AHEAD)
def test_pinhole_projects_as_opencv(point):
    camera = Pinhole(320, 240, 90.0)
    points = np.array([point])
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix(camera), np.zeros(5))
    np.testing.assert_allclose(camera.project(points)[0], expected[:, 0], rtol=1e-9, atol=1e-9)


@given(AHEAD)
def test_fisheye_projects_as_opencv(point):
    camera = Fisheye(320, 240, 150.0)
    points = np.array([[point]])
    expected, _ = cv2.fisheye.projectPoints(points, np.zeros(3), np.zeros(3), matrix(camera), np.zeros(4))
    np.testing.assert_allclose(camera.project(points[0])[0], expected[0], rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
def test_unprojected_pixels_project_to_themselves(camera):
    pixels = pixel_grid(camera)
    rays = camera.unproject(pixels)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1.0, rtol=1e-12)
    again, inside = camera.project(rays * 7.0)
    np.testing.assert_allclose(again, pixels, atol=1e-8)
    assert inside.all()


@given(st.sampled_from(CAMERAS), AHEAD)
def test_projected_points_unproject_to_their_direction(camera, point):
    pixels, _ = camera.project(np.array([point]))
    np.testing.assert_allclose(camera.unproject(pixels)[0], point / np.linalg.norm(point), atol=1e-9)


def test_field_of_view_reaches_from_edge_to_edge():
    for camera, half in ((Pinhole(320, 240, 90.0), 45.0), (Fisheye(320, 240, 150.0), 75.0)):
        ray = camera.unproject(np.array([-0.5, (camera.height - 1) / 2]))
        assert np.degrees(np.arctan2(-ray[0], ray[2])) == pytest.approx(half)


def test_points_out_of_the_picture():
    pinhole = Pinhole(100, 80, 90.0)
    points = np.array([[0, 0, -1.0], [1.01, 0, 1.0], [0.98, 0, 1.0], [0, 0, 0.0], [0, 0.81, 1.0]])
    np.testing.assert_array_equal(pinhole.project(points)[1], [False, False, True, False, False])
    wide = Fisheye(100, 100, 200.0)  # sees 10° behind itself
    angle = np.radians([99.0, 101.0])
    points = np.stack([np.sin(angle), np.zeros(2), np.cos(angle)], axis=-1)
    np.testing.assert_array_equal(wide.project(points)[1], [True, False])


@pytest.mark.parametrize("factor", [2, 3])
@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
def test_enlarged_camera_splits_each_pixel_evenly(camera, factor):
    large = camera.enlarged(factor)
    rays = large.unproject(pixel_grid(large))
    pixels, _ = camera.project(rays)
    blocks = pixels.reshape(camera.height, factor, camera.width, factor, 2)
    np.testing.assert_allclose(blocks.mean(axis=(1, 3)), pixel_grid(camera), atol=1e-8)


@pytest.mark.parametrize("make", [Pinhole, Fisheye])
@pytest.mark.parametrize("arguments", [(0, 10, 60.0), (10, -1, 60.0), (10, 10, 0.0), (10, 10, 400.0)])
def test_impossible_cameras(make, arguments):
    with pytest.raises(RendererError, match="field of view"):
        make(*arguments)


def test_level_camera_looks_ahead():
    T = Mount(height_m=1.5, forward_m=0.2, pitch_deg=0.0).T_robot_camera
    np.testing.assert_allclose(T @ [0, 0, 1, 1], [1.2, 0, 1.5, 1], atol=1e-12)  # z forward
    np.testing.assert_allclose(T @ [1, 0, 0, 1], [0.2, -1, 1.5, 1], atol=1e-12)  # x to the robot's right
    np.testing.assert_allclose(T @ [0, 1, 0, 1], [0.2, 0, 0.5, 1], atol=1e-12)  # y down


@given(st.floats(-80, 80))
def test_mount_is_a_rotation_that_tilts_down(pitch):
    T = Mount(pitch_deg=pitch).T_robot_camera
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    assert np.degrees(np.arcsin(-T[2, 2])) == pytest.approx(pitch)


@given(st.floats(-10, 10), st.floats(-10, 10), st.floats(-10, 10))
def test_robot_pose_maps_local_to_global(x, y, theta):
    """Equation 3-7 written with complex numbers."""
    local = 1.5 - 0.5j
    expected = (x + 1j * y) + np.exp(1j * theta) * local
    actual = T_world_robot(np.array([x, y, theta])) @ [local.real, local.imag, 0.3, 1.0]
    np.testing.assert_allclose(actual, [expected.real, expected.imag, 0.3, 1.0], atol=1e-12)
