"""Cameras against OpenCV, and against themselves there and back."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

from renderers.camera import Fisheye, Intrinsics, Mount, Pinhole, T_world_robot, pixel_grid
from renderers.errors import RendererError

PLAIN = [Pinhole(320, 240, 90.0), Pinhole(33, 20, 45.0), Fisheye(320, 240, 150.0), Fisheye(64, 48, 200.0)]
BENT = [
    Pinhole(96, 72, 80.0, (-0.25, 0.11, 1e-3, -2e-3)),
    Pinhole(96, 72, Intrinsics(58.0, 33.0, 47.8, 36.2), (-0.25, 0.11, 0.0, 0.0, 0.01)),
    Pinhole(96, 72, 100.0, (0.4, 0.05, -1e-3, 5e-4, 0.01, 0.7, 0.15, 0.02)),  # a wide lens, as calibrated
    Pinhole(96, 72, 60.0, (0.3, 0.1, 0.0, 0.0)),  # a pincushion
    Fisheye(96, 72, 170.0, (-0.02, 0.01, -0.008, 0.001)),
    Fisheye(96, 72, Intrinsics(30.0, 31.0, 44.0, 39.0), (0.03, -0.004, 0.001, -0.0002)),
]
CAMERAS = PLAIN + BENT
AHEAD = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.2, 10))


def matrix(camera):
    k = camera.intrinsics
    return np.array([[k.fx, 0, k.cx], [0, k.fy, k.cy], [0, 0, 1]])


def opencv(camera, points):
    """OpenCV's pixels of (n, 3) points."""
    project = cv2.fisheye.projectPoints if isinstance(camera, Fisheye) else cv2.projectPoints
    shape = (4,) if isinstance(camera, Fisheye) else (max(4, len(camera.distortion)),)
    distortion = np.zeros(shape)
    distortion[: len(camera.distortion)] = camera.distortion
    pixels, _ = project(points[None], np.zeros(3), np.zeros(3), matrix(camera), distortion)
    return pixels.reshape(-1, 2)


def small(size):
    return st.floats(-size, size)


INTRINSICS = st.builds(
    Intrinsics, st.floats(100, 600), st.floats(100, 600), st.floats(100, 220), st.floats(60, 180)
)
PINHOLES = st.tuples(INTRINSICS, small(0.3), small(0.2), small(5e-3), small(5e-3), small(0.1))
RATIONAL = st.tuples(small(0.5), small(0.2), small(0.05))
FISHEYES = st.tuples(INTRINSICS, small(0.1), small(0.05), small(0.02), small(0.01))


def camera_or_reject(model, intrinsics, distortion):
    try:
        return model(320, 240, intrinsics, distortion)
    except RendererError as error:
        assert "folds inside" in str(error)
        return reject()


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


def check_against_opencv(camera, points):
    """The same pixels from points, and each pixel's direction back to itself to 1e-6 px."""
    np.testing.assert_allclose(camera.project(points)[0], opencv(camera, points), rtol=1e-9, atol=1e-7)
    u, v = np.meshgrid(np.linspace(-0.5, camera.width - 0.5, 23), np.linspace(-0.5, camera.height - 0.5, 17))
    pixels = np.stack([u.ravel(), v.ravel()], axis=-1)
    rays = camera.unproject(pixels)
    np.testing.assert_allclose(camera.project(rays)[0], pixels, atol=1e-6)
    ahead = rays[:, 2] > 0.05
    np.testing.assert_allclose(opencv(camera, rays[ahead]), pixels[ahead], atol=1e-6)


ODD = settings(suppress_health_check=[HealthCheck.filter_too_much], deadline=None)


@ODD
@given(PINHOLES, st.none() | RATIONAL, st.lists(AHEAD, min_size=1, max_size=5))
def test_any_distorted_pinhole_is_opencv_s(numbers, rational, points):
    intrinsics, *distortion = numbers
    camera = camera_or_reject(Pinhole, intrinsics, (*distortion, *(rational or ())))
    points = np.array(points)
    check_against_opencv(camera, points / [3, 3, 1] + [0, 0, 1])


@ODD
@given(FISHEYES, st.lists(AHEAD, min_size=1, max_size=5))
def test_any_distorted_fisheye_is_opencv_s(numbers, points):
    intrinsics, *distortion = numbers
    check_against_opencv(camera_or_reject(Fisheye, intrinsics, tuple(distortion)), np.array(points))


@pytest.mark.parametrize("camera", BENT, ids=repr)
def test_directions_are_opencv_s(camera):
    """Its own inverses, which iterate in other ways, agree where they converge."""
    pixels = pixel_grid(camera).reshape(1, -1, 2)
    rays = camera.unproject(pixels[0])
    stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 300, 1e-14)
    distortion = np.array(camera.distortion)
    if isinstance(camera, Fisheye):
        plane = cv2.fisheye.undistortPoints(pixels, matrix(camera), distortion, criteria=stop)[0]
    else:
        plane = cv2.undistortPoints(pixels, matrix(camera), distortion, criteria=stop)[:, 0]
    ahead = rays[:, 2] > 0.2
    assert ahead.mean() > 0.7
    mine = rays[ahead, :2] / rays[ahead, 2:]
    np.testing.assert_allclose(mine, plane[ahead], rtol=1e-6, atol=1e-6)


def test_opencv_calibrates_our_camera():
    """From our camera's pictures of a board, `cv2.calibrateCamera` finds the camera's numbers."""
    camera, rng = BENT[0], np.random.default_rng(3)
    board = np.stack(np.meshgrid(np.arange(9.0), np.arange(7.0), [0.0]), axis=-1).reshape(-1, 3)
    board = (board - board.mean(axis=0)) * 0.12
    objects, images = [], []
    for _ in range(15):
        R, _ = cv2.Rodrigues(rng.uniform(-0.5, 0.5, 3))
        pixels, _ = camera.project(board @ R.T + [*rng.uniform(-0.2, 0.2, 2), rng.uniform(0.7, 1.0)])
        objects.append(board.astype(np.float32))
        images.append(pixels.astype(np.float32))
    error, K, found, *_ = cv2.calibrateCamera(
        objects, images, (camera.width, camera.height), None, None, flags=cv2.CALIB_FIX_K3
    )
    assert error < 1e-3
    np.testing.assert_allclose(K, matrix(camera), atol=0.01)
    np.testing.assert_allclose(found.ravel()[:4], camera.distortion, atol=2e-3)


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
def test_unprojected_pixels_project_to_themselves(camera):
    pixels = pixel_grid(camera)
    rays = camera.unproject(pixels)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1.0, rtol=1e-12)
    again, inside = camera.project(rays * 7.0)
    np.testing.assert_allclose(again, pixels, atol=1e-8)
    assert inside.all()


@given(st.sampled_from(PLAIN), AHEAD)
def test_projected_points_unproject_to_their_direction(camera, point):
    pixels, _ = camera.project(np.array([point]))
    np.testing.assert_allclose(camera.unproject(pixels)[0], point / np.linalg.norm(point), atol=1e-9)


def test_field_of_view_reaches_from_edge_to_edge():
    for camera, half in (
        (Pinhole(320, 240, 90.0), 45.0),
        (Pinhole(320, 240, 90.0, (-0.2, 0.05, 0.0, 0.0)), 45.0),
        (Fisheye(320, 240, 150.0), 75.0),
        (Fisheye(320, 240, 150.0, (0.05, -0.01, 0.0, 0.0)), 75.0),
    ):
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


def test_points_that_the_polynomials_bring_back_are_not_in_the_picture():
    """k1 < 0 folds at |p| = 1/√(3 · 0.3) = 1.05: tan 60° comes back to 0.17, and OpenCV draws it there."""
    camera = Pinhole(320, 240, 60.0, (-0.3, 0.0, 0.0, 0.0))
    points = np.array([[np.tan(np.radians(60.0)), 0.0, 1.0], [0.17, 0.0, 1.0]])
    pixels, inside = camera.project(points)
    np.testing.assert_allclose(pixels, opencv(camera, points))
    assert (pixels >= 0).all() and (pixels < (320, 240)).all()
    assert inside.tolist() == [False, True]


@pytest.mark.parametrize("factor", [2, 3])
@pytest.mark.parametrize("camera", PLAIN, ids=repr)
def test_enlarged_camera_splits_each_pixel_evenly(camera, factor):
    large = camera.enlarged(factor)
    rays = large.unproject(pixel_grid(large))
    pixels, _ = camera.project(rays)
    blocks = pixels.reshape(camera.height, factor, camera.width, factor, 2)
    np.testing.assert_allclose(blocks.mean(axis=(1, 3)), pixel_grid(camera), atol=1e-8)


@pytest.mark.parametrize("camera", BENT, ids=repr)
def test_enlarged_camera_looks_where_the_small_one_does(camera):
    """Sample (3 u + 1, 3 v + 1) of a camera three times as large lies on pixel (u, v)."""
    large = camera.enlarged(3)
    assert (large.width, large.height) == (3 * camera.width, 3 * camera.height)
    pixels = pixel_grid(camera)
    np.testing.assert_allclose(large.unproject(3 * pixels + 1), camera.unproject(pixels), atol=1e-9)


NARROW = Intrinsics(100.0, 100.0, 159.5, 119.5)


@pytest.mark.parametrize(
    ("make", "arguments", "says"),
    [
        (Pinhole, (0, 10, 60.0), "camera 0 × 10: both sides must be positive"),
        (Fisheye, (10, -1, 60.0), "camera 10 × -1: both sides"),
        (Pinhole, (10, 10, 0.0), "field of view of a pinhole must lie above 0° and below 180°"),
        (Pinhole, (10, 10, 180.0), "field of view of a pinhole"),
        (Fisheye, (10, 10, 400.0), "field of view of a fisheye must lie above 0° and below 360°"),
        (Fisheye, (10, 10, float("nan")), "field of view"),
        (Fisheye, (320, 240, 300.0), "180° off the axis lies inside the picture"),
        (Pinhole, (320, 240, Intrinsics(0.0, 100.0, 160.0, 120.0)), "fx and fy positive"),
        (Pinhole, (320, 240, Intrinsics(100.0, 100.0, float("inf"), 120.0)), "finite numbers"),
        (Pinhole, (320, 240, 60.0, (0.1,)), "distortion of a pinhole is 0, 4, 5 or 8 finite numbers"),
        (Fisheye, (320, 240, 90.0, (0.1,) * 5), "distortion of a fisheye is 0 or 4 finite numbers"),
        (Fisheye, (320, 240, 90.0, (float("nan"), 0.0, 0.0, 0.0)), "finite numbers"),
        (Pinhole, (320, 240, NARROW, (-0.2, 0.0, 0.0, 0.0)), "folds inside the picture"),
        (Pinhole, (320, 240, 120.0, (-0.3, 0.0, 0.0, 0.0)), "folds inside the picture"),
        (Pinhole, (320, 240, NARROW, (0.0, 0.0, 0.1, 0.1)), "folds inside the picture"),
        (Fisheye, (320, 240, NARROW, (-0.2, 0.0, 0.0, 0.0)), "folds inside the picture"),
    ],
)
def test_impossible_cameras(make, arguments, says):
    with pytest.raises(RendererError) as caught:
        make(*arguments)
    assert says in str(caught.value) and "\n" not in str(caught.value)


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
