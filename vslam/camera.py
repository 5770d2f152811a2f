"""The robot's own calibration: where a pixel looks, and which spot of the floor it shows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vslam.distortion import Distortion
from vslam.errors import VslamError

FloatArray = NDArray[np.float64]
Model = Literal["fisheye", "pinhole"]


@dataclass(frozen=True, eq=False)
class Calibration:
    """A camera mounted on the robot. Pixel centres lie at integer coordinates; axes are OpenCV's.

    Attributes
    ----------
    model : "fisheye" | "pinhole"
        Fisheye: distance from the principal point = f · angle to the optical axis (rad), as ``cv2.fisheye``.
        Pinhole: f · tangent of it.
    width, height : int
        Of the picture, pixels.
    fx, fy : float
        Focal lengths, pixels (per rad for the fisheye).
    cx, cy : float
        Principal point, pixels.
    T_robot_camera : (4, 4) float64
        Maps camera coordinates (x right, y down, z forward) to the robot's (x forward, y left,
        z up, origin on the floor), metres.
    distortion : tuple of float
        OpenCV's coefficients for the model (`vslam.distortion.Distortion.of`), or none.

    Raises
    ------
    VslamError
        For an unknown model, a size or focal length that is not positive, a matrix that is not (4, 4), or a
        distortion that folds inside the picture.
    """

    model: Model
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    T_robot_camera: FloatArray
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.model not in ("fisheye", "pinhole"):
            raise VslamError(f"calibration: unknown camera model {self.model!r}; use 'fisheye' or 'pinhole'")
        if min(self.width, self.height) < 1 or not min(self.fx, self.fy) > 0.0:
            raise VslamError("calibration: width, height, fx and fy must be positive")
        if np.shape(self.T_robot_camera) != (4, 4):
            raise VslamError(
                f"calibration: T_robot_camera must be (4, 4), not {np.shape(self.T_robot_camera)}"
            )
        if np.isnan(self._plane_of_edge).any():
            raise VslamError(
                f"calibration: distortion {list(self.distortion)} folds inside the picture of "
                f"{self.width} × {self.height}"
            )

    def rays(self) -> FloatArray:
        """(H, W, 3) float64: unit viewing direction of each pixel in the camera frame (computed once)."""
        return self._rays

    def unproject(self, pixels: ArrayLike) -> FloatArray:
        """Viewing directions of pixels.

        Parameters
        ----------
        pixels : (n, 2) array_like
            Column u and row v, sub-pixel.

        Returns
        -------
        (n, 3) float64
            Unit vectors in the camera frame; NaN where the distortion has no inverse.
        """
        x, y = self._plane(pixels).T
        if self.model == "pinhole":
            rays = np.stack([x, y, np.ones_like(x)], axis=1)
            return rays / np.linalg.norm(rays, axis=1, keepdims=True)
        angle = np.hypot(x, y)
        radial = np.sinc(angle / np.pi)  # sin θ / θ, finite on the axis
        return np.stack([radial * x, radial * y, np.cos(angle)], axis=1)

    def project(self, points_camera: ArrayLike) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Pixels that show points.

        Parameters
        ----------
        points_camera : (n, 3) array_like
            In the camera frame, metres.

        Returns
        -------
        pixels : (n, 2) float64
            Column and row; NaN where the model has no image of the point (pinhole: behind the camera).
        valid : (n,) bool
            True where the pixel lies inside the picture.
        """
        x, y, z = np.asarray(points_camera, dtype=np.float64).reshape(-1, 3).T
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.model == "pinhole":
                scale = np.where(z > 0.0, 1.0 / z, np.nan)
            else:
                across = np.hypot(x, y)
                on_axis = np.where(z > 0.0, 1.0 / z, np.nan)  # limit θ / sin θ · 1/|P| on the optical axis
                scale = np.where(across > 0.0, np.arctan2(across, z) / across, on_axis)
            plane = np.stack([scale * x, scale * y], axis=1)
            pixels = self._distortion(plane)[0] * (self.fx, self.fy) + (self.cx, self.cy)
            low = (pixels >= -0.5).all(axis=1)
            valid = low & (pixels[:, 0] < self.width - 0.5) & (pixels[:, 1] < self.height - 0.5)
            # far outside the picture the polynomials lead back into it
            farthest = np.hypot(*self._plane_of_edge.T).max()
            valid &= np.hypot(*plane.T) <= farthest * (1.0 + 1e-3)
        return pixels, valid

    def floor_points(self, pixels: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Where pixels meet the floor z = 0.

        Parameters
        ----------
        pixels : (n, 2) array_like
            Column and row, sub-pixel.

        Returns
        -------
        points : (n, 2) float64
            Forward and left coordinate in the robot frame, metres; NaN at and above the horizon.
        jacobian : (n, 2, 2) float64
            d(points)/d(pixels), metres per pixel; NaN likewise.
        """
        rotation, origin = self.T_robot_camera[:3, :3], self.T_robot_camera[:3, 3]
        rays = self.unproject(pixels) @ rotation.T
        d_rays = np.einsum("ij,njk->nik", rotation, self._ray_jacobian(pixels))
        down = np.where(rays[:, 2] < 0.0, rays[:, 2], np.nan)
        scale = -origin[2] / down
        points = origin[:2] + scale[:, None] * rays[:, :2]
        # p = o − (h/d_z) d_xy, differentiated by d: the ray's length cancels.
        slope = rays[:, :2] / down[:, None]
        jacobian = scale[:, None, None] * (d_rays[:, :2] - slope[:, :, None] * d_rays[:, None, 2])
        return points, jacobian

    def pixel_grid(self) -> FloatArray:
        """(H·W, 2) float64: column and row of every pixel, row by row."""
        v, u = np.mgrid[0 : self.height, 0 : self.width]
        return np.stack([u.ravel(), v.ravel()], axis=1).astype(np.float64)

    @cached_property
    def _rays(self) -> FloatArray:
        rays = self.unproject(self.pixel_grid()).reshape(self.height, self.width, 3)
        rays.setflags(write=False)
        return rays

    @cached_property
    def _distortion(self) -> Distortion:
        return Distortion.of(self.model, self.distortion)

    def _plane(self, pixels: ArrayLike) -> FloatArray:
        """(n, 2): tangents or, of a fisheye, angles of the pixels' directions."""
        uv = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
        return self._distortion.inverse((uv - (self.cx, self.cy)) / (self.fx, self.fy))

    @cached_property
    def _plane_of_edge(self) -> FloatArray:
        """(n, 2): the same of points along the picture's outline."""
        along = np.linspace(0.0, 1.0, 65)
        sides = [(along, 0 * along), (along, 0 * along + 1), (0 * along, along), (0 * along + 1, along)]
        edge = np.concatenate([np.stack(side, axis=1) for side in sides])
        return self._plane(edge * (self.width, self.height) - 0.5)

    def _ray_jacobian(self, pixels: ArrayLike) -> FloatArray:
        """(n, 3, 2): d(ray)/d(pixel); the pinhole's up to a part along the ray, unseen on the floor."""
        plane = self._plane(pixels)
        x, y = plane.T
        zero, one = np.zeros_like(x), np.ones_like(x)
        if self.model == "pinhole":
            length = np.sqrt(x * x + y * y + 1.0)
            columns = (
                np.stack([one, zero, zero, one, zero, zero], axis=1).reshape(-1, 3, 2) / length[:, None, None]
            )
        else:
            angle = np.hypot(x, y)
            radial = np.sinc(angle / np.pi)
            with np.errstate(divide="ignore", invalid="ignore"):
                slope = np.where(angle > 1e-4, (np.cos(angle) - radial) / angle**2, -1.0 / 3.0)
            columns = np.stack(
                [
                    radial + slope * x * x,
                    slope * x * y,
                    slope * x * y,
                    radial + slope * y * y,
                    -radial * x,
                    -radial * y,
                ],
                axis=1,
            ).reshape(-1, 3, 2)
        undistorting = np.linalg.inv(self._distortion(plane)[1]) / np.array([self.fx, self.fy])
        return columns @ undistorting


def mounted(
    model: Model = "fisheye",
    width: int = 320,
    height: int = 240,
    fov_deg: float = 150.0,
    height_m: float = 1.2,
    forward_m: float = 0.0,
    pitch_deg: float = 25.0,
) -> Calibration:
    """A camera with square pixels, a centred principal point and no distortion, looking forward and down.

    The defaults are the robot's camera: Table 4-1's 320 × 240 picture and ±75° field of view.

    Parameters
    ----------
    model : "fisheye" | "pinhole"
    width, height : int, pixels
    fov_deg : float
        Horizontal field of view across the whole picture, degrees; a pinhole's below 180.
    height_m, forward_m, pitch_deg : float
        See `mounting`.

    Raises
    ------
    VslamError
        For a field of view that the model cannot have, or a camera at or below the floor.
    """
    if not 0.0 < fov_deg < (180.0 if model == "pinhole" else 360.0):
        raise VslamError(f"calibration: a {model} camera cannot see {fov_deg}° across")
    half = np.radians(fov_deg) / 2.0
    focal = float(width / 2.0 / (np.tan(half) if model == "pinhole" else half))
    pose = mounting(height_m, forward_m, pitch_deg)
    return Calibration(model, width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0, pose)


def mounting(
    height_m: float = 1.2,
    forward_m: float = 0.0,
    pitch_deg: float = 25.0,
    left_m: float = 0.0,
    yaw_deg: float = 0.0,
    roll_deg: float = 0.0,
) -> FloatArray:
    """(4, 4) float64: maps coordinates of a camera that looks forward and down to the robot's.

    Parameters
    ----------
    height_m, forward_m, left_m : float
        Of the optical centre above the floor, ahead and to the left of the robot's origin, metres.
    pitch_deg : float
        Downward tilt of the optical axis, degrees.
    yaw_deg, roll_deg : float
        Turn to the left before the tilt; about the optical axis after it, clockwise as the camera sees it.

    Raises
    ------
    VslamError
        For a camera at or below the floor.
    """
    if not height_m > 0.0:
        raise VslamError(f"calibration: camera height must be above the floor, not {height_m} m")
    c, s = np.cos(np.radians(pitch_deg)), np.sin(np.radians(pitch_deg))
    pose = np.eye(4)
    tilted = np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])
    pose[:3, :3] = _about_z(yaw_deg) @ tilted @ _about_z(roll_deg)
    pose[:3, 3] = forward_m, left_m, height_m
    return pose


def _about_z(degrees: float) -> FloatArray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
