"""Floor points under a camera that nods and rolls: analytic Jacobian against a turned camera."""

import numpy as np
import pytest

from vslam.camera import Calibration, mounted
from vslam.detect import DetectorSettings, DiscDetector
from vslam.mount_noise import mount_covariances, tilt_jacobian

POINTS = np.array([[1.0, 0.0], [2.5, 0.8], [4.0, -1.5], [0.8, 0.6]])


def turned(axis: int, angle: float, base: Calibration) -> Calibration:
    """The camera turned about the robot's axis through its own centre, right-handed."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    T = base.T_robot_camera.copy()
    T[:3, :3] = R @ T[:3, :3]
    return Calibration("pinhole", base.width, base.height, base.fx, base.fy, base.cx, base.cy, T)


@pytest.mark.parametrize(("axis", "column"), [(1, 0), (0, 1)], ids=["pitch", "roll"])
def test_jacobian_as_a_turned_camera_has_it(axis, column):
    camera = mounted("pinhole", 768, 288, 90.0, forward_m=-0.1, height_m=1.35)
    T = camera.T_robot_camera
    pixels, _ = camera.project((np.column_stack([POINTS, np.zeros(4)]) - T[:3, 3]) @ T[:3, :3])
    step = 1e-5
    ahead, behind = (turned(axis, k * step, camera).floor_points(pixels)[0] for k in (1, -1))
    np.testing.assert_allclose(
        tilt_jacobian(camera, POINTS)[:, :, column], (ahead - behind) / (2 * step), rtol=1e-6, atol=1e-7
    )


def test_nose_down_brings_points_nearer_and_the_far_ones_most():
    camera = mounted("pinhole", fov_deg=90.0, height_m=1.0)
    jacobian = tilt_jacobian(camera, np.array([[1.0, 0.0], [3.0, 0.0]]))
    np.testing.assert_allclose(jacobian[:, 0, 0], [-2.0, -10.0])  # −(h + x²/h)


def test_a_sure_mount_adds_nothing_and_a_shaky_one_limits_the_range():
    camera = mounted("pinhole", fov_deg=90.0)
    assert not mount_covariances(camera, POINTS, 0.0, 0.0).any()
    shaky = DiscDetector(camera, DetectorSettings(tilt_sigma_deg=0.5, max_sigma_m=0.05))
    centres = np.concatenate([table.centres for table in shaky._tables])
    farthest = np.nanmax(np.hypot(*shaky._floor.reshape(-1, 2)[centres].T))
    # (h + r²/h) σ = 0.05 m with h = 1.2 m
    assert farthest == pytest.approx(np.sqrt(1.2 * (0.05 / np.radians(0.5) - 1.2)), rel=0.03)


def test_mount_noise_is_in_the_detections_covariance():
    camera = mounted("pinhole", fov_deg=90.0)
    floor, _ = camera.floor_points(camera.pixel_grid())
    disc = np.hypot(*(floor - (1.6, 0.2)).T).reshape(240, 320) <= 0.15
    picture = np.repeat(np.where(disc, 230, 90).astype(np.uint8)[..., None], 3, axis=2)
    sure = DiscDetector(camera, DetectorSettings())(picture)
    shaky = DiscDetector(camera, DetectorSettings(tilt_sigma_deg=0.3, position_sigma_m=0.01))(picture)
    assert len(sure) == len(shaky) == 1
    added = mount_covariances(camera, sure.points, np.radians(0.3), 0.01)
    np.testing.assert_allclose(shaky.covariances - sure.covariances, added, rtol=1e-9)
