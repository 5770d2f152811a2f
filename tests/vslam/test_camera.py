"""The calibration against OpenCV's two camera models, and against itself."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vslam.camera import Calibration, mounted
from vslam.errors import VslamError

MODELS = [("equidistant", 150.0), ("pinhole", 90.0)]


def camera_matrix(c: Calibration) -> np.ndarray:
    return np.array([[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1.0]])


def points_ahead(n: int = 200) -> np.ndarray:
    rng = np.random.default_rng(1)
    return rng.uniform([-3, -2, 0.5], [3, 2, 6], (n, 3))


def test_equidistant_agrees_with_opencv_fisheye():
    c = mounted("equidistant")
    points = points_ahead()
    expected, _ = cv2.fisheye.projectPoints(
        points[None], np.zeros(3), np.zeros(3), camera_matrix(c), np.zeros(4)
    )
    np.testing.assert_allclose(c.project(points)[0], expected[0], atol=1e-9)


def test_pinhole_agrees_with_opencv():
    c = mounted("pinhole", fov_deg=90.0)
    points = points_ahead()
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera_matrix(c), np.zeros(4))
    np.testing.assert_allclose(c.project(points)[0], expected[:, 0], atol=1e-9)


def test_field_of_view_spans_the_picture():
    c = mounted("equidistant", fov_deg=150.0)
    left, right = c.unproject([[-0.5, c.cy], [c.width - 0.5, c.cy]])
    assert np.degrees(np.arccos(left @ right)) == pytest.approx(150.0)


def test_mounting_looks_forward_and_down():
    c = mounted(pitch_deg=25.0, height_m=1.2, forward_m=0.1)
    axis = c.T_robot_camera[:3, :3] @ [0, 0, 1]
    np.testing.assert_allclose(axis, [np.cos(np.radians(25)), 0, -np.sin(np.radians(25))], atol=1e-12)
    np.testing.assert_allclose(c.T_robot_camera[:3, :3] @ [1, 0, 0], [0, -1, 0], atol=1e-12)
    assert np.linalg.det(c.T_robot_camera[:3, :3]) == pytest.approx(1.0)
    point, _ = c.floor_points([[c.cx, c.cy]])
    np.testing.assert_allclose(point[0], [0.1 + 1.2 / np.tan(np.radians(25)), 0.0], atol=1e-12)


@pytest.mark.parametrize(("model", "fov"), MODELS)
@given(u=st.floats(0, 319), v=st.floats(0, 239))
def test_project_inverts_unproject(model, fov, u, v):
    c = mounted(model, fov_deg=fov)
    rays = c.unproject([[u, v]])
    assert np.linalg.norm(rays) == pytest.approx(1.0)
    pixels, valid = c.project(3.7 * rays)
    assert valid[0]
    np.testing.assert_allclose(pixels, [[u, v]], atol=1e-8)


@pytest.mark.parametrize(("model", "fov"), MODELS)
@given(x=st.floats(0.3, 8.0), y=st.floats(-3.0, 3.0))
def test_floor_points_invert_projection_of_the_floor(model, fov, x, y):
    c = mounted(model, fov_deg=fov)
    p_camera = np.linalg.inv(c.T_robot_camera) @ [x, y, 0, 1]
    pixels, _ = c.project(p_camera[None, :3])
    if np.isnan(pixels).any():  # a pinhole sees nothing behind its image plane
        return
    points, _ = c.floor_points(pixels)
    np.testing.assert_allclose(points, [[x, y]], atol=1e-6)


@pytest.mark.parametrize(("model", "fov"), MODELS)
def test_floor_jacobian_is_the_derivative(model, fov):
    c = mounted(model, fov_deg=fov)
    pixels = np.array([[10.0, 150.0], [c.cx, c.cy], [160.3, 239.0], [300.0, 110.5], [159.5, 119.50001]])
    _, jacobian = c.floor_points(pixels)
    step = 1e-4
    for k, offset in enumerate(np.eye(2) * step):
        numeric = (c.floor_points(pixels + offset)[0] - c.floor_points(pixels - offset)[0]) / (2 * step)
        np.testing.assert_allclose(jacobian[:, :, k], numeric, rtol=1e-5, atol=1e-8)


def test_nothing_of_the_floor_above_the_horizon():
    c = mounted(pitch_deg=25.0)
    horizon_row = c.cy - np.radians(25.0) * c.fy
    points, jacobian = c.floor_points([[c.cx, horizon_row - 1], [c.cx, horizon_row + 1]])
    assert np.isnan(points[0]).all() and np.isnan(jacobian[0]).all()
    assert np.isfinite(points[1]).all()


def test_rays_are_those_of_the_pixel_centres():
    c = mounted()
    rays = c.rays()
    assert rays.shape == (240, 320, 3)
    np.testing.assert_array_equal(rays[17, 201], c.unproject([[201, 17]])[0])
    assert c.rays() is rays


def test_points_behind_a_pinhole_have_no_image():
    pixels, valid = mounted("pinhole", fov_deg=90.0).project([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    assert np.isnan(pixels[0]).all() and valid.tolist() == [False, True]


@pytest.mark.parametrize(
    "arguments",
    [{"model": "pinhole", "fov_deg": 180.0}, {"height_m": 0.0}, {"model": "stereographic"}, {"width": 0}],
)
def test_impossible_cameras_are_refused(arguments):
    with pytest.raises(VslamError, match="calibration"):
        mounted(**arguments)
