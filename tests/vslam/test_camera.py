"""The calibration against OpenCV's two camera models, and against itself."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vslam.camera import Calibration, mounted, mounting
from vslam.errors import VslamError

MODELS = [("fisheye", 150.0), ("pinhole", 90.0)]


def camera_matrix(c: Calibration) -> np.ndarray:
    return np.array([[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1.0]])


def points_ahead(n: int = 200) -> np.ndarray:
    rng = np.random.default_rng(1)
    return rng.uniform([-3, -2, 0.5], [3, 2, 6], (n, 3))


def test_fisheye_agrees_with_opencv_fisheye():
    c = mounted("fisheye")
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


BENT = [
    ("pinhole", (180.0, 170.0), (-0.25, 0.11, 1e-3, -2e-3)),
    ("pinhole", (200.0, 200.0), (0.4, 0.05, -1e-3, 5e-4, 0.01, 0.7, 0.15, 0.02)),
    ("pinhole", (250.0, 250.0), (0.3, 0.1, 0.0, 0.0, 0.05)),
    ("fisheye", (120.0, 110.0), (0.04, -0.01, 2e-3, -1e-4)),
    ("fisheye", (110.0, 115.0), (-0.02, 0.01, -8e-3, 1e-3)),
]


def bent(model, focal, distortion):
    return Calibration(model, 320, 240, *focal, 163.0, 112.5, mounting(1.2, 0.1, 25.0), distortion)


@pytest.mark.parametrize("numbers", BENT, ids=str)
def test_distortion_is_opencv_s(numbers):
    c = bent(*numbers)
    project = cv2.fisheye.projectPoints if c.model == "fisheye" else cv2.projectPoints
    points = points_ahead() * (0.2, 0.2, 1.0)
    expected, _ = project(points[None], np.zeros(3), np.zeros(3), camera_matrix(c), np.array(c.distortion))
    np.testing.assert_allclose(c.project(points)[0], expected.reshape(-1, 2), atol=1e-9)


@pytest.mark.parametrize("numbers", BENT, ids=str)
def test_distorted_pixels_come_back(numbers):
    """Each pixel's direction, and the pixel that shows it: to 1e-6 px, from edge to edge."""
    c = bent(*numbers)
    rays = c.rays().reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0, rtol=1e-12)
    pixels, valid = c.project(rays)
    np.testing.assert_allclose(pixels, c.pixel_grid(), atol=1e-6)
    assert valid.all()


@pytest.mark.parametrize("numbers", BENT, ids=str)
def test_floor_jacobian_is_the_derivative_under_distortion(numbers):
    c = bent(*numbers)
    pixels = np.array([[40.0, 200.0], [c.cx, c.cy], [160.3, 239.0], [280.0, 190.5]])
    _, jacobian = c.floor_points(pixels)
    for k, offset in enumerate(np.eye(2) * 1e-4):
        numeric = (c.floor_points(pixels + offset)[0] - c.floor_points(pixels - offset)[0]) / 2e-4
        np.testing.assert_allclose(jacobian[:, :, k], numeric, rtol=1e-5, atol=1e-8)


def test_what_distortion_brings_back_is_not_in_the_picture():
    """k1 = −0.3 folds at a tangent of 1.05, and leads 60° back to 10°."""
    c = Calibration("pinhole", 320, 240, 290.0, 290.0, 159.5, 119.5, np.eye(4), (-0.3, 0.0, 0.0, 0.0))
    pixels, valid = c.project([[np.sqrt(3.0), 0.0, 1.0], [0.17, 0.0, 1.0]])
    assert 159.5 < pixels[0, 0] < 319.0
    assert valid.tolist() == [False, True]


@pytest.mark.parametrize(
    ("model", "distortion", "says"),
    [
        ("pinhole", (-0.3, 0.0, 0.0, 0.0), "folds inside the picture"),
        ("fisheye", (-0.3, 0.0, 0.0, 0.0), "folds inside the picture"),
        ("pinhole", (0.1,), "finite numbers"),
        ("fisheye", (np.nan, 0.0, 0.0, 0.0), "finite numbers"),
    ],
)
def test_impossible_distortions_are_refused(model, distortion, says):
    with pytest.raises(VslamError, match=says):
        bent(model, (100.0, 100.0), distortion)


def test_field_of_view_spans_the_picture():
    c = mounted("fisheye", fov_deg=150.0)
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
